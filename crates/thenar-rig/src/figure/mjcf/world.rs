//! Choice of the world's body that is the figure.

use super::super::link_tree::listed;
use super::classes::Classes;
use super::place::pose_of;
use super::settings::Settings;
use super::{Element, RigError};
use thenar_core::Pose;

/// An element of the tree of bodies, with what surrounds it.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub element: Element<'a>,
    /// The frame in which its pose is given, in that of the body around.
    pub pose: Pose,
    /// Class of what names none.
    pub class: usize,
}

/// The figure of a world.
pub(super) struct World<'a> {
    pub figure: Place<'a>,
    pub notes: Vec<String>,
}

/// Finds the body at the top that has most bodies, and tells what else there is.
pub(super) fn read<'a>(
    root: Element<'a>,
    classes: &Classes<'a>,
    settings: &Settings,
) -> Result<World<'a>, RigError> {
    let mut open: Vec<Place<'a>> = root
        .named("worldbody")
        .map(|element| Place { element, pose: Pose::identity(), class: 0 })
        .collect();
    open.reverse();
    let (mut bodies, mut geoms) = (Vec::new(), 0);
    while let Some(place) = open.pop() {
        match place.element.tag() {
            "worldbody" | "frame" => open.extend(inside(place, classes, settings)?),
            "body" => bodies.push(place),
            "geom" => geoms += 1,
            _ => check_known(place.element)?,
        }
    }
    choose(root, &bodies, geoms)
}

/// Returns the contents of a frame (or of the world), last first.
pub(super) fn inside<'a>(
    place: Place<'a>,
    classes: &Classes<'a>,
    settings: &Settings,
) -> Result<Vec<Place<'a>>, RigError> {
    let pose = match place.element.tag() {
        "frame" => place.pose * pose_of(place.element, settings)?,
        _ => place.pose,
    };
    let class = classes.named(place.element, "childclass", place.class)?;
    let children = place.element.children().rev();
    Ok(children.map(|element| Place { element, pose, class }).collect())
}

/// Errs on elements that make bodies and are not read.
pub(super) fn check_known(element: Element<'_>) -> Result<(), RigError> {
    if !["replicate", "composite", "flexcomp", "attach"].contains(&element.tag()) {
        return Ok(());
    }
    Err(element.error(
        "this makes bodies when MuJoCo compiles the model, and is not read: save the compiled model \
         (mj_saveLastXML does)",
    ))
}

fn choose<'a>(
    root: Element<'a>,
    bodies: &[Place<'a>],
    geoms: usize,
) -> Result<World<'a>, RigError> {
    let count =
        |place: &Place<'a>| place.element.descendants().filter(|e| e.tag() == "body").count();
    let counts: Vec<usize> = bodies.iter().map(count).collect();
    let most = counts.iter().copied().max().unwrap_or(0);
    let chosen = counts.iter().position(|&count| count == most);
    let Some((k, figure)) = chosen.and_then(|k| Some((k, *bodies.get(k)?))) else {
        return Err(root.error("there is no <body> in <worldbody>"));
    };
    let mut notes = Vec::new();
    let others = bodies.iter().enumerate().filter(|(j, _)| *j != k);
    let name = |place: &Place<'a>| place.element.get("name").map_or("", |name| name.value);
    let others: Vec<&str> = others.map(|(_, place)| name(place)).collect();
    if !others.is_empty() {
        notes.push(format!("other bodies of the world are passed over: {}", listed(others)));
    }
    if geoms > 0 {
        notes.push(format!("geoms of the world are passed over: {geoms}"));
    }
    Ok(World { figure, notes })
}
