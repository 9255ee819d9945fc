//! Pads that meet on the tracked hand meet on ours.
//!
//! Hands differ in their proportions, so equal rotations bring a thumb and a finger that touch to
//! places some centimetres apart. As the tracked pads come near, the pads of our hand are therefore
//! brought to each other, at the distance of the tracked ones times the size of the hand [Handa et
//! al. 2020, DexPilot, does so for robots' hands]:
//!
//! ```text
//!  weight 1 ──────╮            press ─────╮
//!                  ╲                       ╲
//!         0         ╰──────          0      ╰────────
//!              LED[1]  LED[0]       PRESSED[1] PRESSED[0]
//!                    gap between the tracked pads
//! ```
//!
//! `weight` is how much pads that meet count for the thumb, which several fingers share, and how
//! far each digit goes from where rotations bring it; `press` is how far pads go into each other,
//! since trackers do not see force. Pads that do not face each other are left alone: a thumb on the
//! back of a finger pinches nothing.

use crate::calibration::{BoneLengths, RATIOS};
use crate::reach::{ALONG, Angles, Chain, FREEDOMS_MAX, PadKinematics, PadPlace, step_within};
use crate::recording::TRACKED_JOINTS;
use crate::retarget::tracked_index;
use nalgebra::{SMatrix, SVector};
use thenar_core::model::{Digit, HandModel};
use thenar_core::{Pose, Quat, Vec3};

/// Depth to which pads that meet press into each other \[m\]: pads that face each other at an angle
/// touch some 3 mm later, and two bent digits of the usual hand, the drives of their joints (some
/// 330 N/m at a tip) and the flesh of their pads, give 1.5 N for the 8 mm that are left (180 N/m
/// were measured for both together).
const PRESS: f64 = 11e-3;
/// Gap at which pads are led by rotations alone, and from which on by each other, in sums of their
/// radii: from a pad's breadth and a half to what trackers err by at a fingertip (some 4 mm of 17).
const LED: [f64; 2] = [1.5, 0.25];
/// Gap at which pads begin to press, and from which on they press fully, in sums of their radii.
/// Between them pads touch where the tracked ones are some 5 mm apart.
const PRESSED: [f64; 2] = [0.5, 0.1];
/// Cosines of the angle between a pad's normal and the way to the other from which on it faces it,
/// and from which on fully. The thumb's first: people touch a finger's pad with its tip or its side
/// as well, at right angles to its pad (headsets see some 77° in a pinch of the tips), and only its
/// back touches nothing. A finger touches with its pad, fully up to 60°: the thumb lies along the
/// side of a fist.
const FACING: [[f64; 2]; 2] = [[-0.5, 0.0], [0.0, 0.5]];
/// Stages in which digits find each other: first they turn to face as far as they can without
/// leaving the tracked angles too far, then their pads close what is left between them.
const STAGES: [Stage; 2] =
    [Stage { turn: 0.02, ease: 0.025, rounds: 8 }, Stage { turn: 0.003, ease: 0.004, rounds: 8 }];
/// Damping \[m/rad\]: a twenty-fifth of the square of a finger's arm of 50 mm.
const DAMPING: f64 = 0.01;
/// Largest change of an angle in one round \[rad\].
const ROUND_MAX: f64 = 0.25;
/// A step is tried so often, at last a sixteenth of it.
const TRIALS: usize = 5;
/// Most digits: the thumb, then the fingers.
const DIGITS: usize = 5;
const UNKNOWNS: usize = DIGITS * FREEDOMS_MAX;

/// Digits that oppose each other, ours and the tracked ones.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct Meeting {
    /// The thumb first.
    tips: Vec<Tip>,
    bones: BoneLengths,
    /// Depth to which pads that touch press into each other \[m\].
    press: f64,
}

/// One digit up to its end.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
struct Tip {
    chain: Chain,
    /// Tracked joint of its last bone; the tracked tip is the next.
    joint: usize,
}

/// Weights of one stage of the search, and its length.
#[derive(Clone, Copy, Debug)]
struct Stage {
    /// Weight of pads that do not face each other beside their distance \[m/rad\].
    turn: f64,
    /// Weight of a way off the angles at its beginning \[m/rad\].
    ease: f64,
    /// Most rounds.
    rounds: usize,
}

/// A finger's pad that is to meet the thumb's.
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    /// Part of the way from where rotations bring them to where they meet.
    weight: f64,
    /// Distance from the bones' axes at which the two pads are to coincide \[m\], the thumb's
    /// first.
    stand_off: [f64; 2],
}

