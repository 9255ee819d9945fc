//! A key and its values, from `--vary`.

use crate::error::CliError;
use thenar_input::quoted;

/// A key and the values that it takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    pub key: String,
    /// Values as they were written: TOML, or bare words.
    pub values: Vec<String>,
}

impl Axis {
    /// From `key=a,b,c`. Commas in brackets, braces and quotes belong to their value.
    ///
    /// # Errors
    /// There is no `=`, no value, or a value is there twice.
    pub fn parse(text: &str) -> Result<Self, CliError> {
        let wrong = |what: String| Err(CliError::Input(format!("--vary {}: {what}", quoted(text))));
        let Some((key, values)) = text.split_once('=') else {
            return wrong("expected key=a,b,c, e.g. hand.hand.friction=0.4,0.8".into());
        };
        let values: Vec<String> = split(values).iter().map(|v| v.trim().to_string()).collect();
        if values.iter().any(String::is_empty) {
            let what = if values.len() == 1 { "there is no value" } else { "a value is empty" };
            return wrong(what.into());
        }
        for (i, value) in values.iter().enumerate() {
            if values[..i].contains(value) {
                return wrong(format!("the value {} is there twice", quoted(value)));
            }
        }
        Ok(Self { key: tidy(key), values })
    }
}

/// A dotted key without blanks.
pub fn tidy(key: &str) -> String {
    key.split('.').map(str::trim).collect::<Vec<_>>().join(".")
}

/// Splits at commas that are in no brackets, braces or quotes.
fn split(text: &str) -> Vec<&str> {
    let (mut parts, mut begin, mut depth) = (Vec::new(), 0, 0_i32);
    let mut quote = None;
    let mut escaped = false;
    for (at, c) in text.char_indices() {
        match (quote, c) {
            (Some('"'), '\\') if !escaped => {
                escaped = true;
                continue;
            }
            (Some(open), _) if c == open && !escaped => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth -= 1,
            (None, ',') if depth <= 0 => {
                parts.push(&text[begin..at]);
                begin = at + 1;
            }
            _ => {}
        }
        escaped = false;
    }
    parts.push(&text[begin..]);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_inside_of_values_are_theirs() {
        let axis = Axis::parse(r#"a . b = 1, [2, 3],{c = [4,5]},"x, \" y",'z,"' "#).unwrap();
        assert_eq!(axis.key, "a.b");
        let values = ["1", "[2, 3]", "{c = [4,5]}", r#""x, \" y""#, r#"'z,"'"#];
        assert_eq!(axis.values, values);
    }

    #[test]
    fn what_makes_no_axis_is_refused() {
        for (text, told) in [
            ("a", "expected key=a,b,c"),
            ("a=", "there is no value"),
            ("a= ", "there is no value"),
            ("a=1,,2", "a value is empty"),
            ("a=1,2,", "a value is empty"),
            ("a=1,2,1", "\"1\" is there twice"),
        ] {
            let error = Axis::parse(text).unwrap_err().to_string();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
