//! Rigid objects of a scene.

use crate::drive;
use crate::entry::{Entry, vector};
use crate::motion::Twist;
use crate::scene::{Part, Sealed};
use crate::{Drive, RigidId};
use std::fmt::Display;
use thenar_core::{Pose, Quat, Vec3};
use toml::Value;

/// A rigid object to be added to a scene. Of 1000 kg/m³ unless it is given another density or a
/// mass, with friction 0.5, at the origin, and moved by forces. Its frame has its origin at the
/// centre of mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Rigid {
    pub(crate) entry: Entry,
    kind: &'static str,
}

/// Density of what is given neither mass nor density \[kg/m³\]: water's.
const DENSITY: f64 = 1000.0;

impl Rigid {
    fn of(
        kind: &'static str,
        keys: impl IntoIterator<Item = (&'static str, Value)>,
        density: Option<f64>,
    ) -> Self {
        let mut entry = Entry::new();
        entry.put("shape", Entry::of_kind(kind, keys).0);
        if let Some(density) = density {
            entry.put("density", density);
        }
        Self { entry, kind }
    }

    fn solid(kind: &'static str, keys: impl IntoIterator<Item = (&'static str, Value)>) -> Self {
        Self::of(kind, keys, Some(DENSITY))
    }

    /// Half space below y = 0, fixed: a table or a floor.
    pub fn plane() -> Self {
        Self::of("plane", [], None).fixed()
    }

    /// Box with these edge lengths along x, y and z \[m\].
    pub fn cuboid(size: impl Into<Vec3>) -> Self {
        Self::solid("box", [("size", vector(&size.into()))])
    }

    /// Ball of this radius \[m\].
    pub fn sphere(radius: f64) -> Self {
        Self::solid("sphere", [("radius", radius.into())])
    }

    /// Rounded segment along y: radius and length without caps \[m\].
    pub fn capsule(radius: f64, length: f64) -> Self {
        Self::solid("capsule", [("radius", radius.into()), ("length", length.into())])
    }

    /// Cylinder along y: radius and length \[m\].
    pub fn cylinder(radius: f64, length: f64) -> Self {
        Self::solid("cylinder", [("radius", radius.into()), ("length", length.into())])
    }

    /// Ellipsoid with these whole axes along x, y and z \[m\].
    pub fn ellipsoid(size: impl Into<Vec3>) -> Self {
        Self::solid("ellipsoid", [("size", vector(&size.into()))])
    }

    /// Cone along y, apex up: radius of the base and height \[m\].
    pub fn cone(radius: f64, height: f64) -> Self {
        Self::solid("cone", [("radius", radius.into()), ("height", height.into())])
    }

    /// Toy car of 0.1 kg that comes with the program; it drives along +x.
    pub fn car() -> Self {
        Self::of("car", [], None)
    }

    /// Triangle mesh from a file (GLB, OBJ, STL, PLY, OFF), in metres, or a model file (`.thenar`).
    pub fn mesh(file: &str) -> Self {
        // A model file has a mass of its own.
        let density = (!file.ends_with(".thenar")).then_some(DENSITY);
        Self::of("mesh", [("file", file.into())], density)
    }

    /// Several shapes as one body, each at its place in the frame of the whole.
    pub fn compound(parts: impl IntoIterator<Item = (Rigid, Pose)>) -> Self {
        let part = |(rigid, pose): (Rigid, Pose)| {
            let mut entry = Entry::new();
            let mut frame = Entry::new();
            frame.put_pose(&pose);
            entry.0.extend(rigid.entry.0.get("shape").map(|s| ("shape".to_owned(), s.clone())));
            entry.put("frame", frame.0);
            Value::Table(entry.0)
        };
        Self::solid("compound", [("parts", Value::Array(parts.into_iter().map(part).collect()))])
    }

