//! Balance of contact: what it gives to one body it takes from the other.

use super::COLLISION;
use crate::lab::validate::case::{Basis, CaseError, Check, Figure};
use crate::lab::validate::run::Solver;
use crate::lab::validate::solids::PAD_PRESS;

/// Columns of the collision: total momentum, the cube's, forces on ball and box.
const COLUMNS: [&str; 15] = [
    "all.px", "all.py", "all.pz", "all.lx", "all.ly", "all.lz", "cube.px", "cube.py", "cube.pz",
    "ball.fx", "ball.fy", "ball.fz", "box.fx", "box.fy", "box.fz",
];

pub fn balance(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = collision(solver)?;
    figures.extend(press(solver)?);
    Ok(figures)
}

/// At every step, what the cube gains in momentum is the opposite of the forces that the probes
/// state for ball and box, and nothing is gained in all.
fn collision(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&COLLISION, &[])?;
    let series = run.record(0.4, &COLUMNS)?;
    let column = |k: usize| &series.columns[k];
    let (mut sum, mut total, mut angular, mut force) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    let (mut momentum, mut turning) = (0.0_f64, 0.0_f64);
    for i in 1..series.time.len() {
        let h = series.time[i] - series.time[i - 1];
        for axis in 0..3 {
            let gained = |k: usize| column(k)[i] - column(k)[i - 1];
            let on_rigid = column(9 + axis)[i] + column(12 + axis)[i];
            sum = sum.max((gained(6 + axis) / h + on_rigid).abs());
            force = force.max(on_rigid.abs());
            total = total.max((column(axis)[i] - column(axis)[0]).abs());
            angular = angular.max((column(3 + axis)[i] - column(3 + axis)[0]).abs());
            momentum = momentum.max(column(axis)[i].abs());
            turning = turning.max(column(3 + axis)[i].abs());
        }
    }
    let setup = run.setup();
    Ok(vec![
        Figure::new("largest contact force [N]", &setup, 0.1, force, Check::AtLeast),
        Figure::new(
            "force on flesh + on objects, worst step / force",
            &setup,
            1e-10,
            sum / force,
            Check::AtMost,
        )
        .rests_on(Basis::Construction),
        Figure::new("momentum gained / momentum", &setup, 1e-10, total / momentum, Check::AtMost)
            .rests_on(Basis::Construction),
        Figure::new(
            "angular momentum gained / angular momentum",
            setup,
            0.0,
            angular / turning,
            Check::Report,
        ),
    ])
}

/// At rest the plate, the bone and the load of 1 N agree.
fn press(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&PAD_PRESS, &[])?;
    let [plate, bone] = run.to(0.3)?.values(["press.fy", "carried.fy"])?;
    let setup = run.setup();
    let check = Check::Relative(0.01);
    Ok(vec![
        Figure::new("pressed with 1 N: force on the plate [N]", &setup, 1.0, plate, check),
        Figure::new("force that the flesh puts on the bone [N]", setup, 1.0, bone, check),
    ])
}
