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
const PARTS_MAX: u32 = 16;
/// Numbers for the places of one part, these and those on its centre line.
pub(crate) const PLACES: u32 = 512;
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

/// Lets the fixed points of a triangle touch part `r`; its corners are contacts of their own. Of those that
/// only arrive in this step the one that would get deepest stands for all: once there, the others are
/// within the margin.
pub(crate) fn meet_samples(
    pair: &SoftRigid,
    near: &Near,
    r: u32,
    part: &Part,
    parts: u32,
    touches: &mut Touches,
) {
    let x = near.x.map(|p| part.pose_SP.inverse_point(&p));
    let mut arriving: Option<(f64, Touch)> = None;
    for (place, weights) in places(parts) {
        let p: Vec3 = (0..3).map(|k| x[k] * weights[k]).sum();
        let now = part.shape.distance(&p);
        if now.value > pair.margin + near.travel {
            continue;
        }
        let feature = feature_at(&weights);
        let touch = |found: Distance| {
            let normal = part.pose_SP.vector(&found.gradient);
            let key = [KEY_SEGMENT | (r * PLACES + place), near.index];
            let faces = outward(pair, near, feature).dot(&normal) < 0.0;
            let (triangle, gap) = (near.index, found.value);
            let touch = Touch { key, triangle, weights, sharp: None, normal, gap };
            (faces && pair.surface.owns(near.index, feature)).then_some(touch)
        };
        if now.value <= pair.margin {
            touch(now).into_iter().for_each(|touch| touches.offer(touch));
            continue;
        }
        let u_P = part.pose_SP.inverse_vector(&near.motion(&weights));
        let Some(found) = approach(&part.shape, &p, &u_P, 0.0, pair.margin) else { continue };
        let end = found.value + found.gradient.dot(&u_P);
        if arriving.is_none_or(|(least, _)| end < least)
            && let Some(touch) = touch(found)
        {
            arriving = Some((end, touch));
        }
    }
    if let Some((_, touch)) = arriving {
        touches.offer(touch);
    }
}

/// Numbers and weights of the fixed points of a triangle whose edges are divided so; its corners left out.
fn places(parts: u32) -> impl Iterator<Item = (u32, [f64; 3])> {
    let of_row = move |i| (0..=parts - i).map(move |j| (i, j));
    (0..=parts).flat_map(of_row).filter_map(move |(i, j)| {
        let counts = [parts - i - j, i, j];
        let place = FIRST + i * (PARTS_MAX + 1) + j;
        let weights = counts.map(|n| f64::from(n) / f64::from(parts));
        (!counts.contains(&parts)).then_some((place, weights))
    })
}

/// The face, or the edge opposite to the corner without weight.
fn feature_at(weights: &[f64; 3]) -> Feature {
    let opposite = weights.iter().position(|w| *w == 0.0);
    opposite.map_or(Feature::Face, |k| Feature::Edge((k + 1) % 3))
}
