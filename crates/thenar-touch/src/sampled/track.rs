//! One tracked bone: samples in at the tracker's rate, a smooth motion out at the haptic rate.

use crate::{Prediction, RigidState, seconds_between};
use thenar::math::{Pose, Quat, Vec3, rotation_vector};

/// What became of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Sample {
    /// Taken, with a velocity.
    Taken,
    /// Taken without a velocity: the first, the first after a pause, or after a jump.
    Restarted,
    /// Left out: not finite.
    NotFinite,
    /// Left out: not later than the one before.
    OutOfOrder,
}

/// One tracked bone: its last sample, an estimate of its velocity, and what was last told of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Track {
    last: Option<(u64, RigidState)>,
    moving: bool,
    /// A sample that nobody has been told of yet.
    news: Option<Sample>,
    told: Option<(u64, RigidState)>,
    /// How far what is told was from the newest sample's prediction (linear, angular), and when.
    correction: [Vec3; 2],
    corrected_ns: u64,
}

/// A bone as told by its track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracked {
    /// Where it is now.
    pub state: RigidState,
    /// Age of what is known about it \[s\].
    pub age: f64,
    /// True for a bone that is somewhere else than it could have got to since the tick before.
    pub jumped: bool,
}

/// After a pause this long \[s\] two samples say nothing about velocity. Also how far back a clock
/// must go to count as set anew.
const PAUSE: f64 = 0.2;

impl Track {
    /// Takes a pose measured at `time_ns`. Trackers that know velocities pass linear \[m/s\]
    /// and angular \[rad/s\], world; otherwise it is the mean of the last difference quotient and
    /// the estimate before, which halves the noise and is exact for steady motion.
    pub fn push(
        &mut self,
        time_ns: u64,
        pose_WB: Pose,
        velocity: Option<[Vec3; 2]>,
        limits: &Prediction,
    ) -> Sample {
        if !pose_WB.is_finite() {
            return Sample::NotFinite;
        }
        let mut state = RigidState::at_rest(pose_WB);
        let mut sample = Sample::Restarted;
        if let Some((last_ns, last)) = &self.last {
            let dt = seconds_between(*last_ns, time_ns);
            if (-PAUSE..=0.0).contains(&dt) {
                return Sample::OutOfOrder;
            }
            let v = (pose_WB.position - last.pose_WB.position) / dt;
            let turn = pose_WB.rotation * last.pose_WB.rotation.inverse();
            let w = rotation_vector(&turn) / dt;
            let jump = v.norm() > limits.speed_max || w.norm() > limits.angular_speed_max;
            if dt > 0.0 && dt < PAUSE && !jump {
                let blend = if self.moving { 0.5 } else { 1.0 };
                state.velocity_W = last.velocity_W.lerp(&v, blend);
                state.angular_velocity_W = last.angular_velocity_W.lerp(&w, blend);
                sample = Sample::Taken;
            }
        }
        self.moving = sample == Sample::Taken;
        let finite = |v: &[Vec3; 2]| v.iter().flatten().all(|x| x.is_finite());
        if let Some([v, w]) = velocity.filter(finite) {
            (state.velocity_W, state.angular_velocity_W) = (v, w);
        }
        self.last = Some((time_ns, state));
        // Of two samples between two ticks a jump is the greater news.
        if self.news != Some(Sample::Restarted) {
            self.news = Some(sample);
        }
        sample
    }

    /// The bone now. Continuous in time, but for jumps.
    pub fn at(&mut self, now_ns: u64, prediction: &Prediction) -> Option<Tracked> {
        let (time_ns, sample) = self.last.as_ref()?;
        let age = seconds_between(*time_ns, now_ns);
        let mut state = prediction.at(sample, age);
        let news = self.news.take();
        let mut jumped = false;
        match (news, &self.told) {
            (Some(Sample::Taken), Some((told_ns, told))) => {
                let went_on = told.pose_after(seconds_between(*told_ns, now_ns));
                let turn = went_on.rotation * state.pose_WB.rotation.inverse();
                self.correction =
                    [went_on.position - state.pose_WB.position, rotation_vector(&turn)];
                self.corrected_ns = now_ns;
            }
            (Some(_), told) => {
                jumped = told.is_some();
                self.correction = [Vec3::zeros(); 2];
            }
            (None, _) => (),
        }
        self.blend_in(&mut state, now_ns, prediction.blend);
        self.told = Some((now_ns, state));
        Some(Tracked { state, age, jumped })
    }

