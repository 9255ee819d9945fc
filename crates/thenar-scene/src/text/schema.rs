//! JSON Schema (draft 2020-12) of the format, from the same declarations that read it.

use super::{Cx, Read};
use serde_json::{Map, Value as Json, json};
use std::collections::BTreeMap;

/// The named parts of a schema.
#[derive(Debug, Default)]
pub struct Defs {
    parts: BTreeMap<String, Json>,
}

impl Defs {
    /// A reference to the part `name`, which `build` describes when it is not yet known.
    pub fn part(&mut self, name: &str, build: impl FnOnce(&mut Self) -> Json) -> Json {
        if !self.parts.contains_key(name) {
            self.parts.insert(name.into(), Json::Null); // stops recursion
            let part = build(self);
            self.parts.insert(name.into(), part);
        }
        json!({ "$ref": format!("#/$defs/{name}") })
    }

    /// The table `part` with a further key `tag` that holds `word`.
    pub fn tagged(&mut self, part: &Json, tag: &str, word: &str, about: &str) -> Json {
        let name = part["$ref"].as_str().unwrap_or_default().trim_start_matches("#/$defs/");
        let mut table = self.parts.get(name).cloned().unwrap_or_default();
        table["description"] = json!(about);
        table["properties"][tag] = json!({ "const": word });
        if let Some(required) = table["required"].as_array_mut() {
            required.insert(0, json!(tag));
        }
        table
    }
}

/// The schema of a document of type `T`.
pub fn document<T: Read>(title: &str) -> Json {
    let mut defs = Defs::default();
    let root = T::schema(&mut defs, &Cx::root());
    let mut document = Map::new();
    document.insert("$schema".into(), json!("https://json-schema.org/draft/2020-12/schema"));
    document.insert("title".into(), json!(title));
    if let Json::Object(root) = root {
        document.extend(root);
    }
    document.insert("$defs".into(), json!(defs.parts));
    Json::Object(document)
}
