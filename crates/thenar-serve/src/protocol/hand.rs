//! Hands in a model message.

use super::arrays::{Array, Arrays, seven};
use serde::Serialize;
use std::f64::consts::PI;
use thenar::Pose;
use thenar::model::{Digit, HandModel, Side};
use thenar_scene::build::BuiltHand;
use thenar_scene::motion::{Anatomy, Articulation, JointRole};

/// A hand.
#[derive(Debug, Serialize)]
pub struct Hand {
    name: String,
    side: Option<Side>,
    soft: Option<u32>,
    length: f64,
    bone_start: u32,
    bone_count: usize,
    target_start: usize,
    bones: Vec<Bone>,
    wrist_B: [f64; 7],
    angles: Vec<Option<Angle>>,
    collision_digits: Array,
}

#[derive(Debug, Serialize)]
struct Bone {
    name: String,
    parent: Option<u32>,
    digit: &'static str,
    ends_B: [[f64; 3]; 2],
    radius: f64,
    mass: f64,
}

/// One angle of a pose message: flexion closes the hand, spread opens it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Angle {
    joint: String,
    rest: f64,
    min: f64,
    max: f64,
}

/// Describes a hand whose first bone is number `target_start` among a snapshot's targets.
pub fn hand(built: &BuiltHand, target_start: usize, arrays: &mut Arrays) -> Hand {
    let model = &built.model;
    let bone = |bone: &thenar::model::Bone| Bone {
        name: bone.name.clone(),
        parent: bone.parent,
        digit: bone.digit.name(),
        ends_B: bone.ends_B.map(|p| [p.x, p.y, p.z]),
        radius: bone.radius,
        mass: bone.mass,
    };
    Hand {
        name: built.name.clone(),
        side: model.side,
        soft: built.flesh(),
        length: model.length,
        bone_start: built.handle.bones.start,
        bone_count: model.bones.len(),
        target_start,
        bones: model.bones.iter().map(bone).collect(),
        wrist_B: seven(&model.bones.first().map_or(Pose::identity(), |palm| palm.pose_BT)),
        angles: angles(model),
        collision_digits: arrays.u8(1, model.collision_digits.iter().map(|d| *d as u8)),
    }
}

/// The 20 angles by which a pose message bends a hand: for each finger, thumb first, base
/// flexion, base spread, second flexion, third flexion.
fn angles(model: &HandModel) -> Vec<Option<Angle>> {
    let anatomy = Anatomy::of(model);
    let rest = Articulation::new(model).map(|a| a.rest_angles).unwrap_or_default();
    let one = |digit: Digit, place: usize, which: fn(&JointRole) -> Option<(usize, f64)>| {
        let j = anatomy.joints_of(digit).find(|j| anatomy.roles[*j].place == place)?;
        let (axis, sign) = which(&anatomy.roles[j])?;
        let joint = &model.joints[j];
        let limit = joint.axes[axis].limit;
        let ends = limit.map_or([-PI, PI], |limit| [sign * limit.min, sign * limit.max]);
        Some(Angle {
            joint: joint.name.clone(),
            rest: sign * rest.get(j).map_or(0.0, |angles| angles[axis]),
            min: ends[0].min(ends[1]),
            max: ends[0].max(ends[1]),
        })
    };
    let flexion: fn(&JointRole) -> _ = |role| role.flexion;
    let spread: fn(&JointRole) -> _ = |role| role.spread;
    let of = |digit| {
        [(0, flexion), (0, spread), (1, flexion), (2, flexion)]
            .map(|(place, which)| one(digit, place, which))
    };
    Digit::FINGERS.into_iter().flat_map(of).collect()
}
