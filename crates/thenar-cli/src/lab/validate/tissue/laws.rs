//! Elastic laws of tissue.

use super::{LAYERS, UNIAXIAL};
use crate::lab::validate::case::{CaseError, Check, Figure};
use crate::lab::validate::run::Solver;

/// T1: `Σ t σ/M` pressed, `Σ t τ/G` sheared. Loads are a thousandth of 1 kPa.
pub fn layers(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let check = Check::Relative(1e-6);
    let mut pressed = solver.open(&LAYERS, &[])?;
    let depth = -1e9 * pressed.to(40.0)?.value("top.y")?;
    let aside = ["load.0.traction=[1, 0, 0]", "soft.slab.fixed.1.axes=yz"].map(String::from);
    let mut sheared = solver.open(&LAYERS, &aside)?;
    let way = 1e6 * sheared.to(40.0)?.value("top.x")?;
    let setup = pressed.setup();
    Ok(vec![
        Figure::new("pressed, at 1 kPa [um]", &setup, 15.235294, depth, check),
        Figure::new("sheared, at 1 kPa [mm]", &setup, 0.396118, way, Check::Relative(2e-6)),
    ])
}

/// T2: nominal stress `2μ/α (λ^(α-1) - λ^(-α/2-1))` \[kPa\] of an incompressible cube: μ \[kPa\],
/// α, stretch, stress.
const OGDEN: [(f64, f64, f64, f64); 8] = [
    (10.0, 8.0, 0.5, -79.98047),
    (10.0, 8.0, 0.7, -14.66887),
    (10.0, 8.0, 0.8, -7.10511),
    (10.0, 8.0, 0.9, -3.03803),
    (10.0, 8.0, 1.1, 3.31949),
    (10.0, 8.0, 1.2, 7.95326),
    (12.9, 6.5, 0.7, -17.51525),
    (12.9, 6.5, 0.9, -3.98769),
];

/// The stress of the table is put on; the stretch that it makes has, by the closed form, this
/// stress.
pub fn ogden(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for (poisson, tolerance) in [(0.4999, 1e-3), (0.49, 0.03)] {
        for (mu, alpha, stretch, stress) in OGDEN {
            let changes = [
                format!(
                    "soft.cube.material={{law=\"ogden\",alpha={alpha:?},mu={:?},poisson={poisson}}}",
                    1e3 * mu
                ),
                format!("load.0.traction=[{:?}, 0, 0]", 1e3 * stress),
            ];
            let mut run = solver.open(&UNIAXIAL, &changes)?;
            let found = run.to(60.0)?.value("corner.x")? / 0.02;
            let closed =
                2.0 * mu / alpha * (found.powf(alpha - 1.0) - found.powf(-0.5 * alpha - 1.0));
            let what = format!("mu {mu}, alpha {alpha}, stretch {stretch}: stress [kPa]");
            let setup = format!("nu = {poisson}, {}", run.mesh());
            let row = Figure::new(what, setup, stress, closed, Check::Relative(tolerance));
            figures.push(if poisson < 0.499 && stretch < 0.6 {
                row.or_cannot("flesh that gives way in volume by 2 % bears more at half its height than what does not: 4 %")
            } else {
                row
            });
        }
    }
    Ok(figures)
}
