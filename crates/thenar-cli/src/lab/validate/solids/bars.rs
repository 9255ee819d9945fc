//! Bars at small deflection. On Kuhn cells the linear elements have one exact solution, known
//! here to six digits; it shows how they lock on coarse meshes. Beside it stands the solution of
//! the continuum, for the reader.

use super::{CANTILEVER, OWN_WEIGHT, SHORT_BAR, TORSION};
use crate::lab::validate::case::{CaseError, Check, Figure, SceneText};
use crate::lab::validate::run::Solver;

/// The scenes' loads are a thousandth of the stated ones.
const LOAD_SCALE: f64 = 1e-3;

/// Cells along the bar and across it, and the deflection they give \[mm\].
type Deflection = ([u32; 3], f64);

pub fn cantilever(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let meshes = [([10, 2, 2], 0.522496), ([20, 4, 4], 0.806378), ([40, 8, 8], 0.951094)];
    deflections(solver, &CANTILEVER, &meshes, 1.0175)
}

pub fn own_weight(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    deflections(solver, &OWN_WEIGHT, &[([10, 2, 2], 19.499608), ([20, 4, 4], 29.860907)], 37.63)
}

pub fn short_bar(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    deflections(solver, &SHORT_BAR, &[([8, 4, 4], 0.143467), ([16, 8, 8], 0.170330)], 0.185)
}

fn deflections(
    solver: Solver,
    scene: &SceneText,
    meshes: &[Deflection],
    continuum: f64,
) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    let mut finest = (0.0, String::new());
    for (cells, expected) in meshes {
        let mut run = solver.open(scene, &[format!("soft.bar.shape.cells={cells:?}")])?;
        let mm = -1e3 * run.to(40.0)?.value("end.y")? / LOAD_SCALE;
        let what = format!("end deflection, Kuhn {cells:?} [mm]");
        figures.push(Figure::new(what, run.setup(), *expected, mm, Check::Relative(1e-5)));
        finest = (mm, run.setup());
    }
    let what = "the same in the continuum (linear elements lock) [mm]";
    figures.push(Figure::new(what, finest.1, continuum, finest.0, Check::Report));
    Ok(figures)
}

/// Torsion against Saint-Venant; the held end cannot warp, which makes the continuum 0.5 % stiffer.
pub fn torsion(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&TORSION, &[])?;
    let millidegrees = 1e3 * run.to(40.0)?.value("end.rx")?.to_degrees();
    let expected = 6.6231;
    let what = "twist of the end [mdeg]";
    Ok(vec![Figure::new(what, run.setup(), expected, millidegrees, Check::Relative(0.08))])
}
