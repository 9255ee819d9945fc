//! Names of the skinned meshes of a file.

use crate::text::{Cx, Defs, Fault, Node, Read, Value};
use serde_json::{Value as Json, json};

/// Names of skinned meshes: one, or several in an array.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshNames(pub Vec<String>);

impl Read for MeshNames {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        let names = match &node.value {
            Value::Array(_) => Vec::read(node, cx)?,
            _ => vec![String::read(node, cx)?],
        };
        match names.is_empty() {
            true => Err(cx.expected(node, "the name of a mesh, or several")),
            false => Ok(Self(names)),
        }
    }

    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> Json {
        json!({ "oneOf": [String::schema(defs, cx), Vec::<String>::schema(defs, cx)] })
    }
}
