//! The kinds of grip: which pads take part, and where on the digits they are.

use serde::{Deserialize, Serialize};
use thenar_core::model::Digit;
use thenar_track::reach::PadPlace;

/// Way of gripping an object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GripKind {
    /// Pads of thumb and index finger against each other.
    #[default]
    Pinch,
    /// The thumb's pad against those of index and middle finger, as a pen is held.
    Tripod,
    /// The thumb's pad against those of all four fingers.
    Power,
    /// Four fingers bent around the object, the thumb out of the way.
    Hook,
    /// The thumb's pad on the side of the bent index finger, as a key is held.
    Lateral,
}

impl GripKind {
    /// All kinds, in the order of their names in a scene.
    pub const ALL: [Self; 5] = [Self::Pinch, Self::Tripod, Self::Power, Self::Hook, Self::Lateral];

    /// Name in a scene.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pinch => "pinch",
            Self::Tripod => "tripod",
            Self::Power => "power",
            Self::Hook => "hook",
            Self::Lateral => "lateral",
        }
    }

    /// The kind of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The fingers that press against the thumb, or in a hook bend around the object.
    pub fn fingers(self) -> &'static [Digit] {
        match self {
            Self::Pinch | Self::Lateral => &Digit::FINGERS[1..2],
            Self::Tripod => &Digit::FINGERS[1..3],
            Self::Power | Self::Hook => &Digit::FINGERS[1..],
        }
    }

    /// True if digits are on opposite sides of a grip of this kind: thumb and finger, or of a hook
    /// palm and finger.
    pub fn opposes(self, one: Digit, other: Digit) -> bool {
        let base = if self.has_thumb() { Digit::Thumb } else { Digit::Palm };
        let is_pair = |a: Digit, b: Digit| a == base && self.fingers().contains(&b);
        is_pair(one, other) || is_pair(other, one)
    }

    /// True if the thumb takes part.
    pub fn has_thumb(self) -> bool {
        self != Self::Hook
    }

    /// Returns the place of the pads on its fingers.
    pub fn place(self) -> PadPlace {
        if self == Self::Lateral { PadPlace::Side } else { PadPlace::Tip }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Digit::{Index, Middle, Palm, Ring, Thumb};

    #[test]
    fn the_thumb_opposes_the_fingers_of_its_grip_and_the_palm_those_of_a_hook() {
        assert!(GripKind::Pinch.opposes(Thumb, Index) && GripKind::Pinch.opposes(Index, Thumb));
        assert!(!GripKind::Pinch.opposes(Thumb, Middle) && GripKind::Tripod.opposes(Thumb, Middle));
        assert!(!GripKind::Tripod.opposes(Thumb, Ring) && GripKind::Power.opposes(Ring, Thumb));
        assert!(!GripKind::Power.opposes(Index, Middle) && !GripKind::Power.opposes(Palm, Index));
        assert!(GripKind::Hook.opposes(Palm, Ring) && !GripKind::Hook.opposes(Thumb, Ring));
        assert!(GripKind::ALL.iter().all(|kind| !kind.opposes(Thumb, Thumb)));
    }
}
