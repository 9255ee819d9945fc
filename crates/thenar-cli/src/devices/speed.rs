//! Speeds of opening fingers and of a moving hand, from what a tracker reports: for the guards of a
//! first force.

use thenar_core::model::Side;
use thenar_core::{Pose, Vec3};
use thenar_link::latency::{LEVER_HAND, LEVERS, TIPS};
use thenar_link::{DIGITS, HandSample};
use thenar_scene::live::LivePose;
use thenar_scene::motion::ANGLES;

/// Two samples nearer to each other tell the sensor's steps, not a speed \[s\].
const SPAN_MIN: f64 = 0.005;
/// Two samples further from each other, or a last one as old, tell none \[s\].
const SPAN_MAX: f64 = 0.1;

/// Speeds between the newest two samples.
pub struct Speeds {
    side: Side,
    levers: [[f64; 3]; DIGITS],
    last: Option<(u64, PoseSample)>,
    digits: [f64; DIGITS],
    wrist: Vec3,
}

/// Parts of a pose that are compared.
#[derive(Clone, Copy)]
enum PoseSample {
    Angles([f64; ANGLES], Vec3),
    Tips([Pose; DIGITS], Pose),
}

impl Speeds {
    /// Speeds of a hand of this length \[m\].
    pub fn new(side: Side, hand_length: f64) -> Self {
        // A bent finger's tip is slower: what is too much errs on the safe side.
        let levers = LEVERS.map(|finger| finger.map(|lever| lever * hand_length / LEVER_HAND));
        Self { side, levers, last: None, digits: [0.0; DIGITS], wrist: Vec3::zeros() }
    }

    /// Takes the newest sample.
    pub fn take(&mut self, sample: &HandSample) {
        if sample.side != self.side {
            return;
        }
        let measured = match &sample.pose {
            None => return self.forget(),
            Some(LivePose::Angles { wrist, angles }) => PoseSample::Angles(*angles, wrist.position),
            Some(LivePose::Joints { joints, .. }) => {
                let wrist = joints[0];
                PoseSample::Tips(TIPS.map(|tip| wrist.inverse() * joints[tip]), wrist)
            }
        };
        let Some((at, before)) = &self.last else {
            self.last = Some((sample.time_ns, measured));
            return;
        };
        let dt = (sample.time_ns as f64 - *at as f64) * 1e-9;
        if (0.0..SPAN_MIN).contains(&dt) {
            return;
        }
        if !(SPAN_MIN..=SPAN_MAX).contains(&dt) {
            self.forget();
        } else {
            (self.digits, self.wrist) = self.between(before, &measured, dt);
        }
        self.last = Some((sample.time_ns, measured));
    }

    fn forget(&mut self) {
        (self.last, self.digits, self.wrist) = (None, [0.0; DIGITS], Vec3::zeros());
    }

    fn between(&self, a: &PoseSample, b: &PoseSample, dt: f64) -> ([f64; DIGITS], Vec3) {
        match (a, b) {
            (PoseSample::Angles(a, from), PoseSample::Angles(b, to)) => {
                let rate = |k: usize| (b[k] - a[k]) / dt;
                let opening = |d: usize| {
                    let [base, second, third] = self.levers[d];
                    let bending = [(4 * d, base), (4 * d + 2, second), (4 * d + 3, third)];
                    -bending.map(|(k, lever)| rate(k) * lever).iter().sum::<f64>()
                };
                (std::array::from_fn(opening), (to - from) / dt)
            }
            (PoseSample::Tips(a, from), PoseSample::Tips(b, to)) => {
                // Out of the back of the finger, in the hand's frame.
                let opening = |d: usize| {
                    let moved: Vec3 = b[d].position - a[d].position;
                    moved.dot(&b[d].vector(&Vec3::y())) / dt
                };
                (std::array::from_fn(opening), (to.position - from.position) / dt)
            }
            _ => ([0.0; DIGITS], Vec3::zeros()),
        }
    }

