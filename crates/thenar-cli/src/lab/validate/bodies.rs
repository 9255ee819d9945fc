//! Rigid bodies, joints, integrator.

mod chains;
mod landing;
mod single;

use super::case::{Basis, Case, CaseError, Check, Figure, SceneText, case, scene};
use super::run::{Solver, order, step_words};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The cases.
pub const CASES: &[Case] = &[
    case("A1", "free fall", free_fall),
    case("A2", "pendulum of finite amplitude", pendulum),
    case("A3", "double pendulum", chains::double_pendulum),
    case("A4", "three-link planar finger", chains::planar_finger),
    case("A5", "universal joint and two hinges in space", chains::universal_finger),
    case("A6", "flip about the intermediate axis", single::axis_flip),
    case("A7", "heavy top in steady precession", single::heavy_top),
    case("A8", "free chain of 16 bones", single::free_hand),
    case("A9", "damped oscillator", damped_oscillator),
    case("A10", "joints do not drift in 60 s", chains::joint_drift),
    case("A11", "inelastic landing of a rod", landing::rod),
    case("A12", "free symmetric body", single::symmetric_body),
];

const FREE_FALL: SceneText = scene!("a01-free-fall");
const PENDULUM: SceneText = scene!("a02-pendulum");
const OSCILLATOR: SceneText = scene!("a09-damped-oscillator");

/// An exact step of backward Euler falls by `g h² n (n + 1) / 2` in n steps.
fn free_fall(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let height = |h: f64| solver.with_step(&FREE_FALL, h)?.to(0.5)?.value("ball.y");
    let mut figures = Vec::new();
    for h in [1e-3, 1.0 / 60.0] {
        let n = (0.5_f64 / h).round();
        let expected = -9.81 * h * h * n * (n + 1.0) / 2.0;
        let what = "y(0.5 s) [m], recurrence";
        let (setup, check) = (step_words(h), Check::Absolute(1e-9));
        let figure = Figure::new(what, setup, expected, height(h)?, check);
        figures.push(figure.rests_on(Basis::Construction));
    }
    let off = |h: f64| Ok::<f64, CaseError>(height(h)? + 9.81 * 0.125);
    let what = "error against g t²/2: ratio when h halves";
    let ratio = off(1e-3)? / off(5e-4)?;
    figures.push(Figure::new(what, "h = 1 and 0.5 ms", 2.0, ratio, Check::Relative(1e-6)));
    Ok(figures)
}

/// `K(k²)` by the arithmetic-geometric mean.
pub fn elliptic_k(k2: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k2).sqrt());
    while a - b > 1e-15 * a {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    FRAC_PI_2 / a
}

/// `T / T₀ = (2/π) K(sin² θ₀/2)`, `T₀ = 2π √(2 L / 3 g)` for a uniform rod.
fn pendulum(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let small = TAU * (2.0 / (3.0 * 9.81_f64)).sqrt();
    let period = |degrees: f64, h: f64| {
        let angle = format!("joint.pivot.angles=[{}]", degrees.to_radians());
        let mut run = solver.open(&PENDULUM, &[format!("time_step={h:e}"), angle])?;
        let crossings = run.record(3.0, &["pivot.angle0"])?.zero_crossings(0);
        let [first, second, ..] = crossings[..] else {
            return Err(CaseError::Missing(format!("no swing from {degrees} degrees")));
        };
        Ok(2.0 * (second - first) / small)
    };
    let mut figures = Vec::new();
    for degrees in [30.0, 60.0, 90.0, 120.0, 150.0_f64] {
        let expected = elliptic_k((0.5 * degrees.to_radians()).sin().powi(2)) / FRAC_PI_2;
        let got = period(degrees, 1e-3)?;
        let what = format!("T/T0 from {degrees} degrees");
        figures.push(Figure::new(what, step_words(1e-3), expected, got, Check::Relative(2e-3)));
        if degrees == 90.0 {
            let off = |h: f64| Ok::<f64, CaseError>(period(degrees, h)? - expected);
            let p = order(off(4e-3)?, off(2e-3)?, 2.0);
            let what = "order of the error of T from 90 degrees";
            figures.push(Figure::new(what, "h = 4 and 2 ms", 1.0, p, Check::AtLeast));
        }
    }
    Ok(figures)
}

/// `(m + h c + h² k) v' = m v - h k x`, `x' = x + h v'`.
fn oscillator_recurrence(h: f64, time: f64) -> f64 {
    let (m, k, c) = (0.020, 100.0, 0.2);
    let (mut x, mut v) = (0.010, 0.0);
    for _ in 0..(time / h).round() as usize {
        v = (m * v - h * k * x) / (m + h * c + h * h * k);
        x += h * v;
    }
    x
}

fn damped_oscillator(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let exact = 4.652942e-3;
    let mut figures = Vec::new();
    let mut off = Vec::new();
    for h in [1e-2, 1e-3, 1e-4] {
        let got = solver.with_step(&OSCILLATOR, h)?.to(0.1)?.value("mass.x")?;
        let expected = oscillator_recurrence(h, 0.1);
        let what = "x(0.1 s) [m], recurrence";
        let figure = Figure::new(what, step_words(h), expected, got, Check::Absolute(1e-9));
        figures.push(figure.rests_on(Basis::Construction));
        off.push(got - exact);
    }
    let p = order(off[1], off[2], 10.0);
    let what = "order of the error against the exact solution";
    figures.push(Figure::new(what, "h = 1 and 0.1 ms", 1.0, p, Check::Absolute(0.1)));
    Ok(figures)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expected_values_are_those_of_independent_codes() {
        assert!((elliptic_k(0.5) / FRAC_PI_2 - 1.180341).abs() < 5e-7);
        let k2 = (75.0_f64.to_radians()).sin().powi(2);
        assert!((elliptic_k(k2) / FRAC_PI_2 - 1.762204).abs() < 5e-7);
        for (h, x) in [(1e-2, 0.865482e-3), (1e-3, 3.782747e-3), (1e-4, 4.553188e-3)] {
            assert!((oscillator_recurrence(h, 0.1) - x).abs() < 5e-10);
        }
    }
}
