//! Elastic solids.

use super::case::Case;

/// The cases.
pub const CASES: &[Case] = &[];
