//! A simulated arm: a handle of some mass that a wearer holds, and the bridge's watchdog.

use super::wire::{Command, State, WireError};
use thenar_core::{Pose, Vec3};

/// Without a command for so long the arm is let go \[ns\].
pub const WATCHDOG_NS: u64 = 20_000_000;

/// The arm and its bridge. Pure: time and datagrams in, datagrams out.
#[derive(Clone, Debug)]
pub struct SimulatedArm {
    /// Pose of the handle.
    pub pose: Pose,
    /// Pressed buttons, bit 0 the first.
    pub buttons: u32,
    seq: u32,
    /// Newest command, and when it came.
    command: Option<(Command, u64)>,
    /// Time and position of the handle in the last state.
    last: Option<(u64, Vec3)>,
}

impl SimulatedArm {
    /// At rest at its origin.
    pub fn new() -> Self {
        Self { pose: Pose::identity(), buttons: 0, seq: 0, command: None, last: None }
    }

    /// Takes a datagram from the host. Commands that are overtaken are left out.
    ///
    /// # Errors
    /// It is no command.
    pub fn receive(&mut self, now_ns: u64, bytes: &[u8]) -> Result<(), WireError> {
        let command = Command::read(bytes)?;
        let fresh = |(last, at): &(Command, u64)| {
            now_ns.saturating_sub(*at) > WATCHDOG_NS
                || command.seq.wrapping_sub(last.seq) as i32 > 0
        };
        if self.command.as_ref().is_none_or(fresh) {
            self.command = Some((command, now_ns));
        }
        Ok(())
    }

    /// The force that its motors give now, device frame \[N\]; none when the host is silent.
    pub fn force(&self, now_ns: u64) -> Vec3 {
        match &self.command {
            Some((command, at)) if now_ns.saturating_sub(*at) <= WATCHDOG_NS => command.force,
            _ => Vec3::zeros(),
        }
    }

    /// The next state for the host.
    pub fn state(&mut self, now_ns: u64) -> [u8; super::wire::STATE_BYTES] {
        let position = self.pose.position;
        let (before, from) = self.last.replace((now_ns, position)).unwrap_or((now_ns, position));
        let dt = now_ns.saturating_sub(before) as f64 * 1e-9;
        let velocity = if dt > 0.0 { (position - from) / dt } else { Vec3::zeros() };
        let state = State {
            seq: self.seq,
            time_ns: now_ns,
            pose: self.pose,
            velocity,
            buttons: self.buttons,
        };
        self.seq = self.seq.wrapping_add(1);
        state.write()
    }
}

impl Default for SimulatedArm {
    fn default() -> Self {
        Self::new()
    }
}
