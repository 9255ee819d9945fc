//! Payload of one step: bones, and their response until the next frame. Plain data of fixed size:
//! the program around moves it through latest-value slots, and neither side ever waits for the
//! other.

use super::{Condensed, RigidState};

/// A simulation frame, as the haptic loop needs it.
#[derive(Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoneFrame {
    /// Time at which the frame's inputs were taken \[ns\]; its age counts from here.
    pub time_ns: u64,
    /// Simulation step; a larger one is a newer frame.
    pub step: u64,
    /// The simulated bones.
    pub bones: Vec<RigidState>,
    /// Bones as they would be in empty air, led by `ProxyTargets::free`; empty where unknown.
    pub free: Vec<RigidState>,
    /// Response until the next frame; without contacts and compliance when it is not used.
    pub response: Condensed,
}

impl Clone for BoneFrame {
    /// With all of its room.
    fn clone(&self) -> Self {
        let mut free = Vec::with_capacity(self.bones.len());
        free.extend_from_slice(&self.free);
        let (bones, response) = (self.bones.clone(), self.response.clone());
        Self { time_ns: self.time_ns, step: self.step, bones, free, response }
    }
}

impl BoneFrame {
    /// A frame of bones at rest, with room for `contacts_max` contacts.
    pub fn new(bones: &[RigidState], contacts_max: usize) -> Self {
        Self {
            time_ns: 0,
            step: 0,
            bones: bones.to_vec(),
            free: Vec::with_capacity(bones.len()),
            response: Condensed::new(bones.len(), contacts_max),
        }
    }

    /// Takes over `other` without allocating; both must be of the same size.
    pub fn copy_from(&mut self, other: &Self) {
        (self.time_ns, self.step) = (other.time_ns, other.step);
        self.bones.copy_from_slice(&other.bones);
        self.free.clone_from(&other.free);
        self.response.copy_from(&other.response);
    }
}
