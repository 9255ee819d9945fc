//! Stiffness of a coupling at which a hand begins to hum: in the product's own loop, and by theory.

use crate::{FingerImpedance, Outcome, Rehearsal, RehearsalError};
use std::f64::consts::PI;
use thenar_scene::session::Session;
use thenar_touch::{LoopProfile, MARGIN};

/// Range in which an onset is sought, as parts of the theoretical one, which takes the hold between
/// two samples and what smooths them for one delay: no more than a factor of two either way, and a
/// quarter to spare. What lies beyond is reported as beyond.
const RANGE: [f64; 2] = [0.4, 2.5];
/// Rehearsals within that: each halves what is left, the last to 3 %.
const PROBES: u32 = 6;

/// The stiffest coupling on which what disturbs a hand dies out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onset {
    /// Stiffness as rehearsed \[N/m\]; infinite when the scene's couplings themselves are soft
    /// enough, and 0 when the softest that was tried is not.
    pub stiffness: f64,
    /// A spring that acts as late as the loop reckons with, by theory \[N/m\].
    pub theory: f64,
    /// All that was tried below the scene's couplings is soft enough: the onset lies above.
    pub beyond: bool,
    /// Stiffness that the loop shows any hand, by the rule with the rehearsal's grip \[N/m\].
    pub shown: f64,
    /// Delay from motion to force that the loop reckons with \[s\].
    pub delay: f64,
}

/// The stiffest spring that acts late by `delay` \[s\] on which such a finger comes to rest
/// \[N/m\]: on `m x" + b x' + k x = -K x(t - τ)` with a swing of ω that goes on, `b ω = K sin ωτ`
/// and `k - m ω² + b ω cot ωτ = 0`. For slow swings that is `b/τ`.
pub fn late_spring_onset(human: &FingerImpedance, delay: f64) -> f64 {
    let FingerImpedance { mass, damping, stiffness } = *human;
    let left = |angle: f64| {
        let swing = angle / delay;
        stiffness - mass * swing * swing + damping * swing / angle.tan()
    };
    // It falls from above nothing to minus infinity within half a turn.
    let (mut low, mut high) = (0.0, PI);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if left(middle) > 0.0 { low = middle } else { high = middle }
    }
    damping * low / (delay * low.sin())
}

/// A loop that ticks a thousand times a second.
fn profile(delay: f64) -> LoopProfile {
    let [damping, friction, resolution] = [0.0; 3];
    let rated_stiffness = f64::INFINITY;
    LoopProfile { period: 1e-3, delay, damping, friction, resolution, rated_stiffness }
}

impl Rehearsal {
    /// Looks for the stiffest coupling on which what disturbs its hand dies out; `open` opens the
    /// scene anew for each try.
    ///
    /// # Errors
    /// A number makes no sense, the hand has no damping, or the scene has no hand that could be
    /// worn.
    pub fn onset<E: From<RehearsalError>>(
        &self,
        open: impl Fn() -> Result<Session, E>,
    ) -> Result<Onset, E> {
        if self.human.damping <= 0.0 {
            let (what, expected) =
                ("the damping B", "more than 0 N s/m: without it nothing dies out");
            let value = format!("{} N s/m", self.human.damping);
            return Err(RehearsalError::Number { what, value, expected }.into());
        }
        let still = |grip: Option<f64>| -> Result<(bool, Outcome), E> {
            let out = Self { grip, sway: None, ..*self }.run(open()?)?;
            Ok((out.is_still(), out))
        };
        let (all, out) = still(None)?;
        let (couplings, delay) = (out.stiffness, out.delay);
        let profile = profile(delay);
        // Half a tick is what holding a force adds.
        let theory = late_spring_onset(&self.human, 0.5 * profile.period + delay);
        let rule = |grip| MARGIN * profile.felt_stiffness_max(grip);
        let shown = self.grip.map_or(couplings, |grip| rule(grip).min(couplings));
        let stiffness = f64::INFINITY;
        let mut onset = Onset { stiffness, theory, beyond: false, shown, delay };
        if all {
            return Ok(onset);
        }
        let [mut low, mut high] = RANGE.map(|part| (part * theory).min(couplings));
        let (mut found, most) = (0.0, high);
        for _ in 0..PROBES {
            let middle = (low * high).sqrt();
            let grip = (middle / rule(1.0)).clamp(1e-3, 1e3);
            let (is_still, out) = still(Some(grip))?;
            if is_still {
                (low, found) = (middle, out.stiffness);
            } else {
                high = middle;
            }
        }
        (onset.stiffness, onset.beyond) = (found, high == most && most < couplings);
        Ok(onset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Finger, Flow};
    use std::collections::VecDeque;

    /// A virtual finger on a spring that is read a whole number of ticks late, and held for one,
    /// begins to swing more and more where theory says, with half a tick for the hold.
    #[test]
    fn fingers_hum_where_theory_says() {
        for (mass, damping, stiffness, ticks) in
            [(0.05, 1.0, 50.0, 200), (0.02, 1.0, 500.0, 100), (0.2, 3.0, 100.0, 500)]
        {
            let human = FingerImpedance { mass, damping, stiffness };
            let h = 1e-4;
            let want = late_spring_onset(&human, h * (f64::from(ticks) + 0.5));
            let flow = Flow::new(&human, h);
            let grows = |spring: f64| {
                let mut finger = Finger { place: 1e-3, speed: 0.0 };
                let mut way: VecDeque<f64> = vec![0.0; ticks as usize].into();
                let mut largest = [0.0_f64; 4];
                for swing in &mut largest {
                    for _ in 0..20_000 {
                        way.push_back(finger.place);
                        let seen = way.pop_front().unwrap_or(0.0);
                        finger.advance(&flow, -spring * seen);
                        *swing = swing.max(finger.place.abs());
                    }
                }
                largest[3] > largest[1]
            };
            assert!(!grows(0.99 * want) && grows(1.01 * want), "{human:?}: {want} N/m");
        }
        let slow = FingerImpedance { mass: 1e-3, damping: 10.0, stiffness: 0.0 };
        let onset = late_spring_onset(&slow, 0.01);
        // Without mass and spring the swing goes a quarter of a turn in τ: half π times b/τ.
        assert!((onset / (0.5 * PI * 1000.0) - 1.0).abs() < 0.01, "{onset} N/m");
    }
}
