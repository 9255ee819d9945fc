//! Figures: flesh on any tree of bones.

use super::drivers::{Driver, Follow, Track};
use super::hand::soften;
use super::joint::kind;
use super::motor::{Course, Motor};
use super::soft::{group_elements, skinning};
use super::solver::set;
use super::{Built, Files, Mesh, RigidLook, SoftBuild, assets, place};
use crate::format::{BonesWord, Figure, FigureJoint, FigureJointsFile, FigureKey, RootWord, Scene};
use crate::math::{Pose, Quat, Vec3};
use crate::text::{At, Fault, Node, SceneError, nearest, parse};
use std::path::Path;
use thenar_core::kinematics::{Tree, joint_rotation};
use thenar_core::model::{
    AngleLimit, CouplingKind, HandHandle, HandModel, HandPlacement, JointDesc, JointKind, Motion,
};
use thenar_rig::figure::{
    FigureOptions, JointChange, SHIPPED, build_figure, change_joints, change_plan, read_plan,
    shipped_plan, usual_coupling_stiffness,
};
use thenar_rig::{Model, RigError, read_model};

/// A figure in the world.
#[derive(Clone, Debug)]
pub struct BuiltFigure {
    /// Name in the scene.
    pub name: String,
    /// The model it was made from.
    pub model: HandModel,
    /// Where its parts are.
    pub handle: HandHandle,
    /// Springs between flesh and bones, per volume of bone \[N/m⁴\].
    pub coupling_stiffness: f64,
    /// Poses `pose_WB` in which its bones start, where these are not those of the rest pose.
    pub start: Option<Vec<Pose>>,
}

/// Largest file of joints \[bytes\].
const JOINTS_BYTES_MAX: u64 = 1 << 20;
/// Tetrahedra wanted when nothing is said.
const TETS: u32 = 1000;

/// Tetrahedra that a figure will have, about; of one that is built already that is not known.
pub fn tets_wanted(figure: &Figure) -> u64 {
    u64::from(figure.tets.as_ref().map_or(TETS, |tets| tets.value))
}

/// Adds all figures.
pub fn add_all(built: &mut Built, scene: &Scene, files: &Files) -> Result<(), Fault> {
    scene.figure.iter().try_for_each(|figure| add(built, figure, files))
}

fn add(built: &mut Built, figure: &Figure, files: &Files) -> Result<(), Fault> {
    let at = |problem| figure.name.fault(problem);
    let is_built = figure.model.value.ends_with(".thenar");
    if !is_built {
        built.memory.take_tets(tets_wanted(figure), at)?;
    }
    let mut model = if is_built { read(figure, files)? } else { made(figure, files)? };
    if is_built {
        built.memory.take_tets(model.flesh.tets.len() as u64, at)?;
    }
    soften(&mut model.flesh, figure.material.as_ref(), false)?;
    built.memory.take_relaxation(&model.flesh.relaxation, at)?;
    set(&mut model.flesh.friction, figure.friction);
    let stiffness = figure.coupling_stiffness.unwrap_or_else(|| usual_coupling_stiffness(&model));
    let placement = HandPlacement {
        name: figure.name.value.clone(),
        pose_WM: Pose::new(figure.position, place::rotation(figure.rotation.as_ref())?),
        coupling: CouplingKind::Bone,
        coupling_stiffness: stiffness,
        coupling_damping_time: figure.coupling_damping_time,
        skinning: skinning(figure.skinning),
        root_drive: None,
        bone_drive: None,
        solid_bones: figure.bones == BonesWord::Solid,
        nails: false,
    };
    let handle = built.world.add_hand(&model, &placement);
    let soft = handle.soft;
    if !figure.self_contact {
        built.world.self_contact.retain(|&other| other != soft);
    }
    if figure.root != RootWord::Free {
        built.world.rigids[handle.bones.start as usize].motion = Motion::Prescribed;
    }
    group_elements(&mut built.world, soft, figure.elements);
    built.names.add_soft(&figure.name, soft)?;
    for i in handle.bones.clone() {
        let name = built.world.rigids[i as usize].name.clone();
        built.names.add_bone(&name, i);
        // Bones lie in the flesh, which is drawn.
        built.looks.push(RigidLook {
            colour: figure.colour,
            mesh: None,
            pose_MB: Pose::identity(),
        });
    }
    for j in handle.joints.clone() {
        let name = built.world.joints[j as usize].name.clone();
        built.names.add_joint_of(&name, j);
    }
    built.meshes.push(Mesh::new(&model.flesh.nodes, &model.flesh.tets));
    built.node_starts.push(None);
    let render = model.render.clone();
    built.softs.push(SoftBuild { soft, render, colour: figure.colour });
    built.figures.push(BuiltFigure {
        name: figure.name.value.clone(),
        model,
        handle,
        coupling_stiffness: stiffness,
        start: None,
    });
    Ok(())
}

