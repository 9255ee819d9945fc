//! Rigid bodies, joints, integrator.

use super::case::{Case, CaseError, Check, Figure, SceneText, scene};
use super::run::{Run, step_words};

/// The cases.
pub const CASES: &[Case] =
    &[Case { id: "A1", title: "free fall", full: false, measure: free_fall }];

const FREE_FALL: SceneText = scene!("a01-free-fall");

/// An exact step of backward Euler falls by `g h² n (n + 1) / 2` in n steps.
fn free_fall() -> Result<Vec<Figure>, CaseError> {
    let fallen = |h: f64| Run::with_step(&FREE_FALL, h)?.to(0.5)?.value("ball.y");
    let mut figures = Vec::new();
    for h in [1e-3, 1.0 / 60.0] {
        let n = (0.5_f64 / h).round();
        let expected = -9.81 * h * h * n * (n + 1.0) / 2.0;
        let what = "y(0.5 s) [m], recurrence";
        figures.push(Figure::new(what, step_words(h), expected, fallen(h)?, Check::Absolute(1e-9)));
    }
    let off = |h: f64| Ok::<f64, CaseError>(fallen(h)? + 9.81 * 0.125);
    let what = "error against t² g/2: ratio when h halves";
    let ratio = off(1e-3)? / off(5e-4)?;
    figures.push(Figure::new(what, "h = 1, 0.5 ms", 2.0, ratio, Check::Relative(1e-6)));
    Ok(figures)
}
