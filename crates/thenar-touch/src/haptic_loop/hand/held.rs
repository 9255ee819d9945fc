//! Last known pose of a hand, for as long as its tracker does not see it.
//!
//! A tracker that is silent for a moment, or says that it does not see the hand, or a loop that
//! stood still, says nothing of where the hand went: the hand is held still where it was, by the
//! same samples again. Seen there anew, it simply continues. Seen elsewhere, it sets out for there.

use serde::{Deserialize, Serialize};
use thenar_track::live::LivePose;

/// Time without a sample after which a hand is reported again, before it would count as lost
/// ([`STALE`](thenar_track::live::STALE)) \[ns\].
const AGAIN_NS: u64 = 85_000_000;
/// A sample of a hand that moved is in doubt: it is borne out so soon after, before it would count
/// as lost as well \[ns\].
const BORNE_OUT_NS: u64 = 5_000_000;
/// After a longer gap between two ticks, at which the guards trip, nothing goes on \[ns\].
const GAP_NS: u64 = 500_000_000;
/// Within this time samples may overtake each other on their way \[ns\]: as long as a pose counts
/// at all.
const OVERTAKEN_NS: u64 = 100_000_000;
/// A sample measured this little after another is that sample again, as a clock that is followed at
/// its rate dates it \[ns\]: poses of one motion lie further apart.
const AGAIN_MEASURED_NS: u64 = 500_000;
/// Seen so far from where it was, it is elsewhere: place \[m\], turn of the wrist and of a joint
/// \[rad\]. A sample so far from what was expected is a teleport.
const FAR: [f64; 2] = [0.05, 0.5];

/// The last sample that was believed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct HeldSample {
    pose: LivePose,
    /// Time of measurement, and of arrival; both advance each time the sample is reported again
    /// \[ns\].
    time_ns: u64,
    came_ns: u64,
    /// Time of its first arrival \[ns\].
    seen_ns: u64,
    /// The sample was repeated, and is in doubt.
    doubted: bool,
}

impl HeldSample {
    /// A sample measured at `time_ns` that came now.
    pub fn new(pose: &LivePose, time_ns: u64, now_ns: u64) -> Self {
        Self { pose: pose.clone(), time_ns, came_ns: now_ns, seen_ns: now_ns, doubted: false }
    }

    /// Returns the time when the hand was last seen \[ns\].
    pub fn seen_ns(&self) -> u64 {
        self.seen_ns
    }

    /// True if nothing may go on: nobody looked for too long.
    pub fn is_over(&self, now_ns: u64) -> bool {
        now_ns.saturating_sub(self.came_ns) > GAP_NS
    }

    /// The sample again, with its new time \[s\], if it is due.
    pub fn again(&mut self, now_ns: u64) -> Option<(f64, &LivePose)> {
        let after = if self.doubted { BORNE_OUT_NS } else { AGAIN_NS };
        if now_ns.saturating_sub(self.came_ns) < after {
            return None;
        }
        self.time_ns = self.time_ns.saturating_add(after);
        self.came_ns += after;
        Some((self.time_ns as f64 * 1e-9, &self.pose))
    }

    /// Notes whether the sample is in doubt, now that it was repeated; what came since is a sample
    /// of its own.
    pub fn doubt(&mut self, doubted: bool) {
        self.doubted = doubted;
    }

    /// True if a hand seen here is elsewhere. What cannot be compared is.
    pub fn is_far(&self, pose: &LivePose) -> bool {
        let near = match (&self.pose, pose) {
            (LivePose::Joints { joints: before, .. }, LivePose::Joints { joints, .. }) => {
                before.iter().zip(joints).all(|(a, b)| (a.position - b.position).norm() < FAR[0])
            }
            (
                LivePose::Angles { wrist: before, angles: bent },
                LivePose::Angles { wrist, angles },
            ) => {
                (before.position - wrist.position).norm() < FAR[0]
                    && before.rotation.angle_to(&wrist.rotation) < FAR[1]
                    && bent.iter().zip(angles).all(|(a, b)| (a - b).abs() < FAR[1])
            }
            _ => false,
        };
        !near
    }
}

