//! Hands of an OpenXR runtime (`XR_EXT_hand_tracking`), without a picture (`XR_MND_headless`).
//!
//! An optional part: the cargo feature `openxr`. The loader is a library of the system that is
//! looked for when the device is opened; nothing of it is needed to build. What the runtime tells
//! is written as bytes and read by a protocol like that of any device, so that all of it but the
//! calls themselves is tested without a runtime.

mod runtime;

use crate::joints::{OPENXR_JOINTS, in_reach, rotation, webxr_of_openxr};
use crate::profile::camera_timing;
use crate::worker::Device;
use crate::{Driver, Event, FoundDevice, HandSample, LinkError, Opened, Protocol, Transport};
use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use thenar_core::model::Side;
use thenar_core::{Pose, Vec3};
use thenar_track::live::LivePose;

/// Shipped profile.
const SHIPPED: &str = include_str!("../../profiles/openxr.toml");
/// Between two questions to the runtime: it tells where hands are at any time.
const PERIOD: Duration = Duration::from_millis(4);
/// Bytes of a joint: flags, place, rotation and radius.
const JOINT_BYTES: usize = 1 + 8 * 4;
/// Bytes of a hand: which, whether it is seen, and its joints.
const HAND_BYTES: usize = 2 + OPENXR_JOINTS * JOINT_BYTES;

/// First byte of a message, which distinguishes it from hands.
const NOTE: u8 = b'n';
/// Between two attempts to open a runtime: a loader that finds none says so on the error stream
/// each time, and some runtimes start a program.
const ATTEMPTS: Duration = Duration::from_secs(3);

/// A joint as a runtime tells it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Joint {
    /// Place and rotation are known.
    pub valid: bool,
    /// Position \[m\].
    pub position: [f32; 3],
    /// x y z w
    pub rotation: [f32; 4],
    /// Radius \[m\].
    pub radius: f32,
}

/// The left and the right hand; `None` for one that is not seen.
pub type HandJoints = [Option<[Joint; OPENXR_JOINTS]>; 2];

/// A runtime with a session.
pub trait Runtime: Send {
    /// The hands now; `None` while the session does not run, as with a headset that nobody wears.
    ///
    /// # Errors
    /// The session has ended.
    fn hands(&mut self) -> io::Result<Option<HandJoints>>;

    /// Takes the pending message for a person, if any.
    fn note(&mut self) -> Option<&'static str> {
        None
    }
}

/// Asks a runtime now and then.
pub struct RuntimeTransport<R> {
    runtime: R,
    asked: Option<Instant>,
    /// The session ran when it was last asked.
    ran: bool,
}

impl<R: Runtime> RuntimeTransport<R> {
    /// Asks this one.
    pub fn new(runtime: R) -> Self {
        Self { runtime, asked: None, ran: false }
    }
}

impl<R: Runtime> Transport for RuntimeTransport<R> {
    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        if let Some(note) = self.runtime.note() {
            return Ok(write_note(buffer, note));
        }
        let left = self.asked.map_or(Duration::ZERO, |at| PERIOD.saturating_sub(at.elapsed()));
        std::thread::sleep(left.min(timeout));
        if left > timeout {
            return Ok(0);
        }
        self.asked = Some(Instant::now());
        let hands = self.runtime.hands()?;
        // Hands are lost when the session stops; after that it is silent.
        if !std::mem::replace(&mut self.ran, hands.is_some()) && hands.is_none() {
            return Ok(0);
        }
        let mut bytes = buffer;
        let mut length = 0;
        for (side, hand) in hands.unwrap_or_default().iter().enumerate() {
            let Some((place, rest)) = bytes.split_at_mut_checked(HAND_BYTES) else { break };
            write(place, side as u8, hand.as_ref());
            (bytes, length) = (rest, length + HAND_BYTES);
        }
        Ok(length)
    }

    fn send(&mut self, _: &[u8]) -> io::Result<()> {
        Ok(())
    }
}

/// Writes a message; returns its length.
fn write_note(place: &mut [u8], note: &str) -> usize {
    let bytes = std::iter::once(&NOTE).chain(note.as_bytes());
    place.iter_mut().zip(bytes).map(|(place, byte)| *place = *byte).count()
}

/// Writes a hand into `HAND_BYTES`.
fn write(place: &mut [u8], side: u8, hand: Option<&[Joint; OPENXR_JOINTS]>) {
    place.fill(0);
    (place[0], place[1]) = (side, u8::from(hand.is_some()));
    let Some(joints) = hand else { return };
    for (place, joint) in place[2..].chunks_exact_mut(JOINT_BYTES).zip(joints) {
        place[0] = u8::from(joint.valid);
        let numbers = joint.position.iter().chain(&joint.rotation).chain([&joint.radius]);
        for (place, number) in place[1..].chunks_exact_mut(4).zip(numbers) {
            place.copy_from_slice(&number.to_le_bytes());
        }
    }
}

