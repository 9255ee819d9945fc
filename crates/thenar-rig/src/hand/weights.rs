//! Bindings of a hand's nodes.

use super::digits::DigitRig;
use super::regions;
use crate::weights::{Chain, bind, pair};
use thenar::Vec3;
use thenar::model::{Binding, Digit};

/// Half width of a knuckle's ramp, relative to the length of the first moving bone.
const KNUCKLE: f64 = 0.45;
/// Half width of the two further joints' ramps, relative to the length of the bone between them.
const FURTHER: f64 = 0.5;

/// What the binding of nodes needs to know of each digit.
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
                half_widths: [
                    (KNUCKLE * length(0)).min(length(0) - FURTHER * length(1)),
                    FURTHER * length(1),
                    FURTHER * length(1),
                ],
            }
        })
        .collect()
}

/// The binding of a node at `p`. `own` is the finger whose flesh alone surrounds it, or the palm
/// where parts meet.
pub(super) fn binding(p: &Vec3, own: Digit, digits: &[DigitRig], chains: &[Chain]) -> Binding {
    if let Some(d) = digits.iter().position(|rig| rig.digit == own) {
        return bind(&chains[d], p, 1.0);
    }
    // In the palm: the digit that would take the node most.
    let palm = regions::palm_distance(p, digits);
    let mut best = pair(0, 0, 0.0);
    let mut best_weight = 0.0;
    for (d, rig) in digits.iter().enumerate() {
        let here = regions::digit_distance(p, rig);
        let other = digits
            .iter()
            .filter(|other| other.digit != rig.digit)
            .map(|other| regions::digit_distance(p, other))
            .fold(f64::INFINITY, f64::min);
        let rival = if rig.digit == Digit::Thumb { other.min(palm) } else { other };
        let hold = claim(here, rival);
        let binding = bind(&chains[d], p, hold);
        let weight = 1.0 - root_weight(&binding);
        if weight > best_weight {
            (best, best_weight) = (binding, weight);
        }
    }
    best
}

/// How much a digit at distance `here` may claim when a rival is at `rival`: all when it is much
/// nearer, nothing when it is much farther.
fn claim(here: f64, rival: f64) -> f64 {
    if rival.is_infinite() {
        return 1.0;
    }
    let t = (rival - here) / (rival + here).max(1e-9);
    (0.6 + 1.2 * t).clamp(0.0, 1.0)
}

fn root_weight(binding: &Binding) -> f64 {
    (0..2).filter(|&k| binding.bones[k] == 0).map(|k| binding.weights[k]).sum()
}
