//! Tissue: layers, laws and memory against closed forms; taps and plates against people.

mod laws;
mod memory;

use super::case::{Case, SceneText, case, scene};
use super::fingers;

const LAYERS: SceneText = scene!("t01-layers");
const UNIAXIAL: SceneText = scene!("b06-uniaxial");
const RELAXATION: SceneText = scene!("t05-relaxation");
const HALF_SINE: SceneText = scene!("t05-half-sine");

/// The cases.
pub const CASES: &[Case] = &[
    case("T1", "three bonded layers, pressed and sheared", laws::layers),
    case("T2", "Ogden's law, uniaxial", laws::ogden),
    case("T5", "memory: relaxation and loss", memory::prony),
    case("T6", "energy lost in taps", fingers::taps),
    case("T7", "a plate on a pad, one set of constants", fingers::plate),
    case("T8", "skin on aluminium and rubber, by load", fingers::tables),
];
