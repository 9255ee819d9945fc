//! Hands in a model message.

use super::arrays::{Array, Arrays, seven};
use super::rigid::{Mesh, drawn};
use serde::Serialize;
use std::collections::BTreeMap;
use thenar_core::Pose;
use thenar_core::model::{HandModel, JointKind, Side};
use thenar_rig::hand::cuff;
use thenar_scene::build::BuiltHand;
use thenar_scene::motion::{
    ANGLES, Anatomy, AngleRange, Articulation, Preset, Shapes, hand_angles,
};

/// A hand in the model message.
#[derive(Debug, Serialize)]
pub struct HandEntry {
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
    shapes: BTreeMap<&'static str, [f64; ANGLES]>,
    collision_digits: Array,
    /// Worn at the wrist of a hand with flesh, in the palm bone's frame.
    cuff: Option<Mesh>,
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
    /// The bone the joint carries, in the hand's list.
    bone: u32,
    /// Axis of the joint's frame about which the angle turns.
    axis: &'static str,
    /// +1 or -1: the sense of that turn.
    sense: f64,
    /// Joint frame in the parent bone and in the bone, quaternions.
    rotation_PJ: [f64; 4],
    rotation_BK: [f64; 4],
}

/// Describes a hand whose first bone is number `target_start` among a snapshot's targets.
pub fn hand(built: &BuiltHand, target_start: usize, arrays: &mut Arrays) -> HandEntry {
    let model = &built.model;
    let bone = |bone: &thenar_core::model::Bone| Bone {
        name: bone.name.clone(),
        parent: bone.parent,
        digit: bone.digit.name(),
        ends_B: bone.ends_B.map(|p| [p.x, p.y, p.z]),
        radius: bone.radius,
        mass: bone.mass,
    };
    HandEntry {
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
        shapes: shapes(model),
        collision_digits: arrays.u8(1, model.collision_digits.iter().map(|d| *d as u8)),
        cuff: built.flesh().and_then(|_| cuff(model)).map(|mesh| drawn(&mesh, &[], arrays)),
    }
}

/// Named shapes of the hand as such angles.
fn shapes(model: &HandModel) -> BTreeMap<&'static str, [f64; ANGLES]> {
    let Ok(articulation) = Articulation::new(model) else { return BTreeMap::new() };
    let anatomy = Anatomy::of(model);
    let shapes = Shapes::new(model, &articulation, &anatomy);
    Preset::NAMED.map(|(name, shape)| (name, shapes.twenty(shape))).into()
}

/// The 20 angles by which a pose message bends a hand.
fn angles(model: &HandModel) -> Vec<Option<Angle>> {
    let Ok(articulation) = Articulation::new(model) else { return vec![None; ANGLES] };
    let angle = |range: AngleRange| {
        let joint = &model.joints[range.index];
        // A hinge turns about x, a universal joint about y, then x.
        let about_x = joint.kind == JointKind::Hinge || range.axis == 1;
        Angle {
            joint: range.joint,
            rest: range.rest,
            min: range.min,
            max: range.max,
            bone: joint.child,
            axis: if about_x { "x" } else { "y" },
            sense: range.sense,
            rotation_PJ: joint.pose_PJ.rotation.coords.into(),
            rotation_BK: joint.pose_CK.rotation.coords.into(),
        }
    };
    hand_angles(model, &articulation).map(|range| range.map(angle)).into()
}