    /// Speed of each fingertip along the pad's inward normal \[m/s\]: positive opens.
    pub fn opening(&self, now_ns: u64) -> [f64; DIGITS] {
        if self.known(now_ns) { self.digits } else { [0.0; DIGITS] }
    }

    /// Velocity of the wrist, world \[m/s\].
    pub fn wrist(&self, now_ns: u64) -> Vec3 {
        if self.known(now_ns) { self.wrist } else { Vec3::zeros() }
    }

    fn known(&self, now_ns: u64) -> bool {
        let age = |at: u64| now_ns.saturating_sub(at) as f64 * 1e-9;
        self.last.as_ref().is_some_and(|(at, _)| age(*at) <= SPAN_MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn sample(ms: u64, pose: LivePose) -> HandSample {
        HandSample { side: Side::Right, time_ns: ms * MS, pose: Some(pose) }
    }

    fn bent(base: f64, x: f64) -> LivePose {
        let mut angles = [0.0; ANGLES];
        angles[4] = base;
        LivePose::Angles { wrist: Pose::translation(x, 0.0, 0.0), angles }
    }

    /// The index finger's base bends by 2 rad/s, its tip 0.1 m away closes at 0.2 m/s; the wrist
    /// moves at 0.5 m/s.
    #[test]
    fn bending_is_closing() {
        let mut speeds = Speeds::new(Side::Right, LEVER_HAND * 0.1 / LEVERS[1][0]);
        for k in 0..100u64 {
            let t = k as f64 * 1e-3;
            speeds.take(&sample(1000 + k, bent(2.0 * t, 0.5 * t)));
        }
        let now = 1099 * MS;
        let opening = speeds.opening(now);
        assert!((opening[1] + 0.2).abs() < 1e-9, "{opening:?}");
        assert!([0, 2, 3, 4].iter().all(|d| opening[*d] == 0.0));
        assert!((speeds.wrist(now) - Vec3::x() * 0.5).norm() < 1e-9);
        // Old news, and a hand that is lost, are no speed.
        assert_eq!(speeds.opening(now + 101 * MS), [0.0; DIGITS]);
        speeds.take(&HandSample { side: Side::Right, time_ns: now + MS, pose: None });
        assert_eq!(speeds.opening(now + MS), [0.0; DIGITS]);
    }

    /// A sensor's step within a millisecond, a clock that steps back or a gap are no speed either.
    #[test]
    fn steps_and_gaps_are_no_speed() {
        let mut speeds = Speeds::new(Side::Right, LEVER_HAND);
        for (ms, base) in [(1000, 0.0), (1001, 0.01), (1500, 0.5), (1490, 0.0), (1700, 0.3)] {
            speeds.take(&sample(ms, bent(base, 0.0)));
            assert_eq!(speeds.opening(ms * MS), [0.0; DIGITS], "{ms}");
        }
        let left = HandSample { side: Side::Left, ..sample(1710, bent(3.0, 0.0)) };
        speeds.take(&left);
        assert_eq!(speeds.opening(1710 * MS), [0.0; DIGITS], "the other hand's");
    }

    /// The middle fingertip moves by 2 mm per 10 ms out of its pad, while the whole hand moves.
    #[test]
    fn tips_are_seen_from_the_wrist() {
        let mut speeds = Speeds::new(Side::Right, LEVER_HAND);
        for k in 0..3u64 {
            let wrist = Pose::translation(0.0, 0.01 * k as f64, 0.0);
            let mut joints = [wrist; 25];
            joints[14] = wrist * Pose::translation(0.0, -0.002 * k as f64, -0.18);
            speeds.take(&sample(1000 + 10 * k, LivePose::Joints { joints, radii: [0.01; 25] }));
        }
        let opening = speeds.opening(1020 * MS);
        assert!((opening[2] + 0.2).abs() < 1e-9 && opening[1].abs() < 1e-12, "{opening:?}");
        assert!((speeds.wrist(1020 * MS).y - 1.0).abs() < 1e-9);
    }
}
