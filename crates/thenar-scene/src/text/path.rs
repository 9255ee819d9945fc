//! The key path of the value being read, kept on the stack and written out only for a message.

use super::{Fault, Node, Range, SourcePlace};

/// One step from a value to a value inside it.
#[derive(Clone, Copy, Debug)]
pub enum Step<'a> {
    /// The file itself.
    Root,
    /// A key of a table.
    Key(&'a str),
    /// An element of an array.
    Index(usize),
}

/// Context of the value being read.
#[derive(Clone, Copy, Debug)]
pub struct Cx<'a> {
    parent: Option<&'a Cx<'a>>,
    step: Step<'a>,
    /// Bounds for every number in the value.
    pub range: &'static Range,
    /// The key that chose this table's kind, which it may therefore contain.
    pub tag: Option<&'static str>,
}

impl<'a> Cx<'a> {
    /// The whole file.
    pub fn root() -> Cx<'static> {
        Cx { parent: None, step: Step::Root, range: Range::ANY, tag: None }
    }

    /// A value inside this one.
    pub fn inside(&'a self, step: Step<'a>, range: &'static Range) -> Cx<'a> {
        Cx { parent: Some(self), step, range, tag: None }
    }

    /// This place, whose table may contain `tag`.
    pub fn with_tag(&self, tag: &'static str) -> Cx<'a> {
        Cx { tag: Some(tag), ..*self }
    }

    /// The full key, e.g. `rigid[0].shape.size`.
    pub fn key(&self) -> String {
        let above = self.parent.map_or(String::new(), Cx::key);
        match self.step {
            Step::Root => above,
            Step::Key(k) if above.is_empty() => k.to_string(),
            Step::Key(k) => format!("{above}.{k}"),
            Step::Index(i) => format!("{above}[{i}]"),
        }
    }

    /// A fault about this value.
    pub fn fault(&self, place: &SourcePlace, problem: impl Into<String>) -> Fault {
        Fault::new(place, self.key(), problem)
    }

    /// "expected X, got Y".
    pub fn expected(&self, node: &Node, what: impl std::fmt::Display) -> Fault {
        self.fault(&node.place, format!("expected {what}, got {}", node.describe()))
    }
}
