//! Measurements of Thenar: benches, comparisons, fits, studies of touch, stress tests, and figures
//! beside theory.

pub mod bench;
pub mod compare;
pub mod fit;
pub mod haptics;
mod press;
pub mod soak;
pub mod validate;
