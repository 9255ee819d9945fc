//! Bodies that turn in space.

use crate::lab::validate::case::{CaseError, Check, Figure, SceneText, scene};
use crate::lab::validate::run::{Series, Solver, step_words};
use thenar_core::{Quat, Vec3};

const AXIS_FLIP: SceneText = scene!("a06-axis-flip");
const HEAVY_TOP: SceneText = scene!("a07-heavy-top");
const FREE_HAND: SceneText = scene!("a08-free-hand");
const SYMMETRIC_BODY: SceneText = scene!("a12-symmetric-body");

const POSE_AND_SPIN: [&str; 7] =
    ["pose.qx", "pose.qy", "pose.qz", "pose.qw", "v.wx", "v.wy", "v.wz"];
const MOMENTUM: [&str; 6] =
    ["momentum.px", "momentum.py", "momentum.pz", "momentum.lx", "momentum.ly", "momentum.lz"];

fn vector(row: &[f64]) -> Vec3 {
    Vec3::new(row[0], row[1], row[2])
}

fn rotation(row: &[f64]) -> Quat {
    Quat::new_normalize(nalgebra::Quaternion::new(row[3], row[0], row[1], row[2]))
}

/// Angular velocity in the body's frame at each row of [`POSE_AND_SPIN`].
fn body_spin(series: &Series) -> Vec<Vec3> {
    let row = |i: usize| -> Vec<f64> { series.columns.iter().map(|c| c[i]).collect() };
    let spin = |row: Vec<f64>| rotation(&row).inverse_transform_vector(&vector(&row[4..]));
    (0..series.time.len()).map(|i| spin(row(i))).collect()
}

/// Mean rate of an angle given at each time, turns counted \[rad/s\].
fn mean_rate(time: &[f64], angles: &[f64]) -> f64 {
    use std::f64::consts::{PI, TAU};
    let step = |w: &[f64]| (w[1] - w[0] + PI).rem_euclid(TAU) - PI;
    let turned: f64 = angles.windows(2).map(step).sum();
    turned / (time[time.len() - 1] - time[0])
}

pub fn axis_flip(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let h = 1e-3;
    let setup = step_words(h);
    let mut run = solver.with_step(&AXIS_FLIP, h)?;
    let columns = [&POSE_AND_SPIN[..], &MOMENTUM[3..], &["energy.kinetic"]].concat();
    let series = run.record(10.0, &columns)?;
    let middle = body_spin(&series).iter().map(|w| w.y).collect();
    let spin = Series { time: series.time.clone(), columns: vec![middle] };
    let crossings = spin.zero_crossings(0);
    let [first, second, third, ..] = crossings[..] else {
        return Err(CaseError::Missing("the body flips fewer than three times in 10 s".into()));
    };
    let row =
        |what: &str, expected, got, check| Figure::new(what, setup.clone(), expected, got, check);
    let exact = Check::Relative(1e-4);
    let mut figures = vec![
        row("first zero of the middle spin [s]", 1.490594, first, exact),
        row("first to second zero [s]", 2.753084, second - first, exact),
        row("second to third zero [s]", 2.753084, third - second, exact),
    ];
    let at = |i: usize| Vec3::from_fn(|k, _| series.columns[7 + k][i]);
    let moved = |i: usize| (at(i) - at(0)).norm() / at(0).norm();
    let momentum = (0..series.time.len()).map(moved).fold(0.0, f64::max);
    let energy: &[f64] = &series.columns[10];
    let change = energy.iter().fold(0.0, |m, e| f64::max(m, (e / energy[0] - 1.0).abs()));
    figures.push(row(
        "|L| at the start [kg m²/s]",
        2.0000025e-3,
        at(0).norm(),
        Check::Relative(1e-9),
    ));
    figures.push(row("2 T at the start [J]", 0.02000004, 2.0 * energy[0], Check::Relative(1e-9)));
    figures.push(row("largest change of L in 10 s, relative", 1e-6, momentum, Check::AtMost));
    figures.push(row("largest change of T in 10 s, relative", 1e-6, change, Check::AtMost));
    Ok(figures)
}

