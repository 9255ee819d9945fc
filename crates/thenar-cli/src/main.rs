//! The `thenar` program.
fn main() {}
