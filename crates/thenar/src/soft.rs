//! Soft objects of a scene.

use crate::SoftId;
use crate::entry::{Entry, rotation, vector};
use crate::scene::{Part, Sealed};
use std::fmt::Display;
use thenar_core::{Quat, Vec3};
use toml::Value;

/// A soft object to be added to a scene: finite elements of 50 kPa and 1000 kg/m³ (bread: 12 kPa
/// and 250 kg/m³) unless it is given others, with friction 0.5.
#[derive(Clone, Debug, PartialEq)]
pub struct Soft {
    entry: Entry,
    kind: &'static str,
}

impl Soft {
    fn of(kind: &'static str, keys: impl IntoIterator<Item = (&'static str, Value)>) -> Self {
        let mut entry = Entry::new();
        entry.put("shape", Entry::of_kind(kind, keys).0);
        Self { entry, kind }
    }

    /// Loaf of bread along x, its bottom on y = 0.
    pub fn bread() -> Self {
        Self::of("bread", [])
    }

    /// Ball of this radius \[m\].
    pub fn ball(radius: f64) -> Self {
        Self::of("ball", [("radius", radius.into())])
    }

    /// Block with these edge lengths \[m\], centred on its frame, with a number of cells along x, y
    /// and z.
    pub fn block(size: impl Into<Vec3>, cells: [u32; 3]) -> Self {
        let cells = cells.iter().map(|n| Value::from(i64::from(*n))).collect();
        Self::of("lattice", [("size", vector(&size.into())), ("cells", Value::Array(cells))])
    }

    /// Closed triangle mesh from a file (GLB, OBJ, STL, PLY, OFF), in metres, filled with elements;
    /// or a model file (`.thenar`).
    pub fn mesh(file: &str) -> Self {
        Self::of("mesh", [("file", file.into())])
    }

    /// Name in messages, probes and recordings; otherwise its shape and a number.
    pub fn named(mut self, name: &str) -> Self {
        self.entry.put("name", name);
        self
    }

    /// Start position of its frame, world \[m\].
    pub fn at(mut self, position: impl Into<Vec3>) -> Self {
        self.entry.put("position", vector(&position.into()));
        self
    }

    /// Start rotation of its frame.
    pub fn turned(mut self, turn: Quat) -> Self {
        self.entry.put("rotation", rotation(&turn));
        self
    }

    /// Young's modulus \[Pa\].
    pub fn young(self, young: f64) -> Self {
        self.set("material.young", format!("{young:?}"))
    }

    /// Poisson's ratio, below 0.5.
    pub fn poisson(self, poisson: f64) -> Self {
        self.set("material.poisson", format!("{poisson:?}"))
    }

    /// Density \[kg/m³\].
    pub fn density(self, density: f64) -> Self {
        self.set("material.density", format!("{density:?}"))
    }

    /// Coefficient of Coulomb friction; two bodies meet with the geometric mean of theirs.
    pub fn friction(mut self, friction: f64) -> Self {
        self.entry.put("friction", friction);
        self
    }

    /// Any key of `[[soft]]` in a scene file, with a value as it stands there, e.g.
    /// `("stiffness_damping", 0.002)`; dotted keys reach into tables.
    pub fn set(mut self, key: &str, value: impl Display) -> Self {
        self.entry.put_text(key, &value.to_string());
        self
    }
}

impl Sealed for Soft {
    const KEY: &'static str = "soft";

    fn usual_name(&self) -> &str {
        self.kind
    }

    fn into_table(self) -> toml::Table {
        self.entry.0
    }
}

impl Part for Soft {
    type Id = SoftId;

    fn id(place: usize) -> SoftId {
        SoftId(place)
    }
}