/// Reads what the transport wrote.
#[derive(Clone, Copy, Debug, Default)]
pub struct OpenXrHands {
    /// True for each hand that was seen when it was last reported.
    seen: [bool; 2],
}

impl Protocol for OpenXrHands {
    fn start(&mut self, _: u64, _: &mut dyn FnMut(&[u8])) {
        self.seen = [false; 2];
    }

    fn receive(
        &mut self,
        now_ns: u64,
        bytes: &[u8],
        event: &mut dyn FnMut(Event),
        _: &mut dyn FnMut(&[u8]),
    ) {
        if let [NOTE, note @ ..] = bytes {
            return event(Event::Note(String::from_utf8_lossy(note).into_owned()));
        }
        for hand in bytes.chunks(HAND_BYTES) {
            let side = match (hand.len(), hand[0]) {
                (HAND_BYTES, 0) => Side::Left,
                (HAND_BYTES, 1) => Side::Right,
                _ => return event(Event::Refused("this is not a hand of a runtime".into())),
            };
            let pose = match hand[1] {
                0 => Ok(None),
                _ => read(&hand[2..]),
            };
            match pose {
                Ok(pose) => {
                    // A hand that stays away is told of once.
                    let told = std::mem::replace(&mut self.seen[side as usize], pose.is_some());
                    event(match told || pose.is_some() {
                        true => Event::Sample(HandSample { side, time_ns: now_ns, pose }),
                        false => Event::Alive,
                    });
                }
                Err(cause) => event(Event::Refused(cause.into())),
            }
        }
    }
}

/// A hand, not seen where any of our joints is not.
fn read(bytes: &[u8]) -> Result<Option<LivePose>, &'static str> {
    let mut joints = [(false, Pose::identity(), 0.0); OPENXR_JOINTS];
    for (joint, bytes) in joints.iter_mut().zip(bytes.chunks_exact(JOINT_BYTES)) {
        let mut numbers = [0.0; 8];
        for (number, bytes) in numbers.iter_mut().zip(bytes[1..].chunks_exact(4)) {
            *number = bytes.first_chunk().map_or(0.0, |b| f64::from(f32::from_le_bytes(*b)));
        }
        let [x, y, z, a, b, c, w, radius] = numbers;
        if bytes[0] == 0 {
            continue;
        }
        let place = Vec3::new(x, y, z);
        let turn = rotation([a, b, c, w]).map_err(|_| "a rotation of the runtime is none")?;
        if !in_reach(&place) || !(0.0..=0.5).contains(&radius) {
            return Err("a joint of the runtime is out of reach");
        }
        *joint = (true, Pose::new(place, turn), radius);
    }
    let ours = webxr_of_openxr(&joints);
    Ok(ours.iter().all(|(valid, ..)| *valid).then(|| LivePose::Joints {
        joints: ours.map(|(_, pose, _)| pose),
        radii: ours.map(|(.., radius)| radius),
    }))
}

/// Driver of addresses `openxr:`.
pub struct OpenXrDriver;

impl Driver for OpenXrDriver {
    fn name(&self) -> &'static str {
        "openxr"
    }

    fn about(&self) -> &'static str {
        "hand tracking of the OpenXR runtime that is active on this computer: openxr:, or openxr:PATH \
         with another loader than the system's"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        Vec::new()
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        let loader = (!address.is_empty()).then(|| PathBuf::from(address));
        if let Some(path) = loader.as_ref().filter(|path| !path.is_absolute()) {
            let what = format!("device `openxr:{address}`");
            let cause =
                format!("expected nothing or the loader's full path, not {}", path.display());
            return Err(LinkError::Setting { what, cause });
        }
        let mut failed: Option<(Instant, io::ErrorKind, String)> = None;
        let connect = move || -> io::Result<Box<dyn Transport>> {
            if let Some((at, kind, cause)) = &failed
                && at.elapsed() < ATTEMPTS
            {
                return Err(io::Error::new(*kind, cause.clone()));
            }
            let opened = runtime::Session::open(loader.as_deref());
            failed = opened.as_ref().err().map(|e| (Instant::now(), e.kind(), e.to_string()));
            Ok(Box::new(RuntimeTransport::new(opened?)))
        };
        let name = if address.is_empty() { "openxr".into() } else { format!("openxr:{address}") };
        let protocol = OpenXrHands::default();
        let timing = camera_timing(self.name(), SHIPPED, None)?;
        Device::tracker(name, Box::new(connect), Box::new(protocol)).timed(timing).open()
    }
}

#[cfg(test)]
mod tests;
