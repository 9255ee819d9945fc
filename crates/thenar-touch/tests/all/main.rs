//! What the haptic loop without its thread promises, on worlds of the core's tests, in one binary.

#[path = "../../../thenar-core/tests/common/mod.rs"]
mod common;
mod condensed;
mod condensed_objects;
mod finger;
mod guarded_wall;
mod multirate;
mod single_rate;
