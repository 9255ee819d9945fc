//! The files of the factor, and as much of a step's system as they ask for.
#![allow(dead_code)] // what the rest of the core uses

use super::BlockMatrix;
use crate::math::Vec3;

#[path = "../../../../../../crates/thenar-core/src/solver/monolithic/aligned.rs"]
pub mod aligned;
#[path = "../../../../../../crates/thenar-core/src/solver/monolithic/dense.rs"]
pub mod dense;
#[path = "../../../../../../crates/thenar-core/src/solver/monolithic/factor.rs"]
pub mod factor;
#[path = "../../../../../../crates/thenar-core/src/solver/monolithic/minimum_degree.rs"]
pub mod minimum_degree;
#[path = "../../../../../../crates/thenar-core/src/solver/monolithic/ordering.rs"]
pub mod ordering;
#[path = "../../../../../../crates/thenar-core/src/solver/monolithic/substitution.rs"]
pub mod substitution;
#[path = "../../../../../../crates/thenar-core/src/solver/monolithic/symbolic.rs"]
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
