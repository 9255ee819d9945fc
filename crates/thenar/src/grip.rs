//! Grips that a scene plans.

use crate::entry::Entry;
use thenar_scene::grip::GripKind;

/// A grip in the plan of a hand: pads find places on an object, close on it and hold it with a
/// force.
#[derive(Clone, Debug, PartialEq)]
pub struct Grip(Entry);

impl Grip {
    /// A grip of the object with this name, as soon as the simulation begins.
    pub fn of(object: &str, kind: GripKind) -> Self {
        let mut entry = Entry::new();
        entry.put("object", object);
        entry.put("kind", kind.name());
        entry.put("at", 0.0);
        Self(entry)
    }

    /// Time at which the fingers set out \[s\].
    pub fn at(mut self, time: f64) -> Self {
        self.0.put("at", time);
        self
    }

    /// Time at which they open \[s\]; never, otherwise.
    pub fn until(mut self, time: f64) -> Self {
        self.0.put("open", time);
        self
    }

    /// Force with which the two sides press against each other \[N\]; otherwise twice what keeps
    /// the object from slipping.
    pub fn force(mut self, force: f64) -> Self {
        self.0.put("force", force);
        self
    }

    pub(crate) fn table(&self) -> toml::Value {
        toml::Value::Table(self.0.0.clone())
    }
}
