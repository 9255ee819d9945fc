//! Values of keys as cells of a table.

/// Kind of a column of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    Truth,
    Count,
    Number,
    Word,
}

impl ColumnKind {
    /// The narrowest kind that all values are of.
    pub fn of<'a>(values: impl Iterator<Item = &'a str> + Clone) -> Self {
        let all = |is: fn(&str) -> bool| values.clone().all(is);
        if all(|v| truth(v).is_some()) {
            Self::Truth
        } else if all(|v| count(v).is_some()) {
            Self::Count
        } else if all(|v| number(v).is_some()) {
            Self::Number
        } else {
            Self::Word
        }
    }

    /// Name in the manifest.
    pub fn name(self) -> &'static str {
        match self {
            Self::Truth => "boolean",
            Self::Count => "integer",
            Self::Number => "number",
            Self::Word => "text",
        }
    }
}

/// A truth value.
pub fn truth(text: &str) -> Option<bool> {
    text.parse().ok()
}

/// A whole number.
pub fn count(text: &str) -> Option<i64> {
    toml_value(text)?.as_integer()
}

/// A number, whole or not, the one nearest to its digits.
pub fn number(text: &str) -> Option<f64> {
    match toml_value(text)? {
        toml::Value::Integer(i) => Some(i as f64),
        toml::Value::Float(x) => Some(x),
        _ => None,
    }
}

/// A word without its quotes; anything else as it is written.
pub fn word(text: &str) -> String {
    match toml_value(text) {
        Some(toml::Value::String(word)) => word,
        _ => text.into(),
    }
}

fn toml_value(text: &str) -> Option<toml::Value> {
    let mut table = format!("v = {text}").parse::<toml::Table>().ok()?;
    table.remove("v").filter(|_| table.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_narrow_as_their_values() {
        let kind = |values: &[&'static str]| ColumnKind::of(values.iter().copied());
        assert_eq!(kind(&["true", "false"]), ColumnKind::Truth);
        assert_eq!(kind(&["1", "-2", "1_000"]), ColumnKind::Count);
        assert_eq!(kind(&["1", "2.5", "1e-3"]), ColumnKind::Number);
        assert_eq!(kind(&["1", "right"]), ColumnKind::Word);
        assert_eq!(kind(&["[1, 2]", "\"a\""]), ColumnKind::Word);
        assert_eq!(word("\"a\\tb\""), "a\tb");
        assert_eq!(word("[1, 2]"), "[1, 2]");
        assert_eq!((count("1_000"), number("1")), (Some(1000), Some(1.0)));
    }
}
