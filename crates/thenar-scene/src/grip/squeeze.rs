//! How hard pads push in: a law on the force that is felt.
//!
//! The pads' targets lie `u` inside where they touched. Force grows with `u` by a stiffness that depends on drives, joints,
//! flesh and object, and is not known; what is known is a bound of it, that of the drives, and the secant `f/u` of what
//! was met so far. Elastic contact stiffens: with `f ~ u^n` the slope is `n` times the secant, and `n` is 2 at most
//! (Hertz 1.5, pads of fingers 1 to 2). So
//!
//! ```text
//! u' = RATE (F - f) / min(bound, 2 f/u)
//! ```
//!
//! closes a gap in force at RATE/2 to RATE, whatever is gripped. Delays between target and felt force add up to 50 ms
//! (one step, the fingers' swing), and a loop of first order does not overshoot while its rate times its delay is below
//! 1/e [Åström and Hägglund 1995]: hence RATE.

/// Part of the lacking force that is closed in a second, at most \[1/s\].
pub const RATE: f64 = 8.0;
/// Fastest push \[m/s\]: as fast as pads close.
const SPEED: f64 = 0.04;
/// The secant counts from here on \[m\]; before it says nothing.
const SECANT_FROM: f64 = 2e-4;
/// No object is softer than this part of the drives.
const SOFTEST: f64 = 1.0 / 32.0;
/// How far in pads are pushed, and how far out where the first touch was too hard \[m\]: half a finger, and the depth of a pad.
pub const RANGE: [f64; 2] = [-5e-3, 0.06];

/// Depth `u` \[m\] after a step of `h` \[s\], with `felt` of the `wanted` force \[N\] and drives whose stiffness is no more
/// than `bound` \[N/m\].
pub fn push(u: f64, felt: f64, wanted: f64, bound: f64, h: f64) -> f64 {
    let secant = if u > SECANT_FROM { 2.0 * felt / u } else { bound };
    let stiffness = secant.clamp(SOFTEST * bound, bound);
    // No more in one step than the whole of what lacks, however long the step.
    let rate = RATE.min(0.5 / h) * (wanted - felt) / stiffness;
    (u + rate.clamp(-SPEED, SPEED) * h).clamp(RANGE[0], RANGE[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Springs from a thirtieth of the bound to all of it, linear to quadratic, felt a step late.
    #[test]
    fn force_settles_without_overshoot_whatever_is_gripped() {
        let bound = 1000.0;
        for h in [1e-3, 5e-3, 1.0 / 60.0] {
            for (stiffness, power) in
                [(1000.0, 1.0), (300.0, 1.0), (40.0, 1.0), (4e4, 2.0), (8e3, 1.5)]
            {
                let force = |u: f64| {
                    if u <= 0.0 { 0.0 } else { f64::min(stiffness * u.powf(power), bound * u) }
                };
                let (mut u, mut felt, mut most) = (0.0, 0.0, 0.0f64);
                for _ in 0..(3.0 / h) as usize {
                    let now = force(u);
                    u = push(u, felt, 2.0, bound, h);
                    felt = now;
                    most = most.max(now);
                }
                let end = force(u);
                assert!(
                    (end - 2.0f64.min(force(RANGE[1]))).abs() < 0.04,
                    "{h} {stiffness}: {end} N"
                );
                assert!(most < 2.0 * 1.05, "{h} {stiffness} {power}: {most} N");
            }
        }
    }
}
