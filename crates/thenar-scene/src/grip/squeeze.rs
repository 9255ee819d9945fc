//! Depth to which pads push in: a law on the force that is felt.
//!
//! The pads' targets lie `u` inside where they touched. Force grows with `u` by a stiffness that
//! depends on drives, joints, flesh and object, and is not known; what is known is a bound of it,
//! that of the drives, and the secant `f/u` of what was met so far. Elastic contact stiffens: with
//! `f ~ u^n` the slope is `n` times the secant, and `n` is 2 at most (Hertz 1.5, pads of fingers 1
//! to 2). So
//!
//! ```text
//! u' = RATE (F - f) / min(bound, 2 f/u)
//! ```
//!
//! closes a gap in force at RATE/2 to RATE, whatever is gripped. Delays between target and felt
//! force add up to 50 ms (one step, the fingers' swing), and a loop of first order does not
//! overshoot while its rate times its delay is below 1/e [Åström and Hägglund 1995]: hence RATE.

use super::felt::Use;

/// Part of the lacking force that is closed in a second, at most \[1/s\].
pub const RATE: f64 = 8.0;
/// Fastest push \[m/s\]: as fast as pads close.
const SPEED: f64 = 0.04;
/// Fastest push, and way back, of pads that press \[m/s\]; where things are hard, gaps in force
/// below 4 N never ask for that speed. A loaf that gives way by 30 mm is held within a second, as
/// people hold one.
const PRESSING: f64 = 0.08;
/// The secant counts from here on \[m\]; before it says nothing.
const SECANT_FROM: f64 = 2e-4;
/// Pads press from this part of the wanted force on: what is below may be the end of a bounce.
const PRESSES: f64 = 0.1;
/// No object is softer than this part of the drives.
const SOFTEST: f64 = 1.0 / 32.0;
/// Range of the depth to which pads are pushed in \[m\]: out by the depth of a pad, where the first
/// touch was too hard, to in by half a finger.
pub const RANGE: [f64; 2] = [-5e-3, 0.06];

/// Depth `u` \[m\] after a step of `h` \[s\], with `felt` of the `wanted` force \[N\] and drives
/// whose stiffness is no more than `bound` \[N/m\].
pub fn push(u: f64, felt: f64, wanted: f64, bound: f64, h: f64) -> f64 {
    let rate = speed_for(wanted - felt, slope(u, felt, bound), h);
    let fastest = if felt < PRESSES * wanted { SPEED } else { PRESSING };
    (u + rate.clamp(-fastest, fastest) * h).clamp(RANGE[0], RANGE[1])
}

/// Stiffness that pads meet at depth `u` with the force `felt` \[N/m\]: twice the secant, at most
/// `bound`.
pub fn slope(u: f64, felt: f64, bound: f64) -> f64 {
    let secant = if u > SECANT_FROM { 2.0 * felt / u } else { bound };
    secant.clamp(SOFTEST * bound, bound)
}

/// Rate of a depth that closes a gap in force \[m/s\]; no more in one step than half of the gap,
/// however long the step.
fn speed_for(gap: f64, stiffness: f64, h: f64) -> f64 {
    RATE.min(0.5 / h) * gap / stiffness
}

/// Ratio of the force that is kept to the one that would slip. People keep to the same where things
/// get heavier or slipperier in their fingers [Johansson and Westling 1984].
const SAFETY: f64 = 1.5;
/// Largest ratio of a force that adapts to the one foreseen: what still slips then does not lack
/// force.
const RISE_MAX: f64 = 4.0;
/// Time in which a force that rose falls again \[s\]. People let go slowly what threatened to slip.
const FALL: f64 = 1.0;

/// Time in which pads come to press harder before the load comes \[s\]: that of [`RATE`].
const READY: f64 = 1.0 / RATE;

/// Returns the force that is wanted after a step of `h` \[s\] \[N\], where pads press with `force`.
/// `begins` is the force foreseen, `margin` its ratio to the one that keeps the object from
/// slipping between pads that press straight. Until the object is carried, pads at their slant keep
/// that ratio, too; from then on the load sets the force.
pub fn wanted(before: f64, [begins, margin]: [f64; 2], force: f64, used: Use, h: f64) -> f64 {
    let most = RISE_MAX * begins;
    let asked = (SAFETY * used.load * force).min(most);
    let least = SAFETY / margin * begins;
    let floor =
        if used.carried { least } else { (begins / (1.0 - used.slant).max(1e-9)).min(most) };
    let time = if floor > before { READY } else { FALL };
    let neared = floor + (before - floor) * (-h / time).exp();
    asked.max(neared)
}

/// A finger is pushed in until it bears this part of the mean of the fingers.
const LEAST_SHARE: f64 = 1.0 / 3.0;
/// Least part of the mean of two fingers: where one of them lets go, a thing turns about the line
/// from the thumb to the other. At `SAFETY` times the slip limit a finger with this part carries
/// its part of the weight just so.
const LEAST_SHARE_OF_TWO: f64 = 1.0 / SAFETY;

/// Part of the mean that each of `count` fingers is to bear at least.
pub fn least_share(count: usize) -> f64 {
    if count == 2 { LEAST_SHARE_OF_TWO } else { LEAST_SHARE }
}

/// Limit of the depth by which one finger is pushed in beyond the others, once it is where it was
/// to touch \[m\]: half as thick as a finger is.
pub const FURTHER_MAX: f64 = 8e-3;
/// Below this part of its least share a finger touches nothing yet.
const TOUCHES: f64 = 0.1;

