//! Contact points between two rigid bodies, piece by piece.
//!
//! Convex pieces have one method; against a mesh, points of one surface meet the exact distance of
//! the other. Fast bodies are looked at where they meet.

use crate::contact::Shape;
use crate::contact::convex_pair;
use crate::contact::manifold::{Manifold, ManifoldPoint};
use crate::contact::mesh_pair::{DEEP, KIND, convex_on_mesh, mesh_of, mesh_on_mesh};
use crate::contact::rigid_body::{Placed, RigidBody};
use crate::contact::sweep::{MovingPiece, meeting};
use crate::contact::traced;

/// One of two rigid bodies.
#[derive(Clone, Copy)]
pub(crate) struct RigidSide<'a> {
    pub body: &'a RigidBody,
    pub placed: &'a Placed,
}

/// Extent of a search.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Length of the step \[s\].
    pub h: f64,
    /// Surfaces nearer than this are in contact \[m\].
    pub margin: f64,
}

/// Two surfaces of one body that are nearer than this part of its size are one surface.
const BURIED: f64 = 1e-6;

/// Fills `manifold` with the points of A against B, normals from B to A.
pub(crate) fn find(a: RigidSide, b: RigidSide, reach: Reach, manifold: &mut Manifold) {
    manifold.clear();
    for (i, piece_a) in a.body.pieces.iter().enumerate() {
        for (j, piece_b) in b.body.pieces.iter().enumerate() {
            let (a, b) =
                (MovingPiece { side: a, piece: piece_a }, MovingPiece { side: b, piece: piece_b });
            let first = manifold.begin();
            pieces(&a, &b, reach, manifold);
            let of_pair = ((i * 4096 + j) as u32).wrapping_mul(0x9E37_79B1);
            manifold.points_mut()[first..].iter_mut().for_each(|p| p.feature ^= of_pair);
        }
    }
    manifold.end();
    traced::find(a, b, reach, manifold);
    manifold.reduce();
}

/// Leaves out points from `first` on inside another piece of a body, or nearer to another piece
/// than to their own, after the part `s` of the step.
fn drop_buried(
    a: &MovingPiece,
    b: &MovingPiece,
    s: f64,
    h: f64,
    first: usize,
    manifold: &mut Manifold,
) {
    let bodies = [a, b].map(|m| m.side.body);
    if bodies.iter().all(|body| body.pieces.len() == 1) {
        return;
    }
    let wholes = [a.whole_at(s, h), b.whole_at(s, h)];
    let slack = BURIED * bodies[0].radius.max(bodies[1].radius);
    // Balls inside a piece tell how deep it is in a mesh, and not where its surface is.
    let of_mesh = bodies.iter().any(|body| body.pieces.iter().any(|p| mesh_of(&p.shape).is_some()));
    manifold.retain_from(first, |p| {
        if of_mesh && p.feature & KIND == DEEP {
            return true;
        }
        let half = 0.5 * p.gap * p.normal_W;
        let (on_a, on_b) = (p.position_W + half, p.position_W - half);
        // Where a mesh meets something later in the step only slow bodies can be told.
        let slack = slack + 1e-3 * p.gap.abs();
        wholes[0].distance(&on_a).value > -slack
            && wholes[1].distance(&on_b).value > -slack
            && wholes[1].distance(&on_a).value > p.gap - slack
    });
}

/// Two pieces.
fn pieces(a: &MovingPiece, b: &MovingPiece, reach: Reach, manifold: &mut Manifold) {
    let shapes = (&a.piece.shape, &b.piece.shape);
    if matches!(shapes, (Shape::HalfSpace, Shape::HalfSpace)) {
        return;
    }
    let first = manifold.points().len();
    match (mesh_of(shapes.0), mesh_of(shapes.1)) {
        (None, None) => return convex(a, b, reach, manifold),
        (None, Some(_)) => convex_on_mesh(a, b, reach, manifold),
        (Some(_), None) => reversed(manifold, |m| convex_on_mesh(b, a, reach, m)),
        (Some(_), Some(_)) => mesh_on_mesh(a, b, reach, manifold),
    }
    drop_buried(a, b, 0.0, reach.h, first, manifold);
}

/// Two convex pieces, where they are, or where they will meet within the step.
fn convex(a: &MovingPiece, b: &MovingPiece, reach: Reach, manifold: &mut Manifold) {
    let Some(s) = meeting(a, b, reach) else { return };
    let first = manifold.points().len();
    let (solid_a, solid_b) = (a.at(s, reach.h), b.at(s, reach.h));
    let travel = a.travel(b, reach.h);
    // Places away from that of the meeting are told by it only if neither body turns off its
    // tangent.
    let straight = [a, b].iter().all(|m| !m.leaves_tangent(reach));
    let far = if travel > reach.margin && straight { reach.margin + travel } else { reach.margin };
    convex_pair::find(&solid_a, &solid_b, reach.margin, far, manifold);
    drop_buried(a, b, s, reach.h, first, manifold);
    if s > 0.0 || a.is_turned_fast(reach) || b.is_turned_fast(reach) {
        manifold.points_mut()[first..].iter_mut().for_each(|p| carry(a, b, s, reach.h, p));
    }
}

/// Turns a contact found after the part `s` of the step into one for the solver, whose constraint
/// on velocities is to hold at the end of the step: a body that is led, and its normal with it (by
/// at most 60°), is looked at where it turns to; one that moves by forces moves straight on, as its
/// constraint does. In pure translation that adds to the gap what the way closes.
fn carry(a: &MovingPiece, b: &MovingPiece, s: f64, h: f64, p: &mut ManifoldPoint) {
    let half = 0.5 * p.gap * p.normal_W;
    let met = [p.position_W + half, p.position_W - half];
    let led = if a.side.body.dynamic { b } else { a };
    let turned = led.turned(&p.normal_W, (1.0 - s) * h);
    if turned.dot(&p.normal_W) > 0.5 {
        p.normal_W = turned;
    }
    let of_a = a.has_lever(b, &p.position_W);
    let (owner, on_owner, side) = if of_a { (a, met[0], -0.5) } else { (b, met[1], 0.5) };
    p.position_W = owner.carried(&on_owner, s, 0.0, h);
    let [start_a, start_b] = [(a, met[0]), (b, met[1])].map(|(m, met)| {
        let motion = h * m.side.placed.velocity_at(&p.position_W);
        match m.side.body.dynamic {
            true => met - s * motion,
            false => m.carried(&met, s, 1.0, h) - motion,
        }
    });
    p.gap = p.normal_W.dot(&(start_a - start_b));
    p.position_W += side * p.gap * p.normal_W;
}

/// Runs `find` for the opposite direction and turns the normals of what it adds.
pub(crate) fn reversed(manifold: &mut Manifold, find: impl FnOnce(&mut Manifold)) {
    let flip = |m: &mut Manifold| {
        m.points_mut().iter_mut().for_each(|p: &mut ManifoldPoint| p.normal_W = -p.normal_W);
    };
    flip(manifold);
    find(manifold);
    flip(manifold);
}
