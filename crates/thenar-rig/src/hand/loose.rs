//! Loose flesh of a hand: over its joints, around the roots of its digits, and in the webs between
//! them.
//!
//! Skin folds and slides over a joint, and between the roots of two fingers lies a fold of skin
//! with loose fat in it: a finger is bent beside a straight one with a few newton centimetres.
//! Elements as large as a knuckle can neither fold nor slide; they are softer there instead.

use super::digits::DigitRig;
use super::{regions, weights};
use crate::lattice::Lattice;
use thenar_core::Vec3;
use thenar_core::model::Digit;

/// A place lies in a web as much as its distance from the nearest digit's bones comes near that
/// from the next digit's. All flesh outside bone does: on a hand of 190 mm bones are 5 to 6 mm
/// thick, in radius, and lie 20 mm apart.
const WEB: [f64; 2] = [0.25, 0.45];
/// A place lies over the first joint of a digit as much as its distances from the bones on both
/// sides come near one another: places r off the axis wholly up to 0.75 r along it and not beyond
/// 1.7 r. That is how far creases reach.
const ROOT: [f64; 2] = [0.5, 0.8];

/// Young's modulus where flesh is loose, relative to that elsewhere, in (0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Softness {
    /// In the middle of a joint.
    pub joint: f64,
    /// Around the roots of digits, and between them.
    pub root: f64,
}

/// Degree to which every inside point of a lattice lies in loose flesh, from 0 to 1.
pub(super) struct Loose {
    joint: Vec<f64>,
    root: Vec<f64>,
}

impl Loose {
    /// `samples` are the digits of the inside points.
    pub fn new(lattice: &Lattice, digits: &[DigitRig], samples: &[Digit]) -> Self {
        let chains = weights::chains(digits);
        let joint = |i: usize| {
            // 1 in the middle of a joint, where two bones carry the flesh equally, 0 beyond it.
            let p = lattice.sample_position(i);
            let [a, b] = weights::binding(&p, samples[i], digits, &chains).weights;
            4.0 * a * b
        };
        let root = |i: usize| match samples[i] {
            Digit::Palm => at_root(&lattice.sample_position(i), digits),
            _ => 0.0,
        };
        let all = 0..lattice.sample_count();
        Self { joint: all.clone().map(joint).collect(), root: all.map(root).collect() }
    }

    /// Part of the modulus that is left at inside point `i`.
    pub fn left(&self, i: usize, softness: &Softness) -> f64 {
        let part = |softness: f64, bump: f64| 1.0 - (1.0 - softness) * bump;
        part(softness.joint, self.joint[i]) * part(softness.root, self.root[i])
    }
}

/// Degree to which a place that is no finger's alone lies at the root of a digit or in a web.
fn at_root(p: &Vec3, digits: &[DigitRig]) -> f64 {
    let mut distances: Vec<f64> =
        digits.iter().map(|rig| regions::digit_distance(p, rig)).collect();
    distances.sort_by(f64::total_cmp);
    let (palm, [nearest, next]) = (regions::palm_distance(p, digits), [distances[0], distances[1]]);
    let ramp = |ratio: f64, [from, to]: [f64; 2]| ((ratio - from) / (to - from)).clamp(0.0, 1.0);
    let root = ramp(nearest.min(palm) / nearest.max(palm), ROOT);
    if palm < nearest { root } else { root.max(ramp(nearest / next, WEB)) }
}
