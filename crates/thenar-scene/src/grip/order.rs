//! Grip that a hand is asked for.

use super::kind::GripKind;
use serde::{Deserialize, Serialize};
use thenar_core::World;
use thenar_core::model::BodyId;

/// One grip, with its object by index.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Order {
    /// The object: whether it is a deformable body, and its index among the rigid or the deformable
    /// ones. None where pads press against each other.
    object: Option<(bool, u32)>,
    /// Kind of grip.
    pub kind: GripKind,
    /// Force with which the two sides press against each other \[N\].
    pub force: f64,
    /// Time at which the fingers begin to close \[s\].
    pub at: f64,
    /// Time at which they open \[s\].
    pub open: Option<f64>,
    /// The force was left open, and may rise to what the load asks. A recording keeps it elsewhere,
    /// since it came later than the rest.
    #[serde(skip)]
    pub adapts: bool,
}

impl Order {
    /// A grip of this object, or of the pads by each other.
    pub fn new(
        object: Option<BodyId>,
        kind: GripKind,
        force: f64,
        at: f64,
        open: Option<f64>,
    ) -> Self {
        let object = object.map(|object| match object {
            BodyId::Rigid(i) => (false, i),
            BodyId::Soft(i) => (true, i),
        });
        Self { object, kind, force, at, open, adapts: false }
    }

    /// The order with a force that may rise to what the load asks, or not.
    pub fn adapting(self, adapts: bool) -> Self {
        Self { adapts, ..self }
    }

    /// True when the object is one of this world's, and the numbers are finite.
    pub fn fits(&self, world: &World) -> bool {
        let counts = |soft: bool| {
            if soft { world.desc().softs.len() } else { world.desc().rigids.len() }
        };
        self.object.is_none_or(|(soft, index)| (index as usize) < counts(soft))
            && self.force.is_finite()
            && self.at.is_finite()
            && self.open.is_none_or(f64::is_finite)
    }

    /// The object; none where pads press against each other.
    pub fn object(&self) -> Option<BodyId> {
        self.object.map(|(soft, i)| if soft { BodyId::Soft(i) } else { BodyId::Rigid(i) })
    }
}
