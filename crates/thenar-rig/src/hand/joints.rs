//! Joints: frames, ranges of motion, passive springs.
//!
//! ```text
//!   side view, straight finger           joint frame J (in the parent):
//!        y (out of the back)               x  flexion axis; a positive turn closes the hand
//!        |                                 y  out of the back of the hand (right hand),
//!    ----+======> z (along the finger)        into the palm (left hand)
//!        x towards you (right hand)        z  along the digit on a right hand,
//!                                             against it on a left hand
//! ```
//!
//! Angles are anatomical: flexion 0 is the straight digit, whatever the pose of the rig, and
//! abduction 0 is the digit's direction at rest. Flexion closes the hand and abduction is towards
//! the thumb's side (radial) when positive, for both hands: a left hand with the mirrored pose has
//! the same angles.

use super::digits::DigitRig;
use super::names;
use nalgebra::{Matrix3, Rotation3};
use thenar_core::model::{AngleLimit, Axis, Bone, Digit, JointDesc, JointKind, Side};
use thenar_core::{Pose, Quat, Vec3};

/// Passive behaviour of one axis, for a hand of 190 mm.
#[derive(Clone, Copy)]
struct PassiveAxis {
    /// Range \[°\].
    range: [f64; 2],
    /// Spring \[N m/rad\].
    stiffness: f64,
}

/// Length for which springs and dampers are given \[m\].
const LENGTH: f64 = 0.19;
/// Damper over spring, as a time \[s\]: a relaxed finger swings back without ringing.
const DAMPING_TIME: f64 = 0.05;
/// Springs past a limit \[N m/rad\]: 1 N at a fingertip gives way by about 2°.
const LIMIT_STIFFNESS: f64 = 3.0;
/// Dampers past a limit \[N m s/rad\].
const LIMIT_DAMPING: f64 = 0.01;
/// Room left beyond the rest pose when a rig rests outside the anatomical range \[rad\].
const REST_MARGIN: f64 = 0.03;

/// Abduction and flexion of moving joint `k`. Ranges: AAOS and e-hand tables; the thumb's carpal
/// joint has 60° of flexion-extension (radial abduction) and 45° of palmar abduction about its
/// rest. Springs: those of tendons and capsule alone. What is measured at a living knuckle
/// (0.02-0.06 N m/rad) is their sum with the bent flesh, which the elements give.
fn passive(digit: Digit, k: usize) -> [PassiveAxis; 2] {
    let axis = |low, high, stiffness| PassiveAxis { range: [low, high], stiffness };
    let none = axis(0.0, 0.0, 0.0);
    match (digit, k) {
        (Digit::Thumb, 0) => [axis(-22.5, 22.5, 0.025), axis(-30.0, 30.0, 0.025)],
        (Digit::Thumb, 1) => [none, axis(-10.0, 55.0, 0.012)],
        (Digit::Thumb, _) => [none, axis(-15.0, 80.0, 0.006)],
        (_, 0) => [axis(-20.0, 20.0, 0.015), axis(-45.0, 90.0, 0.012)],
        (_, 1) => [none, axis(0.0, 100.0, 0.008)],
        (_, _) => [none, axis(0.0, 85.0, 0.004)],
    }
}

/// One joint per moving bone, in the order of the bones.
pub(super) fn joints(
    digits: &[DigitRig],
    bones: &[Bone],
    side: Side,
    length: f64,
) -> Vec<JointDesc> {
    let mut joints = Vec::new();
    for rig in digits {
        for k in 0..3 {
            let child = joints.len() + 1;
            joints.push(joint(rig, k, bones, child, side, length));
        }
    }
    joints
}

fn joint(
    rig: &DigitRig,
    k: usize,
    bones: &[Bone],
    child: usize,
    side: Side,
    length: f64,
) -> JointDesc {
    let parent = bones[child].parent.unwrap_or(0);
    let kind = if k == 0 { JointKind::Universal } else { JointKind::Hinge };
    let straight = zero_direction(rig, k);
    let at = rig.joints[k].position;
    let pose_MJ = Pose::new(at, frame(&rig.flexion, &straight, side));
    let pose_MK = Pose::new(at, frame(&rig.flexion, &rig.direction(k), side));
    let rest = flexion_between(&rig.flexion, &straight, &rig.direction(k));

    let scale = (length / LENGTH).powi(3);
    let [abduction, flexion] = passive(rig.digit, k);
    let flexion = axis(&flexion, flexion_origin(rig.digit, k, rest), rest, scale);
    let axes = match kind {
        JointKind::Universal => [axis(&abduction, 0.0, 0.0, scale), flexion],
        _ => [flexion, Axis::default()],
    };
    JointDesc {
        name: names::joint_name(rig.digit, k),
        kind,
        parent: Some(parent),
        child: child as u32,
        pose_PJ: bones[parent as usize].pose_MB.inverse() * pose_MJ,
        pose_CK: bones[child].pose_MB.inverse() * pose_MK,
        axes,
        limit_stiffness: LIMIT_STIFFNESS * scale,
        limit_damping: LIMIT_DAMPING * scale,
    }
}

/// The direction that counts as flexion 0. The thumb's metacarpal has no straight continuation of
/// the wrist to be measured against; its rest direction takes that place.
fn zero_direction(rig: &DigitRig, k: usize) -> Vec3 {
    if rig.digit == Digit::Thumb && k == 0 { rig.direction(0) } else { rig.direction_before(k) }
}

/// Angle from which the tabulated range counts.
fn flexion_origin(digit: Digit, k: usize, rest: f64) -> f64 {
    if digit == Digit::Thumb && k == 0 { rest } else { 0.0 }
}

fn axis(passive: &PassiveAxis, origin: f64, rest: f64, scale: f64) -> Axis {
    let [low, high] = passive.range.map(|degrees| origin + degrees.to_radians());
    Axis {
        limit: Some(AngleLimit {
            min: low.min(rest - REST_MARGIN),
            max: high.max(rest + REST_MARGIN),
        }),
        stiffness: passive.stiffness * scale,
        rest_angle: rest,
        damping: passive.stiffness * DAMPING_TIME * scale,
    }
}

/// Rotation from the joint frame to M: x the flexion axis, z along (or, left, against) the digit.
fn frame(flexion: &Vec3, along: &Vec3, side: Side) -> Quat {
    let along = (along - flexion * flexion.dot(along)).normalize();
    let z = if side == Side::Right { along } else { -along };
    let axes = Matrix3::from_columns(&[*flexion, z.cross(flexion), z]);
    Quat::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}

/// Angle about the flexion axis from one direction to the other.
fn flexion_between(flexion: &Vec3, from: &Vec3, to: &Vec3) -> f64 {
    let across = |d: &Vec3| d - flexion * flexion.dot(d);
    let (a, b) = (across(from), across(to));
    a.cross(&b).dot(flexion).atan2(a.dot(&b))
}
