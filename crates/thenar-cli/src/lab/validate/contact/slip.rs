//! Friction of a rigid block on a table.

use super::{G, ISOTROPY, SLIDING};
use crate::lab::validate::case::{CaseError, Check, Figure};
use crate::lab::validate::run::Solver;
use std::f64::consts::{FRAC_PI_4, FRAC_PI_8};

/// Friction coefficient and mass \[kg\] of the isotropy scene.
const FRICTION: f64 = 0.5;
const MASS: f64 = 0.1;

/// The pull \[N\] that moves the block by ten nanometres, in each of 16 directions.
fn slip_forces(solver: Solver, cone: &str) -> Result<([f64; 16], String), CaseError> {
    let mut forces = [0.0; 16];
    let mut setup = String::new();
    for (k, force) in forces.iter_mut().enumerate() {
        let (sin, cos) = (FRAC_PI_8 * k as f64).sin_cos();
        let pull = [MASS * G * cos, 0.0, MASS * G * sin];
        let overrides = [format!("load.0.force={pull:?}"), format!("solver.cone={cone}")];
        let mut run = solver.open(&ISOTROPY, &overrides)?;
        let series = run.record(1.0, &["block.x", "block.z"])?;
        let moved = |i: &usize| series.columns[0][*i].hypot(series.columns[1][*i]) > 1e-8;
        let first = (0..series.time.len()).find(moved);
        let step = first.ok_or_else(|| CaseError::Missing(format!("{cone}: no slip")))?;
        *force = MASS * G * series.time[step];
        setup = run.setup();
    }
    Ok((forces, setup))
}

pub fn isotropy(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let limit = FRICTION * MASS * G;
    let spread = |f: &[f64; 16]| f.iter().map(|f| (f / limit - 1.0).abs()).fold(0.0, f64::max);
    let (circular, setup) = slip_forces(solver, "circular")?;
    let (square, _) = slip_forces(solver, "linearised")?;
    let low = square.iter().copied().fold(f64::INFINITY, f64::min) / limit;
    let high = square.iter().copied().fold(0.0, f64::max) / limit;
    Ok(vec![
        Figure::new(
            "circular: slip force / (mu N) - 1, worst of 16",
            &setup,
            0.01,
            spread(&circular),
            Check::AtMost,
        ),
        Figure::new(
            "linearised, n = 4: smallest slip force / (mu N)",
            &setup,
            FRAC_PI_4.cos(),
            low,
            Check::AtLeast,
        ),
        Figure::new(
            "linearised, n = 4: largest slip force / (mu N)",
            &setup,
            1.01,
            high,
            Check::AtMost,
        ),
    ])
}

/// Distance v₀²/(2 μ g) and time v₀/(μ g).
pub fn sliding(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&SLIDING, &[])?;
    let series = run.record(0.2, &["block.x", "velocity.vx"])?;
    let way = 1e3 * series.columns[0].last().copied().unwrap_or(f64::NAN);
    let moving = series.columns[1].iter().filter(|v| **v > 1e-4).count();
    let time = 1e3 * series.time.get(moving).copied().unwrap_or(f64::NAN);
    let setup = run.setup();
    let check = Check::Relative(0.02);
    Ok(vec![
        Figure::new("distance [mm]", &setup, 31.855, way, check),
        Figure::new("time [ms]", setup, 127.42, time, check),
    ])
}
