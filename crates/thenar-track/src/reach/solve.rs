//! Inverse kinematics of one digit: damped least squares within the joints' ranges [Wampler 1986].
//!
//! A step `dq` of the angles makes least
//!
//! ```text
//! |e - J dq|² + w² |e_n - J_n dq|² + c² |q_ease - q - dq|² + λ² |dq|²
//! ```
//!
//! with `e` the way that the pad lacks, `J` how angles move it, `e_n` the turn that lays its normal
//! where it is wanted and `J_n` how angles turn it. A normal that is out of reach stays far off,
//! and then a whole step may go beyond: half of it is taken, and half of that, until the same sum
//! is less. Freedoms at the end of their range that would go on are left out of it. What is weighed
//! beside the place bends it by a fraction of a millimetre, which a loop around this takes away
//! where it matters.

use super::chain::{Angles, Chain, FREEDOMS_MAX, PadKinematics};
use super::within::step_within;
use nalgebra::{SMatrix, SVector};
use std::f64::consts::PI;
use thenar_core::Vec3;
use thenar_core::math::tangents;

/// Weight of the normal's turn \[m/rad\]: half a radian away bends the place by 0.1 mm at an arm of
/// 60 mm.
const TURN: f64 = 0.004;
/// Weight of ease \[m/rad\]: half a radian away bends the place by 0.02 mm at that arm.
const EASE: f64 = 0.0015;
/// Damping \[m/rad\]: a hundredth of the square of a finger's arm of 50 mm.
const DAMPING: f64 = 0.005;
/// Largest change of an angle in one round \[rad\].
const ROUND_MAX: f64 = 0.25;
/// A step is tried so often, at last a five-hundredth of it: what less of it would bring is not
/// felt.
const TRIALS: usize = 10;

/// Goal of a pad, in the palm's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Place of its centre \[m\].
    pub centre: Vec3,
    /// Direction out of the pad's skin.
    pub normal: Vec3,
}

/// Brings the pad of a chain to a goal in a number of rounds from `angles`, which become those
/// found, near `ease` as far as the goal leaves that open; returns how far off the place is \[m\].
pub fn solve(chain: &Chain, ease: &Angles, angles: &mut Angles, goal: &Goal, rounds: usize) -> f64 {
    for _ in 0..rounds {
        if round(chain, ease, angles, goal) < 1e-9 {
            break;
        }
    }
    (goal.centre - chain.reach(angles).centre).norm()
}

/// One round; returns the largest change of an angle.
fn round(chain: &Chain, ease: &Angles, angles: &mut Angles, goal: &Goal) -> f64 {
    let n = chain.freedoms.len();
    let reached = chain.reach(angles);
    let miss = goal.centre - reached.centre;
    let turn = turn_between(&reached.normal, &goal.normal);
    let mut matrix = SMatrix::<f64, FREEDOMS_MAX, FREEDOMS_MAX>::identity();
    let mut right = SVector::<f64, FREEDOMS_MAX>::zeros();
    // Turns about the normal itself are free.
    let across = |axis: &Vec3| axis - reached.normal * reached.normal.dot(axis);
    for i in 0..n {
        let (move_i, turn_i) = (reached.moves[i], across(&reached.turns[i]));
        for k in 0..n {
            matrix[(i, k)] = move_i.dot(&reached.moves[k])
                + TURN * TURN * turn_i.dot(&across(&reached.turns[k]));
        }
        let unease = ease[i] - angles[i];
        right[i] = move_i.dot(&miss) + TURN * TURN * turn_i.dot(&turn) + EASE * EASE * unease;
        matrix[(i, i)] += DAMPING * DAMPING + EASE * EASE;
    }
    let Some(step) = step_within(matrix, right, |i, step| {
        chain.freedoms.get(i).is_some_and(|freedom| freedom.ends(angles[i], step))
    }) else {
        return 0.0;
    };
    let largest = (0..n).map(|i| step[i].abs()).fold(0.0, f64::max);
    let mut scale = (ROUND_MAX / largest.max(1e-300)).min(1.0);
    let now = lack(ease, angles, &reached, goal);
    for _ in 0..TRIALS {
        let mut trial = *angles;
        for i in 0..n {
            let [low, high] = chain.freedoms[i].range;
            trial[i] = (angles[i] + step[i] * scale).clamp(low.min(angles[i]), high.max(angles[i]));
        }
        if lack(ease, &trial, &chain.reach(&trial), goal) < now {
            *angles = trial;
            return largest * scale;
        }
        scale *= 0.5;
    }
    0.0
}

/// Returns the cost that rounds reduce: weighted squares of the way, of the turn and of unease.
fn lack(ease: &Angles, angles: &Angles, reached: &PadKinematics, goal: &Goal) -> f64 {
    let turn = turn_between(&reached.normal, &goal.normal);
    let unease = ease.iter().zip(angles).map(|(ease, angle)| (ease - angle).powi(2));
    (goal.centre - reached.centre).norm_squared()
        + TURN * TURN * turn.norm_squared()
        + EASE * EASE * unease.sum::<f64>()
}

