//! Units of files that do not say theirs: a hand's length tells metres from millimetres.

use super::build::LENGTHS;
use crate::RigError;

/// Lengths of people's hands, wrist to middle fingertip, from infants to the largest \[m\]. A unit
/// is believed where it alone gives such a length.
const PEOPLE: [f64; 2] = [0.12, 0.26];

/// Units that rigs come in, and metres in each.
const UNITS: [(&str, f64); 4] =
    [("millimetres", 1e-3), ("centimetres", 1e-2), ("decimetres", 0.1), ("inches", 0.0254)];

/// The unit in which a hand is as long as people's, and metres in it; none if several or none are.
pub(super) fn of_length(length: f64) -> Option<(&'static str, f64)> {
    let fits = |(_, metres): &&(&str, f64)| (PEOPLE[0]..=PEOPLE[1]).contains(&(length * metres));
    let mut fitting = UNITS.iter().filter(fits);
    let first = fitting.next()?;
    fitting.next().is_none().then_some(*first)
}

/// Errs unless a hand may be so long \[m\], read at this scale; says in what unit it would be one
/// of people's, and how to say so.
pub(super) fn check_length(length: f64, scale: f64) -> Result<(), RigError> {
    let [low, high] = LENGTHS;
    if (low..=high).contains(&length) {
        return Ok(());
    }
    let unscaled = length / scale;
    let help = match of_length(unscaled) {
        Some((unit, metres)) => {
            let own = format!("{:.4}", unscaled * metres);
            let said = said(&format!("--scale {metres}"), &format!("length = {own}"));
            format!("are these {unit}? Then it is {own} m long: {said}")
        }
        None => format!("say how long it is: {}", said("--length", "length")),
    };
    Err(RigError::invalid(format!(
        "the hand length, wrist to middle fingertip, is {length:.4} m, expected {low} to {high} m; {help}"
    )))
}

/// Words for what users write: for the program that builds models, and in scenes, whose hands have
/// a length and no scale.
fn said(option: &str, key: &str) -> String {
    format!("`{option}` for `thenar build`, `{key}` in a scene's [[hand]]")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_hand_in_every_unit_is_told() {
        for (unit, metres) in UNITS {
            for length in [0.15, 0.19, 0.2] {
                assert_eq!(
                    of_length(length / metres),
                    Some((unit, metres)),
                    "{length} m in {unit}"
                );
            }
        }
        assert_eq!(of_length(0.9), None, "a statue's hand");
        assert_eq!(of_length(0.0), None);
        assert_eq!(of_length(f64::NAN), None);
    }

    #[test]
    fn a_strange_length_asks_about_the_unit() {
        let message =
            |length: f64, scale: f64| check_length(length, scale).unwrap_err().to_string();
        assert!(check_length(0.19, 1.0).is_ok() && check_length(0.19, 0.001).is_ok());
        assert!(message(190.0, 1.0).contains("are these millimetres"), "{}", message(190.0, 1.0));
        assert!(message(0.9, 1.0).contains("`--length`"), "{}", message(0.9, 1.0));
        assert!(message(f64::NAN, 1.0).contains("`--length`"));
    }

    /// Hands have a scale on the command line, and a length in scenes.
    #[test]
    fn users_of_the_program_and_of_scenes_are_told_what_each_writes() {
        let message =
            |length: f64, scale: f64| check_length(length, scale).unwrap_err().to_string();
        let told = message(190.0, 1.0);
        assert!(told.contains("`--scale 0.001` for `thenar build`"), "{told}");
        assert!(told.contains("`length = 0.1900` in a scene's [[hand]]"), "{told}");
        let told = message(0.9, 1.0);
        assert!(told.contains("`length` in a scene's [[hand]]"), "{told}");
        // A hand in millimetres that was taken for decimetres.
        let told = message(19.0, 0.1);
        assert!(told.contains("millimetres") && told.contains("--scale 0.001"), "{told}");
    }
}