/// Measurement time of a tracker's newest sample, believed or not \[ns\].
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct NewestTime(Option<u64>);

impl NewestTime {
    /// True for a sample measured at `time_ns` that is neither the newest again nor overtaken by
    /// it, which then is the newest. A clock that jumped back further begins afresh.
    pub fn hears(&mut self, time_ns: u64) -> bool {
        let is_news = self.0.is_none_or(|newest| {
            time_ns > newest + AGAIN_MEASURED_NS || time_ns + OVERTAKEN_NS < newest
        });
        if is_news {
            self.0 = Some(time_ns);
        }
        is_news
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::{Pose, Quat, Vec3};

    const MS: u64 = 1_000_000;

    fn angles(x: f64, turn: f64, bent: f64) -> LivePose {
        let wrist = Pose::new(Vec3::x() * x, Quat::from_scaled_axis(Vec3::z() * turn));
        LivePose::Angles { wrist, angles: [bent; 20] }
    }

    fn joints(place: impl Fn(usize) -> f64) -> LivePose {
        let joints = std::array::from_fn(|k| Pose::translation(place(k), 0.0, 0.0));
        LivePose::Joints { joints, radii: [0.01; 25] }
    }

    /// Within 5 cm and half a radian it is where it was, by either kind of pose; poses of two kinds
    /// cannot be compared, and numbers that are none are nowhere.
    #[test]
    fn far_is_what_a_teleport_is() {
        let held = HeldSample::new(&angles(0.0, 0.0, 0.3), 0, 0);
        assert!(!held.is_far(&angles(0.04, 0.4, 0.7)));
        for far in [angles(0.06, 0.0, 0.3), angles(0.0, 0.6, 0.3), angles(0.0, 0.0, 0.9)] {
            assert!(held.is_far(&far));
        }
        assert!(held.is_far(&angles(f64::NAN, 0.0, 0.3)) && held.is_far(&joints(|_| 0.0)));
        let held = HeldSample::new(&joints(|_| 0.0), 0, 0);
        assert!(!held.is_far(&joints(|_| 0.04)));
        assert!(held.is_far(&joints(|k| if k == 24 { 0.06 } else { 0.0 })));
    }

    /// A sample that is repeated, and one that was overtaken, say nothing new; a clock that was set
    /// back does.
    #[test]
    fn what_is_repeated_is_no_news() {
        let mut newest = NewestTime::default();
        assert!(newest.hears(500 * MS) && newest.hears(501 * MS));
        assert!(
            !newest.hears(501 * MS) && !newest.hears(501 * MS + 1200) && !newest.hears(450 * MS)
        );
        assert!(newest.hears(502 * MS) && newest.hears(399 * MS) && newest.hears(400 * MS));
    }

    /// Every 85 ms of silence once, each by its own time, and 5 ms after one that is in doubt; as
    /// often as was missed after a gap, and not at all after one that trips the guards.
    #[test]
    fn silence_is_filled_by_the_last_sample() {
        let mut held = HeldSample::new(&angles(0.0, 0.0, 0.0), 5 * MS, 10 * MS);
        assert!(held.again(94 * MS).is_none());
        assert!((held.again(95 * MS).unwrap().0 - 0.09).abs() < 1e-12);
        held.doubt(true);
        assert!(held.again(99 * MS).is_none());
        assert!((held.again(100 * MS).unwrap().0 - 0.095).abs() < 1e-12);
        held.doubt(false);
        assert!(held.again(184 * MS).is_none());
        let mut told = Vec::new();
        while let Some((time, _)) = held.again(450 * MS) {
            told.push((time * 1e3).round());
        }
        assert_eq!(told, [180.0, 265.0, 350.0, 435.0]);
        assert_eq!(held.seen_ns(), 10 * MS);
        assert!(!held.is_over(940 * MS) && held.is_over(941 * MS));
    }
}
