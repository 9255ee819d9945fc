//! Trace of a tracker, sample by sample.

use crate::{HandSample, Tracker};
use thenar_core::Vec3;
use thenar_core::model::Side;
use thenar_touch::DIGITS;
use thenar_track::ANGLES;
use thenar_track::live::LivePose;

/// From each bending joint of a straight finger to its tip \[m\], thumb first, of a hand as long as
/// [`LEVER_HAND`]: what an angle moves at the tip.
pub const LEVERS: [[f64; 3]; DIGITS] = [
    [0.106, 0.060, 0.027],
    [0.095, 0.050, 0.024],
    [0.105, 0.055, 0.025],
    [0.098, 0.053, 0.025],
    [0.078, 0.042, 0.023],
];
/// Wrist to middle fingertip of the hand that [`LEVERS`] are of \[m\].
pub const LEVER_HAND: f64 = 0.19;
/// Joints of the fingertips among the 25.
pub const TIPS: [usize; DIGITS] = [4, 9, 14, 19, 24];
/// The three bones of each digit that bend, as a joint and the one before it.
const BENDING: [[[usize; 2]; 3]; DIGITS] = [
    [[1, 0], [2, 1], [3, 2]],
    [[6, 5], [7, 6], [8, 7]],
    [[11, 10], [12, 11], [13, 12]],
    [[16, 15], [17, 16], [18, 17]],
    [[21, 20], [22, 21], [23, 22]],
];

/// Part of a hand whose motion is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComparedPart {
    /// Bending of the fingers.
    Fingers,
    /// Speed of the wrist.
    Wrist,
}

/// Sample of a trace: where a hand was when it was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceSample {
    /// Time of arrival \[s\].
    pub arrived: f64,
    /// Bending of each finger, all joints together \[rad\].
    pub flexion: [f64; DIGITS],
    /// The wrist \[m\].
    pub wrist: Vec3,
    /// Fingertips \[m\]. Of a glove that knows angles only: along y, out of the pads, from the
    /// wrist.
    pub tips: [Vec3; DIGITS],
}

impl TraceSample {
    /// Reads a pose of a hand of this length \[m\].
    pub fn new(arrived: f64, pose: &LivePose, hand_length: f64) -> Self {
        match pose {
            LivePose::Angles { wrist, angles } => {
                Self::of_angles(arrived, wrist.position, angles, hand_length)
            }
            LivePose::Joints { joints, .. } => {
                // Bending turns a bone about x, from -z towards -y.
                let bent = |[joint, before]: [usize; 2]| {
                    let turn = joints[before].rotation.inverse() * joints[joint].rotation;
                    -turn.scaled_axis().x
                };
                Self {
                    arrived,
                    flexion: BENDING.map(|bones| bones.map(bent).iter().sum()),
                    wrist: joints[0].position,
                    tips: TIPS.map(|tip| joints[tip].position),
                }
            }
        }
    }

    fn of_angles(arrived: f64, wrist: Vec3, angles: &[f64; ANGLES], hand_length: f64) -> Self {
        let bending = |d: usize| [angles[4 * d], angles[4 * d + 2], angles[4 * d + 3]];
        let tip = |d: usize| {
            let way: f64 =
                bending(d).iter().zip(LEVERS[d]).map(|(angle, lever)| angle * lever).sum();
            wrist - Vec3::y() * (way * hand_length / LEVER_HAND)
        };
        Self {
            arrived,
            flexion: std::array::from_fn(|d| bending(d).iter().sum()),
            wrist,
            tips: std::array::from_fn(tip),
        }
    }
}

/// The samples of one hand, in the order of their arrival.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// The samples that had a pose.
    pub seen: Vec<TraceSample>,
    /// Number of samples that did not see the hand.
    pub unseen: usize,
}

impl Trace {
    /// Takes what has come from `tracker` since the last time, if anything did. True if it was
    /// something.
    ///
    /// A sample has arrived by `now_ns`, and not after its device was last heard: whoever asks late
    /// does not make it late.
    pub fn take(&mut self, tracker: &mut dyn Tracker, side: Side, now_ns: u64) -> bool {
        let length = tracker.hand_length().unwrap_or(LEVER_HAND);
        let Some(sample) = tracker.latest(side).cloned() else { return false };
        let heard_ns = tracker.heard_ns().unwrap_or(now_ns).min(now_ns);
        self.push(&sample, heard_ns.max(sample.time_ns), length);
        true
    }

    /// Adds a sample that arrived then.
    pub fn push(&mut self, sample: &HandSample, arrived_ns: u64, hand_length: f64) {
        let arrived = arrived_ns as f64 * 1e-9;
        match &sample.pose {
            Some(pose) if self.seen.last().is_none_or(|last| arrived > last.arrived) => {
                self.seen.push(TraceSample::new(arrived, pose, hand_length));
            }
            Some(_) => {}
            None => self.unseen += 1,
        }
    }

    /// Samples per second \[Hz\]; `None` of fewer than ten.
    pub fn rate(&self) -> Option<f64> {
        let span = self.seen.last()?.arrived - self.seen.first()?.arrived;
        let gaps = self.seen.len() - 1;
        (gaps >= 9 && span > 0.0).then_some(gaps as f64 / span)
    }

    /// Samples that arrived between two times \[s\].
    pub fn between(&self, from: f64, to: f64) -> &[TraceSample] {
        let begin = self.seen.partition_point(|seen| seen.arrived < from);
        let end = self.seen.partition_point(|seen| seen.arrived <= to);
        &self.seen[begin..end.max(begin)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::twin::hand::joints;
    use thenar_core::Pose;

    /// A hand of 25 joints that curls by a known angle is bent by it, about whatever the wrist is.
    #[test]
    fn bending_is_the_same_by_joints_and_by_angles() {
        for side in [Side::Left, Side::Right] {
            let wrist = Pose::new(
                Vec3::new(0.1, 1.0, 0.2),
                thenar_core::Quat::from_scaled_axis(Vec3::new(0.3, -1.0, 0.5)),
            );
            let pose =
                LivePose::Joints { joints: joints(side, wrist, [0.5; 5]), radii: [0.01; 25] };
            let seen = TraceSample::new(0.0, &pose, 0.19);
            // 1.4 + 1.7 + 1.0 rad of a closed finger.
            for finger in 1..5 {
                assert!((seen.flexion[finger] - 2.05).abs() < 1e-9, "{side:?} {finger}: {seen:?}");
            }
        }
        let mut angles = [0.0; ANGLES];
        [angles[4], angles[6], angles[7]] = [0.7, 0.85, 0.5];
        let seen =
            TraceSample::new(0.0, &LivePose::Angles { wrist: Pose::identity(), angles }, 0.19);
        assert!((seen.flexion[1] - 2.05).abs() < 1e-9 && seen.flexion[2] == 0.0);
        assert!((seen.tips[1].y + 0.7 * 0.095 + 0.85 * 0.05 + 0.5 * 0.024).abs() < 1e-12);
    }
}
