//! What a hand is asked to grip.

use super::kind::GripKind;
use serde::{Deserialize, Serialize};
use thenar::World;
use thenar::model::BodyId;

/// One grip, with its object by index.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Order {
    /// The object is a deformable body.
    soft: bool,
    /// Its index among the rigid or the deformable bodies.
    index: u32,
    /// How.
    pub kind: GripKind,
    /// Force with which the two sides press against each other \[N\].
    pub force: f64,
    /// When the fingers begin to close \[s\].
    pub at: f64,
    /// When they open \[s\].
    pub open: Option<f64>,
}

impl Order {
    /// A grip of this object.
    pub fn new(object: BodyId, kind: GripKind, force: f64, at: f64, open: Option<f64>) -> Self {
        let (soft, index) = match object {
            BodyId::Rigid(i) => (false, i),
            BodyId::Soft(i) => (true, i),
        };
        Self { soft, index, kind, force, at, open }
    }

    /// True when the object is one of this world's, and the numbers are finite.
    pub fn fits(&self, world: &World) -> bool {
        let count = if self.soft { world.desc().softs.len() } else { world.desc().rigids.len() };
        (self.index as usize) < count
            && self.force.is_finite()
            && self.at.is_finite()
            && self.open.is_none_or(f64::is_finite)
    }

    /// The object.
    pub fn object(&self) -> BodyId {
        if self.soft { BodyId::Soft(self.index) } else { BodyId::Rigid(self.index) }
    }
}
