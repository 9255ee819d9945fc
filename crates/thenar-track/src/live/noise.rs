//! Memory for noise: samples are remembered as long as their noise would be felt, and no longer.
//!
//! White noise of E at a pad, seen every P seconds, is led on by observer and follower, which are
//! late by D together, as `0.74 E √(P/D)` below 40 Hz (0.67 to 0.79, by sums of Fourier from 60 to
//! 1000 Hz and 14 to 300 ms of memory). No filter does much better. A spring to what it leads on
//! takes `K d(ω)`, `d = -Im G(ω)/ω`, off the damping of whoever holds it, D at the worst ω. Of a
//! causal filter with `G(0) = 1` the integral of d over all ω is π/2 (Kramers and Kronig), and half
//! of its power is that of `ω d`, so that it is least where d is D up to `π/4D` and falls with 1/ω²
//! beyond: `0.64 E √(P/D)`.
//!
//! Above 40 Hz they lead on up to `0.33 E (t/M)^2.5` at a memory of M, with t the shortest, up to
//! 50 ms, where the follower is as loose as it becomes, and still less beyond.

use super::OBSERVATION;
use super::memory::Memory;
use super::observer::{MEMORY, longer};
use crate::AngleRange;
use thenar_core::Vec3;
use thenar_core::model::{Digit, HandModel};

/// Longest memory \[s\]: 1 mm, with as much of knuckles 8 cm away, and 2 degrees of each joint,
/// which are 3.7 mm at a pad, call for it at 90 Hz on [`FIRM`], 0.18 s late. What is noisier is
/// felt as noisier, and not softer still.
const LONGEST: f64 = 0.33;
/// Stiffness on which noise up to 50 ms of memory is judged, however soft it is felt \[N/m\]: a
/// hand that is held still may be felt stiffer in the next second.
const FIRM: f64 = 160.0;
/// Wanders of the force that may be felt \[N\]: below 40 Hz a 25th of a pinch of 3 N, above it 5
/// mN; and a tenth less, by which some seconds of them are more than they are on the mean.
const SLOW: f64 = 0.04 * 3.0 / 1.1;
const FAST: f64 = 5e-3 / 1.1;
/// Part of `E √(P/D)` that is led on below 40 Hz.
const LED_ON: f64 = 0.74;
/// Part of E that is led on above 40 Hz at the shortest memory, and by which power it falls with
/// memory.
const SHAKES: [f64; 2] = [0.33, 2.5];
/// Part of the delay that the follower has at its loosest \[s\]: twice its time of 10 ms.
const FOLLOWER: f64 = 0.02;

/// Stiffness that a hand is felt with, by its couplings and by the delay that its grip bears.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FeltSpring {
    /// Stiffness of the couplings alone \[N/m\].
    pub coupling: f64,
    /// Damping that the delay may use up \[N s/m\]; infinite where no rule bounds what is felt.
    pub damping: f64,
    /// Delay behind a tracker without noise, from motion to force \[s\].
    pub delay: f64,
}

impl FeltSpring {
    /// Stiffness where noise is remembered no longer than motion, in N/m.
    pub fn quiet(&self) -> f64 {
        self.stiffness(MEMORY[0])
    }

    /// Stiffness where noise is remembered for `memory` \[s\], in N/m.
    pub fn stiffness(&self, memory: f64) -> f64 {
        let bound = self.damping / (self.delay + OBSERVATION.noisy * longer(memory));
        // A delay that is no number bears nothing.
        if bound.is_nan() { 0.0 } else { self.coupling.min(bound) }
    }

    /// Least memory \[s\] by which this noise \[m\] of samples `gap` \[s\] apart is felt as little
    /// as wanted: a longer one is later, and felt softer.
    fn memory(&self, noise: f64, gap: f64) -> f64 {
        let called_for = |memory: f64| longest(noise, gap, self.stiffness(memory));
        let [mut short, mut long] = [MEMORY[0], LONGEST];
        if called_for(short) <= short {
            return short;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (short + long);
            if called_for(middle) > middle { short = middle } else { long = middle }
        }
        long
    }
}

/// Halvings by which memory is found to a microsecond.
const HALVINGS: usize = 19;

/// Distances of the places where a hand is felt from what turns them \[m\].
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct LeverArms {
    /// From the wrist to the last bone that is farthest.
    wrist: f64,
    /// Per finger: joint, axis and distance to its last bone's centre, for each that bends it.
    fingers: Vec<Vec<(usize, usize, f64)>>,
}

impl LeverArms {
    /// Levers of a hand at rest.
    pub fn of(hand: &HandModel, ranges: &[Option<AngleRange>]) -> Self {
        let last = |digit: Digit| hand.bones.iter().rfind(|bone| bone.digit == digit);
        let from =
            |at: Vec3, digit| last(digit).map_or(0.0, |bone| (bone.pose_MB.position - at).norm());
        let wrist =
            hand.bones.first().map_or(Vec3::zeros(), |root| (root.pose_MB * root.pose_BT).position);
        let joint = |j: usize| (hand.bones[j + 1].pose_MB * hand.joints[j].pose_CK).position;
        let bends = |(finger, digit): (usize, &Digit)| {
            // Knuckle, spread, middle and end: what spreads a finger does not press it.
            let found = [0, 2, 3].map(|k| ranges.get(4 * finger + k).and_then(Option::as_ref));
            let each = found.into_iter().flatten();
            each.map(|range| (range.index, range.axis, from(joint(range.index), *digit))).collect()
        };
        Self {
            wrist: Digit::FINGERS.map(|digit| from(wrist, digit)).into_iter().fold(0.0, f64::max),
            fingers: Digit::FINGERS.iter().enumerate().map(bends).collect(),
        }
    }