impl Meeting {
    /// The pads of `hand`; `None` where it has no thumb or no finger that trackers know.
    pub fn of(hand: &HandModel) -> Option<Self> {
        let tip = |digit: &Digit| {
            let chain = Chain::new(hand, *digit, PadPlace::Tip)?;
            let joint = tracked_index(&hand.bones[chain.pad.bone])?;
            let ends = TRACKED_JOINTS.get(joint + 1)?.ends_with("-tip");
            ends.then_some(Tip { chain, joint })
        };
        let mut tips = vec![tip(&Digit::Thumb)?];
        tips.extend(Digit::FINGERS[1..].iter().filter_map(tip));
        (tips.len() > 1).then(|| Self { tips, bones: BoneLengths::of(hand), press: PRESS })
    }

    /// Lets pads that touch do no more than touch.
    pub fn without_press(&mut self) {
        self.press = 0.0;
    }

    /// Moves `angles` \[rad\], found from rotations, so that pads meet which meet in `tracked`;
    /// `rotation_WP` is our palm's.
    pub fn apply(&self, tracked: &[Pose; 25], rotation_WP: &Quat, angles: &mut [[f64; 2]]) {
        let ratio = self.bones.ratio(tracked).filter(|ratio| RATIOS.contains(ratio));
        let Some(ratio) = ratio else { return };
        let mut start = [[0.0; FREEDOMS_MAX]; DIGITS];
        for (start, tip) in start.iter_mut().zip(&self.tips) {
            *start = tip.chain.read(angles);
        }
        let mut pairs = [Pair::default(); DIGITS];
        let thumb = self.tips[0].chain.reach(&start[0]);
        for (k, tip) in self.tips.iter().enumerate().skip(1) {
            // Distances of the tracked hand, as large as ours is and as our palm sees them.
            let way = tip.tracked(tracked) - self.tips[0].tracked(tracked);
            let pads = rotation_WP.inverse_transform_vector(&way) / ratio;
            let radii = [&self.tips[0], tip].map(|tip| tip.chain.pad.radius);
            pairs[k] = Pair::new(radii, self.press, [&thumb, &tip.chain.reach(&start[k])], &pads);
        }
        pairs[0].weight = pairs.iter().map(|pair| pair.weight).fold(0.0, f64::max);
        if pairs[0].weight == 0.0 {
            return;
        }
        let mut met = start;
        for stage in &STAGES {
            let from = met;
            for _ in 0..stage.rounds {
                if !self.round(stage, &pairs, &from, &mut met) {
                    break;
                }
            }
        }
        for ((tip, pair), (start, met)) in self.tips.iter().zip(&pairs).zip(start.iter().zip(&met))
        {
            let part = |k: usize| start[k] + (met[k] - start[k]) * pair.weight;
            tip.chain.write(&std::array::from_fn(part), angles);
        }
    }

