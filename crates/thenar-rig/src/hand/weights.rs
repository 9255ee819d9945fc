//! Bindings of a hand's nodes.

use super::digits::DigitRig;
use super::regions;
use crate::weights::{Chain, bind, pair};
use thenar_core::Vec3;
use thenar_core::model::{Binding, Digit};

/// Half width of the first joint's ramp, relative to the length of the first moving bone.
const FIRST: f64 = 0.56;
/// Half width of the second joint's ramp, at most, relative to the same length.
const SECOND: f64 = 0.42;
/// Half width of the second joint's ramp, at most, relative to the bone between the two further
/// joints. A finger's third joint has the rest of that bone for its ramp: half of it, or more where
/// the first bone is so short that the second ramp is. A thumb's, which bends less, has half.
const FURTHER: f64 = 0.5;

/// Chain of each digit, as the binding of nodes needs it.
pub(super) fn chains(digits: &[DigitRig]) -> Vec<Chain> {
    digits
        .iter()
        .enumerate()
        .map(|(d, rig)| {
            let first = 1 + 3 * d as u32;
            let length = |k: usize| (rig.bone(k)[1] - rig.bone(k)[0]).norm();
            Chain {
                bones: [0, first, first + 1, first + 2],
                joints: std::array::from_fn(|k| rig.joints[k].position),
                across: std::array::from_fn(|k| {
                    (rig.direction_before(k) + rig.direction(k)).normalize()
                }),
                half_widths: half_widths(rig.digit, [length(0), length(1)]),
            }
        })
        .collect()
}

/// Half widths of a digit's ramps \[m\], by the lengths of its first two moving bones.
fn half_widths(digit: Digit, [first, between]: [f64; 2]) -> [f64; 3] {
    let second = (FURTHER * between).min(SECOND * first);
    let third = if digit == Digit::Thumb { FURTHER * between } else { between - second };
    [FIRST * first, second, third]
}

/// The binding of a node at `p`. `own` is the finger whose flesh alone surrounds it, or the palm
/// where parts meet.
pub(super) fn binding(p: &Vec3, own: Digit, digits: &[DigitRig], chains: &[Chain]) -> Binding {
    let distances: Vec<f64> = digits.iter().map(|rig| regions::digit_distance(p, rig)).collect();
    let palm = regions::palm_distance(p, digits);
    let taken = (0..digits.len()).filter(|&d| own == Digit::Palm || own == digits[d].digit);
    let mut best = pair(0, 0, 0.0);
    for d in taken {
        let binding = bind(&chains[d], p, hold(d, own, &distances, palm));
        if root_weight(&binding) < root_weight(&best) {
            best = binding;
        }
    }
    best
}

/// Hold of digit `d` on a point against the palm and the other digits: fading to nothing where a
/// rival is as near, so that the weights are continuous there.
fn hold(d: usize, own: Digit, distances: &[f64], palm: f64) -> f64 {
    const THUMB: usize = 0;
    let nearer = |rival: f64| (rival - distances[d]) / (rival + distances[d]).max(1e-9);
    let fade = |rival: f64| (2.5 * nearer(rival)).clamp(0.0, 1.0);
    if d == THUMB {
        let rival = if own == Digit::Palm {
            distances[1..].iter().copied().fold(palm, f64::min)
        } else {
            palm
        };
        return fade(rival);
    }
    if own != Digit::Palm {
        return 1.0;
    }
    let neighbour = (1..distances.len())
        .filter(|&other| other != d)
        .map(|other| distances[other])
        .fold(f64::INFINITY, f64::min);
    fade(neighbour) * fade(distances[THUMB])
}

fn root_weight(binding: &Binding) -> f64 {
    (0..2).filter(|&k| binding.bones[k] == 0).map(|k| binding.weights[k]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A person's index finger, 41 and 23 mm, shares the bone between its further joints evenly. A
    /// short first bone, 27.7 mm before 32.7, leaves the second ramp 0.42 · 27.7 = 11.634 mm, and
    /// the third the rest.
    #[test]
    fn ramps_fill_the_bone_between_them() {
        let near = |found: [f64; 3], expected: [f64; 3]| {
            let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) < 1e-12, "{found:?}");
        };
        near(half_widths(Digit::Index, [41.0, 23.0]), [22.96, 11.5, 11.5]);
        near(half_widths(Digit::Index, [27.7, 32.7]), [15.512, 11.634, 21.066]);
        near(half_widths(Digit::Thumb, [27.7, 32.7]), [15.512, 11.634, 16.35]);
    }
}
