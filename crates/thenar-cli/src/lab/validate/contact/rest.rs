//! Bodies that contact keeps at rest.

use super::{G, PINCH, STACK, threshold};
use crate::lab::validate::case::{CaseError, Check, Figure};
use crate::lab::validate::run::{Run, Solver};

/// Mass of each box of the stack \[kg\].
const BOX_MASS: f64 = 0.1;

pub fn stack(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&STACK, &[])?;
    let places = |run: &mut Run| -> Result<Vec<f64>, CaseError> {
        let names = (1..=5).flat_map(|k| ["x", "y", "z"].map(|axis| format!("box{k}.{axis}")));
        names.map(|name| run.value(&name)).collect()
    };
    let before = places(&mut run)?;
    run.to(10.0)?;
    let after = places(&mut run)?;
    let setup = run.setup();
    let mut figures = Vec::new();
    for k in 1..=5 {
        let expected = f64::from(k) * BOX_MASS * G;
        let got = run.value(&format!("under{k}.normal"))?;
        let what = format!("force under box {k} from the top [N]");
        figures.push(Figure::new(what, &setup, expected, got, Check::Relative(0.01)));
    }
    let drift = before.iter().zip(&after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    figures.push(Figure::new("drift in 10 s [mm]", &setup, 0.1, 1e3 * drift, Check::AtMost));
    // As much as lifts the stack by a nanometre.
    let energy = run.value("energy.kinetic")?;
    figures.push(Figure::new("kinetic energy at 10 s [J]", setup, 5e-9, energy, Check::AtMost));
    Ok(figures)
}

/// The smallest normal force of each pad that holds the object, by bisection of the pads' travel.
pub fn pinch(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    Ok(vec![hold(solver, 0.2, 0.6)?])
}

/// The smallest normal force that holds a heavier object, which slides more easily.
pub fn pinch_heavy(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    Ok(vec![hold(solver, 0.3, 0.5)?])
}

fn hold(solver: Solver, mass: f64, friction: f64) -> Result<Figure, CaseError> {
    let mut setup = String::new();
    let mut least = f64::INFINITY;
    threshold(-2.0, -0.3, 0.007, |looser| {
        let travel = -1e-3 * looser;
        let mut run = solver.open(&PINCH, &overrides(mass, friction, travel))?;
        let held = run.to(1.5)?.value("object.y")?;
        let later = run.to(1.8)?.value("object.y")?;
        let holds = held - later < 1e-4 && later > -0.01; // pads give way by millimetres
        let [left, right] = run.values(["left.normal", "right.normal"])?;
        let force = 0.5 * (left + right);
        if holds {
            least = least.min(force);
        }
        setup = run.setup();
        Ok(holds)
    })?;
    let expected = mass * G / (2.0 * friction);
    let what = format!("least N that holds {mass} kg at mu {friction} [N]");
    Ok(Figure::new(what, setup, expected, least, Check::Relative(0.03)))
}

fn overrides(mass: f64, friction: f64, travel: f64) -> [String; 5] {
    let at = |side: &str, x: f64| format!("rigid.{side}.keyframes.1.position=[{x}, 0, 0]");
    [
        format!("rigid.object.mass={mass}"),
        format!("pair.0.friction={friction}"),
        format!("pair.1.friction={friction}"),
        at("left", -0.025 + travel),
        at("right", 0.025 - travel),
    ]
}
