//! A convex shape deep in a mesh.
//!
//! Points of the surfaces tell the way out as long as it is short: farther in, the normals of the
//! two no longer agree anywhere, and none is offered. Then balls inside the shape tell, if one
//! reaches into the mesh, and else the face of the mesh that lies deepest in the shape.

use crate::contact::Distance;
use crate::contact::manifold::Manifold;
use crate::contact::mesh_pair::{DEEP, Pair};
use crate::contact::soft_inside::{InnerBall, inner_balls};
use crate::math::Vec3;

/// Set in the feature of a ball.
const OF_BALL: u32 = 1 << 27;

/// The place of a triangle that lies deepest in the shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeepFace {
    pub triangle: u32,
    pub q_W: Vec3,
    /// Into the shape.
    pub n_W: Vec3,
    pub gap: f64,
}

/// Adds points of a pair that overlaps, of which no other point tells.
pub(super) fn find(pair: &Pair, deepest: Option<DeepFace>, manifold: &mut Manifold) {
    let mut next = DEEP | OF_BALL;
    let mut is_inside = false;
    inner_balls(pair.a.shape, |InnerBall { center, radius }| {
        let center_W = pair.a.world_point(&center);
        let there = pair.b.distance(&center_W);
        let found = Distance { value: there.value - radius, ..there };
        if found.value < 0.0 {
            pair.push_ball(next, &center_W, radius, &found, manifold);
            is_inside = true;
        }
        next += 1;
    });
    if let Some(DeepFace { triangle, q_W, n_W, gap }) = deepest.filter(|_| !is_inside) {
        pair.push(DEEP | triangle, q_W + 0.5 * gap * n_W, n_W, gap, manifold);
    }
}