    /// Noise in one direction of the finger that has most \[m\], by what samples have been off of
    /// late.
    fn noise(&self, memory: &Memory, gap: f64) -> f64 {
        let [place, turn] =
            [&memory.position.noise_square(gap), &memory.rotation.noise_square(gap)];
        // A third of each is along a given axis.
        let wrist = (place + turn * self.wrist * self.wrist) / 3.0;
        let finger = |joints: &Vec<(usize, usize, f64)>| {
            let each = joints.iter().map(|(joint, axis, lever)| {
                memory.joints[*joint][*axis].noise_square(gap) * lever * lever
            });
            each.sum::<f64>()
        };
        (wrist + self.fingers.iter().map(finger).fold(0.0, f64::max)).sqrt()
    }

    /// Longest memory that the noise of its samples, `gap` \[s\] apart, calls for where it is felt
    /// on this spring, in seconds. Delay costs stiffness: beyond 50 ms only for what would be felt.
    pub fn longest(&self, memory: &Memory, gap: f64, spring: &FeltSpring) -> f64 {
        let noise = self.noise(memory, gap);
        longest(noise, gap, FIRM).min(MEMORY[1]).max(spring.memory(noise, gap))
    }
}

/// Memory \[s\] by which this noise \[m\] of samples that are `gap` \[s\] apart is felt as little
/// as wanted on this stiffness \[N/m\].
fn longest(noise: f64, gap: f64, stiffness: f64) -> f64 {
    let force = stiffness * noise;
    let fast = MEMORY[0] * (SHAKES[0] * force / FAST).powf(1.0 / SHAKES[1]);
    let late = gap * (LED_ON * force / SLOW).powi(2);
    // A memory of M is late by M/2, but for half the gap, which counts as the tracker's.
    let slow = 2.0 * (late - FOLLOWER) + gap;
    // Shorter ones have a tighter follower.
    let slow = if slow > MEMORY[1] { slow } else { 0.0 };
    fast.min(MEMORY[1]).max(slow).clamp(MEMORY[0], LONGEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2.3 mm, of a millimetre and as much of knuckles 8 cm away, seen at 90 Hz: 69 ms late. A
    /// tenth of a millimetre is hardly remembered longer than motion is; round-off no longer, and
    /// an inch as long as may be. On an eighth of the stiffness eight times the noise is felt as
    /// much; where nothing is felt none is remembered longer.
    #[test]
    fn memory_is_as_long_as_noise_is_felt() {
        let gap = 1.0 / 90.0;
        let on_firm = |noise| longest(noise, gap, FIRM);
        let late = 0.5 * (on_firm(2.3e-3) - gap) + FOLLOWER;
        assert!(
            (late - gap * (0.74_f64 * 2.3 * 1.1 / 0.75).powi(2)).abs() < 1e-12 && late > 0.065,
            "{late}"
        );
        let little = on_firm(1e-4);
        assert!(little < 1.1 * MEMORY[0], "{little} s");
        assert_eq!([on_firm(0.0), on_firm(1e-6), longest(0.0254, gap, 0.0)], [MEMORY[0]; 3]);
        assert_eq!(on_firm(0.0254), LONGEST);
        let soft = longest(8.0 * 2.3e-3, gap, FIRM / 8.0);
        assert!((soft - on_firm(2.3e-3)).abs() < 1e-12, "{soft} s");
    }

    /// A firmer grip is never felt softer, and what it is felt of noise stays within what is wanted
    /// where memory is not at its end. Without the rule memory is that of the couplings.
    #[test]
    fn firmer_grips_are_felt_no_softer() {
        let gap = 1.0 / 90.0;
        for noise in [1e-4, 1.4e-3, 2.3e-3, 3.7e-3, 0.01] {
            let mut before = 0.0;
            for step in 0..200 {
                let damping = 0.2 * 1.03_f64.powi(step);
                let spring = FeltSpring { coupling: FIRM, damping, delay: 0.02 };
                let memory = spring.memory(noise, gap);
                let stiffness = spring.stiffness(memory);
                assert!(stiffness > before * (1.0 - 1e-4), "{noise} m, {damping}: {stiffness}");
                before = stiffness;
                let called_for = longest(noise, gap, stiffness);
                assert!(called_for <= memory + 1e-6 || memory > LONGEST - 1e-5, "{called_for}");
            }
            let unbounded = FeltSpring { coupling: FIRM, damping: f64::INFINITY, delay: 0.02 };
            assert!((unbounded.memory(noise, gap) - longest(noise, gap, FIRM)).abs() < 1e-6);
            let unknown = FeltSpring { delay: f64::NAN, ..unbounded };
            assert_eq!(unknown.memory(noise, gap), MEMORY[0]);
        }
    }
}
