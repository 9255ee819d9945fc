//! Bodies that a contact is between.

use crate::{HandId, RigidId, SoftId};
use thenar_core::model::Digit;

/// A body that touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// Flesh of a hand, and the digit that it belongs to.
    Skin(HandId, Digit),
    /// A bone of a hand, which touches where flesh is crushed, and the digit that it belongs to.
    Bone(HandId, Digit),
    /// A rigid object.
    Rigid(RigidId),
    /// A soft object.
    Soft(SoftId),
    /// A part of a figure, which only scene files have.
    Figure,
}

impl Body {
    /// The hand that it is a part of.
    pub fn hand(&self) -> Option<HandId> {
        match self {
            Self::Skin(hand, _) | Self::Bone(hand, _) => Some(*hand),
            _ => None,
        }
    }
}

impl From<RigidId> for Body {
    fn from(id: RigidId) -> Self {
        Self::Rigid(id)
    }
}

impl From<SoftId> for Body {
    fn from(id: SoftId) -> Self {
        Self::Soft(id)
    }
}