/// A figure built from a file of bones.
fn made(figure: &Figure, files: &Files) -> Result<HandModel, Fault> {
    for joint in figure.joint.iter().filter(|joint| joint.value.kind.is_none()) {
        if !joint.value.axes.is_empty() {
            return Err(joint.fault("`axes` go with a `kind`: \"hinge\" or \"universal\""));
        }
    }
    let options = FigureOptions {
        name: figure.name.value.clone(),
        scale: figure.scale.as_ref().map_or(1.0, |scale| scale.value),
        thickness: figure.flesh.as_ref().map(|flesh| flesh.value),
        tets: tets_wanted(figure) as usize,
        ..FigureOptions::default()
    };
    let wrong = |e: RigError| figure.model.fault(e.to_string());
    let mut plan = match shipped_plan(&figure.model.value) {
        Some(plan) => plan.map_err(wrong)?,
        None if !figure.model.value.contains(['.', '/']) => return Err(unknown(figure)),
        None => read_plan(&assets::path(files, &figure.model)).map_err(wrong)?,
    };
    for joint in &figure.joint {
        let changed = change_plan(&mut plan, &[change(&joint.value)]);
        changed.map_err(|e| joint.fault(e.to_string()))?;
    }
    build_figure(plan, &options).map(|(model, _)| model).map_err(wrong)
}

/// A name that is no file's.
fn unknown(figure: &Figure) -> Fault {
    let name = &figure.model.value;
    let hint = nearest(name, SHIPPED)
        .map_or_else(String::new, |near| format!("; did you mean \"{near}\"?"));
    let known = SHIPPED.join(", ");
    figure.model.fault(format!(
        "no figure \"{name}\" comes with the program ({known} do), and it is no .glb, .vrm, .urdf, .xml, .mjcf or \
         .thenar file{hint}"
    ))
}

/// A figure that was built before.
fn read(figure: &Figure, files: &Files) -> Result<HandModel, Fault> {
    let already =
        "a model file is built already: leave this out, or give the file that it was built from";
    if let Some(flesh) = &figure.flesh {
        return Err(flesh.fault(already));
    }
    if let Some(scale) = &figure.scale {
        return Err(scale.fault(already));
    }
    if let Some(tets) = &figure.tets {
        return Err(tets.fault(already));
    }
    let path = assets::path(files, &figure.model);
    let fault = |problem: String| figure.model.fault(problem);
    let mut model = match read_model(&path) {
        Ok(Model::Hand(model)) => model,
        Ok(_) => return Err(fault(format!("{} holds no figure", path.display()))),
        Err(e) => return Err(fault(e.to_string())),
    };
    for joint in &figure.joint {
        if let Some(kind) = &joint.value.kind {
            return Err(kind.fault(already));
        }
        change_joints(&mut model, &change(&joint.value)).map_err(|e| joint.fault(e.to_string()))?;
    }
    Ok(model)
}

/// Changes to joints from a file of `[[joint]]` tables, which are those of a scene's `[[figure.joint]]`.
///
/// # Errors
/// The file cannot be read, or something in it is wrong; says what and where.
pub fn figure_joints(file: &Path) -> Result<Vec<JointChange>, SceneError> {
    let text = thenar_input::read_text(file, JOINTS_BYTES_MAX)
        .map_err(|e| SceneError::File { file: file.to_path_buf(), problem: e.to_string() })?;
    let read = Node::parse(&text).and_then(|root| parse::<FigureJointsFile>(&root));
    let tables = read.map_err(|fault| fault.locate(file, &text, &[]))?;
    Ok(tables.joint.iter().map(change).collect())
}

