//! Reading and description of the kinds of values.

use super::{Cx, Defs, Fault, Node, Range, SourcePlace, Step, Value, nearest};
use crate::math::Vec3;
use serde_json::{Value as Json, json};
use std::collections::BTreeMap;

/// A type that can be read from a node and describe itself.
pub trait Read: Sized {
    /// Reads it.
    ///
    /// # Errors
    /// Names the place, the key, what was expected and what was found.
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault>;

    /// The value when its key is missing; `None` makes the key required.
    fn absent() -> Option<Self> {
        None
    }

    /// JSON Schema of the type.
    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> Json;
}

/// Parses a whole document.
///
/// # Errors
/// The text is not TOML, or a value in it is not what the format says.
pub fn parse<T: Read>(root: &Node) -> Result<T, Fault> {
    T::read(root, &Cx::root())
}

/// A value that remembers where it was written, for errors found later.
#[derive(Clone, Debug)]
pub struct Located<T> {
    /// The value.
    pub value: T,
    /// Place where it was written.
    pub place: SourcePlace,
    /// Full key of the value.
    pub key: String,
}

impl<T> Located<T> {
    /// A fault about this value.
    pub fn fault(&self, problem: impl Into<String>) -> Fault {
        Fault::new(&self.place, self.key.clone(), problem)
    }
}

impl<T> Located<Vec<T>> {
    /// No values, written nowhere.
    pub fn none() -> Self {
        Self { value: Vec::new(), place: SourcePlace::Text(0..0), key: String::new() }
    }
}

impl<T: Read> Read for Located<T> {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        Ok(Self { value: T::read(node, cx)?, place: node.place.clone(), key: cx.key() })
    }
    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> Json {
        T::schema(defs, cx)
    }
}

impl<T: Read> Read for Option<T> {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        T::read(node, cx).map(Some)
    }
    fn absent() -> Option<Self> {
        Some(None)
    }
    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> Json {
        T::schema(defs, cx)
    }
}

impl<T: Read> Read for Vec<T> {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        let Value::Array(elements) = &node.value else {
            return Err(cx.expected(node, "an array"));
        };
        let element = |(i, n)| T::read(n, &cx.inside(Step::Index(i), cx.range));
        elements.iter().enumerate().map(element).collect()
    }
    fn absent() -> Option<Self> {
        Some(Vec::new())
    }
    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> Json {
        json!({ "type": "array", "items": T::schema(defs, cx) })
    }
}

impl<T: Read> Read for BTreeMap<String, T> {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        let Value::Table(entries) = &node.value else {
            return Err(cx.expected(node, "a table"));
        };
        let entry = |e: &super::node::Entry| {
            let inner = cx.inside(Step::Key(&e.key), cx.range);
            Ok((e.key.clone(), T::read(&e.node, &inner)?))
        };
        entries.iter().map(entry).collect()
    }
    fn absent() -> Option<Self> {
        Some(Self::new())
    }
    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> Json {
        json!({ "type": "object", "additionalProperties": T::schema(defs, cx) })
    }
}

impl<T: Read, const N: usize> Read for [T; N] {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        let wrong = || cx.expected(node, format_args!("an array of {N}"));
        let Value::Array(elements) = &node.value else { return Err(wrong()) };
        if elements.len() != N {
            return Err(wrong());
        }
        Vec::<T>::read(node, cx)?.try_into().map_err(|_| wrong())
    }
    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> Json {
        json!({ "type": "array", "items": T::schema(defs, cx), "minItems": N, "maxItems": N })
    }
}

impl Read for Vec3 {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        <[f64; 3]>::read(node, cx).map(Vec3::from)
    }
    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> Json {
        <[f64; 3]>::schema(defs, cx)
    }
}

