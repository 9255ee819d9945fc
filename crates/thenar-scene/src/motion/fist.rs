//! The fist of a hand: how far its fingers bend depends on how long they and how thick the palm is.
//!
//! Fingers bend side by side, in their outer joints as far as these go, at the knuckles until a
//! fingertip presses on the palm. The thumb lies across the middle phalanges of index and middle
//! finger. Angles may be beyond a joint's range by a sixth: a fist is squeezed, and the joint's end
//! holds.

use thenar_core::model::{Digit, HandModel};
use thenar_core::readout::TaxelSkin;
use thenar_core::{Pose, Vec3};
use thenar_track::reach::{Chain, Goal, Pad, PadPlace, solve};
use thenar_track::{Anatomy, Articulation};

/// Parts of where their ranges end to which the second and the third joint of a finger are pulled:
/// flesh in the bend of the second resists, and holds it some degrees short of its end.
const OUTER: [f64; 2] = [1.1, 0.92];
/// Parts of where a knuckle's range ends that are tried, the first and the last: a knuckle at its
/// end is pulled on.
const KNUCKLE: [f64; 2] = [0.5, 1.15];
/// Number of steps from the first to the last: 2° each.
const TRIED: u32 = 30;
/// Distance that fingertips are pulled into the palm, of the length of a hand: 6 mm of 190. Usual
/// drives (500 N/m at a fingertip) would give 3 N, but for what bends before.
const SQUEEZE: f64 = 6.0 / 190.0;
/// Distance that the thumb presses in: half of that.
const PRESS: f64 = 0.5 * SQUEEZE;
/// A thumb that ends farther from its place than this, of the length of a hand, has not found it:
/// 10 mm of 190.
const MISS: f64 = 10.0 / 190.0;
/// Farthest that a finger goes aside, so that it lies beside its neighbour \[rad\].
const ASIDE_MAX: f64 = 0.2;
/// Joints whose range ends farther on bend no finger of a person \[rad\]: 130°.
const BEND_MAX: f64 = 2.27;
/// Rounds of inverse kinematics for the thumb.
const ROUNDS: usize = 60;

/// Both angles of all joints of a hand in its fist \[rad\], the thumb over these fingers; `None`
/// for a hand that lacks a digit or joints that bend it.
pub(super) fn fist(
    hand: &HandModel,
    articulation: &Articulation,
    anatomy: &Anatomy,
    thumb_over: &[Digit],
) -> Option<Vec<[f64; 2]>> {
    let mut fist = Fist {
        hand,
        articulation,
        skin: TaxelSkin::new(&hand.flesh, Vec::new()),
        angles: articulation.rest_angles.clone(),
        poses: vec![Pose::identity(); hand.bones.len()],
    };
    let fingers: Option<Vec<_>> = Digit::FINGERS[1..]
        .iter()
        .map(|digit| Finger::of(hand, articulation, anatomy, *digit))
        .collect();
    let fingers = fingers?;
    for finger in &fingers {
        fist.bend(finger);
    }
    // The middle finger stays, the others come to it from both sides.
    for (finger, beside) in [(0, 1), (2, 1), (3, 2)] {
        fist.come_beside(&fingers[finger], &fingers[beside]);
    }
    fist.lay_thumb(fingers.iter().filter(|finger| thumb_over.contains(&finger.digit)))?;
    Some(fist.angles)
}

/// A finger: its pads, and the angles that bend and spread it.
struct Finger {
    digit: Digit,
    tip: Pad,
    side: Pad,
    /// Joint, angle, and where its range ends in the sense that closes \[rad\]; from the knuckle
    /// outwards.
    bends: [(usize, usize, f64); 3],
    /// Joint and angle that spread it.
    spread: Option<(usize, usize)>,
}

impl Finger {
    /// `None` for a finger with more or fewer joints than three, or with one that has no end.
    fn of(
        hand: &HandModel,
        articulation: &Articulation,
        anatomy: &Anatomy,
        digit: Digit,
    ) -> Option<Self> {
        let chain = Chain::new(hand, digit, PadPlace::Tip)?;
        let side = Chain::new(hand, digit, PadPlace::Side)?.pad;
        let (mut bends, mut spread) = (Vec::new(), None);
        for freedom in &chain.freedoms {
            let (joint, axis) = (freedom.joint, freedom.axis);
            let role = anatomy.roles.get(joint)?;
            if let Some((_, sense)) = role.flexion.filter(|(flexion, _)| *flexion == axis) {
                let limit = articulation.tree.limits(joint)[axis]?;
                let end = if sense > 0.0 { limit.max } else { limit.min };
                if !(0.0..BEND_MAX).contains(&(sense * end)) {
                    return None;
                }
                bends.push((joint, axis, end));
            } else if role.spread.is_some_and(|(spread, _)| spread == axis) {
                spread = spread.or(Some((joint, axis)));
            }
        }
        Some(Self { digit, tip: chain.pad, side, bends: bends.try_into().ok()?, spread })
    }
}

/// A hand that is being closed, in the frame of its palm.
struct Fist<'a> {
    hand: &'a HandModel,
    articulation: &'a Articulation,
    skin: TaxelSkin<'a>,
    angles: Vec<[f64; 2]>,
    poses: Vec<Pose>,
}

