//! Joints: frames from anchors and axes, and bodies placed by start angles and rates.

use super::{Built, place};
use crate::format::{Joint, JointWord, Scene};
use crate::math::{Pose, Quat, Vec3};
use crate::text::{Fault, Located};
use thenar_core::kinematics::{joint_rotation, joint_spin};
use thenar_core::model::{AngleLimit, Axis, JointDesc, JointKind};

/// A joint that places its child.
struct Link {
    parent: Option<u32>,
    child: u32,
    pose_PJ: Pose,
    pose_CK: Pose,
    rotation_JK: Quat,
    /// Angular velocity of the child against the parent, in J, when the scene gives rates.
    spin_J: Option<Vec3>,
}

/// Adds all joints and moves the bodies that start angles and rates move.
pub fn add_all(built: &mut Built, scene: &Scene) -> Result<(), Fault> {
    let mut links: Vec<Link> = Vec::new();
    for joint in &scene.joint {
        let (desc, link) = describe(built, joint)?;
        let index = built.world.joints.len() as u32;
        built.names.add_joint(&joint.name, index)?;
        check_placing(scene, joint, &link, &links)?;
        built.world.joints.push(desc);
        links.push(link);
    }
    place_children(built, &links);
    Ok(())
}

fn describe(built: &Built, joint: &Joint) -> Result<(JointDesc, Link), Fault> {
    let child = built.names.rigid(&joint.child)?;
    let parent = joint.parent.as_ref().filter(|p| p.value != "world");
    let parent = parent.map(|p| built.names.rigid(p)).transpose()?;
    if parent == Some(child) {
        return Err(joint.child.fault("the child and the parent are the same body"));
    }
    let pose = |i: u32| built.world.rigids[i as usize].pose_WB;
    let pose_WP = parent.map_or(Pose::identity(), pose);
    let (pose_PJ, pose_CK) = frames(joint, &pose_WP, &pose(child))?;
    let kind = kind(joint.kind);
    let angles = per_axis(&joint.angles, kind, "angle")?;
    let rates = per_axis(&joint.rates, kind, "rate")?;
    let (rotation_JK, spin_J) = start(joint, kind, angles, rates)?;
    let desc = JointDesc {
        name: joint.name.value.clone(),
        kind,
        parent,
        child,
        pose_PJ,
        pose_CK,
        axes: axes(joint, kind)?,
        limit_stiffness: joint.limit_stiffness,
        limit_damping: joint.limit_damping,
    };
    Ok((desc, Link { parent, child, pose_PJ, pose_CK, rotation_JK, spin_J }))
}

pub(super) fn kind(word: JointWord) -> JointKind {
    match word {
        JointWord::Fixed => JointKind::Fixed,
        JointWord::Hinge => JointKind::Hinge,
        JointWord::Universal => JointKind::Universal,
        JointWord::Ball => JointKind::Ball,
        JointWord::Free => JointKind::Free,
    }
}

/// The joint's frame in parent and child.
fn frames(joint: &Joint, pose_WP: &Pose, pose_WC: &Pose) -> Result<(Pose, Pose), Fault> {
    let in_world = joint.anchor.is_some() || joint.axis.is_some() || joint.axes.is_some();
    match (&joint.parent_frame, &joint.child_frame) {
        (Some(p), Some(c)) if !in_world => Ok((place::frame(Some(p))?, place::frame(Some(c))?)),
        (None, None) => {
            let pose_WJ = world_frame(joint, pose_WC)?;
            Ok((pose_WP.inverse() * pose_WJ, pose_WC.inverse() * pose_WJ))
        }
        _ => Err(joint.name.fault(
            "give either `anchor` with `axis` or `axes`, or both `parent_frame` and `child_frame`",
        )),
    }
}

