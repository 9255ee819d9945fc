//! Tools that tests of several crates share: an allocator that counts, a fixed share of many cases, and ports.

pub mod allocations;
mod ports;
mod share;

pub use ports::free_port;
pub use share::{cases_wanted, one_in};