    /// Name in messages, probes and recordings; otherwise its shape and a number.
    pub fn named(mut self, name: &str) -> Self {
        self.entry.put("name", name);
        self
    }

    /// Start position of its centre of mass, world \[m\]; of a mesh, car or compound, of the frame
    /// of its file or parts.
    pub fn at(mut self, position: impl Into<Vec3>) -> Self {
        self.entry.put("position", vector(&position.into()));
        self
    }

    /// Start rotation.
    pub fn turned(mut self, rotation: Quat) -> Self {
        self.entry.put("rotation", crate::entry::rotation(&rotation));
        self
    }

    /// Goes over to another way of moving: keys of the one before would be refused beside those of
    /// this one.
    fn moves(mut self, motion: &str) -> Self {
        for key in ["keyframes", "drive", "velocity", "angular_velocity"] {
            self.entry.take(key);
        }
        self.entry.put("motion", motion);
        if motion == "dynamic" {
            if !self.entry.0.contains_key("mass") && self.kind != "car" {
                self.entry.put("density", DENSITY);
            }
        } else {
            self.entry.take("density");
        }
        self
    }

    /// Start velocity.
    pub fn thrown(mut self, velocity: Twist) -> Self {
        self.entry.put("velocity", vector(&velocity.linear));
        self.entry.put("angular_velocity", vector(&velocity.angular));
        self
    }

    /// Mass \[kg\].
    pub fn mass(mut self, mass: f64) -> Self {
        self.entry.take("density");
        self.entry.put("mass", mass);
        self
    }

    /// Density \[kg/m³\].
    pub fn density(mut self, density: f64) -> Self {
        self.entry.take("mass");
        self.entry.put("density", density);
        self
    }

    /// Coefficient of Coulomb friction; two bodies meet with the geometric mean of theirs.
    pub fn friction(mut self, friction: f64) -> Self {
        self.entry.put("friction", friction);
        self
    }

    /// Holds still, whatever touches it.
    pub fn fixed(self) -> Self {
        self.moves("fixed")
    }

    /// Moves through these poses at these times \[s\], whatever touches it, smoothly.
    pub fn moved(self, keyframes: impl IntoIterator<Item = (f64, Pose)>) -> Self {
        let mut moved = self.moves("scripted");
        moved.entry.put("keyframes", keyframe_tables(keyframes));
        moved
    }

    /// Pulled by a spring to these poses at these times \[s\]; to its start pose, if there are
    /// none.
    pub fn pulled(self, drive: Drive, keyframes: impl IntoIterator<Item = (f64, Pose)>) -> Self {
        let mut pulled = self.moves("dynamic");
        pulled.entry.put("drive", drive::table(&drive));
        pulled.entry.put("keyframes", keyframe_tables(keyframes));
        pulled
    }

    /// Any key of `[[rigid]]` in a scene file, with a value as it stands there, e.g.
    /// `("colour", "[1.0, 0.5, 0.0]")`; dotted keys reach into tables.
    pub fn set(mut self, key: &str, value: impl Display) -> Self {
        match key {
            "mass" => self.entry.take("density"),
            "density" => self.entry.take("mass"),
            _ => {}
        }
        self.entry.put_text(key, &value.to_string());
        self
    }
}

fn keyframe_tables(keyframes: impl IntoIterator<Item = (f64, Pose)>) -> Value {
    let table = |(time, pose): (f64, Pose)| {
        let mut entry = Entry::new();
        entry.put("time", time);
        entry.put_pose(&pose);
        Value::Table(entry.0)
    };
    Value::Array(keyframes.into_iter().map(table).collect())
}

impl Sealed for Rigid {
    const KEY: &'static str = "rigid";

    fn usual_name(&self) -> &str {
        self.kind
    }

    fn into_table(self) -> toml::Table {
        self.entry.0
    }
}

impl Part for Rigid {
    type Id = RigidId;

    fn id(place: usize) -> RigidId {
        RigidId(place)
    }
}
