//! Bounds of the cost of a scene that runs live.

use crate::session::read;

/// Multiply-adds of a processor core: the law of contact does 3e9 to 4e9 a second with 60 contacts
/// on one of 2020.
const MULTIPLY_ADDS_PER_SECOND: f64 = 4e9;

/// The overrides with which a scene runs live: these, and, unless the scene or they say what
/// contact may cost, a bound of a step's time on one core. A scene that cannot be read stays as it
/// is: opening it says why.
pub fn live_overrides(text: &str, overrides: &[String]) -> Vec<String> {
    let bound = read(text, overrides).ok().and_then(|scene| {
        let is_bound = scene.solver.is_some_and(|solver| solver.contact_work_max.is_some());
        let most = MULTIPLY_ADDS_PER_SECOND * scene.time_step;
        (!is_bound).then(|| format!("solver.contact_work_max={most:e}"))
    });
    bound.into_iter().chain(overrides.iter().cloned()).collect()
}
