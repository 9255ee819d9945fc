//! Large rotations and large strains.

use super::{ELASTICA_TIP, ELASTICA_WEIGHT, HYDROSTATIC, UNIAXIAL};
use crate::lab::validate::case::{CaseError, Check, Figure};
use crate::lab::validate::run::Solver;

/// Length of the elastica \[m\].
const LENGTH: f64 = 0.2;

/// Tip load: the scene holds `P L² / (E I)` at 0.5, then at 1. The linear case, from a load a
/// thousand times smaller, shows what the mesh is worth; linear theory at 1 must be far off.
pub fn elastica_tip(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    let small = ["load.0.total=[0, -5.208333333333333e-7, 0]", "time_step=10"];
    let mut linear = solver.open(&ELASTICA_TIP, &small.map(String::from))?;
    let deflection = -1e3 * linear.to(40.0)?.value("tip.y")? / LENGTH;
    let setup = linear.setup();
    let what = "linear case: deflection/L at alpha = 0.001, x 1000";
    figures.push(Figure::new(what, &setup, 1.0 / 3.0, deflection, Check::Relative(0.02)));

    let mut run = solver.open(&ELASTICA_TIP, &[])?;
    let setup = run.setup();
    for (time, alpha, expected) in
        [(7.0, 0.5, [0.162144, 0.984081, 14.0107]), (14.0, 1.0, [0.301721, 0.943567, 26.4335])]
    {
        let [x, y, angle] = run.to(time)?.values(["tip.x", "tip.y", "angle.rz"])?;
        let got = [-y / LENGTH, 1.0 + x / LENGTH, -angle.to_degrees()];
        for (k, name) in ["deflection/L", "tip x/L", "tip angle [deg]"].into_iter().enumerate() {
            let what = format!("alpha = {alpha}: {name}");
            figures.push(Figure::new(what, &setup, expected[k], got[k], Check::Relative(0.03)));
        }
        if alpha == 1.0 {
            let what = "linear theory 1/3 is too high by (relative)";
            let off = (1.0 / 3.0) / got[0] - 1.0;
            figures.push(Figure::new(what, &setup, 0.05, off, Check::AtLeast));
        }
    }
    Ok(figures)
}

pub fn elastica_weight(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&ELASTICA_WEIGHT, &[])?;
    let [x, y] = run.to(12.0)?.values(["tip.x", "tip.y"])?;
    let setup = run.setup();
    let check = Check::Relative(0.03);
    Ok(vec![
        Figure::new("q L^3/EI = 2: deflection/L", &setup, 0.238507, -y / LENGTH, check),
        Figure::new("q L^3/EI = 2: tip x/L", &setup, 0.966893, 1.0 + x / LENGTH, check),
    ])
}

/// `P = E (λ - 1)`, lateral stretch `1 - ν (λ - 1)`.
pub fn corotational(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let cube = uniaxial(solver, "corotational", -10_000.0)?;
    let check = Check::Absolute(1e-8);
    Ok(vec![
        Figure::new("stretch at -10 kPa", &cube.setup, 0.8, cube.stretch, check),
        Figure::new("lateral stretch", &cube.setup, 1.09, cube.lateral, check),
    ])
}

/// Nominal stress \[Pa\] that the law needs for each stretch, and lateral stretch.
pub fn neo_hookean(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let cases = [
        (0.7, -21_696.9, Some(1.170853)),
        (0.9, -5_535.64, Some(1.048313)),
        (1.1, 4_585.17, None),
        (1.3, 11_968.16, None),
        (1.5, 17_930.72, Some(0.830679)),
    ];
    let mut figures = Vec::new();
    for (expected, stress, lateral) in cases {
        let cube = uniaxial(solver, "neo-hookean", stress)?;
        let what = format!("stretch at {:.6} kPa", 1e-3 * stress);
        let check = Check::Absolute(1e-6);
        figures.push(Figure::new(what, &cube.setup, expected, cube.stretch, check));
        if let Some(lateral) = lateral {
            let what = "lateral stretch";
            figures.push(Figure::new(what, &cube.setup, lateral, cube.lateral, check));
        }
    }
    Ok(figures)
}

/// A cube at rest under a nominal stress along x.
struct Cube {
    stretch: f64,
    lateral: f64,
    setup: String,
}

fn uniaxial(solver: Solver, law: &str, stress: f64) -> Result<Cube, CaseError> {
    let overrides =
        [format!("soft.cube.material.law={law}"), format!("load.0.traction=[{stress:?}, 0, 0]")];
    let mut run = solver.open(&UNIAXIAL, &overrides)?;
    let [x, y] = run.to(60.0)?.values(["corner.x", "corner.y"])?;
    Ok(Cube { stretch: x / 0.02, lateral: y / 0.02, setup: run.setup() })
}

/// Volume change of a free block under pressure.
pub fn hydrostatic(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&HYDROSTATIC, &[])?;
    let before = run.value("block.volume")?;
    let change = run.to(100.0)?.value("block.volume")? / before - 1.0;
    let expected = -3.0 * (1.0 - 2.0 * 0.45) * 500.0 / 50e3;
    Ok(vec![Figure::new(
        "dV/V at p = 0.01 E",
        run.setup(),
        expected,
        change,
        Check::Relative(0.01),
    )])
}
