//! Warnings about a scene before it runs.

use super::Session;
use crate::build::is_papers_by_solver;
use crate::format::Hand;
use thenar_core::model::SolverKind;

/// The two-step scheme gains energy with springs in bone at steps longer than this \[s\].
const TWO_STEP_IN_BONE_MAX: f64 = 1e-3;

impl Session {
    /// Known problems of the scene as it is set, a sentence each; empty when there are none.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.world.stability_warnings();
        let two_step = self.world.desc().solver.kind == SolverKind::TwoStep;
        if two_step && self.world.time_step() > TWO_STEP_IN_BONE_MAX {
            let on_bone = self.hands().iter().filter(|hand| hand.hangs_on_bone());
            warnings.extend(on_bone.map(|hand| {
                format!(
                    "the two-step solver gains energy at steps longer than {} ms with springs in bone, as hand `{}` \
                     has them: choose preset = \"paper\" for the hand, or solver.kind = \"monolithic\"",
                    1e3 * TWO_STEP_IN_BONE_MAX,
                    hand.name,
                )
            }));
        }
        warnings.extend(self.unit_questions());
        warnings.extend(self.grip_warnings());
        warnings
    }

    /// Remarks on what the scene means beyond what it says, a sentence each: hands that are not the
    /// usual ones because of the solver.
    pub fn notes(&self) -> Vec<String> {
        let note = |hand: &Hand| {
            format!(
                "hand `{}` is the paper's: springs in bone need the monolithic solver, and the scene names no preset",
                hand.name.value
            )
        };
        let hands = self.scene.hand.iter();
        hands.filter(|hand| is_papers_by_solver(&self.scene, hand)).map(note).collect()
    }
}
