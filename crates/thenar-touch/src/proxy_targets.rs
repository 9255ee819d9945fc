//! Data that cross from the haptic loop to the simulation; the way back is a
//! [`BoneFrame`](crate::BoneFrame). Plain data of fixed size: the program around moves it through
//! latest-value slots, and neither side ever waits for the other.

use crate::RigidState;

/// States of the proxies: the targets of the simulated bones.
#[derive(Clone, Debug)]
pub struct ProxyTargets {
    /// Time of the tick \[ns\].
    pub time_ns: u64,
    /// Haptic tick.
    pub tick: u64,
    /// The proxies; `RigidState::target` makes them targets of `world::Input`.
    pub proxies: Vec<RigidState>,
    /// States of the proxies if the hand touched nothing: the targets of a simulated hand in empty
    /// air.
    pub free: Vec<RigidState>,
}

impl ProxyTargets {
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
