//! How hard pads push in: a law on the force that is felt.
//!
//! The pads' targets lie `u` inside where they touched. Force grows with `u` by a stiffness that depends on drives, joints,
//! flesh and object, and is not known; what is known is a bound of it, that of the drives, and the secant
//! `(f - f₀)/(u - u₀)` of what was met since the force had settled after the touch, at `u₀`. Elastic contact stiffens:
//! with `f ~ u^n` the slope is at most `n` times any secant below it, and `n` is 2 at most (Hertz 1.5, pads of fingers 1
//! to 2). So
//!
//! ```text
//! u' = RATE (F - f) / min(bound, 2 (f - f₀)/(u - u₀))
//! ```
//!
//! closes a gap in force at RATE/2 to RATE, whatever is gripped. Delays between target and felt force add up to 50 ms
//! (one step, the fingers' swing), and a loop of first order does not overshoot while its rate times its delay is below
//! 1/e [Åström and Hägglund 1995]: hence RATE.

use serde::{Deserialize, Serialize};

/// Part of the lacking force that is closed in a second, at most \[1/s\].
pub const RATE: f64 = 8.0;
/// Fastest push \[m/s\]: as fast as pads close.
const SPEED: f64 = 0.04;
/// Where the secant begins, and how long it is before it says anything \[m\].
const SECANT_FROM: f64 = 2e-4;
/// No object is softer than this part of the drives.
const SOFTEST: f64 = 1.0 / 32.0;
/// How far in pads are pushed, and how far out where the first touch was too hard \[m\]: half a finger, and the depth of a pad.
pub const RANGE: [f64; 2] = [-5e-3, 0.06];

/// How far pads are in, and the force where the secant begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Squeeze {
    /// How far pads are pushed in \[m\].
    pub depth: f64,
    /// Force that was felt at the last depth below the secant's beginning \[N\].
    pub from: f64,
}

impl Squeeze {
    /// Goes on by a step of `h` \[s\], with `felt` of the `wanted` force \[N\] and drives whose stiffness is no more than
    /// `bound` \[N/m\].
    pub fn push(&mut self, felt: f64, wanted: f64, bound: f64, h: f64) {
        let along = self.depth - SECANT_FROM;
        if along <= 0.0 {
            self.from = felt;
        }
        let secant = if along > SECANT_FROM { 2.0 * (felt - self.from) / along } else { bound };
        let stiffness = secant.clamp(SOFTEST * bound, bound);
        // No more in one step than the whole of what lacks, however long the step.
        let rate = RATE.min(0.5 / h) * (wanted - felt) / stiffness;
        self.depth = (self.depth + rate.clamp(-SPEED, SPEED) * h).clamp(RANGE[0], RANGE[1]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Springs from a thirtieth of the bound to all of it, linear to quadratic, bent by the touch or not, felt a step late.
    #[test]
    fn force_settles_without_overshoot_whatever_is_gripped() {
        for h in [1e-3, 5e-3, 1.0 / 60.0] {
            for touch in [0.0, 0.1, 0.5] {
                for spring in SPRINGS {
                    let [_, most, end, top] = press(h, touch, spring);
                    let told = format!("{h} {touch} {spring:?}");
                    assert!((end - WANTED.min(top)).abs() < 0.04, "{told}: {end} N");
                    assert!(most < WANTED * 1.05, "{told}: {most} N");
                }
            }
        }
    }

    /// A gap closes at RATE/2 at least, whatever force the touch left: ln 10 of its time constants are nine tenths of it.
    /// Before that the secant is travelled at the drives' own stiffness.
    #[test]
    fn force_rises_as_fast_after_a_hard_touch_as_after_a_soft_one() {
        for h in [1e-3, 5e-3, 1.0 / 60.0] {
            for touch in [0.0, 0.1, 0.5, 1.0] {
                for spring in SPRINGS.into_iter().filter(|(k, n)| *n > 1.0 || *k > 60.0) {
                    let [time, _, _, _] = press(h, touch, spring);
                    let travel = 2.0 * SECANT_FROM * BOUND / (RATE * (WANTED - 1.0));
                    let most = 10f64.ln() / (0.5 * RATE) + travel + 2.0 * h;
                    assert!(time < most, "{h} {touch} {spring:?}: {time} s of {most} s");
                }
            }
        }
    }

    const BOUND: f64 = 1000.0;
    const WANTED: f64 = 2.0;
    const SPRINGS: [(f64, f64); 5] =
        [(1000.0, 1.0), (300.0, 1.0), (40.0, 1.0), (4e4, 2.0), (8e3, 1.5)];

    /// A spring that bears `touch` \[N\] at no depth, pressed for 3 s: when nine tenths of what lacked are there \[s\], the
    /// most force, the last, and what the spring bears at the end of the range \[N\].
    fn press(h: f64, touch: f64, (stiffness, power): (f64, f64)) -> [f64; 4] {
        let met = (touch / stiffness).powf(1.0 / power).max(touch / BOUND);
        let force = |u: f64| {
            let u = u + met;
            if u <= 0.0 { 0.0 } else { f64::min(stiffness * u.powf(power), BOUND * u) }
        };
        let (mut squeeze, mut felt, mut most) = (Squeeze::default(), force(0.0), 0.0f64);
        let (mut time, mut k) = (f64::INFINITY, 0.0);
        while k * h < 3.0 {
            let now = force(squeeze.depth);
            squeeze.push(felt, WANTED, BOUND, h);
            felt = now;
            most = most.max(now);
            if now > WANTED - 0.1 * (WANTED - touch) {
                time = time.min(k * h);
            }
            k += 1.0;
        }
        [time, most, force(squeeze.depth), force(RANGE[1])]
    }
}
