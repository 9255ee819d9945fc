//! Dimensions of a hand: lengths, mass, ranges of motion.

mod body;
mod motion;

use super::case::{Case, CaseError, case};
use super::fingers::{HandVariant, KNUCKLE, OWN, SMALL};
use super::run::{Run, Solver};

/// The cases.
pub const CASES: &[Case] = &[
    case("G1", "lengths of bones", body::lengths),
    case("G2", "mass, its centre and its spread", body::mass),
    case("G3", "ranges of motion", motion::ranges),
    case("G4", "active flexion", motion::active),
];

/// The hands that are measured.
const HANDS: [HandVariant; 2] = [OWN, SMALL];

/// A hand at rest.
fn still(solver: Solver, hand: HandVariant) -> Result<Run, CaseError> {
    let changes: Vec<String> = hand.changes.iter().map(|c| (*c).to_string()).collect();
    solver.open(&KNUCKLE, &changes)
}
