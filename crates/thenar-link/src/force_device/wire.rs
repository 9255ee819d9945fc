//! The two datagrams, little-endian and packed.
//!
//! ```text
//! host to device, 36 bytes                 device to host, 56 bytes
//!  0  u32    seq                            0  u32    seq
//!  4  u64    t     [ns], sender's clock     4  u64    t         [ns], sender's clock
//! 12  f32 x3 force  [N]                    12  f32 x3 position  [m]
//! 24  f32 x3 torque [N m]                  24  f32 x4 rotation  x y z w
//!                                          40  f32 x3 velocity  [m/s]
//!                                          52  u32    buttons, bit 0 the first
//! ```

use crate::joints::{in_reach, rotation};
use thenar_core::{Pose, Vec3};

/// Length of a command.
pub const COMMAND_BYTES: usize = 36;
/// Length of a state.
pub const STATE_BYTES: usize = 56;

/// No handle moves faster \[m/s\].
const SPEED_MAX: f64 = 100.0;

/// Command to the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Number, one more with each.
    pub seq: u32,
    /// The host's clock \[ns\].
    pub time_ns: u64,
    /// In the device's frame \[N\].
    pub force: Vec3,
    /// Torque \[N m\].
    pub torque: Vec3,
}

/// State of the device's handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Number, one more with each.
    pub seq: u32,
    /// The device's clock \[ns\].
    pub time_ns: u64,
    /// In the device's frame.
    pub pose: Pose,
    /// Velocity \[m/s\].
    pub velocity: Vec3,
    /// Bit 0 is the first.
    pub buttons: u32,
}

/// Why a datagram is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WireError {
    /// Another length.
    #[error("a datagram of {got} bytes; expected {expected}")]
    Length {
        /// Length of the message \[bytes\].
        got: usize,
        /// That of its kind.
        expected: usize,
    },
    /// A number that is not finite, or beyond what such a thing can be.
    #[error("{0} is not finite or out of range")]
    Range(&'static str),
}

impl Command {
    /// Packs it.
    pub fn write(&self) -> [u8; COMMAND_BYTES] {
        let mut bytes = [0; COMMAND_BYTES];
        head(&mut bytes, self.seq, self.time_ns);
        floats(&mut bytes[12..], self.force.iter().chain(self.torque.iter()));
        bytes
    }

    /// Reads it, as a device does.
    ///
    /// # Errors
    /// It is none.
    pub fn read(bytes: &[u8]) -> Result<Self, WireError> {
        let (seq, time_ns) = read_head(bytes, COMMAND_BYTES)?;
        let (force, torque) = (vector(bytes, 12), vector(bytes, 24));
        for (what, value) in [("force", force), ("torque", torque)] {
            if !value.norm().is_finite() {
                return Err(WireError::Range(what));
            }
        }
        Ok(Self { seq, time_ns, force, torque })
    }
}

impl State {
    /// Packs it, as a device does.
    pub fn write(&self) -> [u8; STATE_BYTES] {
        let mut bytes = [0; STATE_BYTES];
        head(&mut bytes, self.seq, self.time_ns);
        let (p, q) = (self.pose.position, self.pose.rotation.coords);
        floats(&mut bytes[12..], p.iter().chain(q.iter()).chain(self.velocity.iter()));
        bytes[52..].copy_from_slice(&self.buttons.to_le_bytes());
        bytes
    }

    /// Reads it.
    ///
    /// # Errors
    /// It is none.
    pub fn read(bytes: &[u8]) -> Result<Self, WireError> {
        let (seq, time_ns) = read_head(bytes, STATE_BYTES)?;
        let position = vector(bytes, 12);
        let turn = rotation([24, 28, 32, 36].map(|at| float(bytes, at)));
        let velocity = vector(bytes, 40);
        if !in_reach(&position) {
            return Err(WireError::Range("position"));
        }
        let turn = turn.map_err(|_| WireError::Range("rotation"))?;
        if !(0.0..=SPEED_MAX).contains(&velocity.norm()) {
            return Err(WireError::Range("velocity"));
        }
        let pose = Pose::new(position, turn);
        let buttons = u32::from_le_bytes(take(bytes, 52));
        Ok(Self { seq, time_ns, pose, velocity, buttons })
    }
}

