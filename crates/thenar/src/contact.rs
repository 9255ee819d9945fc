//! Contacts.

use crate::Body;
use thenar_core::Vec3;

/// A contact after a step: it bears force, or is only near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The two bodies, A and B.
    pub bodies: [Body; 2],
    /// Place, world \[m\].
    pub point: Vec3,
    /// Unit normal from B towards A, world.
    pub normal: Vec3,
    /// Mean force on A during the step, or the last part of one made in parts, world \[N\]; B feels
    /// the opposite.
    pub force: Vec3,
    /// Gap at the start of the step, or of its last part \[m\], negative where surfaces overlap.
    pub gap: f64,
    /// Surface that the contact stands for \[m²\]; zero between rigid bodies.
    pub area: f64,
    /// Coefficient of friction in this step.
    pub friction: f64,
    /// True where friction gives all it can: the point slides, or is about to.
    pub slips: bool,
}

impl Contact {
    /// Normal force \[N\].
    pub fn normal_force(&self) -> f64 {
        self.force.dot(&self.normal)
    }

    /// Pressure \[Pa\]; zero between rigid bodies.
    pub fn pressure(&self) -> f64 {
        if self.area > 0.0 { self.normal_force() / self.area } else { 0.0 }
    }
}
