//! Tools that tests of several crates share: an allocator that counts, and a fixed share of many cases.

pub mod allocations;
mod share;

pub use share::{cases_wanted, one_in};
