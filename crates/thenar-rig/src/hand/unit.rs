//! Units of files that do not say theirs: a hand's length tells metres from millimetres.

use super::build::LENGTHS;
use crate::RigError;

/// Lengths of people's hands, wrist to middle fingertip, from infants to the largest \[m\]. A unit is believed where it
/// alone gives such a length.
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

/// Errs unless a hand may be so long; says in what unit it would be one of people's.
pub(super) fn check_length(length: f64) -> Result<(), RigError> {
    let [low, high] = LENGTHS;
    if (low..=high).contains(&length) {
        return Ok(());
    }
    let asked = match of_length(length) {
        Some((unit, metres)) => format!(
            ": are these {unit}? Then the scale is {metres} (`--scale {metres}`), and the hand {:.4} m long",
            length * metres
        ),
        None => ": say its length (`--length`, in scenes `length`)".into(),
    };
    Err(RigError::invalid(format!(
        "the hand length, wrist to middle fingertip, is {length:.4} m, expected {low} to {high} m{asked}"
    )))
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
        let message = |length: f64| check_length(length).unwrap_err().to_string();
        assert!(check_length(0.19).is_ok());
        assert!(message(190.0).contains("are these millimetres"), "{}", message(190.0));
        assert!(message(0.9).contains("--length"), "{}", message(0.9));
        assert!(message(f64::NAN).contains("--length"));
    }
}