fn change(joint: &FigureJoint) -> JointChange {
    let range =
        |[low, high]: &[f64; 2]| AngleLimit { min: low.to_radians(), max: high.to_radians() };
    JointChange {
        name: joint.name.value.clone(),
        kind: joint.kind.as_ref().map(|word| (kind(word.value), joint.axes.clone())),
        ranges: joint.range_deg.iter().map(range).collect(),
        stiffness: joint.stiffness.clone(),
        damping: joint.damping.clone(),
    }
}

/// Gives figures their motors and scripts, and puts them where these begin.
pub fn follow_all(built: &mut Built, scene: &Scene) -> Result<(), Fault> {
    for (f, figure) in scene.figure.iter().enumerate() {
        check_keys(figure)?;
        follow_root(built, f, figure)?;
        let motors = motors(built, f, figure)?;
        start(built, f, &motors);
        built.motors.extend(motors);
    }
    Ok(())
}

fn check_keys(figure: &Figure) -> Result<(), Fault> {
    let late = figure.key.windows(2).find(|pair| pair[1].value.time - pair[0].value.time < 1e-9);
    if let Some([_, key]) = late {
        return Err(key.fault("expected a later `time` than that of the key before"));
    }
    let placed =
        |key: &&At<FigureKey>| key.value.position.is_some() || key.value.rotation.is_some();
    match figure.key.iter().find(placed) {
        Some(key) if figure.root != RootWord::Scripted => {
            Err(key.fault("only a scripted root is where keys say: set root = \"scripted\""))
        }
        _ => Ok(()),
    }
}

/// A scripted root is moved as scripted bodies are; a fixed one stays.
fn follow_root(built: &mut Built, f: usize, figure: &Figure) -> Result<(), Fault> {
    let root = built.figures[f].handle.bones.start;
    if figure.root != RootWord::Scripted {
        return Ok(());
    }
    let pose_MB = built.figures[f].model.bones[0].pose_MB;
    let mut before = Pose::new(figure.position, place::rotation(figure.rotation.as_ref())?);
    let mut keys: Vec<(f64, Pose)> = Vec::new();
    for key in &figure.key {
        let key = &key.value;
        let rotation = match &key.rotation {
            Some(_) => place::rotation(key.rotation.as_ref())?,
            None => before.rotation,
        };
        if key.position.is_some() || key.rotation.is_some() {
            before = Pose::new(key.position.unwrap_or(before.position), rotation);
            keys.push((key.time, before * pose_MB));
        }
    }
    // From where it is placed to the first of them.
    let placed = Pose::new(figure.position, place::rotation(figure.rotation.as_ref())?);
    if keys.first().is_none_or(|key| key.0 > 0.0) {
        keys.insert(0, (0.0, placed * pose_MB));
    }
    let track = Track::Keys { keys, interpolation: figure.interpolation };
    built.drivers.push(Driver { rigid: root, follow: Follow::Exactly, track });
    Ok(())
}

/// Motors of the joints that keys name, or whose torque is bounded.
fn motors(built: &Built, f: usize, figure: &Figure) -> Result<Vec<Motor>, Fault> {
    let BuiltFigure { model, handle, .. } = &built.figures[f];
    let mut of_joint: Vec<Vec<(f64, Vec<f64>)>> = vec![Vec::new(); model.joints.len()];
    for key in &figure.key {
        // The more a name says the more it counts: names with a `*` come first, shorter before longer ones.
        let mut named: Vec<_> = key.value.joints.iter().collect();
        named.sort_by_key(|(name, _)| (!name.ends_with('*'), name.len()));
        for (name, angles) in named {
            for j in joints_like(model, name, angles)? {
                let joint = &model.joints[j];
                check_angles(joint, angles)?;
                let radians = angles.value.0.iter().map(|a| a.to_radians()).collect();
                match of_joint[j].last_mut() {
                    Some(last) if last.0 == key.value.time => last.1 = radians,
                    _ => of_joint[j].push((key.value.time, radians)),
                }
            }
        }
    }
    let mut motors = Vec::new();
    for (j, keys) in of_joint.into_iter().enumerate() {
        let joint = &model.joints[j];
        let torque_max = torque_max(figure, &joint.name, &model.bones[joint.child as usize].name);
        if keys.is_empty() && torque_max.is_none() {
            continue;
        }
        let springs = if joint.kind == JointKind::Ball { 1 } else { joint.kind.angles() };
        if joint.axes[..springs].iter().any(|axis| axis.stiffness == 0.0) {
            return Err(figure.name.fault(format!(
                "joint \"{}\" has a motor (keys, or `torque_max`) and no spring: give it `stiffness` in a `joint` table",
                joint.name
            )));
        }
        let rest = joint.axes.map(|axis| axis.rest_angle);
        let course = course(joint.kind, &keys, rest, figure);
        motors.push(Motor { joint: handle.joints.start + j as u32, course, torque_max });
    }
    Ok(motors)
}

