//! Friction by load: the coefficient of a patch follows its normal force of the step before.

use crate::contact::{Contact, Site};
use crate::model::BodyId;
use crate::solver::ContactRows;
use crate::world::model::Model;
use crate::world::response::{body_of, nearest_vertex};
use crate::world::state::{Scratch, State};

/// Names a patch: friction table, then the parts of its first and second body.
pub type PatchKey = [u32; 3];

/// Most patches that can have a load.
pub fn patches_max(model: &Model) -> usize {
    let parts = |body: &BodyId| match body {
        BodyId::Rigid(_) => 1,
        BodyId::Soft(s) => {
            let of_bones = model.flesh_of_bone.iter().flatten().filter(|flesh| flesh.0 == *s);
            let all = model.parts[*s as usize].iter().copied().chain(of_bones.map(|flesh| flesh.1));
            1 + all.max().unwrap_or(0) as usize
        }
    };
    model.friction.iter().map(|table| table.bodies.iter().map(parts).product::<usize>()).sum()
}

/// Gives the rows of patches with a table the coefficient at their load.
pub fn set_coefficients(model: &Model, state: &State, scratch: &mut Scratch) {
    if model.friction.is_empty() {
        return;
    }
    for (contact, row) in scratch.found.iter().zip(&mut scratch.rows.rows) {
        if let Some(key) = patch(model, contact) {
            let at = state.patch_loads.binary_search_by_key(&key, |(key, _)| *key);
            let load = at.map_or(0.0, |i| state.patch_loads[i].1);
            row.friction = model.friction[key[0] as usize].at(load);
        }
    }
}

/// Keeps the loads for the next step.
pub fn keep_loads(
    model: &Model,
    found: &[Contact],
    rows: &ContactRows,
    h: f64,
    loads: &mut Vec<(PatchKey, f64)>,
) {
    loads.clear();
    if model.friction.is_empty() {
        return;
    }
    for (contact, row) in found.iter().zip(&rows.rows) {
        let pressing = row.lambda.x > 0.0 && row.lambda.x.is_finite();
        let Some(key) = patch(model, contact).filter(|_| pressing) else { continue };
        let load = row.lambda.x / h;
        match loads.binary_search_by_key(&key, |(key, _)| *key) {
            Ok(i) => loads[i].1 += load,
            Err(i) => loads.insert(i, (key, load)),
        }
    }
}

/// The patch of a contact whose pair has a table.
fn patch(model: &Model, contact: &Contact) -> Option<PatchKey> {
    let [a, b] = [&contact.a, &contact.b].map(|site| body_and_part(model, site));
    model.friction.iter().enumerate().find_map(|(i, table)| match table.bodies {
        // A body against itself: which part is met first means nothing.
        pair if pair == [a.0, b.0] && a.0 == b.0 => Some([i as u32, a.1.min(b.1), a.1.max(b.1)]),
        pair if pair == [a.0, b.0] => Some([i as u32, a.1, b.1]),
        pair if pair == [b.0, a.0] => Some([i as u32, b.1, a.1]),
        _ => None,
    })
}

/// The body that a contact touches and the part of it; of a bone its flesh.
fn body_and_part(model: &Model, site: &Site) -> (BodyId, u32) {
    match (body_of(site), nearest_vertex(site)) {
        (BodyId::Rigid(bone), _) => match model.flesh_of_bone[bone as usize] {
            Some((soft, part)) => (BodyId::Soft(soft), u32::from(part)),
            None => (BodyId::Rigid(bone), 0),
        },
        (soft @ BodyId::Soft(i), vertex) => (soft, vertex.map_or(0, |v| model.part_of(i, v))),
    }
}
