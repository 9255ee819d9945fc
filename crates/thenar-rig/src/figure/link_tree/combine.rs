//! One joint of several hinges that meet in a point.

use super::super::plan::PlanJoint;
use super::settle::SettledJoint;
use super::{frame_of, frame_of_x, listed};
use thenar_core::model::{Axis, JointKind};
use thenar_core::{Pose, Quat, Vec3};
use thenar_input::quoted;

/// Hinges meet within this part of the figure's size, and at right angles within this angle
/// \[rad\]; what is less is round-off and is not told.
const EXACTNESS: f64 = 1e-6;
/// Hinges that pass each other within this part of the figure's size meet halfway, which is
/// reported: the two axes of an ankle lie 10 to 40 mm apart in descriptions of people of 1.4 to 1.8
/// m.
const PASSING: f64 = 0.05;

/// The joint that a chain of joints makes, and what to tell of it; `frame` turns the frame of a
/// ball joint.
///
/// # Errors
/// Says why the chain is no hinge, universal joint or ball joint.
pub(super) fn combine(
    joints: &[SettledJoint],
    frame: &Quat,
    size: f64,
) -> Result<(PlanJoint, Option<String>), String> {
    if let [joint] = joints {
        return Ok((single(joint, frame), None));
    }
    if joints.iter().any(|joint| joint.kind != JointKind::Hinge) {
        return Err("a ball joint turns freely already".to_owned());
    }
    if joints.len() > 3 {
        return Err("more than three hinges follow each other".to_owned());
    }
    for pair in joints.windows(2) {
        right_angle(pair)?;
    }
    match joints {
        [first, second] => {
            let (point, away) = common_point(joints, size)?;
            let names = listed([first, second].map(|j| j.name.as_str()));
            let name = quoted(&second.name);
            let moved = moved(away);
            let note = format!("the hinges {names} became the universal joint {name}{moved}");
            Ok((universal(first, second, point), Some(note)))
        }
        [.., last] => {
            let (point, away) = common_point(joints, size)?;
            let names = listed(joints.iter().map(|j| j.name.as_str()));
            let name = quoted(&last.name);
            let note = format!(
                "the hinges {names} became the ball joint {name}, which has no ranges and the mean of their \
                 dampers{}",
                moved(away)
            );
            Ok((ball(joints, last, point, frame), Some(note)))
        }
        [] => Err("it has no joint".to_owned()),
    }
}

fn single(joint: &SettledJoint, frame: &Quat) -> PlanJoint {
    let rotation = match joint.kind {
        JointKind::Hinge => frame_of_x(&joint.axis_M),
        _ => *frame,
    };
    PlanJoint {
        name: joint.name.clone(),
        kind: joint.kind,
        pose_MJ: Pose::new(joint.point_M, rotation),
        axes: [joint.axis, Axis::default()],
    }
}

/// The first hinge turns about y, the second about x.
fn universal(first: &SettledJoint, second: &SettledJoint, point: Vec3) -> PlanJoint {
    let y = first.axis_M;
    let across = second.axis_M - y * y.dot(&second.axis_M);
    let x = across / across.norm();
    let rotation = frame_of(&x, &y);
    PlanJoint {
        name: second.name.clone(),
        kind: JointKind::Universal,
        pose_MJ: Pose::new(point, rotation),
        axes: [first.axis, second.axis],
    }
}

fn ball(joints: &[SettledJoint], last: &SettledJoint, point: Vec3, frame: &Quat) -> PlanJoint {
    let mean = |of: fn(&Axis) -> f64| {
        joints.iter().map(|joint| of(&joint.axis)).sum::<f64>() / joints.len() as f64
    };
    let axis = Axis {
        stiffness: mean(|axis| axis.stiffness),
        damping: mean(|axis| axis.damping),
        ..Axis::default()
    };
    PlanJoint {
        name: last.name.clone(),
        kind: JointKind::Ball,
        pose_MJ: Pose::new(point, *frame),
        axes: [axis, Axis::default()],
    }
}

fn right_angle(pair: &[SettledJoint]) -> Result<(), String> {
    let [a, b] = pair else { return Ok(()) };
    // A product that is not a number is no right angle.
    if a.axis_M.dot(&b.axis_M).abs() <= EXACTNESS {
        return Ok(());
    }
    let names = listed([a, b].map(|joint| joint.name.as_str()));
    Err(format!("the hinges {names} are not at right angles"))
}

/// Remark on hinges whose axes are moved by up to `away` to meet \[m\].
fn moved(away: Option<f64>) -> String {
    away.map_or_else(String::new, |away| {
        format!(", halfway between their axes, which are moved by up to {:.1} mm", 1e3 * away)
    })
}

/// The point in which all axes meet, that of the first two, which are at right angles; and how far
/// from it they pass \[m\], where that is more than round-off.
fn common_point(joints: &[SettledJoint], size: f64) -> Result<(Vec3, Option<f64>), String> {
    let [first, second, ..] = joints else { return Err("it has no two hinges".to_owned()) };
    let between = second.point_M - first.point_M;
    let on_first = first.point_M + first.axis_M * between.dot(&first.axis_M);
    let on_second = second.point_M - second.axis_M * between.dot(&second.axis_M);
    let point = (on_first + on_second) * 0.5;
    let passes = |joint: &SettledJoint| {
        let arm = point - joint.point_M;
        (arm - joint.axis_M * arm.dot(&joint.axis_M)).norm()
    };
    let away = joints.iter().map(passes).fold(0.0, f64::max);
    // What is not a number meets nowhere.
    if !(joints.iter().all(|joint| passes(joint).is_finite()) && away <= PASSING * size) {
        let names = listed(joints.iter().map(|joint| joint.name.as_str()));
        return Err(format!(
            "the hinges {names} pass each other {:.1} mm apart and do not meet in one point",
            1e3 * away
        ));
    }
    Ok((point, Some(away).filter(|away| *away > EXACTNESS * size)))
}
