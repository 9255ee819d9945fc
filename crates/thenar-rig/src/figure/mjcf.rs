//! MJCF (the format of MuJoCo), without what moves a figure: motors are set in scenes; of
//! constraints, those by which joints follow others are read.

mod assets;
mod body;
mod classes;
mod equality;
mod geom;
mod joint;
mod place;
mod settings;
#[cfg(test)]
mod tests;
mod world;

use super::link_tree::{LinkTree, Meshes, listed};
use super::plan::Plan;
use super::xml::{self, Element};
use crate::RigError;
use assets::Assets;
use classes::Classes;
use settings::Settings;
use std::collections::BTreeSet;
use std::path::Path;

/// Sections that say nothing of a figure's bones, or are read.
const SILENT: [&str; 9] = [
    "compiler",
    "default",
    "asset",
    "worldbody",
    "option",
    "size",
    "visual",
    "statistic",
    "equality",
];

/// Context of reading: all that is needed of the file besides the bodies.
struct Context<'a> {
    settings: Settings,
    classes: Classes<'a>,
    assets: Assets<'a>,
    meshes: Meshes,
    notes: Notes<'a>,
}

/// Details that figures leave out, gathered while bodies are read.
#[derive(Default)]
struct Notes<'a> {
    /// Ball joints whose range is dropped.
    ranged_balls: Vec<String>,
    /// Joints to the world.
    to_world: Vec<String>,
    /// Attributes that are passed over.
    attributes: BTreeSet<&'a str>,
}

/// Reads the bodies of an MJCF text as bones. Meshes are looked for in the file's `folder`, or in
/// `meshdir` there.
///
/// One body at the top is the figure; its joints to the world are left out, since a figure's root
/// is free. Bodies without a joint become part of their parents. Two hinges that meet in a point at
/// right angles become a universal joint, three a ball joint. What the figure leaves out stands in
/// the plan's notes.
///
/// # Errors
/// Names the line, body, joint, geom or file, and the cause.
pub fn read_mjcf(text: &str, folder: &Path) -> Result<Plan, RigError> {
    let document = xml::parse(text)?;
    let root = Element::root(&document);
    check_root(root)?;
    let settings = Settings::read(root, folder)?;
    let classes = Classes::read(root)?;
    let assets = Assets::read(root, &classes)?;
    let world = world::read(root, &classes, &settings)?;
    let meshes = Meshes::default();
    let mut context = Context { settings, classes, assets, meshes, notes: Notes::default() };
    let links = body::read(&world.figure, &mut context)?;
    let mut notes = world.notes;
    notes.extend(sections(root));
    let follows = equality::read(root, &links, &mut notes)?;
    notes.extend(context.notes.told());
    let name = root.get("model").map_or(String::new(), |name| name.value.to_owned());
    LinkTree { name, noun: "body", links, follows, notes }.finish()
}

/// Errs when the file is of another format, or is not whole.
fn check_root(root: Element<'_>) -> Result<(), RigError> {
    match root.tag() {
        "mujoco" => {}
        "robot" => return Err(root.error("this is URDF, not MJCF")),
        _ => return Err(root.error("an MJCF file begins with <mujoco>")),
    }
    match root.descendants().find(|element| element.tag() == "include") {
        Some(include) => Err(include.error(
            "included files are not read: save the model as one file (mj_saveLastXML does)",
        )),
        None => Ok(()),
    }
}

/// Note on sections that are passed over.
fn sections(root: Element<'_>) -> Option<String> {
    let other: BTreeSet<&str> =
        root.children().map(Element::tag).filter(|tag| !SILENT.contains(tag)).collect();
    (!other.is_empty()).then(|| format!("sections passed over: {}", listed(other)))
}

impl Notes<'_> {
    fn told(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let names = |names: &[String]| listed(names.iter().map(String::as_str));
        if !self.to_world.is_empty() {
            let which = names(&self.to_world);
            notes.push(format!(
                "joints to the world are left out, a figure's root is free: {which}"
            ));
        }
        if !self.ranged_balls.is_empty() {
            let which = names(&self.ranged_balls);
            notes.push(format!("ball joints lose their ranges: {which}"));
        }
        if !self.attributes.is_empty() {
            let which = listed(self.attributes.iter().copied());
            notes.push(format!("attributes of joints and geoms passed over: {which}"));
        }
        notes
    }
}
