//! What crosses between the haptic loop and the simulation. Plain data of fixed size: the program
//! around moves it through latest-value slots, and neither side ever waits for the other.

use crate::haptic::RigidState;
use crate::haptic::shared::Condensed;

/// A simulation frame, as the haptic loop needs it.
#[derive(Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SlowToFast {
    /// When the frame's inputs were taken \[ns\]; its age counts from here.
    pub time_ns: u64,
    /// Simulation step; a larger one is a newer frame.
    pub step: u64,
    /// The simulated bones.
    pub bones: Vec<RigidState>,
    /// Where they would be in empty air, led by `FastToSlow::free`; empty where nobody knows.
    pub free: Vec<RigidState>,
    /// How they answer until the next frame; without contacts and compliance when it is not used.
    pub response: Condensed,
}

/// Where the proxies are: the targets of the simulated bones.
#[derive(Clone, Debug)]
pub struct FastToSlow {
    /// When \[ns\].
    pub time_ns: u64,
    /// Haptic tick.
    pub tick: u64,
    /// The proxies; `RigidState::target` makes them targets of `world::Input`.
    pub proxies: Vec<RigidState>,
    /// Where they would be if the hand touched nothing: the targets of a simulated hand in empty air.
    pub free: Vec<RigidState>,
}

impl Clone for SlowToFast {
    /// With all of its room.
    fn clone(&self) -> Self {
        let mut free = Vec::with_capacity(self.bones.len());
        free.extend_from_slice(&self.free);
        let (bones, response) = (self.bones.clone(), self.response.clone());
        Self { time_ns: self.time_ns, step: self.step, bones, free, response }
    }
}

impl SlowToFast {
    /// A frame of bones at rest, with room for so many contacts.
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

impl FastToSlow {
    /// Proxies at these states.
    pub fn new(proxies: &[RigidState]) -> Self {
        Self { time_ns: 0, tick: 0, proxies: proxies.to_vec(), free: proxies.to_vec() }
    }

    /// Takes over `other` without allocating; both must be of the same size.
    pub fn copy_from(&mut self, other: &Self) {
        (self.time_ns, self.tick) = (other.time_ns, other.tick);
        self.proxies.copy_from_slice(&other.proxies);
        self.free.copy_from_slice(&other.free);
    }
}
