//! MCAP files, read by nothing but what is in them.

use crate::stage::{Folder, err};
use prost_reflect::{DescriptorPool, DynamicMessage, ReflectMessage};
use std::collections::BTreeMap;

/// Messages by topic with their times, read by nothing but the schemas in the file.
fn topics(bytes: &[u8]) -> BTreeMap<String, Vec<(u64, DynamicMessage)>> {
    let mut topics: BTreeMap<String, Vec<(u64, DynamicMessage)>> = BTreeMap::new();
    for message in mcap::MessageStream::new(bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!(
            (&schema.encoding[..], &message.channel.message_encoding[..]),
            ("protobuf", "protobuf")
        );
        let pool = DescriptorPool::decode(&schema.data[..]).unwrap();
        let kind = pool.get_message_by_name(&schema.name).unwrap();
        let value = DynamicMessage::decode(kind, &message.data[..]).unwrap();
        assert_eq!(value.unknown_fields().count(), 0, "{}", schema.name);
        topics.entry(message.channel.topic.clone()).or_default().push((message.log_time, value));
    }
    topics
}

/// The messages of a repeated field.
fn list(message: &DynamicMessage, field: &str) -> Vec<DynamicMessage> {
    let value = message.get_field_by_name(field).unwrap();
    value.as_list().unwrap().iter().map(|entry| entry.as_message().unwrap().clone()).collect()
}

fn number(message: &DynamicMessage, field: &str) -> f64 {
    message.get_field_by_name(field).unwrap().as_f64().unwrap()
}

/// Bytes per point and all of them.
fn cloud(message: &DynamicMessage) -> (usize, Vec<u8>) {
    let stride = message.get_field_by_name("point_stride").unwrap().as_u32().unwrap();
    let data = message.get_field_by_name("data").unwrap();
    (stride as usize, data.as_bytes().unwrap().to_vec())
}

#[test]
fn an_mcap_file_has_the_promised_topics_and_the_physics_in_them() {
    let folder = Folder::new("mcap");
    assert!(folder.thenar(&["record", "soft-cube", "--seconds", "0.4", "-q"]).status.success());
    let replayed = folder.thenar(&["replay", "soft-cube.rec", "--mcap", "c.mcap", "--rate", "50"]);
    assert!(replayed.status.success(), "{}", err(&replayed));
    let bytes = std::fs::read(folder.0.join("c.mcap")).unwrap();
    let topics = topics(&bytes);
    let names: Vec<&str> = topics.keys().map(String::as_str).collect();
    let expected = [
        "/flesh",
        "/forces",
        "/haptics/force",
        "/log",
        "/objects",
        "/points/contacts",
        "/points/flesh/cube",
        "/points/forces",
        "/points/objects/table",
        "/probes",
        "/sim/step",
        "/sim/timing",
        "/tf",
    ];
    assert_eq!(names, expected);
    let schema = |topic: &str| topics[topic][0].1.descriptor().full_name().to_string();
    assert_eq!(schema("/tf"), "foxglove.FrameTransforms");
    assert_eq!(schema("/flesh"), "foxglove.SceneUpdate");
    assert_eq!(schema("/points/flesh/cube"), "foxglove.PointCloud");
    assert_eq!(schema("/sim/step"), "thenar.Step");
    // 200 steps of 2 ms, and moments 50 times a second.
    assert_eq!(topics["/sim/timing"].len(), 200);
    assert_eq!(topics["/tf"].len(), 21);
    let times: Vec<u64> = topics["/sim/timing"].iter().map(|(time, _)| *time).collect();
    assert_eq!(times[199] - times[0], 398_000_000);
    assert!(topics.values().all(|messages| messages.is_sorted_by_key(|(time, _)| *time)));
    let simulated = number(&topics["/sim/timing"][199].1, "simulated");
    assert!((simulated - 0.4).abs() < 1e-12, "{simulated}");

    // The cube falls from 60 mm with its mass in the middle until it touches at 35 mm.
    let height = |message: &DynamicMessage| {
        let entity = &list(message, "entities")[0];
        let points = list(&list(entity, "triangles")[0], "points");
        points.iter().map(|p| number(p, "y")).fold(f64::INFINITY, f64::min)
    };
    // The first update clears the topic, the second is the start.
    let flesh = &topics["/flesh"];
    let cleared =
        list(&flesh[0].1, "deletions")[0].get_field_by_name("type").unwrap().as_enum_number();
    assert_eq!(cleared, Some(1));
    let fallen = height(&flesh[1].1) - height(&flesh[3].1);
    let t = (flesh[3].0 - flesh[1].0) as f64 * 1e-9;
    let theory = 0.5 * 9.81 * t * t;
    assert!((fallen - theory).abs() < 0.1 * theory + 2e-6, "{fallen} m in {t} s, {theory}");
    // Its points fall with it: they lie on its lowest face too.
    let lowest = |message: &DynamicMessage| {
        let (stride, data) = cloud(message);
        let y = |point: &[u8]| f64::from(f32::from_le_bytes(point[4..8].try_into().unwrap()));
        data.chunks_exact(stride).map(y).fold(f64::INFINITY, f64::min)
    };
    let dots = &topics["/points/flesh/cube"];
    for (k, (_, message)) in dots.iter().enumerate() {
        assert!((lowest(message) - height(&flesh[k + 1].1)).abs() < 1e-6, "{k}");
    }
    let arrows = |message: &DynamicMessage| list(&list(message, "entities")[0], "arrows").len();
    assert_eq!(arrows(&topics["/forces"][0].1), 0);
    let landed = arrows(&topics["/forces"].last().unwrap().1);
    assert!(landed > 0, "it has landed");
    // An arrow and twelve points for each force that is seen.
    let (stride, data) = cloud(&topics["/points/forces"].last().unwrap().1);
    assert_eq!(data.len() / stride, 12 * landed);
    // Pressure over area is the force along the normal, and the flat face of 50 mm that lies on the
    // table bears it all.
    let contacts = &topics["/points/contacts"].last().unwrap().1;
    let (stride, data) = cloud(contacts);
    let fields = list(contacts, "fields");
    let value = |point: &[u8], name: &str| {
        let named =
            |f: &&DynamicMessage| f.get_field_by_name("name").unwrap().as_str() == Some(name);
        let field = fields.iter().find(named).unwrap();
        let at = field.get_field_by_name("offset").unwrap().as_u32().unwrap() as usize;
        f64::from(f32::from_le_bytes(point[at..at + 4].try_into().unwrap()))
    };
    let mut area = 0.0;
    for point in data.chunks_exact(stride) {
        let of = |name: &str| value(point, name);
        let normal = ["normal_x", "normal_y", "normal_z"].map(of);
        let along: f64 =
            normal.iter().zip(["x", "y", "z"]).map(|(n, k)| n * of(&format!("force_{k}"))).sum();
        assert!((normal.iter().map(|n| n * n).sum::<f64>() - 1.0).abs() < 1e-5);
        assert!((along - of("normal_force")).abs() < 1e-5);
        assert!((of("pressure") * of("area") - along).abs() < 1e-5 * along.max(1.0));
        area += of("area");
    }
    assert!((area / 0.05_f64.powi(2) - 1.0).abs() < 0.05, "{area} m²");
    // A file that could not be finished leaves nothing.
    let refused = folder.thenar(&["replay", "soft-cube.rec", "--mcap", "no/such/folder.mcap"]);
    assert_ne!(refused.status.code(), Some(0));
    assert!(std::fs::read_dir(&folder.0).unwrap().count() == 2);
}
