//! Hands of a scene.

use crate::entry::{Entry, rotation, vector};
use crate::scene::{Part, Sealed};
use crate::{Coupling, Drive, Grip, HandId, drive};
use std::fmt::Display;
use thenar_core::{Quat, Vec3};
use toml::Value;

/// A hand to be added to a scene: 16 bones, 15 joints and flesh, which follows the poses that it is
/// given, or holds its start pose. Its model frame has +y along the fingers, flat at the start,
/// with the wrist at the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Hand(Entry);

impl Hand {
    fn of(model: &str) -> Self {
        let mut entry = Entry::new();
        entry.put("model", model);
        Self(entry)
    }

    /// Right hand that comes with the program.
    pub fn right() -> Self {
        Self::of("right")
    }

    /// Left hand that comes with the program.
    pub fn left() -> Self {
        Self::of("left")
    }

    /// Hand from a rigged mesh (`.glb`), or a model file (`.thenar`) as `thenar build` writes it.
    pub fn from_file(file: &str) -> Self {
        Self::of(file)
    }

    /// The paper's hand: 600 tetrahedra, springs on all flesh. Several times faster than the usual
    /// one, whose pads and joints are as soft as people's.
    pub fn paper(mut self) -> Self {
        self.0.put("preset", "paper");
        self
    }

    /// Name in messages, probes and recordings; otherwise `hand` and a number.
    pub fn named(mut self, name: &str) -> Self {
        self.0.put("name", name);
        self
    }

    /// Start position of its model frame, world \[m\].
    pub fn at(mut self, position: impl Into<Vec3>) -> Self {
        self.0.put("position", vector(&position.into()));
        self
    }

    /// Start rotation of its model frame.
    pub fn turned(mut self, turn: Quat) -> Self {
        self.0.put("rotation", rotation(&turn));
        self
    }

    /// Length from wrist to middle fingertip \[m\]; otherwise as the mesh has it.
    pub fn length(mut self, length: f64) -> Self {
        self.0.put("length", length);
        self
    }

    /// Fineness of the flesh's mesh: 1 has cubes of 4 mm at the pads, and edges go with its
    /// inverse.
    pub fn detail(mut self, detail: f64) -> Self {
        self.0.put("detail", detail);
        self
    }

    /// Springs between flesh and bones.
    pub fn coupling(mut self, coupling: Coupling) -> Self {
        coupling.put(&mut self.0);
        self
    }

    /// Drives that lead the palm and all other bones to their targets.
    pub fn drives(mut self, palm: Drive, bones: Drive) -> Self {
        self.0.put("palm_drive", drive::table(&palm));
        self.0.put("bone_drive", drive::table(&bones));
        self
    }

    /// Coefficient of Coulomb friction of the skin; otherwise the model's.
    pub fn friction(mut self, friction: f64) -> Self {
        self.0.put("friction", friction);
        self
    }

    /// Plans a grip; may be given several times, in the order of their times.
    pub fn grip(mut self, grip: Grip) -> Self {
        let grips = self.0.0.entry("grip").or_insert_with(|| Value::Array(Vec::new()));
        if let Value::Array(grips) = grips {
            grips.push(grip.table());
        }
        self
    }

    /// Any key of `[[hand]]` in a scene file, with a value as it stands there, e.g.
    /// `("tissue", "layered")`; dotted keys reach into tables.
    pub fn set(mut self, key: &str, value: impl Display) -> Self {
        self.0.put_text(key, &value.to_string());
        self
    }
}

impl Sealed for Hand {
    const KEY: &'static str = "hand";

    fn usual_name(&self) -> &str {
        "hand"
    }

    fn into_table(self) -> toml::Table {
        self.0.0
    }
}

impl Part for Hand {
    type Id = HandId;

    fn id(place: usize) -> HandId {
        HandId(place)
    }
}
