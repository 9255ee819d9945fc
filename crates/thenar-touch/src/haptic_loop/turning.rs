//! Stiffness with which a turn of the palm is felt: the rule of [`FeltStiffness`] in angle.
//!
//! A handle is held by fingers at some distance from the axis that it turns about. Each damps with
//! b at its lever r, so that a grip of b damps turns with `b r²`, and torque on a spring of κ
//! behind the delay t_d oscillates by itself above `κ = b r²/(T/2 + t_d)`: what the rule allows a
//! spring of `κ/r²` at the lever. Damping grows with the force of a grip (Hasser and Cutkosky 2002,
//! of a knob in a pinch); the least of it is a pinch of the loosest fingers.

use crate::{FeltBounds, FeltStiffness, Proxy, series_stiffness};

/// From the axis of a turn to the fingers that hold on \[m\]: half a phalanx, as couplings and
/// limits of torques have it. A wider grip, and the wrist behind it, damp more.
pub(super) const GRIP_LEVER: f64 = 0.02;

/// The rule for turns of a bone that is held by this proxy, of whose torque this part is shown.
pub(super) fn felt_turn(bounds: FeltBounds, proxy: &Proxy, part: f64) -> FeltStiffness {
    let turning = series_stiffness(proxy.device.angular_stiffness, proxy.bone.angular_stiffness);
    FeltStiffness::new(bounds, vec![part * turning / (GRIP_LEVER * GRIP_LEVER)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CouplingDesign, GRIP, LoopProfile, MARGIN, Observation, TrackerTiming};
    use thenar_core::math::Mat3;

    /// Bones that are soft to push and stiff to turn, and the other way round: turning is cut by
    /// what a pinch damps, within 80 and 100 % of Gil's rule, or not at all.
    #[test]
    fn turns_are_cut_to_the_rule_in_angle() {
        let [delay, damping, friction, resolution] = [0.0; 4];
        let rated_stiffness = f64::INFINITY;
        let profile =
            LoopProfile { period: 1e-3, delay, damping, friction, resolution, rated_stiffness };
        let observation = Observation::default();
        let bounds = FeltBounds { grip: Some(GRIP), profile, observation, holds_only: false };
        let timing = TrackerTiming { rate: 100.0, latency: 0.01, noise: 0.0 };
        let rule = GRIP * GRIP_LEVER * GRIP_LEVER / (0.5e-3 + timing.delay());
        for angular in [10.0, 0.5 * rule] {
            let mut proxy =
                CouplingDesign::default().proxy(0.1, &Mat3::from_diagonal_element(1e-4));
            for drive in [&mut proxy.device, &mut proxy.bone] {
                (drive.stiffness, drive.angular_stiffness) = (2.0, angular);
            }
            let mut felt = felt_turn(bounds, &proxy, 1.0);
            felt.hear(0, 0, Some(timing));
            felt.step(1e-3, 0.0, |_, observed| observed);
            let turning = 0.5 * angular * felt.part(0);
            assert!(turning <= rule, "{turning} of {rule} N m/rad");
            let want = (0.5 * angular).min(MARGIN * rule);
            assert!((turning / want - 1.0).abs() < 1e-9, "{turning} of {want} N m/rad");
        }
    }
}
