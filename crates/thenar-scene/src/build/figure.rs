//! Figures: flesh on any tree of bones.

use super::drivers::{Driver, Follow, PoseTrack};
use super::figure_motors::{motors, trains};
use super::hand::apply_material;
use super::joint::kind;
use super::motor::Motor;
use super::soft::{group_elements, skinning};
use super::solver::set;
use super::{Built, Files, Mesh, RigidAppearance, SoftBuild, Train, assets, place};
use crate::format::{BonesWord, Figure, FigureJoint, FigureJointsFile, FigureKey, RootWord, Scene};
use crate::math::Pose;
use crate::text::{Fault, Located, Node, SceneError, nearest, parse};
use std::path::Path;
use thenar_core::kinematics::{Tree, joint_rotation};
use thenar_core::model::{
    AngleLimit, CouplingKind, HandHandle, HandModel, HandPlacement, JointKind, Motion,
};
use thenar_core::world::JointTarget;
use thenar_rig::RigError;
use thenar_rig::figure::{
    FigureOptions, JointChange, Mimic, Plan, SHIPPED, build_figure, change_joints, change_plan,
    read_plan, read_plan_of, shipped_plan, usual_coupling_stiffness,
};
use thenar_rig::mesh::read_file;
use thenar_rig::model_file::read_figure;

/// A figure in the world.
#[derive(Clone, Debug)]
pub struct BuiltFigure {
    /// Name in the scene.
    pub name: String,
    /// The model it was made from.
    pub model: HandModel,
    /// Joints of it that mimic others.
    pub mimics: Vec<Mimic>,
    /// Indices of its parts in the world.
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
    let (mut model, mimics) = if is_built { read(figure, files)? } else { made(figure, files)? };
    if is_built {
        built.memory.take_tets(model.flesh.tets.len() as u64, at)?;
    }
    apply_material(&mut model.flesh, figure.material.as_ref(), false)?;
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
        built.looks.push(RigidAppearance {
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
        mimics,
        handle,
        coupling_stiffness: stiffness,
        start: None,
    });
    Ok(())
}

/// A figure built from a file of bones.
fn made(figure: &Figure, files: &Files) -> Result<(HandModel, Vec<Mimic>), Fault> {
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
    let mut plan = plan(figure, files)?;
    for joint in &figure.joint {
        let changed = change_plan(&mut plan, &[change(&joint.value)]);
        changed.map_err(|e| joint.fault(e.to_string()))?;
    }
    build_figure(plan, &options).map(|(model, report)| (model, report.mimics)).map_err(wrong)
}

/// Plan of the figure's file, or of one that comes with the program.
fn plan(figure: &Figure, files: &Files) -> Result<Plan, Fault> {
    let wrong = |e: RigError| figure.model.fault(e.to_string());
    let name = &figure.model.value;
    if let Some(plan) = shipped_plan(name) {
        return match &figure.mesh {
            Some(mesh) => {
                Err(mesh.fault("this figure has no meshes to choose from: leave `mesh` out"))
            }
            None => plan.map_err(wrong),
        };
    }
    if !name.contains(['.', '/']) {
        return Err(unknown(figure));
    }
    let path = assets::path(files, &figure.model);
    let Some(mesh) = &figure.mesh else { return read_plan(&path).map_err(wrong) };
    assets::check_meshes(Some(mesh), &read_file(&path).map_err(wrong)?)?;
    read_plan_of(&path, &mesh.value.0).map_err(|e| mesh.fault(e.to_string()))
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
fn read(figure: &Figure, files: &Files) -> Result<(HandModel, Vec<Mimic>), Fault> {
    let already =
        "a model file is built already: leave this out, or give the file that it was built from";
    if let Some(flesh) = &figure.flesh {
        return Err(flesh.fault(already));
    }
    if let Some(mesh) = &figure.mesh {
        return Err(mesh.fault(already));
    }
    if let Some(scale) = &figure.scale {
        return Err(scale.fault(already));
    }
    if let Some(tets) = &figure.tets {
        return Err(tets.fault(already));
    }
    let path = assets::path(files, &figure.model);
    let (mut model, mimics) = read_figure(&path).map_err(|e| figure.model.fault(e.to_string()))?;
    for joint in &figure.joint {
        if let Some(kind) = &joint.value.kind {
            return Err(kind.fault(already));
        }
        change_joints(&mut model, &change(&joint.value)).map_err(|e| joint.fault(e.to_string()))?;
    }
    Ok((model, mimics))
}

/// Changes to joints from a file of `[[joint]]` tables, which are those of a scene's
/// `[[figure.joint]]`.
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
        let trains = trains(built, f, &motors);
        start(built, f, &motors, &trains);
        built.motors.extend(motors);
        built.trains.extend(trains);
    }
    Ok(())
}

fn check_keys(figure: &Figure) -> Result<(), Fault> {
    let late = figure.key.windows(2).find(|pair| pair[1].value.time - pair[0].value.time < 1e-9);
    if let Some([_, key]) = late {
        return Err(key.fault("expected a later `time` than that of the key before"));
    }
    let placed =
        |key: &&Located<FigureKey>| key.value.position.is_some() || key.value.rotation.is_some();
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
    let track = PoseTrack::Keys { keys, interpolation: figure.interpolation };
    built.drivers.push(Driver { rigid: root, follow: Follow::Exactly, track });
    Ok(())
}

/// Puts bones and flesh where script and motors begin.
fn start(built: &mut Built, f: usize, motors: &[Motor], trains: &[Train]) {
    let BuiltFigure { model, handle, .. } = &built.figures[f];
    let Ok(tree) = Tree::of_hand(model) else { return };
    let root = handle.bones.start as usize;
    let driver = built.drivers.iter().find(|driver| driver.rigid as usize == root);
    let root_pose = driver.map_or(built.world.rigids[root].pose_WB, |d| d.track.at(0.0).0);
    let mut wanted: Vec<Option<JointTarget>> = vec![None; model.joints.len()];
    for motor in motors {
        wanted[(motor.joint - handle.joints.start) as usize] = Some(motor.wanted(0.0));
    }
    for (joint, axis, angle) in trains.iter().flat_map(Train::starts) {
        let target = &mut wanted[(joint - handle.joints.start) as usize];
        target.get_or_insert_default().angles[axis] = angle;
    }
    let mut poses_JK = vec![Pose::identity(); model.joints.len()];
    for (j, wanted) in wanted.into_iter().enumerate() {
        let Some(wanted) = wanted else { continue };
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
