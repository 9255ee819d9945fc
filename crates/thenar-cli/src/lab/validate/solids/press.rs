//! A static press does not know the time step.

use super::PAD_PRESS;
use crate::lab::validate::case::{CaseError, Check, Figure};
use crate::lab::validate::run::Solver;

pub fn step_independence(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures: Vec<Figure> = Vec::new();
    for h in [0.001, 0.005, 1.0 / 60.0] {
        let mut run = solver.with_step(&PAD_PRESS, h)?;
        let mm = -1e3 * run.to(0.3)?.value("bone.y")?;
        let first = figures.first().map(|f| f.got);
        let what = match first {
            None => "the bone sinks by, at 1 N [mm] (people: 1.0-2.5)",
            Some(_) => "the same with a longer step [mm]",
        };
        let (expected, check) = first.map_or((mm, Check::Report), |e| (e, Check::Relative(0.02)));
        figures.push(Figure::new(what, run.setup(), expected, mm, check));
    }
    Ok(figures)
}
