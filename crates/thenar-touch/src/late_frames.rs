//! Delay that frames add from a wearer's motion to the force that answers it.
//!
//! A frame answers the hand as it was when its inputs were taken. It arrives L later and is used
//! for a period P, so that it is old by `L + P/2` on the mean and by `Δ = L + P` at the end. What
//! that does to the wearer is another thing in each mode; each is derived for a hand that moves at
//! a speed v against a bone that cannot move.
//!
//! **Multirate.** Contact is felt with frames only: of two equal hands, one is held by contact and
//! one is not, and frames say how far they are from each other. The free one's bone is where its
//! proxy was when the frame's inputs were taken, and draws the proxy back by its coupling k_s. With
//! k_h to the wearer and `r = k_h/(k_h + k_s)` the proxy goes at r v within a frame and leaps at
//! its end, so that inputs taken then, which is the worst time, are behind the mean by another
//! `(1 - r) P/2`. The coupling's damper c_s, whose bone stands still between frames, draws at both
//! proxies as well. With `k = r k_s` and τ, in which corrections of frames are blended in, what is
//! felt is
//!
//! ```text
//! F = k (x - v t),  t = Δ/r - P/2 + (1 - r²) c_s/k + τ
//! ```
//!
//! **Shared constraints.** Listed contacts answer in the very tick; one that a frame does not list
//! begins up to Δ late, v Δ deep, and is then blended in. Against a contact that begins in time the
//! wearer is spared, on the way in, `k (v Δ)²/2 + k v Δ v τ`, while a grip of damping b takes up
//! `2 b v D` on a way of depth D there and back. A contact is felt at all if D is v Δ or more, and
//! the worst is D = v Δ: as bad as a spring late by `Δ/4 + τ/2`. What frames correct of contacts
//! that they list is late by no more than τ.
//!
//! **Single-rate** has no frames.

use crate::{BLEND, Proxy, series_stiffness};

/// Delay in multirate of what is felt through this proxy \[s\], of frames every `period` \[s\] that
/// are `age` \[s\] old on arrival.
pub(super) fn of_multirate(proxy: &Proxy, period: f64, age: f64) -> f64 {
    let (hand, bone) = (proxy.device.stiffness, proxy.bone.stiffness);
    let series = series_stiffness(hand, bone);
    if series <= 0.0 {
        return BLEND;
    }
    let part = hand / (hand + bone);
    let damped = proxy.bone.damping * (1.0 - part * part) / series;
    (age + period) / part - 0.5 * period + damped + BLEND
}

/// Delay with shared constraints \[s\] that is as bad as contacts that begin with the next frame.
pub(super) fn of_shared_constraints(period: f64, age: f64) -> f64 {
    BLEND.max(0.25 * (age + period) + 0.5 * BLEND)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        BoneFrame, CouplingDesign, HandSettings, HapticHand, ProxyTargets, RigidState, Touch,
    };
    use std::collections::VecDeque;
    use thenar_core::math::{Mat3, Pose, Vec3};

    const MS: u64 = 1_000_000;

    /// Returns the mean delay of force \[s\], for a hand that goes evenly into a bone that is held;
    /// the simulation in empty air follows its proxies at once, with frames every `period` ms that
    /// arrive `latency` ms after their inputs. Beside it the delay by the derivation above for
    /// inputs that are taken where they are taken, without blending, and the rule.
    fn seen(design: &CouplingDesign, mass: f64, [period, latency]: [u64; 2]) -> [f64; 3] {
        let proxy = design.proxy(mass, &Mat3::from_diagonal_element(1e-6));
        let at = |x: f64| RigidState::at_rest(Pose::translation(x, 0.0, 0.0));
        let mut hand =
            HapticHand::new(HandSettings::default(), vec![proxy], &[at(0.0)], 0).unwrap();
        let mut frame = BoneFrame::new(&[at(0.0)], 0);
        let mut back = ProxyTargets::new(&[at(0.0)]);
        let mut way = VecDeque::new();
        let speed = 0.02;
        let stiffness = series_stiffness(proxy.device.stiffness, proxy.bone.stiffness);
        let (mut sum, mut count) = (0.0, 0.0);
        for ms in 1..=1500 + 12 * period {
            let now_ns = ms * MS;
            while let Some((due, inputs_ns, free)) = way.pop_front() {
                if due > ms {
                    way.push_front((due, inputs_ns, free));
                    break;
                }
                (frame.time_ns, frame.step) = (inputs_ns, frame.step + 1);
                frame.free.clear();
                frame.free.push(free);
            }
            if ms % period == 0 {
                way.push_back((ms + latency, now_ns, back.free[0]));
            }
            let x = speed * 1e-3 * ms as f64;
            hand.lead(0, RigidState { velocity_W: Vec3::x() * speed, ..at(x) });
            hand.tick(now_ns, &frame);
            hand.write_targets(now_ns, &mut back);
            // Whole periods.
            if ms > 1500 {
                sum += x + hand.device_wrenches()[0][0].x / stiffness;
                count += 1.0;
            }
        }
        let part = proxy.device.stiffness / (proxy.device.stiffness + proxy.bone.stiffness);
        let [p, l] = [period, latency].map(|ms| 1e-3 * ms as f64);
        // Inputs are taken so long after the last frame came.
        let since = if period == latency { p } else { p - l };
        let behind = l + 0.5 * p + (1.0 - part) * (since - 0.5 * p);
        let theory = behind / part + proxy.bone.damping * (1.0 - part * part) / stiffness;
        [sum / count / speed, theory, hand.added_delay(0, 0.0)]
    }

    /// Every part of the rule by itself: equal couplings and unequal ones, light bones and heavy
    /// ones, frames at once and a period late. What is seen is theory's within the blend, which
    /// acts on what proxies do not smooth themselves, two ticks, by which inputs are late, and a
    /// twentieth, by which heavy proxies do not come to rest within a frame; and no more than the
    /// rule says.
    #[test]
    fn multirate_is_as_late_as_the_rule_says() {
        let equal = CouplingDesign::default();
        let unequal = CouplingDesign { bone_stiffness: 200.0, ..equal };
        for (design, mass, frames) in [
            (equal, 0.004, [16, 16]),
            (equal, 0.004, [50, 50]),
            (equal, 0.004, [16, 2]),
            (equal, 0.3, [16, 16]),
            (unequal, 0.01, [10, 5]),
            (unequal, 0.01, [33, 33]),
            (equal, 0.02, [4, 4]),
        ] {
            let [late, theory, rule] = seen(&design, mass, frames);
            println!(
                "{mass} kg, {frames:?} ms: {late} s, in theory {theory} s, by the rule {rule} s"
            );
            let most = 0.5 * BLEND + 2e-3 + 0.05 * theory;
            assert!((late - theory - 0.5 * BLEND).abs() < most, "{late} of {theory} s");
            assert!(late < rule + 1e-3 && late > 0.6 * rule, "{frames:?}: {late} of {rule} s");
        }
    }

    /// Frames at 60 Hz a period late: 8.3 and 3.25 ms. Quick ones: the blend.
    #[test]
    fn shared_constraints_are_late_by_a_quarter_of_a_frames_last_age() {
        let delay = of_shared_constraints(1.0 / 60.0, 1.0 / 60.0);
        assert!((delay - (0.5 / 60.0 + 0.5 * BLEND)).abs() < 1e-15);
        assert_eq!(of_shared_constraints(2e-3, 1e-3), BLEND);
    }
}