fn bounds(kind: &str, range: &Range) -> Json {
    let mut schema = json!({ "type": kind });
    let number =
        |x: f64| if x.fract() == 0.0 && x.abs() < 1e15 { json!(x as i64) } else { json!(x) };
    if range.min.is_finite() {
        schema[if range.open_min { "exclusiveMinimum" } else { "minimum" }] = number(range.min);
    }
    if range.max.is_finite() {
        schema[if range.open_max { "exclusiveMaximum" } else { "maximum" }] = number(range.max);
    }
    schema
}

impl Read for f64 {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        let wrong = || cx.expected(node, format_args!("a finite number{}", cx.range.words()));
        let x = match node.value {
            Value::Float(x) => x,
            Value::Integer(i) => i as f64,
            _ => return Err(wrong()),
        };
        if cx.range.contains(x) { Ok(x) } else { Err(wrong()) }
    }
    fn schema(_: &mut Defs, cx: &Cx<'_>) -> Json {
        bounds("number", cx.range)
    }
}

impl Read for u32 {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        let wrong = || cx.expected(node, format_args!("a whole number{}", whole(cx).words()));
        let Value::Integer(i) = node.value else { return Err(wrong()) };
        u32::try_from(i).ok().filter(|i| whole(cx).contains(f64::from(*i))).ok_or_else(wrong)
    }
    fn schema(_: &mut Defs, cx: &Cx<'_>) -> Json {
        bounds("integer", whole(cx))
    }
}

/// The bounds of a whole number: those given, or any index.
fn whole(cx: &Cx<'_>) -> &'static Range {
    if cx.range.min.is_finite() { cx.range } else { Range::INDEX }
}

impl Read for bool {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        match node.value {
            Value::Bool(b) => Ok(b),
            _ => Err(cx.expected(node, "true or false")),
        }
    }
    fn schema(_: &mut Defs, _: &Cx<'_>) -> Json {
        json!({ "type": "boolean" })
    }
}

impl Read for String {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        match &node.value {
            Value::Text(s) if !s.is_empty() && !s.chars().any(|c| c.is_control() && c != '\n') => {
                Ok(s.clone())
            }
            Value::Text(_) => {
                Err(cx.expected(node, "text that is not empty and without control characters"))
            }
            _ => Err(cx.expected(node, "a string")),
        }
    }
    fn schema(_: &mut Defs, _: &Cx<'_>) -> Json {
        json!({ "type": "string", "minLength": 1 })
    }
}

/// The keys of a table being read.
pub struct Fields<'a> {
    node: &'a Node,
    cx: &'a Cx<'a>,
}

impl<'a> Fields<'a> {
    /// Checks that `node` is a table with no other keys than `known` and the context's tag.
    ///
    /// # Errors
    /// It is no table, or has an unknown key.
    pub fn new(node: &'a Node, cx: &'a Cx<'a>, known: &[&str]) -> Result<Self, Fault> {
        let Value::Table(entries) = &node.value else {
            return Err(cx.expected(node, "a table"));
        };
        let stranger = entries
            .iter()
            .find(|e| !known.contains(&e.key.as_str()) && cx.tag != Some(e.key.as_str()));
        match stranger {
            None => Ok(Self { node, cx }),
            Some(entry) => {
                let at = cx.inside(Step::Key(&entry.key), Range::ANY);
                let hint = match nearest(&entry.key, known.iter().copied()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("expected one of: {}", known.join(", ")),
                };
                Err(at.fault(&entry.place, format!("unknown key; {hint}")))
            }
        }
    }

    /// The value of a key, or its default.
    ///
    /// # Errors
    /// It is missing though required, or is not what it should be.
    pub fn take<T: Read>(
        &self,
        key: &str,
        range: &'static Range,
        default: Option<T>,
    ) -> Result<T, Fault> {
        match self.node.get(key) {
            Some(node) => T::read(node, &self.cx.inside(Step::Key(key), range)),
            None => default.or_else(T::absent).ok_or_else(|| {
                self.cx.fault(&self.node.place, format!("the key `{key}` is missing"))
            }),
        }
    }
}
