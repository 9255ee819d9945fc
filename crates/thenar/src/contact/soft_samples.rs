//! Fixed points of a deformable surface against a round part that is large beside its triangles.
//!
//! The place where a flat triangle is nearest to a ball of radius R moves by `R θ` when the triangle
//! tilts by θ. Held at that place alone, a triangle under a load F rocks from step to step for ever
//! where `R F` exceeds its stiffness against tilting; held at fixed points it does not. Points so near to
//! each other that the ball bulges by less than [`TOUCHING`] between them hold it as well as all of the
//! triangle would.

use crate::contact::approach::approach;
use crate::contact::area::TOUCHING;
use crate::contact::near::Near;
use crate::contact::soft_feature::Touch;
use crate::contact::soft_rigid::{KEY_SEGMENT, SoftRigid};
use crate::contact::soft_round::{Touches, outward};
use crate::contact::triangle::Feature;
use crate::contact::{Distance, Part};
use crate::math::Vec3;

/// Most parts of an edge: a ball for which they are not enough is small, and held at its nearest place.
const PARTS_MAX: u32 = 6;
/// Numbers for the places of one part, these and those on its centre line.
pub(crate) const PLACES: u32 = 64;
/// The first number of a fixed point.
const FIRST: u32 = 8;

/// Into how many parts to divide the edges of a triangle under a round part, so that it bulges by no
/// more than [`TOUCHING`] between points; `None` where these would be too many. It depends on lengths at
/// rest alone.
pub(crate) fn parts(pair: &SoftRigid, near: &Near, part: &Part) -> Option<u32> {
    let corners = pair.surface.triangles[near.index as usize];
    let edge = corners.iter().map(|&v| pair.surface.edge_around[v as usize]).fold(0.0, f64::max);
    let apart = (8.0 * part.shape.least_radius() * TOUCHING).sqrt();
    let parts = (edge / apart).ceil().max(1.0);
    (parts <= f64::from(PARTS_MAX)).then_some(parts as u32)
}

/// Lets the fixed points of a triangle touch part `r`; its corners are contacts of their own.
pub(crate) fn meet_samples(
    pair: &SoftRigid,
    near: &Near,
    r: u32,
    part: &Part,
    parts: u32,
    touches: &mut Touches,
) {
    let x = near.x.map(|p| part.pose_SP.inverse_point(&p));
    for i in 0..=parts {
        for j in 0..=parts - i {
            let counts = [parts - i - j, i, j];
            let feature = match counts.iter().filter(|n| **n == 0).count() {
                0 => Feature::Face,
                1 => Feature::Edge((0..3).find(|&k| counts[(k + 2) % 3] == 0).unwrap_or(0)),
                _ => continue,
            };
            if !pair.surface.owns(near.index, feature) {
                continue;
            }
            let weights = counts.map(|n| f64::from(n) / f64::from(parts));
            let p: Vec3 = (0..3).map(|k| x[k] * weights[k]).sum();
            let now = part.shape.distance(&p);
            let found = if now.value <= pair.margin {
                Some(now)
            } else if now.value <= pair.margin + near.travel {
                let u_P = part.pose_SP.inverse_vector(&near.motion(&weights));
                approach(&part.shape, &p, &u_P, 0.0, pair.margin)
            } else {
                None
            };
            let Some(Distance { value: gap, gradient }) = found else { continue };
            let normal = part.pose_SP.vector(&gradient);
            if outward(pair, near, feature).dot(&normal) < 0.0 {
                let place = FIRST + i * (PARTS_MAX + 1) + j;
                let key = [KEY_SEGMENT | (r * PLACES + place), near.index];
                let triangle = near.index;
                touches.offer(Touch { key, triangle, weights, sharp: None, normal, gap });
            }
        }
    }
}
