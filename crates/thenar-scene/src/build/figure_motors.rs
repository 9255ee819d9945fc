//! Motors of a figure.

use super::figure::BuiltFigure;
use super::motor::{JointTrack, Motor};
use super::{Built, PoseTrack, Train};
use crate::format::{AnglesDeg, Figure};
use crate::math::{Pose, Quat, Vec3};
use crate::text::{Fault, Located};
use thenar_core::model::{HandModel, JointDesc, JointKind};
use thenar_rig::figure::Mimic;

/// Keys of each joint of a figure: times \[s\] and angles \[rad\].
type Keys = Vec<Vec<(f64, Vec<f64>)>>;

/// Motors of the joints that keys name, that others mimic, or whose torque is bounded.
pub fn motors(built: &Built, f: usize, figure: &Figure) -> Result<Vec<Motor>, Fault> {
    let BuiltFigure { model, mimics, handle, .. } = &built.figures[f];
    let mut motors = Vec::new();
    for (j, keys) in keys(model, mimics, figure)?.into_iter().enumerate() {
        let joint = &model.joints[j];
        let in_train = [0, 1].map(|k| mimics.iter().any(|m| m.ends().contains(&(j as u32, k))));
        let leads = mimics.iter().any(|mimic| mimic.leader as usize == j);
        let torque_max = torque_max(figure, &joint.name, &model.bones[joint.child as usize].name);
        let led = !keys.is_empty() || torque_max.is_some();
        if follows(mimics, joint.kind, j) || !(led || leads) {
            continue;
        }
        let springs = if joint.kind == JointKind::Ball { 1 } else { joint.kind.angles() };
        let limp = (0..springs).find(|&k| joint.axes[k].stiffness == 0.0 && (led || in_train[k]));
        if limp.is_some() {
            let what = if led { "a motor (keys, or `torque_max`)" } else { "joints that mimic it" };
            return Err(figure.name.fault(format!(
                "joint \"{}\" has {what} and no spring: give it `stiffness` in a `joint` table",
                joint.name
            )));
        }
        let rest = joint.axes.map(|axis| axis.rest_angle);
        let joint_track = joint_track(joint.kind, &keys, rest, figure);
        motors.push(Motor {
            joint: handle.joints.start + j as u32,
            joint_track,
            torque_max,
            in_train,
        });
    }
    Ok(motors)
}

/// True when every axis of a joint mimics one of another, so that keys have no say.
fn follows(mimics: &[Mimic], kind: JointKind, j: usize) -> bool {
    let mimicked = |k: usize| mimics.iter().any(|m| m.ends()[1] == (j as u32, k as u8));
    kind != JointKind::Ball && kind.angles() > 0 && (0..kind.angles()).all(mimicked)
}

fn keys(model: &HandModel, mimics: &[Mimic], figure: &Figure) -> Result<Keys, Fault> {
    let mut of_joint: Keys = vec![Vec::new(); model.joints.len()];
    for key in &figure.key {
        // The more a name says the more it counts: names with a `*` come first, shorter before
        // longer ones.
        let mut named: Vec<_> = key.value.joints.iter().collect();
        named.sort_by_key(|(name, _)| (!name.ends_with('*'), name.len()));
        for (name, angles) in named {
            for j in joints_like(model, name, angles)? {
                let joint = &model.joints[j];
                if follows(mimics, joint.kind, j) {
                    if name.ends_with('*') {
                        continue;
                    }
                    return Err(angles.fault(mimics_another(model, mimics, j)));
                }
                check_angles(joint, angles)?;
                let radians = angles.value.0.iter().map(|a| a.to_radians()).collect();
                match of_joint[j].last_mut() {
                    Some(last) if last.0 == key.value.time => last.1 = radians,
                    _ => of_joint[j].push((key.value.time, radians)),
                }
            }
        }
    }
    Ok(of_joint)
}

fn mimics_another(model: &HandModel, mimics: &[Mimic], j: usize) -> String {
    let leader = mimics.iter().find(|mimic| mimic.joint as usize == j).map(|m| m.leader as usize);
    let name = |j: usize| model.joints[j].name.as_str();
    let leader = leader.map_or("", name);
    format!("\"{}\" mimics \"{leader}\": give keys to that alone", name(j))
}

/// Trains of the motors whose axes others mimic; the world's joints get the springs of these.
pub fn trains(built: &mut Built, f: usize, motors: &[Motor]) -> Vec<Train> {
    let BuiltFigure { mimics, handle, .. } = &built.figures[f];
    let first = handle.joints.start;
    let is_first = |end: (u32, u8)| {
        let follows = mimics.iter().any(|mimic| mimic.ends()[1] == end);
        !follows && mimics.iter().any(|mimic| mimic.ends()[0] == end)
    };
    let mut trains = Vec::new();
    for motor in motors {
        for k in 0..2 {
            let leader = (motor.joint - first, k);
            if is_first(leader) {
                let (laws, k) = (laws_from(mimics, leader), usize::from(k));
                let joints = &mut built.world.joints;
                trains.push(Train::new(motor.clone(), k, laws, first, joints));
            }
        }
    }
    trains
}

