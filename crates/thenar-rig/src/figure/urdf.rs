//! URDF (Unified Robot Description Format), with the ball joints and capsules that some tools add.

mod geometry;
mod joint;
mod link;
#[cfg(test)]
mod tests;
mod tree;

use super::link_tree::{LinkTree, Meshes, listed};
use super::plan::Plan;
use super::xml::{self, Element};
use crate::RigError;
use joint::Joint;
use std::collections::BTreeSet;
use std::path::Path;
use thenar_core::{Pose, Quat, Vec3};
use tree::Tree;

/// Reads the links and joints of a URDF text as bones. Meshes are looked for beside the file, which
/// lies in `folder`.
///
/// Fixed links become part of their parents. Two hinges at right angles with a link of neither mass
/// nor geometry between them become a universal joint, three a ball joint. Geometry is that of
/// collisions, or where a link has none, what is drawn. What the figure leaves out stands in the
/// plan's notes.
///
/// # Errors
/// Names the line, link, joint or file, and the cause.
pub fn read_urdf(text: &str, folder: &Path) -> Result<Plan, RigError> {
    let document = xml::parse(text)?;
    let robot = Element::root(&document);
    check_root(robot)?;
    let tree = Tree::read(robot)?;
    let mut notes = notes(robot, &tree);
    let mut meshes = Meshes::default();
    let order = tree.order()?;
    let mut place = vec![0; tree.links.len()];
    let mut links = Vec::with_capacity(order.len());
    for &i in &order {
        place[i] = links.len();
        let joint = tree.joint_of(i);
        let parent = joint.filter(|joint| !joint.is_dropped()).map(|joint| place[joint.parent]);
        let name = tree.links[i].needs_name("name")?.to_owned();
        let mut link = link::read(tree.links[i], name, folder, &mut meshes)?;
        link.parent = parent;
        if let Some(joint) = joint {
            joint.attach(&mut link)?;
        }
        links.push(link);
    }
    notes.extend(tree.dropped_root()?);
    let name = robot.get("name").map_or(String::new(), |name| name.value.to_owned());
    LinkTree { name, noun: "link", links, follows: tree.mimics()?, notes }.finish()
}

/// Errs when the outermost element is that of another format.
fn check_root(robot: Element<'_>) -> Result<(), RigError> {
    let what = match robot.tag() {
        "robot" => return check_expanded(robot),
        "mujoco" => "this is MJCF, not URDF".to_owned(),
        "sdf" => "this is SDF, not URDF: convert it".to_owned(),
        _ => "a URDF file begins with <robot>".to_owned(),
    };
    Err(robot.error(what))
}

fn check_expanded(robot: Element<'_>) -> Result<(), RigError> {
    match robot.descendants().find(|element| element.namespace().contains("xacro")) {
        Some(element) => {
            Err(element.error("macros are not read: expand the file with xacro first"))
        }
        None => Ok(()),
    }
}

/// Notes on what the file says and figures leave out.
fn notes(robot: Element<'_>, tree: &Tree<'_>) -> Vec<String> {
    let mut notes = Vec::new();
    let told = |child: &str, attributes: &[&str]| {
        let says = |joint: &&Joint<'_>| {
            let element = joint.element.child(child);
            element.is_some_and(|e| attributes.iter().any(|name| e.get(name).is_some()))
        };
        tree.joints.iter().any(|joint| says(&joint))
    };
    if told("limit", &["effort", "velocity"]) {
        notes
            .push("limits of effort and velocity are passed over: motors are set in scenes".into());
    }
    if told("dynamics", &["friction"]) {
        notes.push("friction of joints is passed over".into());
    }
    let known = ["link", "joint", "material"];
    let other: BTreeSet<&str> =
        robot.children().map(Element::tag).filter(|tag| !known.contains(tag)).collect();
    if !other.is_empty() {
        notes.push(format!("passed over: {}", listed(other)));
    }
    notes
}

/// The `<origin>` of an element; without one, none.
fn origin(element: Element<'_>) -> Result<Pose, RigError> {
    let Some(origin) = element.child("origin") else { return Ok(Pose::identity()) };
    let [xyz, rpy] = ["xyz", "rpy"].map(|name| origin.numbers::<3>(name));
    let [roll, pitch, yaw] = rpy?.unwrap_or_default();
    let position = Vec3::from(xyz?.unwrap_or_default());
    Ok(Pose::new(position, Quat::from_euler_angles(roll, pitch, yaw)))
}
