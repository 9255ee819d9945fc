//! Choice of a hand's preset where a scene does not name one.

use crate::format::{CouplingWord, Hand, PresetWord, Scene, SolverWord};

/// The hand that a scene means unless something in it is about the paper's.
pub const USUAL: PresetWord = PresetWord::Touch;

/// The preset of a hand: what the scene says; else the paper's where something in the scene is
/// about that hand; else the usual one.
pub fn preset(scene: &Scene, hand: &Hand) -> PresetWord {
    let papers = is_papers(hand) || !solves_springs_in_bone(scene);
    hand.preset.unwrap_or(if papers { PresetWord::Paper } else { USUAL })
}

/// True when it is the solver alone that makes a hand the paper's.
pub fn is_papers_by_solver(scene: &Scene, hand: &Hand) -> bool {
    let built_here = hand.model.as_ref().is_none_or(|model| !model.value.ends_with(".thenar"));
    let silent = built_here && hand.preset.is_none() && !is_papers(hand);
    silent && USUAL != PresetWord::Paper && !solves_springs_in_bone(scene)
}

/// True when a hand's table says what is about the paper's hand: how many tetrahedra of one size,
/// springs on all flesh, or how stiff springs are without what they hold.
fn is_papers(hand: &Hand) -> bool {
    let coupling = hand.coupling.as_ref().map(|word| word.value);
    let stiffness_alone = hand.coupling_stiffness.is_some() && coupling.is_none();
    hand.tets.is_some() || coupling == Some(CouplingWord::Uniform) || stiffness_alone
}

/// False with the two-step scheme, which gains energy with them.
fn solves_springs_in_bone(scene: &Scene) -> bool {
    let kind = scene.solver.as_ref().and_then(|solver| solver.kind);
    kind.is_none_or(|kind| kind == SolverWord::Monolithic)
}
