//! Grading of a hand's flesh: pads finest, fingers and knuckles twice as coarse, palm and back of
//! the hand four times.

use super::digits::DigitRig;
use super::regions;
use crate::RigError;
use crate::lattice::{Grading, Lattice};
use thenar_core::Vec3;

/// Edge of the coarsest cubes at detail 1, relative to the length of the hand: 16 mm of 190.
const COARSE: f64 = 1.0 / 12.0;
/// From the palm's cubes to the pads'.
const HALVINGS: usize = 2;
/// Around the first joint of a finger the palm is as fine as the finger, within this part of the
/// hand's length: a knuckle is about 20 mm wide on a hand of 190 mm.
const KNUCKLE: f64 = 10.0 / 190.0;
/// Least and largest detail. At the largest the shipped hand has 32 thousand elements, and inside
/// points are as close as memory lets them be: finer elements would not be resolved.
pub const DETAILS: [f64; 2] = [0.25, 1.5];
/// Tetrahedra of a hand of detail 1: 12 thousand in the shipped ones.
const TETS: f64 = 1.2e4;

/// Tetrahedra that a hand of this detail will have, about.
pub fn graded_tets(detail: f64) -> u64 {
    (TETS * detail.powi(3)) as u64
}

/// Sizes of the elements of a hand of length `length` \[m\] at this detail.
pub(super) fn grading(length: f64, detail: f64) -> Result<Grading, RigError> {
    if !(DETAILS[0]..=DETAILS[1]).contains(&detail) {
        let expected = "from 0.25 to 1.5";
        return Err(RigError::Parameter { name: "detail", expected, value: detail });
    }
    Ok(Grading { coarse: COARSE * length / detail, halvings: HALVINGS })
}

/// Edge of the cubes wanted at a place in the hand \[m\].
pub(super) fn edge(p: &Vec3, digits: &[DigitRig], length: f64, grading: &Grading) -> f64 {
    let to_finger = |rig: &DigitRig| regions::digit_distance(p, rig);
    let nearest = digits.iter().min_by(|a, b| to_finger(a).total_cmp(&to_finger(b)));
    let Some(rig) = nearest else { return grading.coarse };
    let distance = to_finger(rig);
    if distance < regions::palm_distance(p, digits) {
        let pad = regions::bone_distance(p, rig, 2) <= distance && is_palmar(p, rig);
        return grading.coarse / if pad { 4.0 } else { 2.0 };
    }
    let to_knuckle = |rig: &DigitRig| (p - rig.joints[0].position).norm();
    let at_knuckle = digits.iter().any(|rig| to_knuckle(rig) < KNUCKLE * length);
    grading.coarse / if at_knuckle { 2.0 } else { 1.0 }
}

/// True if a place lies on the palm's side of the last bone's middle.
fn is_palmar(p: &Vec3, rig: &DigitRig) -> bool {
    // A digit that closes moves its tip this way.
    let palmar = rig.flexion.cross(&rig.direction(2));
    (p - rig.bone(2)[0]).dot(&palmar) > 0.0
}

/// Mean edge of a body-centred cubic tetrahedron, over that of its cube: two edges of 1, four of
/// √3/2.
const MEAN_EDGE: f64 = 0.911;

/// Triangles in which a surface of this area has edges no longer than 0.7 of those of the finest
/// elements, so that there is something left to simplify.
pub(super) fn triangles(area: f64, grading: &Grading) -> usize {
    let edge = 0.7 * MEAN_EDGE * grading.coarse / f64::from(1 << grading.halvings);
    // An equilateral triangle of edge e has √3/4 e².
    (area / (0.433 * edge * edge)) as usize
}

/// Mean edge of each of a lattice's elements \[m\].
pub(super) fn element_edges(lattice: &Lattice) -> Vec<f64> {
    let edges = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let mean = |t: usize| {
        let x = lattice.corners(t);
        edges.iter().map(|&(a, b)| (x[a] - x[b]).norm()).sum::<f64>() / 6.0
    };
    (0..lattice.tets.len()).map(mean).collect()
}
