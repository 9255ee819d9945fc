//! Fingertips that are wanted at places in the world.

use super::chain::{Angles, Chain, PadPlace};
use super::solve::{Goal, solve};
use crate::{ANGLES, Articulation, FitError, hand_angles};
use thenar_core::model::{Digit, HandModel};
use thenar_core::{Pose, Vec3};

/// Times that the middle of a pad's skin is brought nearer, as its bone turns meanwhile.
const TURNS: usize = 60;
/// Rounds of inverse kinematics in each.
const ROUNDS: usize = 6;
/// A pad that ends nearer than this is there \[m\]: a tenth of what skin gives way under a light
/// touch.
const THERE: f64 = 1e-4;

/// Digits of a hand that bring the middle of their pads' skin to places.
#[derive(Clone, Debug)]
pub struct Fingertips {
    articulation: Articulation,
    chains: [Option<Chain>; 5],
}

impl Fingertips {
    /// The fingertips of a hand.
    ///
    /// # Errors
    /// Its joints are no tree.
    pub fn new(hand: &HandModel) -> Result<Self, FitError> {
        let articulation = Articulation::new(hand)?;
        let chains = Digit::FINGERS.map(|digit| Chain::new(hand, digit, PadPlace::Tip));
        Ok(Self { articulation, chains })
    }

    /// Bends digits so that the middle of each one's pad is at its place, world \[m\], with the
    /// wrist's frame at `pose_WT`; those without a place, and angles that a place leaves open, stay
    /// near to those given, of all joints \[rad\]. Returns how far each ends from its place \[m\]:
    /// infinity for a digit that cannot be led, zero for one without a place.
    pub fn bend(
        &self,
        pose_WT: &Pose,
        places_W: &[Option<Vec3>; 5],
        angles: &mut [[f64; 2]],
    ) -> [f64; 5] {
        let palm_WB = *pose_WT * self.articulation.pose_BT.inverse();
        std::array::from_fn(|k| {
            let Some(place_W) = &places_W[k] else { return 0.0 };
            let Some(chain) = &self.chains[k] else { return f64::INFINITY };
            let place = palm_WB.inverse_point(place_W);
            let given = chain.within(chain.read(angles));
            // From the angles given, and where those lead nowhere, from ease, bent far and bent
            // little.
            let starts =
                [given, chain.ease(), part_of_range(chain, 0.75), part_of_range(chain, 0.25)];
            let mut best = (f64::INFINITY, given);
            for start in starts {
                let found = bring(chain, &given, start, &place);
                if found.0 < best.0 {
                    best = found;
                }
                if best.0 < THERE {
                    break;
                }
            }
            chain.write(&best.1, angles);
            best.0
        })
    }

    /// The twenty angles of [`hand_angles`] \[rad\] of a hand whose pads are at these places, as
    /// [`Fingertips::bend`] finds them from its rest, and how far each ends from its place \[m\].
    pub fn angles(
        &self,
        hand: &HandModel,
        pose_WT: &Pose,
        places_W: &[Option<Vec3>; 5],
    ) -> ([f64; ANGLES], [f64; 5]) {
        let mut angles = self.articulation.rest_angles.clone();
        let misses = self.bend(pose_WT, places_W, &mut angles);
        let ranges = hand_angles(hand, &self.articulation);
        let of = |k: usize| {
            ranges[k].as_ref().map_or(0.0, |range| range.sense * angles[range.index][range.axis])
        };
        (std::array::from_fn(of), misses)
    }
}

