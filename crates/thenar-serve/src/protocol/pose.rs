//! Pose messages, strictly read: what does not fit the protocol is refused, never repaired.

use super::{VERSION, kind};
use thenar_core::model::Side;
use thenar_core::{Pose, Quat, Vec3};
use thenar_scene::text::plain;

/// Length of a message with 25 joints.
pub const JOINTS_BYTES: usize = 16 + 25 * 8 * 4;
/// Length of a message with a wrist and 20 angles.
pub const ANGLES_BYTES: usize = 16 + (7 + 20) * 4;
/// Length of the message that a hand is not tracked any more.
pub const LOST_BYTES: usize = 16;

/// Nothing tracked is farther from the origin \[m\].
const FAR: f64 = 10.0;
/// Nothing of a hand is thicker \[m\].
const THICK: f64 = 0.5;
/// Most that the length of a quaternion may differ from one.
const UNIT_TOLERANCE: f64 = 0.02;

/// A pose message.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseMessage {
    /// Side of the hand.
    pub side: Side,
    /// The client's number of the message, from 1.
    pub number: u32,
    /// The client's clock \[s\].
    pub clock: f64,
    /// Contents of the message.
    pub body: PoseBody,
}

/// Contents of a pose message.
#[derive(Clone, Debug, PartialEq)]
pub enum PoseBody {
    /// The joints of WebXR Hand Input.
    Joints {
        /// In the world.
        poses: Box<[Pose; 25]>,
        /// Radii \[m\].
        radii: Box<[f64; 25]>,
    },
    /// The wrist in the world, and our angles \[rad\].
    Angles {
        /// Pose of the wrist.
        wrist: Pose,
        /// For each finger, thumb first: base flexion, base spread, second and third flexion.
        angles: Box<[f64; 20]>,
    },
    /// The hand is not tracked any more.
    Lost,
}

/// Why a pose message is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// Too short for any message, or not of the length of its kind.
    #[error("a pose message of {got} bytes; this kind has {expected}")]
    Length {
        /// Length of the message.
        got: usize,
        /// Length of its kind.
        expected: usize,
    },
    /// No such kind.
    #[error("binary message of kind {0}; expected 16, 17 or 18")]
    Kind(u8),
    /// Another protocol.
    #[error("protocol version {0}; this server speaks version {VERSION}: reload the page")]
    Version(u8),
    /// Neither left nor right.
    #[error("hand {0}; expected 0 (left) or 1 (right)")]
    Hand(u8),
    /// A byte that must be zero is not.
    #[error("byte 3 of a pose message is {0}; it must be 0")]
    Padding(u8),
    /// Messages are numbered from 1.
    #[error("pose messages are numbered from 1, not 0")]
    Number,
    /// A number that is none.
    #[error("{0} is not finite")]
    NotFinite(&'static str),
    /// Out of reach.
    #[error("{what} is {}, beyond {limit}", plain(*.value))]
    Range {
        /// Part of the message that is wrong.
        what: &'static str,
        /// Value that was sent.
        value: f64,
        /// The largest that is taken.
        limit: f64,
    },
    /// A rotation that is none.
    #[error("a quaternion has length {0}; it must be 1")]
    Quaternion(f64),
}

impl PoseMessage {
    /// Reads a message.
    ///
    /// # Errors
    /// It is not one of the protocol's pose messages.
    pub fn read(bytes: &[u8]) -> Result<Self, PoseError> {
        let got = bytes.len();
        if got < LOST_BYTES {
            return Err(PoseError::Length { got, expected: LOST_BYTES });
        }
        let expected = match bytes[0] {
            kind::JOINTS => JOINTS_BYTES,
            kind::ANGLES => ANGLES_BYTES,
            kind::LOST => LOST_BYTES,
            other => return Err(PoseError::Kind(other)),
        };
        if bytes[1] != VERSION {
            return Err(PoseError::Version(bytes[1]));
        }
        if got != expected {
            return Err(PoseError::Length { got, expected });
        }
        let side = match bytes[2] {
            0 => Side::Left,
            1 => Side::Right,
            other => return Err(PoseError::Hand(other)),
        };
        if bytes[3] != 0 {
            return Err(PoseError::Padding(bytes[3]));
        }
        let mut rest = Reader(&bytes[4..]);
        let number = rest.u32();
        if number == 0 {
            return Err(PoseError::Number);
        }
        let clock = rest.f64();
        if !clock.is_finite() {
            return Err(PoseError::NotFinite("the clock"));
        }
        let body = match bytes[0] {
            kind::JOINTS => joints(&mut rest)?,
            kind::ANGLES => angles(&mut rest)?,
            _ => PoseBody::Lost,
        };
        Ok(Self { side, number, clock, body })
    }
}

fn joints(rest: &mut Reader) -> Result<PoseBody, PoseError> {
    let mut poses = Box::new([Pose::identity(); 25]);
    let mut radii = Box::new([0.0; 25]);
    for (pose, radius) in poses.iter_mut().zip(radii.iter_mut()) {
        *pose = rest.pose()?;
        *radius = rest.within("a radius", THICK)?;
        if *radius < 0.0 {
            return Err(PoseError::Range { what: "a radius", value: *radius, limit: 0.0 });
        }
    }
    Ok(PoseBody::Joints { poses, radii })
}

fn angles(rest: &mut Reader) -> Result<PoseBody, PoseError> {
    let wrist = rest.pose()?;
    let mut angles = Box::new([0.0; 20]);
    for angle in angles.iter_mut() {
        *angle = rest.within("an angle", std::f64::consts::TAU)?;
    }
    Ok(PoseBody::Angles { wrist, angles })
}

/// Takes numbers off the front. The length has been checked: what is not there reads as zero.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let Some((first, rest)) = self.0.split_first_chunk::<N>() else { return [0; N] };
        self.0 = rest;
        *first
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn f64(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }

    /// A number of this size at most.
    fn within(&mut self, what: &'static str, limit: f64) -> Result<f64, PoseError> {
        let value = f64::from(f32::from_le_bytes(self.take()));
        if !value.is_finite() {
            return Err(PoseError::NotFinite(what));
        }
        if value.abs() > limit {
            return Err(PoseError::Range { what, value, limit });
        }
        Ok(value)
    }

    fn pose(&mut self) -> Result<Pose, PoseError> {
        let mut number = |what, limit| self.within(what, limit);
        let x =
            [number("a position", FAR)?, number("a position", FAR)?, number("a position", FAR)?];
        let q = [
            number("a quaternion", 2.0)?,
            number("a quaternion", 2.0)?,
            number("a quaternion", 2.0)?,
            number("a quaternion", 2.0)?,
        ];
        let position = Vec3::from(x);
        if position.norm() > FAR {
            let value = position.norm();
            return Err(PoseError::Range { what: "a position", value, limit: FAR });
        }
        let quaternion = nalgebra::Quaternion::new(q[3], q[0], q[1], q[2]);
        let length = quaternion.norm();
        if (length - 1.0).abs() > UNIT_TOLERANCE {
            return Err(PoseError::Quaternion(length));
        }
        Ok(Pose::new(position, Quat::new_normalize(quaternion)))
    }
}
