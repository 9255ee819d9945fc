//! Bones of links: fixed links become part of their parents, chains of weightless ones become one
//! joint.

use super::super::plan::PlanJoint;
use super::combine::combine;
use super::listed;
use super::settle::{Settled, SettledJoint};
use crate::RigError;
use thenar_core::model::JointKind;
use thenar_input::quoted;

/// A link that moves by itself.
pub(super) struct Bone {
    pub link: Settled,
    pub parent: Option<u32>,
    pub joint: Option<PlanJoint>,
    /// Names of the hinges that the joint was made of, in order, and their angles of rest in the
    /// file \[rad\].
    pub hinges: Vec<(String, f64)>,
}

/// The bones of links, parents before children.
pub(super) fn bones(
    mut links: Vec<Settled>,
    noun: &str,
    size: f64,
    notes: &mut Vec<String>,
) -> Result<Vec<Bone>, RigError> {
    let alive = merge_fixed(&mut links, noun, notes);
    let absorbed = weightless(&links, &alive, noun)?;
    let mut index: Vec<Option<u32>> = vec![None; links.len()];
    let mut bones = Vec::new();
    for i in 0..links.len() {
        if !alive[i] || absorbed[i] {
            continue;
        }
        let (joint, parent, hinges) = match links[i].parent {
            None => (None, None, Vec::new()),
            Some(_) => {
                let chain = chain(&links, i, &absorbed);
                let (joint, note) = combine(&chain.joints, &links[i].pose_ML.rotation, size)
                    .map_err(|reason| chain.error(&links[i].name, noun, &reason))?;
                notes.extend(note);
                let hinges = chain.joints.into_iter().map(|joint| (joint.name, joint.rest));
                (Some(joint), index[chain.parent], hinges.collect())
            }
        };
        index[i] = u32::try_from(bones.len()).ok();
        bones.push((i, parent, joint, hinges));
    }
    let mut links: Vec<Option<Settled>> = links.into_iter().map(Some).collect();
    let bone = |(i, parent, joint, hinges): (usize, _, _, _)| {
        links[i].take().map(|link| Bone { link, parent, joint, hinges })
    };
    Ok(bones.into_iter().filter_map(bone).collect())
}

/// Gives what fixed links have to their parents, and their children to them; tells which. True for
/// the others.
fn merge_fixed(links: &mut [Settled], noun: &str, notes: &mut Vec<String>) -> Vec<bool> {
    let mut becomes: Vec<usize> = (0..links.len()).collect();
    let mut names = Vec::new();
    for i in 0..links.len() {
        let Some(parent) = links[i].parent.map(|parent| becomes[parent]) else { continue };
        links[i].parent = Some(parent);
        if links[i].joints.is_empty() {
            becomes[i] = parent;
            let (mass, solids) = (links[i].mass, std::mem::take(&mut links[i].solids));
            links[parent].mass = links[parent].mass.plus(mass);
            links[parent].solids.extend(solids);
            names.push(links[i].name.clone());
        }
    }
    let which = listed(names.iter().map(String::as_str));
    match names.len() {
        0 => {}
        1 => notes.push(format!("1 fixed {noun} became part of its parent: {which}")),
        n => {
            let nouns = if noun == "body" { "bodies" } else { "links" };
            notes.push(format!("{n} fixed {nouns} became parts of their parents: {which}"));
        }
    }
    becomes.iter().enumerate().map(|(i, &to)| i == to).collect()
}

/// Marks links without mass and geometry that lie in a chain of hinges; others of that kind are
/// errors.
fn weightless(links: &[Settled], alive: &[bool], noun: &str) -> Result<Vec<bool>, RigError> {
    let mut children = vec![0_usize; links.len()];
    let mut on_hinges = vec![true; links.len()];
    let hinged = |link: &Settled| link.joints.iter().all(|j| j.kind == JointKind::Hinge);
    for (link, _) in links.iter().zip(alive).filter(|(_, alive)| **alive) {
        if let Some(parent) = link.parent {
            children[parent] += 1;
            on_hinges[parent] &= hinged(link);
        }
    }
    let mut absorbed = vec![false; links.len()];
    for (i, link) in links.iter().enumerate().filter(|(i, _)| alive[*i]) {
        if link.mass.body.is_some() || !link.solids.is_empty() {
            continue;
        }
        if link.parent.is_none() {
            return Err(RigError::invalid(format!(
                "the root {noun} {} has neither mass nor geometry: give it one, or leave it out",
                quoted(&link.name)
            )));
        }
        if children[i] != 1 || !on_hinges[i] || !hinged(link) {
            let reason = "only one between two hinges, which make a universal joint, may have none";
            return Err(weightless_error(&link.name, noun, reason));
        }
        absorbed[i] = true;
    }
    Ok(absorbed)
}

fn weightless_error(name: &str, noun: &str, reason: &str) -> RigError {
    RigError::invalid(format!(
        "{noun} {} moves and has neither mass nor geometry ({reason}): give it one of them",
        quoted(name)
    ))
}

/// The joints between a bone and the bone that carries it.
struct Chain {
    joints: Vec<SettledJoint>,
    /// Index of the link that carries it.
    parent: usize,
    /// The weightless link nearest to the bone.
    through: Option<String>,
}

/// Most joints that may become one; a longer chain is not followed.
const CHAIN_MAX: usize = 3;

fn chain(links: &[Settled], of: usize, absorbed: &[bool]) -> Chain {
    let mut joints: Vec<SettledJoint> = links[of].joints.clone();
    let (mut parent, mut through) = (links[of].parent.unwrap_or(0), None);
    while absorbed[parent] && joints.len() <= CHAIN_MAX {
        through.get_or_insert_with(|| links[parent].name.clone());
        joints.splice(0..0, links[parent].joints.iter().cloned());
        parent = links[parent].parent.unwrap_or(0);
    }
    Chain { joints, parent, through }
}

impl Chain {
    /// Why the joints cannot be one.
    fn error(&self, name: &str, noun: &str, reason: &str) -> RigError {
        match &self.through {
            Some(between) => weightless_error(between, noun, reason),
            None => RigError::invalid(format!(
                "{noun} {} has {} joints that cannot be simulated as one ({reason}): let hinges meet in one \
                 point at right angles, or put a {noun} with a mass between them",
                quoted(name),
                self.joints.len()
            )),
        }
    }
}
