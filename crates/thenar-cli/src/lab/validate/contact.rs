//! Contact and friction.

mod balance;
mod incline;
mod indentation;
mod rest;
mod slip;
mod tangential;

use super::case::{Case, CaseError, SceneText, case, scene};

const HERTZ: SceneText = scene!("c01-hertz");
const LAYER: SceneText = scene!("c02-layer");
const FINGER_PAD: SceneText = scene!("c03-finger-pad");
const INCLINE: SceneText = scene!("c04-incline");
const INCLINE_SOFT: SceneText = scene!("c04-incline-soft");
const ISOTROPY: SceneText = scene!("c05-isotropy");
const STACK: SceneText = scene!("c06-stack");
const SLIDING: SceneText = scene!("c07-sliding");
const PINCH: SceneText = scene!("c08-pinch");
const COLLISION: SceneText = scene!("c09-collision");
const TIPPING: SceneText = scene!("c10-tipping");
const MINDLIN: SceneText = scene!("c11-mindlin");
const TORSION: SceneText = scene!("c12-torsion");

/// Gravity of the scenes \[m/s²\].
const G: f64 = 9.81;

/// The cases.
pub const CASES: &[Case] = &[
    case("C1", "Hertz: sphere on a half space, 0.5 mm", indentation::hertz),
    case("C1F", "Hertz at three depths, and the exponent", indentation::hertz_depths).only_full(),
    case("C2", "sphere on a layer bonded to bone", indentation::layer).only_full(),
    case("C3", "ball of flesh around a bone on a plate, 0.4 mm", indentation::finger_pad),
    case("C3F", "the same at 0.2 and 0.8 mm", indentation::finger_pad_depths).only_full(),
    case("C4", "block on an incline", incline::incline),
    case("C5", "friction in 16 directions", slip::isotropy),
    case("C6", "stack of five boxes", rest::stack),
    case("C7", "sliding to rest", slip::sliding),
    case("C8", "pinch hold", rest::pinch),
    case("C8F", "the same of a heavier object", rest::pinch_heavy).only_full(),
    case("C9", "action and reaction", balance::balance),
    case("C10", "tipping before slipping", incline::tipping),
    case("C11", "Cattaneo and Mindlin: a pressed ball dragged aside", tangential::mindlin)
        .only_full(),
    case("C12", "a pressed ball turned about the normal", tangential::torsion).only_full(),
];

/// The value between `low` (where `holds` is true) and `high` (where it is false) at which
/// `holds` changes, to within `width`.
fn threshold(
    mut low: f64,
    mut high: f64,
    width: f64,
    mut holds: impl FnMut(f64) -> Result<bool, CaseError>,
) -> Result<f64, CaseError> {
    for (end, expected) in [(low, true), (high, false)] {
        if holds(end)? != expected {
            let word = if expected { "fails" } else { "holds" };
            return Err(CaseError::Missing(format!("no threshold: {word} already at {end}")));
        }
    }
    while high - low > width {
        let middle = 0.5 * (low + high);
        if holds(middle)? { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_threshold_is_found_or_missed_aloud() {
        let found = threshold(0.0, 2.0, 1e-6, |x| Ok(x * x <= 2.0)).unwrap();
        assert!((found - 2.0_f64.sqrt()).abs() < 1e-6);
        assert!(threshold(0.0, 1.0, 1e-6, |_| Ok(true)).is_err());
        assert!(threshold(0.0, 1.0, 1e-6, |_| Ok(false)).is_err());
    }
}
