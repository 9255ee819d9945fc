//! Springs of a hand: those that lead its bones, and those that hold its flesh.

use crate::entry::Entry;
pub use thenar_core::model::Drive;
use toml::Value;

/// A drive as a table of a scene file.
pub(crate) fn table(drive: &Drive) -> Value {
    let mut entry = Entry::new();
    entry.put("stiffness", drive.stiffness);
    entry.put("damping", drive.damping);
    entry.put("angular_stiffness", drive.angular_stiffness);
    entry.put("angular_damping", drive.angular_damping);
    Value::Table(entry.0)
}

/// Springs between flesh and bones (Eq. 7 to 9 of the paper).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// True: springs hold all flesh, skin and pads included, as in the paper. False: flesh in the
    /// place of bone, and what lies between bone and skin is free.
    pub uniform: bool,
    /// Springs per volume of what they hold \[N/m⁴\]; `None` leaves that to the hand's own flesh
    /// and length.
    pub stiffness: Option<f64>,
    /// Damping time of the springs \[s\].
    pub damping_time: f64,
}

impl Default for Coupling {
    /// Springs in bone, as stiff as the hand's flesh asks.
    fn default() -> Self {
        Self {
            uniform: false,
            stiffness: None,
            damping_time: thenar_core::model::Coupling::DAMPING_TIME,
        }
    }
}

impl Coupling {
    /// The paper's: springs on all flesh.
    pub fn uniform() -> Self {
        Self { uniform: true, ..Self::default() }
    }

    /// Writes the keys of a hand.
    pub(crate) fn put(&self, hand: &mut Entry) {
        hand.put("coupling", if self.uniform { "uniform" } else { "bone" });
        match self.stiffness {
            Some(stiffness) => hand.put("coupling_stiffness", stiffness),
            None => hand.take("coupling_stiffness"),
        }
        hand.put("coupling_damping_time", self.damping_time);
    }
}
