//! Tools that tests of several crates share: an allocator that counts, repeatable damage, a fixed
//! share of many cases, ports and pipes.

pub mod allocations;
mod damage;
mod mutator;
#[cfg(unix)]
mod pipe;
mod ports;
mod share;

pub use damage::damaged;
pub use mutator::Mutator;
#[cfg(unix)]
pub use pipe::make_pipe;
pub use ports::free_port;
pub use share::{cases_wanted, one_in};
