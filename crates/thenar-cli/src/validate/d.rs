//! Flesh-bone coupling and skinning.

use super::case::Case;

/// The cases.
pub const CASES: &[Case] = &[];
