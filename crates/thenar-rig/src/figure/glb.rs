//! The plan of a skinned mesh (glTF, VRM): its joints with the mesh's own skin. glTF knows no kinds
//! of joints: all are balls, until whoever builds the figure says otherwise.

use super::plan::{Plan, PlanBone, PlanJoint, PlanSkin};
use crate::RigError;
use crate::glb::{SkinnedMesh, SkinnedPart, read_skinned_glb_of};
use crate::object::size_in_words;
use std::collections::{HashMap, HashSet};
use thenar_core::Pose;
use thenar_core::model::{Axis, JointKind};
use thenar_input::quoted;

/// The plan of the skinned mesh of a GLB file that encloses most.
///
/// # Errors
/// When the file is damaged or holds no skinned mesh, or its joints are no single tree.
pub fn read_glb_plan(bytes: &[u8]) -> Result<Plan, RigError> {
    read_glb_plan_of(bytes, &[])
}

/// The plan of the skinned meshes of these names in a GLB file; without names, of the one that
/// encloses most.
///
/// # Errors
/// As [`read_glb_plan`]; also when a name is none of the file's, or meshes hang on skeletons
/// without common joints.
pub fn read_glb_plan_of(bytes: &[u8], names: &[String]) -> Result<Plan, RigError> {
    let rig = read_skinned_glb_of(bytes, names)?;
    let mut notes = told(&rig.parts, names);
    let carrying = carrying(&rig);
    let (kept, dropped): (Vec<usize>, Vec<usize>) =
        (0..rig.joints.len()).partition(|&j| carrying[j]);
    if !dropped.is_empty() {
        let names: Vec<&str> = dropped.iter().map(|&j| &rig.joints[j].name[..]).collect();
        notes.push(format!("joints that carry no skin are left out: {}", names.join(", ")));
    }
    let order = parents_first(&rig, &kept, &carrying)?;
    let mut new = vec![0; rig.joints.len()];
    (0..).zip(&order).for_each(|(i, &j)| new[j] = i);
    let bones = order.iter().map(|&j| {
        let parent = above(&rig, j, &carrying).map(|p| new[p]);
        bone(&rig.joints[j].name, rig.joints[j].pose, parent)
    });
    let bones = unique(bones.collect());
    let influences = rig.influences.iter().map(|four| four.map(|(j, w)| (new[j as usize], w)));
    let skin = PlanSkin {
        influences: influences.collect(),
        mesh: rig.mesh,
        joined: rig.parts.iter().filter(|part| part.chosen).count() > 1,
    };
    Ok(Plan { name: String::new(), bones, skin: Some(skin), mimics: Vec::new(), notes })
}

/// Sentences on which meshes the body is of, and which are left out; none where the file has one.
fn told(parts: &[SkinnedPart], names: &[String]) -> Vec<String> {
    if parts.len() < 2 {
        return Vec::new();
    }
    let listed = |chosen: bool| {
        let of = parts.iter().filter(move |part| part.chosen == chosen);
        let each = of.map(|part| format!("{} ({})", quoted(&part.name), size_in_words(&part.size)));
        each.collect::<Vec<_>>().join(", ")
    };
    let why = if names.is_empty() { ", the mesh that encloses most" } else { "" };
    let mut notes = vec![format!("body: {}{why}", listed(true))];
    if parts.iter().any(|part| !part.chosen) {
        let other = "`--mesh NAME` names another, given again it joins several";
        let help = if names.is_empty() { format!("; {other}") } else { String::new() };
        notes.push(format!("meshes left out: {}{help}", listed(false)));
    }
    notes.extend(parts.iter().filter_map(|part| {
        let (name, damage) = (quoted(&part.name), part.damage.as_ref()?);
        Some(format!("mesh {name} is damaged and cannot be the body: {damage}"))
    }));
    notes
}

fn bone(name: &str, pose_ML: Pose, parent: Option<u32>) -> PlanBone {
    let axes = [Axis::default(); 2];
    let joint = parent.map(|_| PlanJoint {
        name: name.to_owned(),
        kind: JointKind::Ball,
        pose_MJ: pose_ML,
        axes,
    });
    PlanBone { name: name.to_owned(), parent, pose_ML, joint, mass: None, solids: Vec::new() }
}

/// Names made unique by numbers.
fn unique(mut bones: Vec<PlanBone>) -> Vec<PlanBone> {
    let mut taken: HashSet<String> = bones.iter().map(|bone| bone.name.clone()).collect();
    let mut seen: HashMap<String, usize> = HashMap::new();
    for bone in &mut bones {
        let count = seen.entry(bone.name.clone()).or_insert(0);
        *count += 1;
        if *count == 1 {
            continue;
        }
        let mut name = format!("{}-{count}", bone.name);
        while !taken.insert(name.clone()) {
            *count += 1;
            name = format!("{}-{count}", bone.name);
        }
        bone.joint.iter_mut().for_each(|joint| joint.name.clone_from(&name));
        bone.name = name;
    }
    bones
}

/// Joints that move skin, or lie on the way between two that do.
fn carrying(rig: &SkinnedMesh) -> Vec<bool> {
    let mut own = vec![false; rig.joints.len()];
    for (j, w) in rig.influences.iter().flatten() {
        own[*j as usize] |= *w > 0.0;
    }
    // Children below which something is carried.
    let mut sides = vec![0_usize; own.len()];
    let mut seen = vec![false; own.len()];
    for j in (0..own.len()).filter(|&j| own[j]) {
        let mut at = Some(j);
        while let Some(j) = at.filter(|&j| !std::mem::replace(&mut seen[j], true)) {
            at = rig.joints[j].parent.map(|p| p as usize);
            at.into_iter().for_each(|p| sides[p] += 1);
        }
    }
    let hangs_on_one = |j: usize| {
        let mut up =
            std::iter::successors(rig.joints[j].parent, |&p| rig.joints[p as usize].parent);
        up.any(|p| own[p as usize])
    };
    (0..own.len()).map(|j| own[j] || sides[j] > 1 || sides[j] == 1 && hangs_on_one(j)).collect()
}

/// The nearest joint above `j` that is kept.
fn above(rig: &SkinnedMesh, j: usize, kept: &[bool]) -> Option<usize> {
    let parent = |&j: &usize| rig.joints[j].parent.map(|p| p as usize);
    std::iter::successors(parent(&j), parent).find(|&p| kept[p])
}

/// The joints in an order in which parents come first.
fn parents_first(
    rig: &SkinnedMesh,
    joints: &[usize],
    kept: &[bool],
) -> Result<Vec<usize>, RigError> {
    let parents: Vec<Option<usize>> = joints.iter().map(|&j| above(rig, j, kept)).collect();
    let roots: Vec<&str> = joints
        .iter()
        .zip(&parents)
        .filter(|(_, parent)| parent.is_none())
        .map(|(&j, _)| &rig.joints[j].name[..])
        .collect();
    let [_] = roots[..] else {
        return Err(RigError::invalid(format!(
            "a figure has one root bone; the joints of this skin have {}: {}",
            roots.len(),
            roots.join(", ")
        )));
    };
    let mut placed = vec![false; rig.joints.len()];
    let mut order: Vec<usize> = Vec::new();
    while order.len() < joints.len() {
        let before = order.len();
        for (&j, parent) in joints.iter().zip(&parents) {
            if !placed[j] && parent.is_none_or(|p| placed[p]) {
                placed[j] = true;
                order.push(j);
            }
        }
        if order.len() == before {
            return Err(RigError::invalid("the joints of the skin are no tree"));
        }
    }
    Ok(order)
}
