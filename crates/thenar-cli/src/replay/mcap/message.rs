//! Messages as Foxglove's schemas want them.

use serde::Serialize;
use thenar::{Pose, Quat, Vec3};

/// A moment since 1970.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Time {
    sec: u64,
    nsec: u32,
}

impl Time {
    /// From nanoseconds.
    pub fn of(ns: u64) -> Self {
        Self { sec: ns / 1_000_000_000, nsec: (ns % 1_000_000_000) as u32 }
    }
}

/// A point or direction.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Xyz {
    x: f64,
    y: f64,
    z: f64,
}

impl From<Vec3> for Xyz {
    fn from(v: Vec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl Xyz {
    /// To the micrometre: what is to be looked at needs no more, and text is long.
    pub fn seen(v: &Vec3) -> Self {
        let round = |x: f64| (x * 1e6).round() / 1e6;
        Self { x: round(v.x), y: round(v.y), z: round(v.z) }
    }
}

/// A rotation.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Xyzw {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

impl From<Quat> for Xyzw {
    fn from(q: Quat) -> Self {
        let q = q.coords;
        Self { x: q.x, y: q.y, z: q.z, w: q.w }
    }
}

/// A pose.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Placed {
    position: Xyz,
    orientation: Xyzw,
}

impl From<Pose> for Placed {
    fn from(pose: Pose) -> Self {
        Self { position: pose.position.into(), orientation: pose.rotation.into() }
    }
}

/// Red, green, blue, opacity from 0 to 1.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Colour {
    r: f64,
    g: f64,
    b: f64,
    a: f64,
}

impl From<[f64; 3]> for Colour {
    fn from([r, g, b]: [f64; 3]) -> Self {
        Self { r, g, b, a: 1.0 }
    }
}

/// A box or an ellipsoid.
#[derive(Clone, Debug, Serialize)]
pub struct Sized {
    /// Its middle.
    pub pose: Placed,
    /// Its width in all directions.
    pub size: Xyz,
    /// Colour.
    pub color: Colour,
}

/// A cylinder along z.
#[derive(Clone, Debug, Serialize)]
pub struct Cylinder {
    /// Its middle.
    pub pose: Placed,
    /// Its width in all directions.
    pub size: Xyz,
    /// 1.
    pub bottom_scale: f64,
    /// 1.
    pub top_scale: f64,
    /// Colour.
    pub color: Colour,
}

/// A surface.
#[derive(Clone, Debug, Serialize)]
pub struct Triangles {
    /// Where its points are.
    pub pose: Placed,
    /// Vertices.
    pub points: Vec<Xyz>,
    /// Colour.
    pub color: Colour,
    /// None: one for all.
    pub colors: [Colour; 0],
    /// Three for each triangle.
    pub indices: Vec<u32>,
}

/// An arrow along x.
#[derive(Clone, Debug, Serialize)]
pub struct Arrow {
    /// Where it begins.
    pub pose: Placed,
    /// \[m\].
    pub shaft_length: f64,
    /// \[m\].
    pub shaft_diameter: f64,
    /// \[m\].
    pub head_length: f64,
    /// \[m\].
    pub head_diameter: f64,
    /// Colour.
    pub color: Colour,
}

/// A length of time.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Span {
    sec: i64,
    nsec: u32,
}

/// Something to be seen.
#[derive(Clone, Debug, Serialize)]
pub struct Entity {
    /// Since when.
    pub timestamp: Time,
    /// In which frame.
    pub frame_id: String,
    /// Replaces what had this name.
    pub id: String,
    /// Zero: until it is replaced.
    pub lifetime: Span,
    /// It moves with its frame.
    pub frame_locked: bool,
    /// None.
    pub metadata: [(); 0],
    /// Arrows.
    pub arrows: Vec<Arrow>,
    /// Boxes.
    pub cubes: Vec<Sized>,
    /// Ellipsoids.
    pub spheres: Vec<Sized>,
    /// Cylinders.
    pub cylinders: Vec<Cylinder>,
    /// None.
    pub lines: [(); 0],
    /// Surfaces.
    pub triangles: Vec<Triangles>,
    /// None.
    pub texts: [(); 0],
    /// None.
    pub models: [(); 0],
}

impl Entity {
    /// Empty.
    pub fn new(timestamp: Time, frame_id: &str, id: &str) -> Self {
        Self {
            timestamp,
            frame_id: frame_id.into(),
            id: id.into(),
            lifetime: Span::default(),
            frame_locked: true,
            metadata: [],
            arrows: Vec::new(),
            cubes: Vec::new(),
            spheres: Vec::new(),
            cylinders: Vec::new(),
            lines: [],
            triangles: Vec::new(),
            texts: [],
            models: [],
        }
    }
}

/// Takes entities away.
#[derive(Clone, Debug, Serialize)]
pub struct Deletion {
    timestamp: Time,
    #[serde(rename = "type")]
    kind: u8,
    id: String,
}

impl Deletion {
    /// All of the topic.
    pub fn all(timestamp: Time) -> Self {
        Self { timestamp, kind: 1, id: String::new() }
    }
}

/// `foxglove.SceneUpdate`.
#[derive(Clone, Debug, Serialize)]
pub struct SceneUpdate {
    /// What goes.
    pub deletions: Vec<Deletion>,
    /// What comes.
    pub entities: Vec<Entity>,
}

/// A frame in another.
#[derive(Clone, Debug, Serialize)]
pub struct FrameTransform {
    timestamp: Time,
    parent_frame_id: String,
    child_frame_id: String,
    translation: Xyz,
    rotation: Xyzw,
}

impl FrameTransform {
    /// The pose of `child` in `parent`.
    pub fn new(timestamp: Time, parent: &str, child: &str, pose: &Pose) -> Self {
        Self {
            timestamp,
            parent_frame_id: parent.into(),
            child_frame_id: child.into(),
            translation: pose.position.into(),
            rotation: pose.rotation.into(),
        }
    }
}

/// `foxglove.FrameTransforms`.
#[derive(Clone, Debug, Serialize)]
pub struct FrameTransforms {
    /// All.
    pub transforms: Vec<FrameTransform>,
}

/// How grave a log message is.
#[derive(Clone, Copy, Debug)]
pub enum Level {
    /// Good to know.
    Info = 2,
    /// Something is missing.
    Warning = 3,
}

/// `foxglove.Log`.
#[derive(Clone, Debug, Serialize)]
pub struct Log {
    timestamp: Time,
    level: u8,
    message: String,
    name: &'static str,
    file: &'static str,
    line: u32,
}

impl Log {
    /// A message.
    pub fn new(timestamp: Time, level: Level, message: String) -> Self {
        Self { timestamp, level: level as u8, message, name: "thenar", file: "", line: 0 }
    }
}
