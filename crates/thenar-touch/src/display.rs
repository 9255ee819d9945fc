//! From the wrench of a distal proxy's device coupling to what a device can show. Pure functions,
//! and one small latch for movement stops. Safety comes after.

use thenar_core::math::{Pose, Vec3};

/// Out of the skin of a finger pad, in the bone's frame B: WebXR axes have the back of the hand at
/// +y.
pub const PAD_NORMAL_B: Vec3 = Vec3::new(0.0, -1.0, 0.0);

/// CyberGrasp: largest continuous force per finger \[N\].
pub const CYBERGRASP_FORCE_MAX: f64 = 12.0;

/// Force on the finger pad along its inward normal \[N\], positive when something presses on the
/// pad: the projection of Sec. 5. `force_W` is the device coupling's force on the wearer.
pub fn pad_force(force_W: &Vec3, pose_WB: &Pose) -> f64 {
    -force_W.dot(&pose_WB.vector(&PAD_NORMAL_B))
}

/// A tendon on the back of the finger (CyberGrasp): it pulls, never pushes, and not above
/// `force_max` \[N\]. Not-a-number becomes no pull.
pub fn tendon_pull(pad_force: f64, force_max: f64) -> f64 {
    if pad_force.is_finite() { pad_force.clamp(0.0, force_max.max(0.0)) } else { 0.0 }
}

/// A brake can only resist: its force \[N\] for a wanted pad force and the pad's velocity along the
/// inward normal \[m/s\] (opening is positive). While the finger opens the brake is free, so force
/// times velocity is never positive.
pub fn brake_force(pad_force: f64, opening_velocity: f64, force_max: f64) -> f64 {
    let opening = opening_velocity > 0.0 || opening_velocity.is_nan();
    if opening { 0.0 } else { tendon_pull(pad_force, force_max) }
}

/// Returns the position at which a LucidGloves servo stops a finger: 0 leaves it free, 1000 blocks
/// it fully open. `1000 (1 - curl)`, with curl 0 open and 1 closed; `None` is free.
pub fn servo_stop(curl_at_contact: Option<f64>) -> u16 {
    match curl_at_contact {
        Some(curl) if curl.is_finite() => (1000.0 * (1.0 - curl.clamp(0.0, 1.0))).round() as u16,
        _ => 0,
    }
}

/// Remembers at which curl a finger began to push, so that its stop stands still while it pushes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct StopLatch {
    /// Pad force at which contact begins \[N\].
    pub force_on: f64,
    /// Pad force below which it ends \[N\]; less than `force_on`, lest the stop chatter.
    pub force_off: f64,
    /// The curl at which the present contact began.
    curl: Option<f64>,
}

impl StopLatch {
    /// Not in contact.
    pub fn new(force_on: f64, force_off: f64) -> Self {
        Self { force_on, force_off, curl: None }
    }

    /// Takes the finger's pad force \[N\] and curl (0 open, 1 closed); returns the curl to stop
    /// at. A finger that opens past its stop moves the stop along: it never pushes a finger open
    /// further than the wearer went.
    pub fn update(&mut self, pad_force: f64, curl: f64) -> Option<f64> {
        if !(pad_force.is_finite() && curl.is_finite()) || pad_force < self.force_off {
            self.curl = None;
        } else if let Some(stop) = self.curl {
            self.curl = Some(stop.min(curl));
        } else if pad_force >= self.force_on {
            self.curl = Some(curl);
        }
        self.curl
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::math::Quat;
    use thenar_core::random::Random;

    /// A hand palm down: the table pushes up, into the pad, whatever the shear.
    #[test]
    fn the_pad_feels_what_presses_on_it() {
        let flat = Pose::identity();
        assert_eq!(pad_force(&Vec3::new(3.0, 2.0, -1.0), &flat), 2.0);
        assert_eq!(pad_force(&Vec3::new(0.0, -2.0, 0.0), &flat), -2.0);
        let turned = Pose::new(Vec3::zeros(), Quat::from_scaled_axis(Vec3::z() * 0.5));
        let along = turned.vector(&Vec3::y()) * 4.0;
        assert!((pad_force(&along, &turned) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn tendons_pull_and_brakes_resist() {
        let mut random = Random::new(5);
        for _ in 0..10_000 {
            let (force, velocity) = (random.range(-40.0, 40.0), random.range(-1.0, 1.0));
            let pull = tendon_pull(force, CYBERGRASP_FORCE_MAX);
            assert!((0.0..=12.0).contains(&pull));
            assert!(force < 0.0 || pull == force.min(12.0));
            let brake = brake_force(force, velocity, 10.0);
            assert!((0.0..=10.0).contains(&brake) && brake * velocity <= 0.0);
        }
        assert_eq!(tendon_pull(f64::NAN, 12.0), 0.0);
        assert_eq!(tendon_pull(f64::INFINITY, 12.0), 0.0);
        assert_eq!(brake_force(5.0, f64::NAN, 12.0), 0.0);
        assert_eq!(brake_force(5.0, 0.0, 12.0), 5.0);
    }

    #[test]
    fn stops_are_where_contact_began() {
        assert_eq!(servo_stop(None), 0);
        assert_eq!(servo_stop(Some(0.0)), 1000);
        assert_eq!(servo_stop(Some(0.3)), 700);
        assert_eq!(servo_stop(Some(1.0)), 0);
        assert_eq!(servo_stop(Some(7.0)), 0);
        assert_eq!(servo_stop(Some(-7.0)), 1000);
        assert_eq!(servo_stop(Some(f64::NAN)), 0);

        let mut latch = StopLatch::new(0.5, 0.2);
        let told: Vec<_> =
            [(0.0, 0.2), (0.6, 0.4), (2.0, 0.5), (0.3, 0.35), (0.1, 0.3), (0.3, 0.3)]
                .map(|(force, curl)| latch.update(force, curl))
                .to_vec();
        assert_eq!(told, [None, Some(0.4), Some(0.4), Some(0.35), None, None]);
        latch.update(1.0, 0.4);
        assert_eq!(latch.update(f64::NAN, 0.4), None);
    }
}