/// Azimuth about z against the slow and the fast root of
/// `I Ω² cos θ - I₃ ω₃ Ω + m g l = 0`, I about the pivot.
pub fn heavy_top(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let h = 1e-4;
    let precession = |overrides: &[String], time: f64| -> Result<(f64, f64), CaseError> {
        let mut run = solver.open(&HEAVY_TOP, overrides)?;
        let series = run.record(time, &["disc.x", "disc.y", "disc.z"])?;
        let [x, y, z] = &series.columns[..] else { return Ok((f64::NAN, f64::NAN)) };
        let azimuth: Vec<f64> = x.iter().zip(y).map(|(x, y)| y.atan2(*x)).collect();
        let tilt = |z: &f64| ((z / 0.04).clamp(-1.0, 1.0).acos() - 30_f64.to_radians()).abs();
        let nods = z.iter().map(tilt).fold(0.0, f64::max);
        Ok((mean_rate(&series.time, &azimuth), nods))
    };
    let (slow, nods) = precession(&[], 2.0)?;
    let spin = "joint.pivot.angular_velocity=[114.31834179, 0, 280.40843611]";
    let (fast, _) = precession(&[spin.into()], 0.2)?;
    let (whirl, gyroscopic) = (Check::Relative(5e-3), 2.90667);
    let row =
        |what: &str, expected, got, check| Figure::new(what, step_words(h), expected, got, check);
    Ok(vec![
        row("slow precession [rad/s]", 3.01294, slow, whirl),
        row("fast precession [rad/s]", 82.4033, fast, whirl),
        row("slow precession over m g l / I3 w3", 3.01294 / gyroscopic, slow / gyroscopic, whirl),
        row("largest change of tilt [rad]", 0.0, nods, Check::Report),
    ])
}

/// Momentum after a push of 50 ms must stay, whatever the joints do.
pub fn free_hand(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let h = 1e-3;
    let mut run = solver.with_step(&FREE_HAND, h)?;
    let start = run.to(0.06)?.values(MOMENTUM)?;
    let (p, l) = (vector(&start), vector(&start[3..]));
    let columns = [&MOMENTUM[..], &["energy.kinetic", "step.joint_gap_max"]].concat();
    let series = run.record(10.0, &columns)?;
    let off = |from: usize, v: Vec3| {
        let at = |i: usize| Vec3::from_fn(|k, _| series.columns[from + k][i]);
        (0..series.time.len()).map(|i| (at(i) - v).norm()).fold(0.0, f64::max)
    };
    let row = |what: &str, expected, got, check| {
        Figure::new(what, format!("16 bones, {}", step_words(h)), expected, got, check)
    };
    Ok(vec![
        row("largest change of P in 10 s, relative", 1e-10, off(0, p) / p.norm(), Check::AtMost),
        row("largest change of L in 10 s, relative", 1e-6, off(3, l) / l.norm(), Check::AtMost),
        row("|P| [kg m/s]", 0.0, p.norm(), Check::Report),
        row("|L| about the origin [kg m²/s]", 0.0, l.norm(), Check::Report),
        row("largest kinetic energy [J]", 0.0, series.largest(6), Check::Report),
        row("largest joint gap [m]", 0.0, series.largest(7), Check::Report),
    ])
}

/// Precession at `|L| / I₁` in space and `(I₃ - I₁) ω₃ / I₁` in the body.
pub fn symmetric_body(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let h = 1e-4;
    let series = solver
        .with_step(&SYMMETRIC_BODY, h)?
        .record(2.0, &[&POSE_AND_SPIN[..], &MOMENTUM[3..]].concat())?;
    let in_body: Vec<f64> = body_spin(&series).iter().map(|w| w.y.atan2(w.x)).collect();
    let l = Vec3::from_fn(|k, _| series.columns[7 + k][0]).normalize();
    let (across, along) = thenar_core::math::tangents(&l);
    let azimuth = |i: usize| {
        let row: Vec<f64> = series.columns.iter().map(|c| c[i]).collect();
        let axis = rotation(&row) * Vec3::z();
        let turn = axis.dot(&along).atan2(axis.dot(&across));
        if across.cross(&along).dot(&l) > 0.0 { turn } else { -turn }
    };
    let in_space: Vec<f64> = (0..series.time.len()).map(azimuth).collect();
    let row = |what: &str, expected, angles: &[f64]| {
        let got = mean_rate(&series.time, angles);
        Figure::new(what, step_words(h), expected, got, Check::Relative(1e-4))
    };
    Ok(vec![
        row("precession about L in space [rad/s]", 35.1283, &in_space),
        row("precession in the body [rad/s]", 15.0, &in_body),
    ])
}
