//! The world as a whole: states, parameters, failures, and thrashing.

mod bad_input;
mod failing_island;
mod parts;
mod pose_offsets;
mod restore;
mod retune;
mod thrash;
