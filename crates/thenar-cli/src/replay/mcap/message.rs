//! Values as Foxglove's messages hold them.

use foxglove::messages::{
    Color, FrameTransform, Log, Point3, Pose as Placed, Quaternion, SceneEntity,
    SceneEntityDeletion, Timestamp, Vector3, log::Level, scene_entity_deletion,
};
use thenar_core::{Pose, Quat, Vec3};

/// A moment \[ns since 1970\]; until 2106, as Foxglove counts.
pub fn time(ns: u64) -> Timestamp {
    let seconds = u32::try_from(ns / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new(seconds, (ns % 1_000_000_000) as u32)
}

/// A direction or a size.
pub fn vector(v: Vec3) -> Vector3 {
    Vector3 { x: v.x, y: v.y, z: v.z }
}

/// A place.
pub fn point(v: &Vec3) -> Point3 {
    Point3 { x: v.x, y: v.y, z: v.z }
}

fn quaternion(q: &Quat) -> Quaternion {
    let q = q.coords;
    Quaternion { x: q.x, y: q.y, z: q.z, w: q.w }
}

/// A pose.
pub fn placed(pose: &Pose) -> Placed {
    let position = Some(vector(pose.position));
    Placed { position, orientation: Some(quaternion(&pose.rotation)) }
}

/// An opaque colour.
pub fn colour([r, g, b]: [f64; 3]) -> Color {
    Color { r, g, b, a: 1.0 }
}

/// Something to be seen, still empty, until it is replaced by what has the same name.
pub fn entity(now: Timestamp, frame: &str, name: &str) -> SceneEntity {
    SceneEntity {
        timestamp: Some(now),
        frame_id: frame.into(),
        id: name.into(),
        frame_locked: true,
        ..SceneEntity::default()
    }
}

/// Takes all entities of a topic away.
pub fn clear(now: Timestamp) -> SceneEntityDeletion {
    let kind = scene_entity_deletion::Type::All as i32;
    SceneEntityDeletion { timestamp: Some(now), r#type: kind, id: String::new() }
}

/// The pose of the frame `child` in `parent`.
pub fn transform(now: Timestamp, parent: &str, child: &str, pose: &Pose) -> FrameTransform {
    FrameTransform {
        timestamp: Some(now),
        parent_frame_id: parent.into(),
        child_frame_id: child.into(),
        translation: Some(vector(pose.position)),
        rotation: Some(quaternion(&pose.rotation)),
    }
}

/// A line for the log.
pub fn log(now: Timestamp, level: Level, message: String) -> Log {
    Log {
        timestamp: Some(now),
        level: level as i32,
        message,
        name: "thenar".into(),
        ..Log::default()
    }
}
