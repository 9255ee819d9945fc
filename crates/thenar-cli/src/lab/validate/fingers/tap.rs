//! Taps: what of the energy of a short press is lost.

use super::curve::{force_and_area, open};
use super::{HandVariant, OWN, SMALL};
use crate::lab::validate::case::{Basis, CaseError, Check, Figure};
use crate::lab::validate::run::Solver;

/// Depth of all taps \[m\].
const DEPTH: f64 = 2e-3;
/// Steps and keyframes of a tap.
const STEPS: u32 = 100;
const KEYS: u32 = 50;

/// The part of the work of a half-sine press of this time \[s\] that is lost.
fn loss(solver: Solver, hand: HandVariant, time: f64) -> Result<f64, CaseError> {
    let depth = |t: f64| DEPTH * (std::f64::consts::PI * t / time).sin();
    let course: Vec<[f64; 2]> =
        (0..=KEYS).map(|k| time * f64::from(k) / f64::from(KEYS)).map(|t| [t, depth(t)]).collect();
    let step = [format!("time_step={:e}", time / f64::from(STEPS))];
    let (mut run, plate) = open(solver, hand, 30.0, &course, &step)?;
    let (mut given, mut back, mut before) = (0.0, 0.0, 0.0);
    for k in 1..=STEPS {
        run.step()?;
        let force = force_and_area(&mut run, &plate)?.0;
        // Straight between keyframes, as the plate goes.
        let now = between(&course, time * f64::from(k) / f64::from(STEPS));
        let work = force * (now - before);
        if work > 0.0 {
            given += work
        } else {
            back -= work
        }
        before = now;
    }
    Ok(1.0 - back / given)
}

fn between(course: &[[f64; 2]], t: f64) -> f64 {
    let k = course.partition_point(|key| key[0] <= t).clamp(1, course.len() - 1);
    let ([t0, d0], [t1, d1]) = (course[k - 1], course[k]);
    d0 + (d1 - d0) * ((t - t0) / (t1 - t0)).clamp(0.0, 1.0)
}

/// Jindrich et al. 2003: eight people, 81 %, within 3 % over energies and forces.
pub fn taps(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for hand in [OWN, SMALL] {
        let setup = format!("{}, 30°, 2 mm, h = T/100", hand.name);
        let times: &[f64] = if hand == OWN { &[0.02, 0.05, 0.1, 0.2] } else { &[0.05] };
        let mut losses = Vec::new();
        for time in times {
            let loss = loss(solver, hand, *time)?;
            let what = format!("energy lost in a tap of {} ms", 1e3 * time);
            figures.push(
                Figure::within(what, &setup, [0.76, 0.86], loss)
                    .rests_on(Basis::People)
                    .or_cannot("three terms of memory on a linear law; the times are those of Pawluk and Howe, the parts are not measured"),
            );
            losses.push(loss);
        }
        if losses.len() > 1 {
            let high = losses.iter().copied().fold(0.0, f64::max);
            let low = losses.iter().copied().fold(1.0, f64::min);
            figures.push(
                Figure::new("spread of the losses", &setup, 0.08, high - low, Check::AtMost)
                    .rests_on(Basis::People),
            );
        }
    }
    Ok(figures)
}
