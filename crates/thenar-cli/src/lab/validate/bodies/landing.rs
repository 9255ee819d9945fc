//! A rod that lands on an edge.

use crate::lab::validate::case::{CaseError, Check, Figure, SceneText, scene};
use crate::lab::validate::run::{Solver, step_words};

const ROD: SceneText = scene!("a11-rod-landing");

/// A plastic impact at one end of a uniform rod: impulse `m v / 4`, centre speed `¾ v`,
/// `ω = 1.5 v / L`.
pub fn rod(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let (h, length, mass) = (1e-4, 0.2, 0.1);
    let mut run = solver.with_step(&ROD, h)?;
    // Its underside reaches the edge at 8.55 ms; half a millisecond later the rod has turned by
    // 4 mrad.
    let [vy, wz] = run.to(9e-3)?.values(["rod.vy", "rod.wz"])?;
    let row = |what: &str, expected, got| {
        Figure::new(what, step_words(h), expected, got, Check::Relative(0.01))
    };
    Ok(vec![
        row("speed of the centre [m/s]", -0.75, vy),
        row("angular velocity [rad/s]", 1.5 / length, wz),
        row("impulse of the edge [N s]", 0.25 * mass, mass * (vy + 1.0)),
    ])
}