/// Returns the depth by which a finger is pushed in beyond the others after a step of `h` \[s\],
/// `most` \[m\] at most, when it bears `felt`, all together bear `mean` each \[N\], of which it is
/// to bear the part `least`, and meet a [`slope`], of which one finger's is a part; less again when
/// it bears more than the mean. One that bears its share is left alone: were each finger to have a
/// force of its own, an object would wander that its weight presses on one side.
pub fn further(
    before: f64,
    felt: f64,
    (mean, least): (f64, f64),
    (slope, most): (f64, f64),
    h: f64,
) -> f64 {
    let share = least * mean;
    let lacks = (share - felt).max(0.0) + (mean - felt).min(0.0);
    let rate = match felt < TOUCHES * share {
        true => SPEED,
        false => speed_for(lacks, slope, h),
    };
    (before + rate.clamp(-SPEED, SPEED) * h).clamp(0.0, most)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A load that has 0.8 of its friction in use wants a fifth more than there is, one that slides
    /// half as much again, and no load more than four times what was foreseen.
    #[test]
    fn force_rises_with_the_part_of_friction_in_use() {
        let wanted_of = |force: f64, load: f64| {
            wanted(1.0, [1.0, 2.0], force, Use { load, ..Use::default() }, 0.01)
        };
        assert!((wanted_of(1.0, 0.8) - 1.2).abs() < 1e-12);
        assert_eq!(wanted_of(1.0, 1.0), 1.5);
        assert_eq!(wanted_of(30.0, 1.0), RISE_MAX);
    }

    /// Foreseen are twice what would slip. Without a load they are kept, and pads of which half of
    /// the friction goes to their slant press twice as hard; under the load half of the way to 1.5
    /// times is left after 0.69 s, whatever the step.
    #[test]
    fn force_is_kept_until_the_load_is_felt_and_falls_then() {
        for h in [1e-3, 1e-2] {
            let after = |time: f64, used: Use| {
                let steps = (time / h).round() as usize;
                (0..steps).fold(2.0, |before, _| wanted(before, [2.0, 2.0], before, used, h))
            };
            assert_eq!(after(3.0, Use::default()), 2.0);
            let aslant = after(3.0, Use { slant: 0.5, ..Use::default() });
            assert!((aslant - 4.0).abs() < 1e-3, "{aslant}");
            let under_load = (0..(2f64.ln() / h).round() as usize).fold(2.0, |before, _| {
                // A load whose slip limit is 1 N uses up this part of what a force gives.
                wanted(
                    before,
                    [2.0, 2.0],
                    before,
                    Use { load: 1.0 / before, carried: true, ..Use::default() },
                    h,
                )
            });
            assert!((under_load - 1.75).abs() < 5e-3, "{h}: {under_load}");
        }
    }

    /// With 1.5 times the slip limit `m g / (2 μ)` of the thumb's side, a finger that bears its
    /// least share carries a part `m g / 4` of the weight just so: `μ` times two thirds of half of
    /// the force.
    #[test]
    fn the_least_share_of_two_fingers_carries_their_part() {
        let (weight, friction) = (1.0, 0.8);
        let force = SAFETY * weight / (2.0 * friction);
        let carried = friction * least_share(2) * force / 2.0;
        assert!((carried - weight / 4.0).abs() < 1e-12, "{carried} N");
    }

    /// An idle finger 5 mm off a spring comes in, and stops near its third.
    #[test]
    fn an_idle_finger_comes_in_until_it_bears_its_share() {
        for h in [1e-3, 1e-2, 1.0 / 60.0] {
            let (mut way, mut felt) = (0.0, 0.0);
            for _ in 0..(3.0 / h) as usize {
                let now = 400.0 * f64::max(way - 0.005, 0.0);
                way = further(way, felt, (1.5, LEAST_SHARE), (1000.0, FURTHER_MAX), h);
                felt = now;
            }
            assert!((felt - 0.5).abs() < 0.05, "{h}: {felt} N");
        }
        assert_eq!(further(0.003, 0.6, (1.5, LEAST_SHARE), (1000.0, FURTHER_MAX), 0.01), 0.003);
        // It goes back where it bears more than the others, no farther than they are.
        assert!(further(0.003, 2.5, (1.5, LEAST_SHARE), (1000.0, FURTHER_MAX), 0.01) < 0.003);
        assert_eq!(further(1e-6, 2.5, (1.5, LEAST_SHARE), (1000.0, FURTHER_MAX), 0.01), 0.0);
        let nothing = (0..1000)
            .fold(0.0, |way, _| further(way, 0.0, (1.5, LEAST_SHARE), (1000.0, FURTHER_MAX), 0.01));
        assert_eq!(nothing, FURTHER_MAX);
    }

    /// A body that gives way by 30 mm is pressed with 95 % of the force within 0.85 s, whatever the
    /// step; were pads that press no faster than pads that close, it would take 0.95 s at least.
    #[test]
    fn what_is_soft_is_held_soon() {
        for h in [1e-3, 5e-3, 1.0 / 60.0] {
            let (mut u, mut felt, mut t) = (0.0, 0.0, 0.0);
            while felt < 0.95 * 6.0 {
                let now = 200.0 * u;
                u = push(u, felt, 6.0, 900.0, h);
                (felt, t) = (now, t + h);
            }
            assert!(t < 0.85, "{h}: {t} s");
        }
    }

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
