//! What the core promises, through its public face, in one binary, as each would build the same
//! generic code again: `cargo test -p thenar --test all contact::area` runs a part. Tests that
//! count allocations stand apart, for their allocator is the whole binary's.

#[path = "../common/mod.rs"]
mod common;
mod contact;
mod flesh;
mod skeleton;
mod solver;
mod world;
