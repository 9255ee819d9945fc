//! Bound on the freedoms that the monolithic solver takes at once.

use crate::model::{Motion, SolverKind, WorldDesc};
use crate::world::ModelError;

/// Freedoms of bodies that joints hold together, at most: they share one dense matrix, whose
/// factorisation takes the cube of them, a third of 10⁹ multiplications at this number, and their
/// columns 48 bytes times the square.
const TOGETHER_MAX: usize = 1000;

/// Refuses trees of joints that the monolithic solver would take seconds a step for.
pub(super) fn check(desc: &WorldDesc) -> Result<(), ModelError> {
    if desc.solver.kind != SolverKind::Monolithic {
        return Ok(());
    }
    let moves = |body: u32| desc.rigids[body as usize].motion == Motion::Dynamic;
    let mut leader: Vec<u32> = (0..desc.rigids.len() as u32).collect();
    let mut freedoms: Vec<usize> =
        (0..desc.rigids.len() as u32).map(|body| if moves(body) { 6 } else { 0 }).collect();
    for joint in desc.joints.iter().filter(|joint| joint.kind.rows() > 0) {
        let Some(parent) = joint.parent.filter(|&parent| moves(parent)) else { continue };
        if !moves(joint.child) {
            continue;
        }
        let ends = [parent, joint.child].map(|body| find(&mut leader, body));
        let [first, other] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        // A joint that closes a loop takes directions out of the matrix, but no rows.
        if first != other {
            leader[other as usize] = first;
            freedoms[first as usize] += freedoms[other as usize] - joint.kind.rows();
        }
    }
    let heads = (0..desc.rigids.len()).filter(|&body| leader[body] as usize == body);
    match heads.max_by_key(|&head| freedoms[head]) {
        Some(head) if freedoms[head] > TOGETHER_MAX => Err(ModelError::ManyFreedoms {
            thing: desc.rigids[head].name.clone(),
            freedoms: freedoms[head],
            most: TOGETHER_MAX,
        }),
        _ => Ok(()),
    }
}

/// The first body of those that hold together; shortens the way there.
fn find(leader: &mut [u32], mut body: u32) -> u32 {
    while leader[body as usize] != body {
        leader[body as usize] = leader[leader[body as usize] as usize];
        body = leader[body as usize];
    }
    body
}