/// The rotation vector that turns one direction into the other, without a turn about either.
fn turn_between(from: &Vec3, to: &Vec3) -> Vec3 {
    let axis = from.cross(to);
    let (sin, cos) = (axis.norm(), from.dot(to));
    match sin < 1e-9 {
        false => axis * (sin.atan2(cos) / sin),
        true if cos > 0.0 => Vec3::zeros(),
        // Half a turn, about whatever lies across.
        true => tangents(from).0 * PI,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use crate::reach::PadPlace;
    use thenar_core::model::Digit;
    use thenar_core::random::Random;

    /// Places that digits reach at angles drawn from their ranges are reached from ease, but for
    /// what ease and turn bend.
    #[test]
    fn places_within_reach_are_reached() {
        let hand = fixture::hand(false);
        let mut random = Random::new(3);
        for digit in Digit::FINGERS {
            let chain = Chain::new(&hand, digit, PadPlace::Tip).expect("a chain");
            for _ in 0..50 {
                let mut there = chain.ease();
                for (angle, freedom) in there.iter_mut().zip(&chain.freedoms) {
                    let [low, high] = freedom.range;
                    *angle = random.range(low, high);
                }
                let reached = chain.reach(&there);
                let goal = Goal { centre: reached.centre, normal: reached.normal };
                let mut angles = chain.ease();
                let miss = solve(&chain, &chain.ease(), &mut angles, &goal, 60);
                assert!(miss < 1e-3, "{digit:?}: {miss} m of {there:?}");
                assert_eq!(angles, chain.within(angles), "within the ranges");
            }
        }
    }

    /// A goal that stands still is held still, also where the pad cannot be turned to it: one round
    /// after the other at most a hair's breadth of 0.1 mm at an arm of 100 mm.
    #[test]
    fn what_stands_still_is_held_still() {
        let hand = fixture::hand(false);
        let mut random = Random::new(5);
        for digit in Digit::FINGERS {
            let chain = Chain::new(&hand, digit, PadPlace::Tip).expect("a chain");
            for _ in 0..100 {
                let mut there = chain.ease();
                for (angle, freedom) in there.iter_mut().zip(&chain.freedoms) {
                    let [low, high] = freedom.range;
                    *angle = random.range(low, high);
                }
                let centre = chain.reach(&there).centre;
                let way = random.vector(1.0);
                let Some(normal) = way.try_normalize(0.1) else { continue };
                let goal = Goal { centre, normal };
                let mut angles = chain.ease();
                solve(&chain, &chain.ease(), &mut angles, &goal, 300);
                let before = angles;
                for _ in 0..2 {
                    solve(&chain, &chain.ease(), &mut angles, &goal, 1);
                    let moved = (0..FREEDOMS_MAX).map(|k| (angles[k] - before[k]).abs());
                    let most = moved.fold(0.0, f64::max);
                    assert!(most < 1e-3, "{digit:?}: {most} rad at {before:?}, normal {normal:?}");
                }
            }
        }
    }

    /// A pad that looks the opposite way turns round as far as its joints let it.
    #[test]
    fn an_opposite_normal_turns_the_pad() {
        let hand = fixture::hand(false);
        let chain = Chain::new(&hand, Digit::Thumb, PadPlace::Tip).expect("a chain");
        let reached = chain.reach(&chain.ease());
        let goal = Goal { centre: reached.centre, normal: -reached.normal };
        let mut angles = chain.ease();
        solve(&chain, &chain.ease(), &mut angles, &goal, 100);
        let turned = chain.reach(&angles).normal.dot(&goal.normal);
        assert!(turned > -0.99, "cosine {turned}");
    }

    /// The columns of the Jacobian are differences.
    #[test]
    fn moves_are_derivatives_of_the_place() {
        let hand = fixture::hand(true);
        let chain = Chain::new(&hand, Digit::Thumb, PadPlace::Tip).expect("a chain");
        let at = chain.ease();
        let reached = chain.reach(&at);
        for k in 0..chain.freedoms.len() {
            let step = |e: f64| {
                let mut moved = at;
                moved[k] += e;
                chain.reach(&moved)
            };
            let (low, high) = (step(-1e-6), step(1e-6));
            let place = (high.centre - low.centre) / 2e-6;
            let normal = (high.normal - low.normal) / 2e-6;
            assert!((place - reached.moves[k]).norm() < 1e-8, "{k}");
            assert!((normal - reached.turns[k].cross(&reached.normal)).norm() < 1e-6, "{k}");
        }
    }

    /// A goal out of reach is approached as near as a digit goes: along the line to it when the
    /// digit is straight.
    #[test]
    fn what_is_out_of_reach_is_approached() {
        let hand = fixture::hand(false);
        let chain = Chain::new(&hand, Digit::Index, PadPlace::Tip).expect("a chain");
        let straight = chain.within([0.0; FREEDOMS_MAX]);
        let tip = chain.reach(&straight);
        let knuckle = hand.joints[chain.bones[1] - 1].pose_PJ.position;
        let along = (tip.centre - knuckle).normalize();
        let goal = Goal { centre: tip.centre + along * 0.05, normal: tip.normal };
        let mut angles = chain.ease();
        let miss = solve(&chain, &chain.ease(), &mut angles, &goal, 200);
        assert!((miss - 0.05).abs() < 1e-3, "{miss}");
    }
}
