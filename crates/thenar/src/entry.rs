//! Tables of a scene file in the making.

use thenar_core::{Pose, Quat, Vec3};
use toml::{Table, Value};

/// The keys of one part of a scene that were set.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry(pub Table);

impl Entry {
    /// An entry without keys.
    pub fn new() -> Self {
        Self(Table::new())
    }

    /// A shape of this kind, its keys in the order given.
    pub fn of_kind(kind: &str, keys: impl IntoIterator<Item = (&'static str, Value)>) -> Self {
        let kind = ("kind".to_owned(), Value::from(kind));
        Self([kind].into_iter().chain(keys.into_iter().map(|(k, v)| (k.to_owned(), v))).collect())
    }

    /// Sets a key.
    pub fn put(&mut self, key: &str, value: impl Into<Value>) {
        self.0.insert(key.to_owned(), value.into());
    }

    /// Takes a key away.
    pub fn take(&mut self, key: &str) {
        self.0.remove(key);
    }

    /// Sets a key, dotted ones within tables, to a value as it stands in a scene file; what is no
    /// TOML value is text.
    pub fn put_text(&mut self, key: &str, text: &str) {
        put_text(&mut self.0, key, text);
    }

    /// Sets position and rotation \[m\].
    pub fn put_pose(&mut self, pose: &Pose) {
        self.put("position", vector(&pose.position));
        self.put("rotation", rotation(&pose.rotation));
    }
}

fn put_text(table: &mut Table, key: &str, text: &str) {
    match key.split_once('.') {
        None => {
            table.insert(key.to_owned(), value_of(text));
        }
        Some((first, rest)) => {
            let inner = table.entry(first).or_insert_with(|| Value::Table(Table::new()));
            if !inner.is_table() {
                *inner = Value::Table(Table::new());
            }
            if let Value::Table(inner) = inner {
                put_text(inner, rest, text);
            }
        }
    }
}

/// A value as it stands in a scene file; what is no TOML value is text.
pub(crate) fn value_of(text: &str) -> Value {
    let parsed = format!("value = {text}").parse::<Table>();
    let only = |mut table: Table| table.remove("value").filter(|_| table.is_empty());
    parsed.ok().and_then(only).unwrap_or_else(|| Value::from(text))
}

/// Three numbers.
pub(crate) fn vector(v: &Vec3) -> Value {
    Value::Array(v.iter().map(|x| Value::Float(*x)).collect())
}

/// A rotation as a quaternion.
pub(crate) fn rotation(q: &Quat) -> Value {
    let numbers = q.coords.iter().map(|x| Value::Float(*x)).collect();
    Value::Table([("quaternion".to_owned(), Value::Array(numbers))].into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_a_scene_file() {
        let mut entry = Entry::new();
        for (key, text) in [
            ("mass", "0.5"),
            ("grid", "56"),
            ("motion", "fixed"),
            ("position", "[0.0, 1.0, 2.0]"),
            ("material.young", "2e4"),
            ("material.law", "\"ogden\""),
            ("name", "0.1 = x\nkey = 2"),
        ] {
            entry.put_text(key, text);
        }
        let expected = r#"
            mass = 0.5
            grid = 56
            motion = "fixed"
            position = [0.0, 1.0, 2.0]
            name = "0.1 = x\nkey = 2"
            [material]
            young = 2e4
            law = "ogden"
        "#;
        assert_eq!(entry.0, expected.parse::<Table>().unwrap());
    }
}
