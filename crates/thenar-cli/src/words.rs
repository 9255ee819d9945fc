//! Words of messages.

use std::fmt::Display;

/// A count of things, of which most names take an s: `1 case`, `2 cases`.
pub fn counted<N: Display + PartialEq + From<u8>>(count: N, thing: &str) -> String {
    let ending = if count == N::from(1) { "" } else { "s" };
    format!("{count} {thing}{ending}")
}

/// An energy \[J\] without the sign of what rounds to zero.
pub fn joules(energy: f64) -> String {
    let text = format!("{energy:.6} J");
    match text.strip_prefix('-') {
        Some(rest) if rest == "0.000000 J" => rest.into(),
        _ => text,
    }
}

/// A number to two digits, without an exponent: `0.04`, `2`, `130`.
pub fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let places = (1.0 - x.abs().log10().floor()).clamp(0.0, 12.0) as usize;
    without_zeros(format!("{x:.places$}"))
}

/// A number's text without zeros at the end of its decimals.
pub fn without_zeros(text: String) -> String {
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').into(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thing_is_no_more() {
        assert_eq!([0_u64, 1, 2].map(|n| counted(n, "case")), ["0 cases", "1 case", "2 cases"]);
    }

    #[test]
    fn no_energy_has_no_sign() {
        let words = [-0.0, -4e-7, -6e-7, 0.25].map(joules);
        assert_eq!(words, ["0.000000 J", "0.000000 J", "-0.000001 J", "0.250000 J"]);
    }

    #[test]
    fn short_numbers_have_two_digits_and_no_exponent() {
        let words = [0.0, 0.01, 1.234e-5, 0.995, 2.0, 16.66, 130.4, -0.25].map(short);
        assert_eq!(words, ["0", "0.01", "0.000012", "0.99", "2", "17", "130", "-0.25"]);
    }
}
