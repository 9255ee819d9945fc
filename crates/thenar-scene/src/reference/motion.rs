//! Motion files: keyframes, from the tables that read them, and the lines of recordings.

use super::{describe, describe_keys};
use crate::format::KeyframesTable;
use crate::motion::TRACKED_JOINTS;
use crate::text::schema_document;
use serde_json::{Value, json};
use std::fmt::Write;

/// The JSON Schema of a motion file, as text: its root is a file of keyframes (TOML);
/// `RecordingHeader` and `RecordingSample` among its parts are the first line of a recording and
/// the others (JSON Lines).
pub fn motion_schema() -> String {
    serde_json::to_string_pretty(&document()).map_or(String::new(), |text| text + "\n")
}

fn document() -> Value {
    let mut document = schema_document::<KeyframesTable>("Thenar motion file, version 1");
    document["$defs"]["RecordingHeader"] = header();
    document["$defs"]["RecordingSample"] = sample();
    document
}

fn header() -> Value {
    let joints = TRACKED_JOINTS.len();
    json!({
        "type": "object",
        "description": "First line of a recording of tracked hands.",
        "properties": {
            "format": { "const": "hand-joints-jsonl", "description": "Name of the format." },
            "version": { "const": 1, "description": "Version of the format." },
            "quat": { "const": "x,y,z,w", "description": "Order of a quaternion's numbers." },
            "joints": {
                "type": "array",
                "items": { "type": "string", "enum": TRACKED_JOINTS },
                "minItems": joints,
                "maxItems": joints,
                "description": "The tracked joints, each once, in the order of the lines that follow.",
            },
        },
        "required": ["format", "version", "joints", "quat"],
    })
}

fn sample() -> Value {
    let joints = TRACKED_JOINTS.len();
    let each = |item: Value, about: &str| {
        json!({
            "type": "array",
            "items": item,
            "minItems": joints,
            "maxItems": joints,
            "description": about,
        })
    };
    let numbers = |n: usize| {
        let number = json!({ "type": "number" });
        json!({ "type": "array", "items": number, "minItems": n, "maxItems": n })
    };
    json!({
        "type": "object",
        "description": "Any other line: one hand at one instant. The frame is right-handed, +y is up.",
        "properties": {
            "t": { "type": "number", "description": "Time [s]." },
            "hand": { "type": "string", "enum": ["left", "right"], "description": "Side of the hand." },
            "pos": each(numbers(3), "Position of each joint [m]."),
            "quat": each(
                numbers(4),
                "Rotation of each joint: -z along the bone away from the wrist, +y out of the back of the hand.",
            ),
            "radius": each(
                json!({ "type": "number", "minimum": 0 }),
                "Radius of each joint [m]; may be left out, and is not used.",
            ),
        },
        "required": ["t", "hand", "pos", "quat"],
    })
}

/// Tables of what stands in motion files, in Markdown.
pub(super) fn motion_keys(out: &mut String) {
    let mut document = document();
    describe(out, &document, ("KeyframesTable", "Motion files of keyframes"), "####");
    for (part, title) in [
        ("RecordingHeader", "First line of a recording"),
        ("RecordingSample", "Other lines of a recording"),
    ] {
        let table = &mut document["$defs"][part];
        let about = table["description"].as_str().unwrap_or_default();
        let _ = writeln!(out, "#### {title}\n\n{about}\n");
        // A constant is a key like others here.
        if let Some(properties) = table["properties"].as_object_mut() {
            for value in properties.values_mut() {
                if let Some(constant) = value.as_object_mut().and_then(|v| v.remove("const")) {
                    value["enum"] = json!([constant]);
                }
            }
        }
        describe_keys(out, table, &mut Vec::new());
    }
}
