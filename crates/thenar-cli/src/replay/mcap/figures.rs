//! Numbers of a session, to be plotted.

use super::message::Time;
use serde_json::{Map, Value, json};
use thenar_record::ChannelInfo;
use thenar_scene::session::{Column, HandLoad, PARTS, Session};

/// The schema of a message whose members are these numbers, beside its time.
fn schema(title: &str, numbers: Map<String, Value>) -> Value {
    let mut properties = numbers;
    let timestamp = json!({
        "type": "object",
        "title": "time",
        "properties": {
            "sec": { "type": "integer", "minimum": 0 },
            "nsec": { "type": "integer", "minimum": 0, "maximum": 999_999_999 },
        },
    });
    properties.insert("timestamp".into(), timestamp);
    json!({ "title": title, "type": "object", "properties": properties })
}

fn number(meaning: &str) -> Value {
    json!({ "type": "number", "description": meaning })
}

/// A message of these numbers. What is not known, or not finite, is left out: JSON has no such numbers.
fn message(time: Time, numbers: impl IntoIterator<Item = (String, Option<f64>)>) -> Value {
    let known =
        numbers.into_iter().filter_map(|(name, x)| Some((name, x.filter(|x| x.is_finite())?)));
    let mut message: Map<String, Value> = known.map(|(name, x)| (name, json!(x))).collect();
    message.insert("timestamp".into(), json!(time));
    Value::Object(message)
}

fn numbers<'a>(all: impl IntoIterator<Item = (&'a str, &'a str)>) -> Map<String, Value> {
    all.into_iter().map(|(name, meaning)| (name.into(), number(meaning))).collect()
}

/// Schema of [`timing`].
pub fn timing_schema() -> Value {
    schema(
        "thenar.Timing",
        numbers([
            ("step", "Steps of the replay so far"),
            ("simulated", "Simulated time [s]"),
            ("cost", "What the step took when it was recorded [s]"),
            ("period", "Time since the step before, in the recording [s]"),
        ]),
    )
}

/// When a step was made and what it took, where that is known.
pub fn timing(session: &Session, time: Time, cost: Option<f64>, period: Option<f64>) -> Value {
    let numbers = [
        ("step", Some(session.steps() as f64)),
        ("simulated", Some(session.world().time())),
        ("cost", cost),
        ("period", period),
    ];
    message(time, numbers.map(|(name, x)| (name.to_string(), x)))
}

/// Schema of [`step`].
pub fn step_schema() -> Value {
    schema(
        "thenar.Step",
        numbers([
            ("contacts", "Contacts, near or touching"),
            ("contacts_active", "Of these, carrying force"),
            ("penetration", "Deepest penetration [m]"),
            ("joint_gap", "Largest distance between the two sides of a joint [m]"),
            ("contact_residual", "What contact leaves undone [m/s]"),
            ("iterations", "Conjugate-gradient iterations"),
            ("kinetic", "Energy of motion [J]"),
            ("potential", "Energy of weight [J]"),
            ("elastic", "Energy of deformation [J]"),
            ("energy", "All energies together [J]"),
        ]),
    )
}

/// What the last step reported.
pub fn step(session: &Session, time: Time) -> Value {
    let report = session.report();
    let energy = session.world().energy(session.input());
    json!({
        "timestamp": time,
        "contacts": report.contacts,
        "contacts_active": report.contacts_active,
        "penetration": report.penetration_max,
        "joint_gap": report.joint_gap_max,
        "contact_residual": report.contact_residual,
        "iterations": report.cg_iterations,
        "kinetic": energy.kinetic,
        "potential": energy.gravity,
        "elastic": energy.elastic,
        "energy": energy.total(),
    })
}

/// Schema of [`force`].
pub fn force_schema() -> Value {
    let load = json!({
        "type": "object",
        "properties": numbers([
            ("normal", "Sum of normal forces [N]"),
            ("shear", "Tangential force [N]"),
            ("area", "Area in contact [m²]"),
        ]),
    });
    let mut hand: Map<String, Value> =
        PARTS.iter().map(|part| (part.name().into(), load.clone())).collect();
    hand.insert("hand".into(), json!({ "type": "string" }));
    let hands = json!({ "type": "array", "items": { "type": "object", "properties": hand } });
    schema("thenar.Force", Map::from_iter([("hands".to_string(), hands)]))
}

/// What presses on each part of each hand.
pub fn force(session: &Session, time: Time) -> Value {
    let load =
        |load: &HandLoad| json!({ "normal": load.normal, "shear": load.shear, "area": load.area });
    let hands = session.hands().iter().enumerate().map(|(k, hand)| {
        let loads = session.hand_loads(k);
        let mut parts: Map<String, Value> =
            PARTS.iter().zip(&loads).map(|(part, l)| (part.name().into(), load(l))).collect();
        parts.insert("hand".into(), json!(hand.name));
        Value::Object(parts)
    });
    json!({ "timestamp": time, "hands": hands.collect::<Vec<_>>() })
}

/// Schema of [`probes`].
pub fn probes_schema(columns: &[Column]) -> Value {
    let meaning = |c: &Column| number(&format!("[{}]", c.unit));
    schema("thenar.Probes", columns.iter().map(|c| (c.name.clone(), meaning(c))).collect())
}

/// Probes' values.
pub fn probes(session: &mut Session, time: Time) -> Value {
    let names: Vec<String> = session.columns().iter().map(|c| c.name.clone()).collect();
    message(time, names.into_iter().zip(session.probe().iter().copied().map(Some)))
}

/// Schema of the records of a channel.
pub fn channel_schema(info: &ChannelInfo) -> Value {
    let fields = info.fields.iter();
    let title = format!("thenar.channel.{}", info.name);
    let all = fields.map(|f| (f.name.clone(), number(&format!("[{}]", f.unit))));
    schema(&title, all.collect())
}

/// A record of a channel.
pub fn record(info: &ChannelInfo, values: &[f64], time: Time) -> Value {
    let fields = info.fields.iter().map(|field| field.name.clone());
    message(time, fields.zip(values.iter().copied().map(Some)))
}
