//! Elastic solids: linear tetrahedra against theory and against their own exact solutions.

mod bars;
mod forces;
mod large;
mod modes;
mod press;

use super::case::{Case, SceneText, case, scene};

const PATCH: SceneText = scene!("b01-patch");
const RIGID_MOTION: SceneText = scene!("b02-rigid-motion");
const CANTILEVER: SceneText = scene!("b03-cantilever");
const OWN_WEIGHT: SceneText = scene!("b04-own-weight");
const ELASTICA_TIP: SceneText = scene!("b05-elastica-tip");
const ELASTICA_WEIGHT: SceneText = scene!("b05-elastica-weight");
const UNIAXIAL: SceneText = scene!("b06-uniaxial");
const MODES: SceneText = scene!("b08-modes");
const HYDROSTATIC: SceneText = scene!("b09-hydrostatic");
const SHORT_BAR: SceneText = scene!("b10-short-bar");
const TORSION: SceneText = scene!("b11-torsion");
/// A fingertip pressed on a plate; also carries the balance of forces of C9.
pub const PAD_PRESS: SceneText = scene!("b12-pad-press");

/// The cases.
pub const CASES: &[Case] = &[
    case("B1", "patch test", forces::patch),
    case("B2", "rigid motions and balance of forces", forces::rigid_motions),
    case("B3", "cantilever under an end load", bars::cantilever),
    case("B4", "cantilever under its own weight", bars::own_weight),
    case("B5", "elastica under a tip load", large::elastica_tip),
    case("B5W", "elastica under its own weight", large::elastica_weight).only_full(),
    case("B6", "uniaxial stress, co-rotational", large::corotational),
    case("B7", "uniaxial stress, neo-Hookean", large::neo_hookean),
    case("B8", "modes of a cantilever", modes::modes).only_full(),
    case("B9", "hydrostatic pressure", large::hydrostatic),
    case("B10", "short cantilever", bars::short_bar),
    case("B11", "torsion of a square bar", bars::torsion),
    case("B12", "a fingertip's indentation at any time step", press::step_independence),
];
