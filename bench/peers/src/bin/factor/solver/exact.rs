//! The files of the factor, and as much of a step's system as they ask for.
#![allow(dead_code)] // what the rest of the core uses

use super::BlockMatrix;
use crate::math::Vec3;

#[path = "../../../../../../crates/thenar-core/src/solver/exact/aligned.rs"]
pub mod aligned;
#[path = "../../../../../../crates/thenar-core/src/solver/exact/dense.rs"]
pub mod dense;
#[path = "../../../../../../crates/thenar-core/src/solver/exact/factor.rs"]
pub mod factor;
#[path = "../../../../../../crates/thenar-core/src/solver/exact/minimum_degree.rs"]
pub mod minimum_degree;
#[path = "../../../../../../crates/thenar-core/src/solver/exact/ordering.rs"]
pub mod ordering;
#[path = "../../../../../../crates/thenar-core/src/solver/exact/substitution.rs"]
pub mod substitution;
#[path = "../../../../../../crates/thenar-core/src/solver/exact/symbolic.rs"]
pub mod symbolic;

/// The flesh alone: no body, nothing known.
pub struct System<'a> {
    pub A: &'a BlockMatrix,
    pub bodies: NoBodies,
    pub springs: &'a [f64],
}

pub struct NoBodies;

impl NoBodies {
    pub fn bodies(&self) -> usize {
        0
    }
}

impl System<'_> {
    pub fn unknown(&self, _: usize, f: &Vec3) -> Vec3 {
        *f
    }
}
