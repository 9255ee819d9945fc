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
}
