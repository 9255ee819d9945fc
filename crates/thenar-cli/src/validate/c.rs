//! Contact and friction.

use super::case::Case;

/// The cases.
pub const CASES: &[Case] = &[];
