//! A block with the skin's friction, drawn over a plane.

use super::DRAG;
use crate::lab::validate::case::{Basis, CaseError, Check, Figure};
use crate::lab::validate::run::Solver;

/// Loads \[N\] and coefficients of the two tables: a power law that falls by 46 % from 1 to 20 N.
const LOADS: [f64; 6] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0];
const ALUMINIUM: [f64; 6] = [0.960, 0.832, 0.722, 0.598, 0.518, 0.449];
const RUBBER: [f64; 6] = [1.440, 1.248, 1.083, 0.897, 0.777, 0.674];

/// Friction over load once the block slides, and mesh and step.
fn drawn(solver: Solver, name: &str, load: f64) -> Result<(f64, String), CaseError> {
    let changes = [
        format!("pair.0.friction={name}"),
        format!("rigid.block.mass={}", load / 10.0),
        format!("load.0.force=[{}, 0, 0]", 2.0 * load),
    ];
    let mut run = solver.open(&DRAG, &changes)?;
    let [shear, normal] = run.to(0.1)?.values(["contact.shear", "contact.normal_sum"])?;
    Ok((shear / normal, run.setup()))
}

/// Seo et al. 2009: twelve middle fingertips at 1, 10 and 20 N.
pub fn means(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for (name, mean) in [("skin-on-aluminium", 0.6), ("skin-on-rubber", 0.9)] {
        let mut sum = 0.0;
        let mut ends = [0.0; 3];
        let mut setup = String::new();
        for (end, load) in ends.iter_mut().zip([1.0, 10.0, 20.0]) {
            (*end, setup) = drawn(solver, name, load)?;
            sum += *end / 3.0;
        }
        let row = |what: &str, want, got| {
            Figure::new(format!("{name}: {what}"), &setup, want, got, Check::Relative(0.01))
                .rests_on(Basis::People)
        };
        figures.push(row("mean", mean, sum));
        figures.push(row("20 N over 1 N", 0.54, ends[2] / ends[0]));
    }
    Ok(figures)
}

/// T8: every row of the tables.
pub fn tables(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for (name, rows) in [("skin-on-aluminium", ALUMINIUM), ("skin-on-rubber", RUBBER)] {
        for (load, want) in LOADS.into_iter().zip(rows) {
            let (mu, setup) = drawn(solver, name, load)?;
            let what = format!("{name}, {load} N");
            figures.push(Figure::new(what, setup, want, mu, Check::Relative(0.01)));
        }
    }
    Ok(figures)
}
