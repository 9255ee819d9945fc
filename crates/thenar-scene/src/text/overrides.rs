//! Overrides such as `--set solver.cone="linearised"`: a dotted key and a TOML value.

use super::node::Entry;
use super::{Fault, Node, SourcePlace, Value};

/// Most parts of a dotted key: as many as the TOML reader takes in a file (its recursion limit).
/// Trees are walked by recursion.
const PARTS_MAX: usize = 80;

/// A dotted key and its value, e.g. `rigid.0.mass` and `2.5`.
#[derive(Clone, Debug)]
pub struct Override {
    /// Text as it was given.
    pub text: String,
}

impl Override {
    /// From `key=value`.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into() }
    }
}

/// Writes one override into the tree. A bare word that is not TOML is taken as a string.
/// A step into an array is an index or the `name` of an element.
///
/// # Errors
/// There is no `=`, the value is not TOML, or the key leads through something that is no table.
pub fn apply(root: &mut Node, given: &Override, index: usize) -> Result<(), Fault> {
    let place = SourcePlace::Override(index);
    let fault = |problem: &str| Fault::new(&place, "", problem);
    let (key, value) = given
        .text
        .split_once('=')
        .ok_or_else(|| fault("expected key=value, e.g. solver.cone=\"linearised\""))?;
    let steps: Vec<&str> = key.trim().split('.').map(str::trim).collect();
    if steps.iter().any(|s| s.is_empty()) {
        return Err(fault("the key has an empty part"));
    }
    if steps.len() > PARTS_MAX {
        let count = steps.len();
        return Err(fault(&format!("too deep: the key has {count} parts, at most {PARTS_MAX}")));
    }
    let value = parse_value(value.trim(), index)?;
    insert(root, &steps, value, &place)
}

fn parse_value(text: &str, index: usize) -> Result<Node, Fault> {
    let parsed = Node::parse_override(&format!("value = {text}"), index);
    let only = |node: Node| match node.value {
        Value::Table(mut entries) if entries.len() == 1 => entries.pop().map(|e| e.node),
        _ => None,
    };
    let place = SourcePlace::Override(index);
    let bare = |text: &str| {
        !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || "-_/.*".contains(c))
    };
    match parsed {
        Ok(node) => only(node).ok_or_else(|| Fault::new(&place, "", "expected one value")),
        Err(_) if bare(text) => Ok(Node { value: Value::Text(text.into()), place }),
        Err(fault) => Err(fault),
    }
}

fn insert(node: &mut Node, steps: &[&str], value: Node, place: &SourcePlace) -> Result<(), Fault> {
    let Some((first, rest)) = steps.split_first() else {
        *node = value;
        return Ok(());
    };
    let found = node.describe();
    match &mut node.value {
        Value::Table(entries) => {
            let at = match entries.iter().position(|e| e.key == *first) {
                Some(at) => at,
                None => {
                    let empty = Node { value: Value::Table(Vec::new()), place: place.clone() };
                    let key = (*first).to_string();
                    entries.push(Entry { key, place: place.clone(), node: empty });
                    entries.len() - 1
                }
            };
            insert(&mut entries[at].node, rest, value, place)
        }
        Value::Array(elements) => {
            let count = elements.len();
            let at = element(elements, first).ok_or_else(|| {
                let problem = format!(
                    "`{first}` is neither the name nor the index of one of {count} elements"
                );
                Fault::new(place, steps.join("."), problem)
            })?;
            insert(&mut elements[at], rest, value, place)
        }
        _ => Err(Fault::new(place, steps.join("."), format!("cannot look inside {found}"))),
    }
}

fn element(elements: &[Node], step: &str) -> Option<usize> {
    let named =
        |n: &Node| matches!(n.get("name").map(|v| &v.value), Some(Value::Text(t)) if t == step);
    elements
        .iter()
        .position(named)
        .or_else(|| step.parse().ok().filter(|i: &usize| *i < elements.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(text: &str, key_value: &str) -> Result<Node, Fault> {
        let mut root = Node::parse(text).unwrap();
        apply(&mut root, &Override::new(key_value), 0).map(|()| root)
    }

    fn number(node: Option<&Node>) -> f64 {
        match node.map(|n| &n.value) {
            Some(Value::Float(x)) => *x,
            Some(Value::Integer(i)) => *i as f64,
            other => panic!("not a number: {other:?}"),
        }
    }

    #[test]
    fn replaces_adds_and_reaches_into_arrays() {
        let root = set("a = 1\n[b]\nc = 2", "b.c=3.5").unwrap();
        assert_eq!(number(root.get("b").unwrap().get("c")), 3.5);
        let root = set("", "solver.tol = 1e-9").unwrap();
        assert_eq!(number(root.get("solver").unwrap().get("tol")), 1e-9);
        for key in ["rigid.ball.mass=7", "rigid.0.mass=7"] {
            let root = set("[[rigid]]\nname = \"ball\"", key).unwrap();
            let Value::Array(a) = &root.get("rigid").unwrap().value else { panic!() };
            assert_eq!(number(a[0].get("mass")), 7.0);
        }
    }

    #[test]
    fn bare_words_are_strings_and_nonsense_is_refused() {
        let root = set("", "solver.cone=linearised").unwrap();
        let cone = root.get("solver").unwrap().get("cone").unwrap();
        assert!(matches!(&cone.value, Value::Text(t) if t == "linearised"));
        for bad in ["no-equals", "a=[1", "=3", "a..b=1", "a.b.c=1"] {
            assert!(set("a = 1", bad).is_err(), "{bad}");
        }
        assert!(set("r = [1]", "r.4=2").unwrap_err().problem.contains("index of one of 1"));
    }

    /// The reader of files is the measure: what it takes is taken, what it refuses is refused.
    #[test]
    fn keys_are_as_deep_as_those_of_files_and_no_deeper() {
        let deep = |parts: usize| format!("{}b=1", "a.".repeat(parts - 1));
        for (parts, taken) in [(2, true), (80, true), (81, false), (50_000, false)] {
            assert_eq!(set("", &deep(parts)).is_ok(), taken, "{parts} parts");
            assert_eq!(Node::parse(&deep(parts)).is_ok(), taken, "{parts} parts in a file");
        }
        let told = set("", &deep(50_000)).unwrap_err().problem;
        assert_eq!(told, "too deep: the key has 50000 parts, at most 80");
    }
}
