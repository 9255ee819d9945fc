//! The JSON Schema of the format, its reference in Markdown from the same declarations, and the
//! names of a hand.

mod hand;
mod motion;

pub use hand::hand_tables;
pub use motion::motion_schema;

use crate::format::Scene;
use crate::text::schema_document;
use serde_json::Value;
use std::fmt::Write;

/// The JSON Schema of a scene, as text.
pub fn schema() -> String {
    let document = schema_document::<Scene>("Thenar scene, version 1");
    serde_json::to_string_pretty(&document).map_or(String::new(), |text| text + "\n")
}

/// Tables of all keys, in Markdown.
pub fn keys() -> String {
    let mut out = String::new();
    describe(&mut out, &schema_document::<Scene>(""), ("Scene", "The file"), "###");
    out
}

/// Tables of a part of a schema under this title, and of all parts that it leads to; `level` stands
/// before headings.
fn describe(out: &mut String, document: &Value, (part, title): (&str, &str), level: &str) {
    let mut done: Vec<String> = Vec::new();
    let mut waiting: Vec<(String, String)> = vec![(part.into(), title.into())];
    while let Some((part, title)) = waiting.pop() {
        if done.contains(&part) {
            continue;
        }
        let table = &document["$defs"][part.as_str()];
        let _ = writeln!(out, "{level} {title}\n\n{}\n", text(table, "description"));
        let mut found: Vec<(String, String)> = Vec::new();
        match table["oneOf"].as_array() {
            Some(variants) => variants.iter().for_each(|v| describe_variant(out, v, &mut found)),
            None => describe_keys(out, table, &mut found),
        }
        found.reverse();
        waiting.extend(found);
        done.push(part);
    }
}

fn text<'a>(schema: &'a Value, key: &str) -> &'a str {
    schema[key].as_str().unwrap_or_default()
}

fn describe_variant(out: &mut String, variant: &Value, found: &mut Vec<(String, String)>) {
    let tag = variant["properties"]
        .as_object()
        .and_then(|p| p.iter().find_map(|(k, v)| v["const"].as_str().map(|word| (k, word))));
    if let Some((key, word)) = tag {
        let _ = writeln!(out, "**`{key} = \"{word}\"`**: {}\n", text(variant, "description"));
    }
    describe_keys(out, variant, found);
}

fn describe_keys(out: &mut String, table: &Value, found: &mut Vec<(String, String)>) {
    let required: Vec<&str> =
        table["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let Some(properties) = table["properties"].as_object() else { return };
    let mut keys: Vec<_> = properties.iter().filter(|(_, v)| v.get("const").is_none()).collect();
    keys.sort_by_key(|(k, _)| !required.contains(&k.as_str()));
    if keys.is_empty() {
        return;
    }
    out.push_str("| key | value | meaning |\n|---|---|---|\n");
    for (key, schema) in keys {
        let needed = if required.contains(&key.as_str()) { " (required)" } else { "" };
        let about = text(schema, "description");
        let _ = writeln!(out, "| `{key}`{needed} | {} | {about} |", kind(schema, found));
    }
    out.push('\n');
}

/// The kind of a value in words; tables are remembered in `found`.
fn kind(schema: &Value, found: &mut Vec<(String, String)>) -> String {
    if let Some(part) = schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/")) {
        let title = heading(part);
        found.push((part.into(), title.clone()));
        return format!("[{title}](#{})", title.to_lowercase().replace(' ', "-"));
    }
    if let Some(words) = schema["enum"].as_array() {
        let words: Vec<_> = words.iter().map(|word| format!("`{word}`")).collect();
        return words.join(", ");
    }
    if let Some(ways) = schema["oneOf"].as_array() {
        return ways.iter().map(|way| kind(way, found)).collect::<Vec<_>>().join(" or ");
    }
    match text(schema, "type") {
        "array" => {
            let item = kind(&schema["items"], found);
            match schema["minItems"].as_u64() {
                Some(n) => format!("{n} × {item}"),
                None => format!("list of {item}"),
            }
        }
        "object" => {
            let known = schema["properties"].as_object().into_iter().flat_map(|known| known.keys());
            let value = kind(&schema["additionalProperties"], found);
            format!("name = {value}{}", such_as(known.map(String::as_str)))
        }
        "boolean" => "`true`, `false`".into(),
        other => {
            let known = schema["examples"].as_array().into_iter().flatten();
            format!("{other}{}{}", bounds(schema), such_as(known.filter_map(Value::as_str)))
        }
    }
}

/// Names that a free text may have; nothing where none are known.
fn such_as<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    if names.is_empty() { String::new() } else { format!(" such as {}", names.join(", ")) }
}

fn bounds(schema: &Value) -> String {
    let part = |key: &str, sign: &str| {
        schema.get(key).map(|bound| format!("{sign} {bound}")).unwrap_or_default()
    };
    let all = [
        part("minimum", "≥"),
        part("exclusiveMinimum", ">"),
        part("maximum", "≤"),
        part("exclusiveMaximum", "<"),
    ];
    let all: Vec<_> = all.into_iter().filter(|p| !p.is_empty()).collect();
    if all.is_empty() { String::new() } else { format!(" {}", all.join(", ")) }
}

/// `JointTorqueLoad` as `Joint torque load`; the endings `Table`, `Word` say nothing.
fn heading(part: &str) -> String {
    let mut title = String::new();
    for c in part.trim_end_matches("Table").chars() {
        if c.is_uppercase() && !title.is_empty() {
            title.push(' ');
            title.extend(c.to_lowercase());
        } else {
            title.push(c);
        }
    }
    title
}
