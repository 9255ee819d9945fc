//! The passive stiffness of a knuckle, flesh and all.

use super::{KNUCKLE, OWN, SMALL};
use crate::lab::validate::case::{Basis, CaseError, Figure};
use crate::lab::validate::run::Solver;

/// Held so long \[s\], with this torque \[N m\].
const HOLD: f64 = 10.0;
const TORQUE: f64 = 0.01;

/// Four healthy people had 0.033 to 0.047 N m/rad in the middle of their range.
pub fn stiffness(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for hand in [OWN, SMALL] {
        // Torques of joints grow with the cube of lengths, as muscles and lever arms do.
        let scale = if hand == SMALL { (0.17_f64 / 0.19).powi(3) } else { 1.0 };
        let mut angles = [0.0; 2];
        for (angle, sign) in angles.iter_mut().zip([-1.0, 1.0]) {
            let mut changes: Vec<String> = hand.changes.iter().map(|c| (*c).to_string()).collect();
            changes.push(format!("load.0.torque={}", sign * TORQUE * scale));
            // The flexion is the second axis of the knuckle.
            *angle = solver.open(&KNUCKLE, &changes)?.to(HOLD)?.value("knuckle.angle1")?;
        }
        let stiffness = 2.0 * TORQUE * scale / (angles[1] - angles[0]);
        let what = "stiffness of the index knuckle, for 190 mm [N m/rad]";
        let setup = format!("{}, h = 5 ms", hand.name);
        figures.push(
            Figure::within(what, setup, [0.02, 0.06], stiffness / scale).rests_on(Basis::People).or_cannot(
                "its springs make up what flesh of 50 kPa leaves, and this flesh keeps 8 kPa after ten seconds",
            ),
        );
    }
    Ok(figures)
}