    /// One step of damped least squares, within the joints' ranges, towards where
    ///
    /// ```text
    /// Σ w (|p_f - p_t|² + turn² |n_f + n_t|²) + ease² |q - q_start|²
    /// ```
    ///
    /// is least, with `p` the middles of the pads of finger and thumb and `n` their normals. False
    /// where nothing less is found.
    fn round(
        &self,
        stage: &Stage,
        pairs: &[Pair; DIGITS],
        start: &[Angles; DIGITS],
        at: &mut [Angles; DIGITS],
    ) -> bool {
        let mut matrix = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::identity();
        let mut right = SVector::<f64, UNKNOWNS>::zeros();
        let mut reached = [None; DIGITS];
        for (d, tip) in self.tips.iter().enumerate().filter(|(d, _)| pairs[*d].weight > 0.0) {
            reached[d] = Some(tip.chain.reach(&at[d]));
            for k in 0..tip.chain.freedoms.len() {
                let i = d * FREEDOMS_MAX + k;
                matrix[(i, i)] = stage.ease * stage.ease + DAMPING * DAMPING;
                right[i] = stage.ease * stage.ease * (start[d][k] - at[d][k]);
            }
        }
        let Some(thumb) = reached[0] else { return false };
        for (d, pair) in pairs.iter().enumerate().skip(1) {
            let Some(finger) = reached[d] else { continue };
            let sides = [(0, &thumb, -1.0), (d, &finger, 1.0)];
            let pads = [0, 1].map(|s| sides[s].1.centre + sides[s].1.normal * pair.stand_off[s]);
            let (apart, facing) = (pads[1] - pads[0], thumb.normal + finger.normal);
            let column = |(side, k): (usize, usize)| {
                let (d, reached, sign) = sides[side];
                let turned = reached.turns[k].cross(&reached.normal);
                let moved = (reached.moves[k] + turned * pair.stand_off[side]) * sign;
                (d * FREEDOMS_MAX + k, moved, turned)
            };
            let freedoms = |side: usize| {
                let count = self.tips[sides[side].0].chain.freedoms.len();
                (0..count).map(move |k| (side, k))
            };
            for (i, moved_i, turned_i) in freedoms(0).chain(freedoms(1)).map(column) {
                for (j, moved_j, turned_j) in freedoms(0).chain(freedoms(1)).map(column) {
                    let turn = stage.turn * stage.turn * turned_i.dot(&turned_j);
                    matrix[(i, j)] += pair.weight * (moved_i.dot(&moved_j) + turn);
                }
                let turn = stage.turn * stage.turn * turned_i.dot(&facing);
                right[i] -= pair.weight * (moved_i.dot(&apart) + turn);
            }
        }
        let Some(step) = step_within(matrix, right, |i, step| {
            let (d, k) = (i / FREEDOMS_MAX, i % FREEDOMS_MAX);
            let freedom = self.tips.get(d).and_then(|tip| tip.chain.freedoms.get(k));
            freedom.is_some_and(|freedom| freedom.ends(at[d][k], step))
        }) else {
            return false;
        };
        let freedoms = || {
            let tips = self.tips.iter().enumerate();
            tips.flat_map(|(d, tip)| {
                tip.chain.freedoms.iter().enumerate().map(move |(k, freedom)| (d, k, freedom.range))
            })
        };
        // The whole step, or so much of it that the sum falls.
        let now = self.lack(stage, pairs, start, at);
        let mut scale = (ROUND_MAX / step.amax().max(ROUND_MAX)).min(1.0);
        for _ in 0..TRIALS {
            let mut trial = *at;
            for (d, k, [low, high]) in freedoms() {
                let moved = at[d][k] + step[d * FREEDOMS_MAX + k] * scale;
                trial[d][k] = moved.clamp(low.min(at[d][k]), high.max(at[d][k]));
            }
            if self.lack(stage, pairs, start, &trial) < now {
                *at = trial;
                return true;
            }
            scale *= 0.5;
        }
        false
    }

    /// The sum that rounds make less.
    fn lack(
        &self,
        stage: &Stage,
        pairs: &[Pair; DIGITS],
        start: &[Angles; DIGITS],
        at: &[Angles; DIGITS],
    ) -> f64 {
        let thumb = self.tips[0].chain.reach(&at[0]);
        let mut sum = 0.0;
        for (d, tip) in self.tips.iter().enumerate().filter(|(d, _)| pairs[*d].weight > 0.0) {
            let ways = start[d].iter().zip(&at[d]).map(|(start, at)| (at - start).powi(2));
            sum += stage.ease * stage.ease * ways.sum::<f64>();
            if d > 0 {
                let Pair { weight, stand_off } = pairs[d];
                let finger = tip.chain.reach(&at[d]);
                let apart = finger.centre + finger.normal * stand_off[1]
                    - (thumb.centre + thumb.normal * stand_off[0]);
                let facing = (finger.normal + thumb.normal).norm_squared();
                sum += weight * (apart.norm_squared() + stage.turn * stage.turn * facing);
            }
        }
        sum
    }
}

impl Pair {
    /// The pads of thumb and finger, of these radii, which rotations bring to `reached`; `pads` is
    /// the way from the tracked thumb's pad to the finger's \[m\].
    fn new(radii: [f64; 2], press: f64, reached: [&PadKinematics; 2], pads: &Vec3) -> Self {
        let sum = radii[0] + radii[1];
        let gap = pads.norm() - sum;
        let Some(towards) = pads.try_normalize(1e-6) else { return Self::default() };
        let [thumb, finger] = reached.map(|reached| reached.normal.dot(&towards));
        let faces = |cosine, [from, fully]: [f64; 2]| smooth((cosine - from) / (fully - from));
        let facing = faces(thumb, FACING[0]).min(faces(-finger, FACING[1]));
        let weight = facing * over(gap / sum, LED);
        let distance = sum + gap.max(0.0) - press * over(gap / sum, PRESSED);
        Self { weight, stand_off: radii.map(|radius| radius * distance / sum) }
    }
}

impl Tip {
    /// The tracked digit's pad, on its last bone.
    fn tracked(&self, joints: &[Pose; 25]) -> Vec3 {
        joints[self.joint].position.lerp(&joints[self.joint + 1].position, ALONG)
    }
}

/// From 0 at the first gap to 1 at the second, which is smaller.
fn over(gap: f64, [far, near]: [f64; 2]) -> f64 {
    smooth((far - gap) / (far - near))
}

/// Rises from 0 at 0 to 1 at 1, level at both.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests;
