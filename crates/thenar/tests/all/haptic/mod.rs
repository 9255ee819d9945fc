//! The haptic loop without its thread.

mod condensed;
mod condensed_objects;
mod finger;
mod guarded_wall;
mod multirate;
mod single_rate;
