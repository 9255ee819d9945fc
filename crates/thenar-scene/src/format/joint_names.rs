//! Names of a hand's joints, which the schema lists: those of all hands that are built from a mesh.
//! Hands from model files may have others.

use super::JointAngles;
use crate::text::{Cx, Defs, Fault, Node, Read};
use serde_json::{Map, Value as Json, json};
use std::collections::BTreeMap;
use thenar_rig::hand::joint_names;

/// Name of a joint of a hand, or of the bone that it carries.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JointName(pub String);

impl Read for JointName {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        String::read(node, cx).map(Self)
    }

    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> Json {
        let mut schema = String::schema(defs, cx);
        schema["examples"] = json!(joint_names());
        schema
    }
}

/// Angles of joints of a hand by their names, or by those of the bones that they carry.
#[derive(Clone, Debug, Default)]
pub struct NamedJoints(pub BTreeMap<String, JointAngles>);

impl Read for NamedJoints {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        BTreeMap::read(node, cx).map(Self)
    }

    fn absent() -> Option<Self> {
        Some(Self::default())
    }

    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> Json {
        let mut schema = BTreeMap::<String, JointAngles>::schema(defs, cx);
        let any = schema["additionalProperties"].clone();
        let known: Map<String, Json> =
            joint_names().into_iter().map(|name| (name, any.clone())).collect();
        schema["properties"] = known.into();
        schema
    }
}