/// The joint's frame in the world at zero angles.
fn world_frame(joint: &Joint, pose_WC: &Pose) -> Result<Pose, Fault> {
    let anchor = match (joint.anchor, joint.kind) {
        (Some(anchor), _) => anchor,
        (None, JointWord::Fixed | JointWord::Free) => pose_WC.position,
        (None, _) => return Err(joint.name.fault("the key `anchor` is missing")),
    };
    let unit = |v: &Vec3, at: &dyn Fn(String) -> Fault| {
        place::direction(v).ok_or_else(|| at("expected an axis that is not zero".into()))
    };
    let rotation = match (joint.kind, &joint.axis, &joint.axes) {
        (JointWord::Hinge, Some(axis), None) => {
            let x = unit(&axis.value, &|p| axis.fault(p))?;
            let (y, z) = thenar_core::math::tangents(&x);
            place::from_axes(x, y, z)
        }
        (JointWord::Universal, None, Some(axes)) => {
            // J turns about the parent's y, then the child's x.
            let y = unit(&axes.value[0], &|p| axes.fault(p))?;
            let x = unit(&axes.value[1], &|p| axes.fault(p))?;
            if x.dot(&y).abs() > 1e-6 {
                return Err(axes.fault("expected two axes at right angles to each other"));
            }
            let x = (x - y * x.dot(&y)).normalize();
            place::from_axes(x, y, x.cross(&y))
        }
        (JointWord::Hinge, _, _) => return Err(joint.name.fault("a hinge needs `axis`")),
        (JointWord::Universal, _, _) => {
            return Err(joint.name.fault("a universal joint needs `axes`"));
        }
        (_, None, None) => Quat::identity(),
        _ => {
            return Err(joint
                .name
                .fault("only a hinge has `axis`, and only a universal joint `axes`"));
        }
    };
    Ok(Pose::new(anchor, rotation))
}

/// One number for each angle of the joint; nothing given is zero.
fn per_axis(list: &Located<Vec<f64>>, kind: JointKind, what: &str) -> Result<[f64; 2], Fault> {
    check_count(list, kind.angles(), kind, what)?;
    let at = |k: usize| list.value.get(k).copied().unwrap_or(0.0);
    Ok([at(0), at(1)])
}

fn check_count<T>(
    list: &Located<Vec<T>>,
    count: usize,
    kind: JointKind,
    what: &str,
) -> Result<(), Fault> {
    let got = list.value.len();
    match got == count || got == 0 {
        true => Ok(()),
        false => Err(list.fault(format!(
            "expected {count} values, one for each {what} of a {kind:?} joint, got {got}"
        ))),
    }
}

/// Start rotation and spin of child against parent.
fn start(
    joint: &Joint,
    kind: JointKind,
    angles: [f64; 2],
    rates: [f64; 2],
) -> Result<(Quat, Option<Vec3>), Fault> {
    let only_ball = |fault: Fault| if kind == JointKind::Ball { Ok(()) } else { Err(fault) };
    if let Some(rotation) = &joint.rotation {
        only_ball(rotation.fault("only a ball joint has `rotation`; others have `angles`"))?;
        let spin = joint.angular_velocity.as_ref().map(|w| w.value);
        return Ok((place::rotation(Some(rotation))?, spin));
    }
    if let Some(w) = &joint.angular_velocity {
        only_ball(w.fault("only a ball joint has `angular_velocity`; others have `rates`"))?;
        return Ok((Quat::identity(), Some(w.value)));
    }
    let spin = (!joint.rates.value.is_empty()).then(|| joint_spin(kind, angles, rates));
    Ok((joint_rotation(kind, angles), spin))
}

/// Springs, dampers and limits about the axes.
fn axes(joint: &Joint, kind: JointKind) -> Result<[Axis; 2], Fault> {
    let springs = if kind == JointKind::Ball { 1 } else { kind.angles() };
    check_count(&joint.stiffness, springs, kind, "spring")?;
    check_count(&joint.damping, springs, kind, "damper")?;
    check_count(&joint.rest_angles, kind.angles(), kind, "angle")?;
    check_count(&joint.limits, kind.angles(), kind, "angle")?;
    if let Some([min, max]) = joint.limits.value.iter().find(|[min, max]| min > max) {
        return Err(joint
            .limits
            .fault(format!("expected [smallest, largest], got [{min}, {max}]")));
    }
    let value = |list: &[f64], k: usize| list.get(k).copied().unwrap_or(0.0);
    Ok([0, 1].map(|k| Axis {
        limit: joint.limits.value.get(k).map(|[min, max]| AngleLimit { min: *min, max: *max }),
        stiffness: value(&joint.stiffness.value, k),
        rest_angle: value(&joint.rest_angles.value, k),
        damping: value(&joint.damping.value, k),
    }))
}

