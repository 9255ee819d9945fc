//! The twenty angles of a hand, under the same numbers whatever the rig: for each digit, thumb
//! first, the flexion and the spread of its base joint, then the flexion of its second and third
//! joint.

use super::anatomy::{Anatomy, JointRole};
use super::articulation::Articulation;
use std::f64::consts::PI;
use thenar_core::model::{Digit, HandModel};

/// Number of angles of a hand: four for each digit.
pub const ANGLES: usize = 20;

/// One of the twenty angles. Angles are anatomical: flexion is positive when the hand closes,
/// spread away from the middle finger (middle finger: towards the thumb; thumb: out of the palm).
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct AngleRange {
    /// Name of the joint.
    pub joint: String,
    /// At rest \[rad\].
    pub rest: f64,
    /// Smallest admissible \[rad\].
    pub min: f64,
    /// Largest admissible \[rad\].
    pub max: f64,
    /// Index of the joint in the hand.
    pub index: usize,
    /// Number of the angle among the joint's axes.
    pub axis: usize,
    /// +1 or -1: the joint's own angle is this times the anatomical one.
    pub sense: f64,
}

/// The twenty angles of `hand`; `None` for a joint it lacks.
pub fn hand_angles(hand: &HandModel, articulation: &Articulation) -> [Option<AngleRange>; ANGLES] {
    let roles = Anatomy::of(hand).roles;
    std::array::from_fn(|k| {
        let (digit, part) = (Digit::FINGERS[k / 4], k % 4);
        let place = part.saturating_sub(1);
        let found = |(_, role): &(usize, &JointRole)| role.digit == digit && role.place == place;
        let (index, role) = roles.iter().enumerate().find(found)?;
        let (axis, sense) = if part == 1 { role.spread? } else { role.flexion? };
        let limit = articulation.tree.limits(index)[axis];
        let [low, high] = limit.map_or([-PI, PI], |limit| [limit.min, limit.max]);
        Some(AngleRange {
            joint: role.joint.clone(),
            rest: sense * articulation.rest_angles[index][axis],
            min: (sense * low).min(sense * high),
            max: (sense * low).max(sense * high),
            index,
            axis,
            sense,
        })
    })
}