/// For each axis that follows this one, directly or not, the laws on the way. What follows is a
/// tree.
fn laws_from(mimics: &[Mimic], leader: (u32, u8)) -> Vec<Vec<Mimic>> {
    let mut found: Vec<Vec<Mimic>> = Vec::new();
    let mut open: Vec<(Vec<Mimic>, (u32, u8))> = vec![(Vec::new(), leader)];
    while let Some((laws, end)) = open.pop() {
        for mimic in mimics.iter().filter(|mimic| mimic.ends()[0] == end) {
            let laws = [&laws[..], &[*mimic]].concat();
            open.push((laws.clone(), mimic.ends()[1]));
            found.push(laws);
        }
    }
    found
}

/// Course on which keys lead a joint; without any it stays where its spring is relaxed.
fn joint_track(
    kind: JointKind,
    keys: &[(f64, Vec<f64>)],
    rest: [f64; 2],
    figure: &Figure,
) -> JointTrack {
    let interpolation = figure.interpolation;
    let at = |angles: &[f64], k: usize| angles.get(k).copied().unwrap_or(0.0);
    if kind == JointKind::Ball {
        let vector = |a: &[f64]| Vec3::new(at(a, 0), at(a, 1), at(a, 2));
        let turned = |a: &[f64]| Pose::new(Vec3::zeros(), Quat::from_scaled_axis(vector(a)));
        let mut keys: Vec<(f64, Pose)> = keys.iter().map(|(t, a)| (*t, turned(a))).collect();
        if keys.is_empty() {
            keys.push((0.0, Pose::identity()));
        }
        return JointTrack::Rotation(PoseTrack::Keys { keys, interpolation });
    }
    let mut keys: Vec<(f64, [f64; 2])> =
        keys.iter().map(|(t, a)| (*t, [at(a, 0), at(a, 1)])).collect();
    if keys.is_empty() {
        keys.push((0.0, rest));
    }
    JointTrack::Angles { keys, interpolation }
}

fn fits(pattern: &str, name: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(start) => name.starts_with(start),
        None => name == pattern,
    }
}

/// Joints that a name fits, by their own name or that of their bone.
fn joints_like<T>(model: &HandModel, name: &str, at: &Located<T>) -> Result<Vec<usize>, Fault> {
    let joints = model.joints.iter().enumerate();
    let found: Vec<usize> = joints
        .filter(|(_, j)| fits(name, &j.name) || fits(name, &model.bones[j.child as usize].name))
        .map(|(j, _)| j)
        .collect();
    match found.is_empty() {
        false => Ok(found),
        true => {
            let known: Vec<&str> = model.joints.iter().map(|j| &j.name[..]).collect();
            let problem =
                format!("the figure has no joint \"{name}\"; it has {}", known.join(", "));
            Err(at.fault(problem))
        }
    }
}

/// Checks that there are as many angles as the joint has, within its range.
fn check_angles(joint: &JointDesc, angles: &Located<AnglesDeg>) -> Result<(), Fault> {
    let JointDesc { name, kind, .. } = joint;
    let wanted = if *kind == JointKind::Ball { 3 } else { kind.angles() };
    let got = angles.value.0.len();
    if got != wanted || wanted == 0 {
        return Err(angles
            .fault(format!("\"{name}\" is a {kind:?} joint and has {wanted} angles, got {got}")));
    }
    for (axis, angle) in joint.axes.iter().zip(&angles.value.0) {
        let Some(range) = axis.limit.filter(|_| *kind != JointKind::Ball) else { continue };
        let [low, high] = [range.min, range.max].map(f64::to_degrees);
        // What was written in degrees and turned to radians may be off by round-off.
        if *angle < low - 1e-9 || *angle > high + 1e-9 {
            return Err(angles.fault(format!(
                "\"{name}\" turns from {low:.1} to {high:.1} degrees, got {angle}"
            )));
        }
    }
    Ok(())
}

/// The largest torque that the last fitting table gives a joint.
fn torque_max(figure: &Figure, joint: &str, bone: &str) -> Option<f64> {
    let tables = figure.joint.iter().map(|table| &table.value).rev();
    let fitting = tables.filter(|t| fits(&t.name.value, joint) || fits(&t.name.value, bone));
    fitting.filter_map(|table| table.torque_max).next()
}