/// Refuses what cannot be placed, or is placed twice.
fn check_placing(scene: &Scene, joint: &Joint, link: &Link, before: &[Link]) -> Result<(), Fault> {
    let moved = !joint.angles.value.is_empty()
        || !joint.rates.value.is_empty()
        || joint.rotation.is_some()
        || joint.angular_velocity.is_some()
        || joint.parent_frame.is_some();
    if !moved {
        return Ok(());
    }
    let child = &joint.child.value;
    let Some(body) = scene.rigid.iter().find(|r| r.name.value == *child) else {
        return Err(joint.child.fault("a bone of a hand cannot be placed by a joint"));
    };
    if before.iter().any(|l| l.child == link.child) {
        return Err(joint.name.fault(format!("\"{child}\" is already placed by another joint")));
    }
    if joint.parent_frame.is_some()
        && let Some(own) = body
            .position
            .as_ref()
            .map(|p| p.fault(""))
            .or(body.rotation.as_ref().map(|r| r.fault("")))
    {
        let problem = format!(
            "joint \"{}\" places this body by its frames: leave this out",
            joint.name.value
        );
        return Err(Fault { problem, ..own });
    }
    if link.spin_J.is_some()
        && (body.velocity != Vec3::zeros() || body.angular_velocity != Vec3::zeros())
    {
        return Err(joint
            .name
            .fault(format!("both the joint's rates and \"{child}\" itself give a velocity")));
    }
    Ok(())
}

/// Places children after their parents. A body is moved by the first joint of which it is the
/// child; its velocity follows where rates are given, or are given further up.
fn place_children(built: &mut Built, links: &[Link]) {
    let count = built.world.rigids.len();
    let mut placed_by: Vec<Option<usize>> = vec![None; count];
    for (l, link) in links.iter().enumerate().rev() {
        placed_by[link.child as usize] = Some(l);
    }
    let mut done: Vec<bool> = placed_by.iter().map(Option::is_none).collect();
    let mut swung = vec![false; count];
    loop {
        let next = links.iter().enumerate().find(|(l, link)| {
            placed_by[link.child as usize] == Some(*l)
                && !done[link.child as usize]
                && link.parent.is_none_or(|p| done[p as usize])
        });
        let Some((_, link)) = next else { return };
        let parent_swings = link.parent.is_some_and(|p| swung[p as usize]);
        place_child(built, link, parent_swings);
        swung[link.child as usize] = parent_swings || link.spin_J.is_some();
        done[link.child as usize] = true;
    }
}

fn place_child(built: &mut Built, link: &Link, parent_swings: bool) {
    let rigids = &mut built.world.rigids;
    let still = (Pose::identity(), Vec3::zeros(), Vec3::zeros());
    let (pose_WP, v_P, w_P) = link.parent.map_or(still, |p| {
        let parent = &rigids[p as usize];
        (parent.pose_WB, parent.velocity_W, parent.angular_velocity_W)
    });
    let pose_WJ = pose_WP * link.pose_PJ;
    let pose_WK = pose_WJ * Pose::new(Vec3::zeros(), link.rotation_JK);
    let child = &mut rigids[link.child as usize];
    child.pose_WB = pose_WK * link.pose_CK.inverse();
    if link.spin_J.is_some() || parent_swings {
        let w = w_P + pose_WJ.rotation * link.spin_J.unwrap_or_else(Vec3::zeros);
        let anchor = pose_WJ.position;
        child.angular_velocity_W = w;
        child.velocity_W = v_P
            + w_P.cross(&(anchor - pose_WP.position))
            + w.cross(&(child.pose_WB.position - anchor));
    }
}
