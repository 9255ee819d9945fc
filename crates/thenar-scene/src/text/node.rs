//! A TOML document as a tree in which every value knows where it was written.

use super::{Fault, SourcePlace, plain};
use thenar_input::quoted;
use toml::de::{DeTable, DeValue};

/// A value and its place.
#[derive(Clone, Debug)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// Place where it was written.
    pub place: SourcePlace,
}

/// A TOML value. Tables keep the order of the text.
#[derive(Clone, Debug)]
pub enum Value {
    /// A string.
    Text(String),
    /// An integer.
    Integer(i64),
    /// A float, perhaps not finite.
    Float(f64),
    /// A boolean.
    Bool(bool),
    /// A date or time; no key wants one.
    Date(String),
    /// An array.
    Array(Vec<Node>),
    /// A table.
    Table(Vec<Entry>),
}

/// One key of a table.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Name of the key.
    pub key: String,
    /// Place where the name was written.
    pub place: SourcePlace,
    /// Value of the key.
    pub node: Node,
}

impl Node {
    /// Parses a document.
    ///
    /// # Errors
    /// The text is not TOML.
    pub fn parse(text: &str) -> Result<Node, Fault> {
        let parsed = DeTable::parse(text).map_err(|e| syntax(&e))?;
        from_table(parsed.get_ref(), &SourcePlace::Text)
            .map(|value| Node { value, place: SourcePlace::Text(0..0) })
    }

    /// Parses `key = value` where every place is override `index`.
    ///
    /// # Errors
    /// The text is not TOML.
    pub fn parse_override(text: &str, index: usize) -> Result<Node, Fault> {
        let place = SourcePlace::Override(index);
        let parsed =
            DeTable::parse(text).map_err(|e| Fault::new(&place, "", e.message().to_string()))?;
        from_table(parsed.get_ref(), &|_| SourcePlace::Override(index))
            .map(|value| Node { value, place })
    }

    /// The value in words, for messages: `the string "x"`, `-1`, `an array of 2`.
    pub fn describe(&self) -> String {
        match &self.value {
            Value::Text(s) if s.chars().count() <= 40 => format!("the string \"{s}\""),
            Value::Text(_) => "a long string".into(),
            Value::Integer(i) => format!("{i}"),
            Value::Float(x) => plain(*x),
            Value::Bool(b) => format!("{b}"),
            Value::Date(d) => format!("the date {d}"),
            Value::Array(a) => format!("an array of {}", a.len()),
            Value::Table(_) => "a table".into(),
        }
    }

    /// The value of a key, when this is a table that has it.
    pub fn get(&self, key: &str) -> Option<&Node> {
        match &self.value {
            Value::Table(entries) => entries.iter().find(|e| e.key == key).map(|e| &e.node),
            _ => None,
        }
    }
}

type MakePlace<'a> = &'a dyn Fn(std::ops::Range<usize>) -> SourcePlace;

fn syntax(error: &toml::de::Error) -> Fault {
    let at = error.span().unwrap_or(0..0);
    Fault::new(&SourcePlace::Text(at), "", format!("not valid TOML: {}", error.message()))
}

fn from_table(table: &DeTable<'_>, place: MakePlace<'_>) -> Result<Value, Fault> {
    let mut entries = Vec::with_capacity(table.len());
    for (key, value) in table {
        entries.push((
            key.span().start,
            Entry {
                key: key.get_ref().to_string(),
                place: place(key.span()),
                node: Node { value: from_value(value, place)?, place: place(value.span()) },
            },
        ));
    }
    entries.sort_by_key(|(start, _)| *start);
    Ok(Value::Table(entries.into_iter().map(|(_, e)| e).collect()))
}

fn from_value(value: &toml::Spanned<DeValue<'_>>, place: MakePlace<'_>) -> Result<Value, Fault> {
    let too_big = |text: &str| {
        Fault::new(&place(value.span()), "", format!("the number {} is too large", quoted(text)))
    };
    Ok(match value.get_ref() {
        DeValue::String(s) => Value::Text(s.to_string()),
        DeValue::Integer(i) => {
            let parsed = i64::from_str_radix(i.as_str(), i.radix());
            Value::Integer(parsed.map_err(|_| too_big(i.as_str()))?)
        }
        DeValue::Float(x) => Value::Float(x.as_str().parse().map_err(|_| too_big(x.as_str()))?),
        DeValue::Boolean(b) => Value::Bool(*b),
        DeValue::Datetime(d) => Value::Date(d.to_string()),
        DeValue::Array(a) => Value::Array(
            a.iter()
                .map(|v| Ok(Node { value: from_value(v, place)?, place: place(v.span()) }))
                .collect::<Result<_, Fault>>()?,
        ),
        DeValue::Table(t) => from_table(t, place)?,
    })
}