impl Fist<'_> {
    fn forward(&mut self) {
        self.articulation.tree.forward(&Pose::identity(), &self.angles, &mut self.poses);
    }

    /// Bends a finger until its tip presses on the palm, or as far as it goes.
    fn bend(&mut self, finger: &Finger) {
        let [knuckle, outer @ ..] = finger.bends;
        for (bend, part) in outer.into_iter().zip(OUTER) {
            self.pull(bend, part);
        }
        for i in 0..=TRIED {
            let part = f64::from(i) / f64::from(TRIED);
            self.pull(knuckle, KNUCKLE[0] + (KNUCKLE[1] - KNUCKLE[0]) * part);
            self.forward();
            if self.clearance(&finger.tip).is_some_and(|clear| clear < -SQUEEZE * self.hand.length)
            {
                return;
            }
        }
    }

    /// Pulls a joint to a part of where its range ends, beyond that end or within its range.
    fn pull(&mut self, (joint, axis, end): (usize, usize, f64), part: f64) {
        self.angles[joint][axis] = part * end;
        if part < 1.0 {
            self.angles[joint][axis] = self.clamped(joint, axis);
        }
    }

    /// An angle of a joint within its range \[rad\].
    fn clamped(&self, joint: usize, axis: usize) -> f64 {
        self.articulation.tree.clamp(joint, self.angles[joint])[axis]
    }

    /// Way from a fingertip to the hand's skin at rest below its palm, along the palm's normal
    /// \[m\]; `None` where there is none.
    fn clearance(&self, tip: &Pad) -> Option<f64> {
        let last = &self.hand.bones[tip.bone];
        let along_B = (last.ends_B[1] - last.ends_B[0]).try_normalize(1e-9)?;
        // The end of the finger is as round as its pad is thick.
        let end_B = last.ends_B[1]
            + along_B * (self.way(tip.bone, &last.ends_B[1], &along_B)? - tip.radius);
        let end = self.poses[tip.bone].point(&end_B);
        // From within the flesh, at the height of the palm's bone.
        let palm = &self.hand.bones[0];
        let within = Vec3::new(end.x, palm.ends_B[0].y.midpoint(palm.ends_B[1].y), end.z);
        Some(within.y - self.way(0, &within, &-Vec3::y())? - end.y - tip.radius)
    }

    /// Way from a point of a bone to the skin at rest, both in the bone's frame \[m\].
    fn way(&self, bone: usize, from_B: &Vec3, along_B: &Vec3) -> Option<f64> {
        let pose_MB = &self.hand.bones[bone].pose_MB;
        self.skin.way(&pose_MB.point(from_B), &pose_MB.vector(along_B))
    }

    /// Spreads a finger so that its middle phalanx lies beside that of its neighbour.
    fn come_beside(&mut self, finger: &Finger, beside: &Finger) {
        let Some((joint, axis)) = finger.spread else { return };
        let mut best = (f64::INFINITY, self.angles[joint][axis]);
        for i in -10..=10 {
            self.angles[joint][axis] = ASIDE_MAX * f64::from(i) / 10.0;
            self.angles[joint][axis] = self.clamped(joint, axis);
            self.forward();
            let off = self.gap(&finger.side, &beside.side).abs();
            if off < best.0 {
                best = (off, self.angles[joint][axis]);
            }
        }
        self.angles[joint][axis] = best.1;
        self.forward();
    }

    /// Gap between two phalanges, at right angles to the second \[m\].
    fn gap(&self, one: &Pad, other: &Pad) -> f64 {
        let centre = |pad: &Pad| self.poses[pad.bone].point(&pad.centre_B);
        let [from, to] = self.hand.bones[other.bone].ends_B;
        let along = self.poses[other.bone].vector(&(to - from).normalize());
        let way = centre(one) - centre(other);
        (way - along * along.dot(&way)).norm() - one.radius - other.radius
    }

    /// Lays the thumb's pad on the backs of fingers, on their middle phalanges and between them.
    fn lay_thumb<'f>(&mut self, fingers: impl Iterator<Item = &'f Finger>) -> Option<()> {
        let thumb = Chain::new(self.hand, Digit::Thumb, PadPlace::Tip)?;
        let (mut place, mut out, mut count) = (Vec3::zeros(), Vec3::zeros(), 0.0);
        for pad in fingers.map(|finger| &finger.side) {
            let [from, to] = self.hand.bones[pad.bone].ends_B;
            let along = (to - from).try_normalize(1e-9)?;
            let back_B = (Vec3::y() - along * along.y).try_normalize(1e-9)?;
            let skin_B = pad.centre_B + back_B * self.way(pad.bone, &pad.centre_B, &back_B)?;
            place += self.poses[pad.bone].point(&skin_B);
            out += self.poses[pad.bone].vector(&back_B);
            count += 1.0;
        }
        let out = out.try_normalize(1e-9)?;
        let goal = Goal {
            centre: place / count + out * (thumb.pad.radius - PRESS * self.hand.length),
            normal: -out,
        };
        let mut angles = thumb.ease();
        if solve(&thumb, &thumb.ease(), &mut angles, &goal, ROUNDS) > MISS * self.hand.length {
            return None;
        }
        thumb.write(&angles, &mut self.angles);
        Some(())
    }
}
