//! Between two frames of the simulation the haptic loop goes on: bones are carried forward by their
//! velocity, not far, and then held.

use crate::RigidState;

/// Horizon of states carried forward, and limits of what counts as motion at all.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Prediction {
    /// Up to this age a state moves on at its velocity; over as long again it slows down to a
    /// halt, so it ends `1.5 × horizon × velocity` ahead \[s\].
    pub horizon: f64,
    /// Larger speeds are not believed: the state is held \[m/s\].
    pub speed_max: f64,
    /// Likewise \[rad/s\].
    pub angular_speed_max: f64,
}

impl Prediction {
    /// For a simulation at 20 Hz or more. Hands reach about 5 m/s, fingers about 40 rad/s.
    pub const SIMULATION: Self = Self { horizon: 0.05, speed_max: 8.0, angular_speed_max: 80.0 };

    /// `state` as it should be after `age` \[s\]; a negative or senseless age is taken as zero.
    /// Pose and velocity are continuous in age.
    pub fn at(&self, state: &RigidState, age: f64) -> RigidState {
        let believed = state.velocity_W.norm() <= self.speed_max
            && state.angular_velocity_W.norm() <= self.angular_speed_max;
        if !believed || self.horizon.is_nan() || self.horizon <= 0.0 {
            return RigidState::at_rest(state.pose_WB);
        }
        let (time, rate) = slowing(age, self.horizon);
        RigidState {
            pose_WB: state.pose_after(time),
            velocity_W: state.velocity_W * rate,
            angular_velocity_W: state.angular_velocity_W * rate,
        }
    }
}

/// A time that runs with `age` up to `horizon`, slows down over as long again and stops; and its
/// rate.
fn slowing(age: f64, horizon: f64) -> (f64, f64) {
    let age = age.max(0.0); // NaN becomes zero
    if age <= horizon {
        return (age, 1.0);
    }
    let past = (age - horizon).min(horizon);
    (horizon + past - past * past / (2.0 * horizon), 1.0 - past / horizon)
}

/// Trust in something of this age \[s\]: 1 up to `hold`, then falling to 0 over `fade`.
pub fn hold_then_fade(age: f64, hold: f64, fade: f64) -> f64 {
    if age <= hold {
        1.0
    } else if age < hold + fade {
        1.0 - (age - hold) / fade
    } else {
        0.0 // NaN as well
    }
}

/// From one time in nanoseconds to another, in seconds; negative when it runs backwards.
pub fn seconds_between(from_ns: u64, to_ns: u64) -> f64 {
    if to_ns >= from_ns {
        (to_ns - from_ns) as f64 * 1e-9
    } else {
        -((from_ns - to_ns) as f64 * 1e-9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::math::{Pose, Quat, Vec3};

    const FRAMES: Prediction = Prediction::SIMULATION;

    /// Never further than 1.5 horizons, without a jump in pose or velocity.
    #[test]
    fn prediction_is_bounded_and_smooth() {
        let state = RigidState {
            velocity_W: Vec3::x(),
            ..RigidState::at_rest(Pose::new(Vec3::zeros(), Quat::identity()))
        };
        let mut before = FRAMES.at(&state, 0.0);
        for k in 1..2000 {
            let now = FRAMES.at(&state, 1e-4 * f64::from(k));
            let moved = now.pose_WB.position.x - before.pose_WB.position.x;
            assert!((0.0..=1e-4 + 1e-15).contains(&moved));
            assert!((before.velocity_W.x - now.velocity_W.x).abs() <= 1e-4 / 0.05 + 1e-12);
            before = now;
        }
        assert!((before.pose_WB.position.x - 0.075).abs() < 1e-12);
        assert_eq!(before.velocity_W.x, 0.0);
        assert_eq!(FRAMES.at(&state, f64::NAN).pose_WB, state.pose_WB);
        assert_eq!(FRAMES.at(&state, -3.0).pose_WB, state.pose_WB);
        let mad = RigidState { velocity_W: Vec3::x() * 1e9, ..state };
        assert_eq!(FRAMES.at(&mad, 0.01), RigidState::at_rest(state.pose_WB));
    }

    #[test]
    fn trust_holds_then_fades() {
        let ages = [-1.0, 0.0, 0.05, 0.075, 0.1, 9.0, f64::NAN];
        let trust = ages.map(|age| hold_then_fade(age, 0.05, 0.05));
        assert_eq!(trust[..3], [1.0, 1.0, 1.0]);
        assert!((trust[3] - 0.5).abs() < 1e-12);
        assert!(trust[4] < 1e-12);
        assert_eq!(trust[5..], [0.0, 0.0]);
    }
}