    /// Adds what is left of the correction.
    fn blend_in(&self, state: &mut RigidState, now_ns: u64, blend: f64) {
        let since = seconds_between(self.corrected_ns, now_ns);
        if blend.is_nan() || blend <= 0.0 || since < 0.0 {
            return;
        }
        let left = (-since / blend).exp();
        let [linear, angular] = self.correction.map(|part| part * left);
        state.pose_WB.position += linear;
        state.pose_WB.rotation = Quat::from_scaled_axis(angular) * state.pose_WB.rotation;
        state.velocity_W -= linear / blend;
        state.angular_velocity_W -= angular / blend;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    const MS: u64 = 1_000_000;
    const TRACKER: Prediction = Prediction::TRACKER;

    /// A screw at constant rates is its own prediction.
    #[test]
    fn steady_motion_is_predicted_exactly() {
        let mut random = Random::new(11);
        let (v, w) = (random.vec3(1.0), random.vec3(5.0));
        let start = RigidState {
            pose_WB: Pose::new(random.vec3(1.0), random.rotation(3.0)),
            velocity_W: v,
            angular_velocity_W: w,
        };
        let mut track = Track::default();
        for k in 0..5u64 {
            let pose = start.pose_after(k as f64 * 0.011);
            track.push(k * 11 * MS, pose, None, &TRACKER);
        }
        let Tracked { state: now, age, .. } = track.at(44 * MS + 15 * MS, &TRACKER).unwrap();
        let want = start.pose_after(0.059);
        assert!((age - 0.015).abs() < 1e-12);
        assert!((now.pose_WB.position - want.position).norm() < 1e-12);
        assert!(now.pose_WB.rotation.angle_to(&want.rotation) < 1e-7);
        assert!((now.velocity_W - v).norm() < 1e-10);
    }

    #[test]
    fn bad_samples_are_left_out_or_restart_the_estimate() {
        let mut track = Track::default();
        let at = |x: f64| Pose::translation(x, 0.0, 0.0);
        assert_eq!(track.at(0, &TRACKER), None);
        assert_eq!(track.push(10 * MS, at(0.0), None, &TRACKER), Sample::Restarted);
        assert_eq!(track.push(20 * MS, at(0.01), None, &TRACKER), Sample::Taken);
        assert_eq!(track.push(20 * MS, at(0.02), None, &TRACKER), Sample::OutOfOrder);
        assert_eq!(track.push(15 * MS, at(0.02), None, &TRACKER), Sample::OutOfOrder);
        assert_eq!(track.push(30 * MS, at(f64::NAN), None, &TRACKER), Sample::NotFinite);
        // A metre in ten milliseconds: the pose is taken, the velocity is not believed.
        assert_eq!(track.push(30 * MS, at(1.0), None, &TRACKER), Sample::Restarted);
        let state = track.at(40 * MS, &TRACKER).unwrap().state;
        assert_eq!(state, RigidState::at_rest(at(1.0)));
        // After half a second, and after the clock is set back by more than a pause.
        assert_eq!(track.push(530 * MS, at(1.01), None, &TRACKER), Sample::Restarted);
        assert_eq!(track.push(100 * MS, at(1.01), None, &TRACKER), Sample::Restarted);
    }

    /// A hand that is led at 0.3 m/s, seen at 90 Hz with a millimetre of noise: what is told moves
    /// without steps, stays near, and its velocity is the derivative of its place.
    #[test]
    fn noise_does_not_become_steps() {
        let mut random = Random::new(23);
        let mut track = Track::default();
        let (mut before, mut farthest) = (None::<RigidState>, 0.0_f64);
        for ms in 0..3000u64 {
            let truth = 0.3 * 1e-3 * ms as f64;
            if ms % 11 == 0 {
                let seen = Vec3::x() * truth + random.vec3(1e-3);
                track.push(ms * MS, Pose::new(seen, random.rotation(0.01)), None, &TRACKER);
            }
            let Tracked { state, jumped, .. } = track.at(ms * MS, &TRACKER).unwrap();
            assert!(!jumped);
            if let Some(before) = before.filter(|_| ms > 100) {
                let rate = (state.pose_WB.position - before.pose_WB.position) / 1e-3;
                assert!(rate.norm() < 0.9, "{ms}: {rate}");
                let told = 0.5 * (state.velocity_W + before.velocity_W);
                // Velocities step where a sample comes in, poses do not.
                assert!(ms % 11 == 0 || (rate - told).norm() < 1e-3, "{ms}: {rate} {told}");
                farthest = farthest.max((state.pose_WB.position.x - truth).abs());
            }
            before = Some(state);
        }
        assert!(farthest < 4e-3, "{farthest} m from the truth");
    }

    #[test]
    fn jumps_are_told_once() {
        let mut track = Track::default();
        let at = |x: f64| Pose::translation(x, 0.0, 0.0);
        track.push(0, at(0.0), None, &TRACKER);
        assert!(!track.at(MS, &TRACKER).unwrap().jumped, "the first sample is no jump");
        track.push(10 * MS, at(0.5), None, &TRACKER);
        track.push(20 * MS, at(0.5), None, &TRACKER);
        let told = track.at(21 * MS, &TRACKER).unwrap();
        assert!(told.jumped && (told.state.pose_WB.position.x - 0.5).abs() < 1e-9);
        assert!(!track.at(22 * MS, &TRACKER).unwrap().jumped);
    }
}