fn head(bytes: &mut [u8], seq: u32, time_ns: u64) {
    bytes[..4].copy_from_slice(&seq.to_le_bytes());
    bytes[4..12].copy_from_slice(&time_ns.to_le_bytes());
}

fn floats<'a>(bytes: &mut [u8], values: impl Iterator<Item = &'a f64>) {
    for (place, value) in bytes.chunks_exact_mut(4).zip(values) {
        place.copy_from_slice(&(*value as f32).to_le_bytes());
    }
}

fn read_head(bytes: &[u8], expected: usize) -> Result<(u32, u64), WireError> {
    if bytes.len() != expected {
        return Err(WireError::Length { got: bytes.len(), expected });
    }
    Ok((u32::from_le_bytes(take(bytes, 0)), u64::from_le_bytes(take(bytes, 4))))
}

/// Lengths have been checked: what is not there would read as zero.
fn take<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes.get(at..).and_then(|rest| rest.first_chunk()).copied().unwrap_or([0; N])
}

fn float(bytes: &[u8], at: usize) -> f64 {
    f64::from(f32::from_le_bytes(take(bytes, at)))
}

fn vector(bytes: &[u8], at: usize) -> Vec3 {
    Vec3::new(float(bytes, at), float(bytes, at + 4), float(bytes, at + 8))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes written by hand from the table above.
    #[test]
    fn bytes_are_where_the_table_says() {
        let command = Command {
            seq: 0x0102_0304,
            time_ns: 0x1112_1314_1516_1718,
            force: Vec3::new(1.0, -2.0, 0.5),
            torque: Vec3::new(0.0, 0.25, -1.0),
        };
        let mut want = vec![4, 3, 2, 1, 0x18, 0x17, 0x16, 0x15, 0x14, 0x13, 0x12, 0x11];
        want.extend([0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0, 0, 0, 0, 0x3f]);
        want.extend([0, 0, 0, 0, 0, 0, 0x80, 0x3e, 0, 0, 0x80, 0xbf]);
        assert_eq!(command.write()[..], want[..]);
        assert_eq!(Command::read(&want), Ok(command));

        let mut bytes = vec![7, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0];
        bytes.extend([0, 0, 0x80, 0x3f, 0, 0, 0, 0x40, 0, 0, 0x40, 0x40]);
        bytes.extend([0, 0, 0, 0, 0, 0, 0x80, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0]);
        bytes.extend([0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x3f, 5, 0, 0, 0]);
        let state = State::read(&bytes).unwrap();
        assert_eq!((state.seq, state.time_ns, state.buttons), (7, 9, 5));
        assert_eq!(state.pose.position, Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(state.velocity, Vec3::new(0.0, 0.0, 0.5));
        assert!((state.pose.vector(&Vec3::x()) + Vec3::x()).norm() < 1e-12, "half a turn about y");
        assert_eq!(state.write()[..], bytes[..]);
    }

    #[test]
    fn what_is_no_state_is_refused() {
        let good = State {
            seq: 1,
            time_ns: 2,
            pose: Pose::identity(),
            velocity: Vec3::zeros(),
            buttons: 0,
        };
        for length in (0..200).filter(|length| *length != STATE_BYTES) {
            let error = State::read(&vec![0; length]).unwrap_err();
            assert_eq!(error, WireError::Length { got: length, expected: STATE_BYTES });
        }
        for (at, what) in (12..52).map(|at| (at, ["position", "rotation", "velocity"])) {
            let what = what[if at < 24 { 0 } else { usize::from(at >= 40) + 1 }];
            for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38] {
                let mut bytes = good.write();
                let at = at / 4 * 4;
                bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
                assert_eq!(State::read(&bytes), Err(WireError::Range(what)), "{at} {value}");
            }
        }
    }
}
