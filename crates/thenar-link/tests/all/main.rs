//! Drivers with simulated devices, in one binary: `cargo test -p thenar-link --test all streams::`
//! runs a part. Apart stand the haptic loop, which is timed, what counts allocations, and what ends
//! every device of its process.

// What the fuzz target of all protocols is written with; `noise.rs` stands in for it.
extern crate self as libfuzzer_sys;

#[path = "../conformance/mod.rs"]
mod conformance;
mod cyberglove;
mod cybergrasp;
mod every_driver;
mod fuzz_profiles;
mod lucidgloves;
mod mute;
mod noise;
mod streams;
mod wifi;
