//! Simulated devices, byte for byte: for trying everything without hardware, and for tests.

pub mod hand;
mod network;
#[cfg(unix)]
mod pty;
mod simulation;

#[cfg(unix)]
pub use pty::PtyTwin;
pub use simulation::{SIMULATIONS, SimulatedDevice, Simulation};

/// A device's firmware, hand and actuators. Pure: bytes and time in, bytes out.
pub trait Twin: Send {
    /// Power comes. What the actuators hold is kept: they may have a supply of their own.
    fn power_on(&mut self, now_ns: u64);

    /// Time passes, and these bytes come from the host.
    fn step(&mut self, now_ns: u64, received: &[u8], send: &mut dyn FnMut(&[u8]));

    /// The wearer moves: each finger's curl, 0 open to 1 closed, thumb first. Devices with more
    /// sensors move those along.
    fn set_curls(&mut self, curls: [f64; 5]);

    /// Sensation at each finger of the wearer, 0 for nothing to 1 for the most it can; zeros for a
    /// device without actuators.
    fn felt(&self) -> [f64; 5];
}