/// Brings the middle of a pad's skin to a place in the palm's frame; how far it ends from there
/// \[m\], and the angles.
fn bring(chain: &Chain, ease: &Angles, start: Angles, place: &Vec3) -> (f64, Angles) {
    let mut angles = start;
    let mut wanted = *place;
    let mut best = (f64::INFINITY, start);
    for _ in 0..TURNS {
        let normal = chain.reach(&angles).normal;
        let goal = Goal { centre: wanted - normal * chain.pad.radius, normal };
        solve(chain, ease, &mut angles, &goal, ROUNDS);
        let reached = chain.reach(&angles);
        let miss = place - (reached.centre + reached.normal * chain.pad.radius);
        if miss.norm() < best.0 {
            best = (miss.norm(), angles);
        }
        // Ease bends a pad off its place; a little beyond it makes up for that.
        wanted = place + (wanted + miss - place).cap_magnitude(chain.pad.radius);
    }
    best
}

/// Angles at this part of their ranges.
fn part_of_range(chain: &Chain, part: f64) -> Angles {
    let mut angles = chain.ease();
    for (angle, freedom) in angles.iter_mut().zip(&chain.freedoms) {
        let [low, high] = freedom.range;
        *angle = low + part * (high - low);
    }
    angles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use thenar_core::random::Random;

    /// Pads are brought again to places taken at angles drawn from their ranges, wherever the wrist
    /// is: to a tenth of a millimetre nine times of ten, and all to a millimetre.
    #[test]
    fn pads_come_to_places_that_they_can_reach() {
        let mut random = Random::new(7);
        for flip in [false, true] {
            let hand = fixture::hand(flip);
            let tips = Fingertips::new(&hand).unwrap();
            let turn = random.vector(1.0);
            let wrist =
                Pose::new(Vec3::new(0.4, 1.1, -0.2), thenar_core::Quat::from_scaled_axis(turn));
            let palm = wrist * tips.articulation.pose_BT.inverse();
            let (mut far, mut worst) = (0, 0.0_f64);
            for _ in 0..20 {
                let mut places = [None; 5];
                for (place, chain) in places.iter_mut().zip(&tips.chains) {
                    let chain = chain.as_ref().unwrap();
                    let mut there = chain.ease();
                    for (angle, freedom) in there.iter_mut().zip(&chain.freedoms) {
                        let [low, high] = freedom.range;
                        *angle = low + (high - low) * (0.5 + 0.4 * random.symmetric());
                    }
                    let reached = chain.reach(&there);
                    *place =
                        Some(palm.point(&(reached.centre + reached.normal * chain.pad.radius)));
                }
                let mut angles = tips.articulation.rest_angles.clone();
                let misses = tips.bend(&wrist, &places, &mut angles);
                for ((chain, place), miss) in tips.chains.iter().zip(&places).zip(misses) {
                    let chain = chain.as_ref().unwrap();
                    let reached = chain.reach(&chain.read(&angles));
                    let there = palm.point(&(reached.centre + reached.normal * chain.pad.radius));
                    assert!(((there - place.unwrap()).norm() - miss).abs() < 1e-12);
                    far += u32::from(miss > THERE);
                    worst = worst.max(miss);
                }
            }
            assert!(far <= 10 && worst < 1e-3, "{far} of 100 pads farther off, {worst} m at most");
        }
    }

    /// A place beyond a finger's length is approached, and told; digits without a place stay at
    /// rest.
    #[test]
    fn what_is_out_of_reach_is_told_and_others_stay() {
        let hand = fixture::hand(false);
        let tips = Fingertips::new(&hand).unwrap();
        let wrist = Pose::identity();
        let mut places = [None; 5];
        places[1] = Some(Vec3::new(-0.025, 0.0, -0.5));
        let (angles, misses) = tips.angles(&hand, &wrist, &places);
        assert!(misses[1] > 0.2 && misses[1] < 0.4, "{misses:?}");
        assert_eq!([misses[0], misses[2], misses[3], misses[4]], [0.0; 4]);
        let ranges = hand_angles(&hand, &tips.articulation);
        for k in (0..ANGLES).filter(|k| k / 4 != 1) {
            assert_eq!(angles[k], ranges[k].as_ref().map_or(0.0, |range| range.rest), "{k}");
        }
    }
}