/// Where keys lead a joint; without any it stays where its spring is relaxed.
fn course(kind: JointKind, keys: &[(f64, Vec<f64>)], rest: [f64; 2], figure: &Figure) -> Course {
    let interpolation = figure.interpolation;
    let at = |angles: &[f64], k: usize| angles.get(k).copied().unwrap_or(0.0);
    if kind == JointKind::Ball {
        let vector = |a: &[f64]| Vec3::new(at(a, 0), at(a, 1), at(a, 2));
        let turned = |a: &[f64]| Pose::new(Vec3::zeros(), Quat::from_scaled_axis(vector(a)));
        let mut keys: Vec<(f64, Pose)> = keys.iter().map(|(t, a)| (*t, turned(a))).collect();
        if keys.is_empty() {
            keys.push((0.0, Pose::identity()));
        }
        return Course::Rotation(Track::Keys { keys, interpolation });
    }
    let mut keys: Vec<(f64, [f64; 2])> =
        keys.iter().map(|(t, a)| (*t, [at(a, 0), at(a, 1)])).collect();
    if keys.is_empty() {
        keys.push((0.0, rest));
    }
    Course::Angles { keys, interpolation }
}

fn fits(pattern: &str, name: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(start) => name.starts_with(start),
        None => name == pattern,
    }
}

/// Joints that a name fits, by their own name or that of their bone.
fn joints_like<T>(model: &HandModel, name: &str, at: &At<T>) -> Result<Vec<usize>, Fault> {
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

/// As many angles as the joint has, within its range.
fn check_angles(joint: &JointDesc, angles: &At<crate::format::AnglesDeg>) -> Result<(), Fault> {
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

/// Puts bones and flesh where script and motors begin.
fn start(built: &mut Built, f: usize, motors: &[Motor]) {
    let BuiltFigure { model, handle, .. } = &built.figures[f];
    let Ok(tree) = Tree::of_hand(model) else { return };
    let root = handle.bones.start as usize;
    let driver = built.drivers.iter().find(|driver| driver.rigid as usize == root);
    let root_pose = driver.map_or(built.world.rigids[root].pose_WB, |d| d.track.at(0.0).0);
    let mut poses_JK = vec![Pose::identity(); model.joints.len()];
    for motor in motors {
        let j = (motor.joint - handle.joints.start) as usize;
        let wanted = motor.wanted(0.0);
        poses_JK[j].rotation = match model.joints[j].kind {
            JointKind::Ball => wanted.rotation_JK,
            kind => joint_rotation(kind, tree.clamp(j, wanted.angles)),
        };
    }
    let still = poses_JK.iter().all(|pose| *pose == Pose::identity());
    if still && root_pose == built.world.rigids[root].pose_WB {
        return;
    }
    let mut poses = vec![Pose::identity(); model.bones.len()];
    tree.forward_joint_poses(&root_pose, &poses_JK, &mut poses);
    let moves: Vec<Pose> =
        poses.iter().zip(&model.bones).map(|(pose, bone)| *pose * bone.pose_MB.inverse()).collect();
    let nodes = model.flesh.nodes.iter().zip(&model.bindings).map(|(x, binding)| {
        let by = |k: usize| moves[binding.bones[k] as usize].point(x) * binding.weights[k];
        by(0) + by(1)
    });
    // The world itself is described at rest, from which flesh knows its place in the bones.
    built.node_starts[handle.soft as usize] = Some(nodes.collect());
    built.figures[f].start = Some(poses);
}
