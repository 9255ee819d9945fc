//! Recordings of tracked hands: one JSON object per line.
//!
//! The first line names the joints; every other line is one sample of one hand:
//!
//! ```text
//! {"format":"hand-joints-jsonl","version":1,"joints":["wrist", ...],"quat":"x,y,z,w"}
//! {"t":0.0112,"hand":"left","pos":[[x,y,z], ...],"quat":[[x,y,z,w], ...],"radius":[ ... ]}
//! ```
//!
//! Times are seconds, positions metres, frames right-handed with +y up. Each joint's frame follows
//! WebXR: -z along the bone away from the wrist, +y out of the back of the hand. Whatever breaks
//! these rules is refused with the file, the line and the cause; nothing is guessed.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use thenar_core::model::Side;
use thenar_core::{Pose, Quat, Vec3};

mod line;

/// The tracked joints of a hand, in the order of this module (WebXR's).
pub const TRACKED_JOINTS: [&str; 25] = [
    "wrist",
    "thumb-metacarpal",
    "thumb-phalanx-proximal",
    "thumb-phalanx-distal",
    "thumb-tip",
    "index-finger-metacarpal",
    "index-finger-phalanx-proximal",
    "index-finger-phalanx-intermediate",
    "index-finger-phalanx-distal",
    "index-finger-tip",
    "middle-finger-metacarpal",
    "middle-finger-phalanx-proximal",
    "middle-finger-phalanx-intermediate",
    "middle-finger-phalanx-distal",
    "middle-finger-tip",
    "ring-finger-metacarpal",
    "ring-finger-phalanx-proximal",
    "ring-finger-phalanx-intermediate",
    "ring-finger-phalanx-distal",
    "ring-finger-tip",
    "pinky-finger-metacarpal",
    "pinky-finger-phalanx-proximal",
    "pinky-finger-phalanx-intermediate",
    "pinky-finger-phalanx-distal",
    "pinky-finger-tip",
];

/// Longest recording \[bytes\].
pub const RECORDING_BYTES_MAX: u64 = 256 << 20;
/// Longest line \[bytes\].
pub const LINE_BYTES_MAX: u64 = 64 << 10;

/// Why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file cannot be read.
    #[error("{file}: {cause}", file = file.display())]
    Read {
        /// File that was read.
        file: PathBuf,
        /// Error of the system.
        cause: std::io::Error,
    },
    /// A line is wrong.
    #[error("{file}:{line}: {cause}", file = file.display())]
    Line {
        /// File that was read.
        file: PathBuf,
        /// Counted from 1.
        line: usize,
        /// Cause in words.
        cause: String,
    },
    /// The file is too long.
    #[error("{file}: longer than {RECORDING_BYTES_MAX} bytes", file = file.display())]
    TooLong {
        /// File that was read.
        file: PathBuf,
    },
}

/// All joints of one hand at one instant: poses in the recording's space, in the order of
/// [`TRACKED_JOINTS`].
#[derive(Clone, Debug, PartialEq)]
pub struct TrackedSample {
    /// Time \[s\].
    pub time: f64,
    /// Joint frames.
    pub joints: [Pose; 25],
}

/// A recording of up to two hands.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    left: Vec<TrackedSample>,
    right: Vec<TrackedSample>,
}

impl Recording {
    /// Reads a file.
    pub fn open(file: &Path) -> Result<Self, RecordingError> {
        let (opened, _) = thenar_input::open_plain(file).map_err(|cause| RecordingError::Read {
            file: file.to_path_buf(),
            cause: cause.into(),
        })?;
        Self::read(BufReader::new(opened), file)
    }

    /// Reads a stream; `file` is named in errors.
    pub fn read(mut reader: impl BufRead, file: &Path) -> Result<Self, RecordingError> {
        let mut text = Vec::new();
        let mut bytes = 0;
        let mut order = None;
        let mut recording = Self::default();
        for line in 1.. {
            let bad = |cause| RecordingError::Line { file: file.to_path_buf(), line, cause };
            text.clear();
            let read = std::io::Read::take(&mut reader, LINE_BYTES_MAX + 1)
                .read_until(b'\n', &mut text)
                .map_err(|cause| RecordingError::Read { file: file.to_path_buf(), cause })?
                as u64;
            bytes += read;
            if read == 0 {
                break;
            }
            if read > LINE_BYTES_MAX {
                return Err(bad(format!("line longer than {LINE_BYTES_MAX} bytes")));
            }
            if bytes > RECORDING_BYTES_MAX {
                return Err(RecordingError::TooLong { file: file.to_path_buf() });
            }
            if text.iter().all(u8::is_ascii_whitespace) {
                continue;
            }
            match &order {
                None => order = Some(line::header(&text).map_err(bad)?),
                Some(order) => {
                    let (side, sample) = line::sample(&text, order).map_err(bad)?;
                    recording.push(side, sample).map_err(bad)?;
                }
            }
        }
        if order.is_none() {
            let cause = "empty: the first line must be the header".into();
            return Err(RecordingError::Line { file: file.to_path_buf(), line: 1, cause });
        }
        Ok(recording)
    }

    /// Samples of one hand, in order of time.
    pub fn hand(&self, side: Side) -> &[TrackedSample] {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }

    /// First and last time of any hand \[s\], if there are samples.
    pub fn span(&self) -> Option<[f64; 2]> {
        let ends = [&self.left, &self.right];
        let first = ends.iter().filter_map(|s| s.first()).map(|s| s.time).reduce(f64::min)?;
        let last = ends.iter().filter_map(|s| s.last()).map(|s| s.time).reduce(f64::max)?;
        Some([first, last])
    }

    /// Adds a sample. Of two at the same time the later line counts.
    fn push(&mut self, side: Side, sample: TrackedSample) -> Result<(), String> {
        let samples = match side {
            Side::Left => &mut self.left,
            Side::Right => &mut self.right,
        };
        match samples.last_mut() {
            Some(last) if sample.time < last.time => {
                Err(format!("time goes back from {} s to {} s", last.time, sample.time))
            }
            Some(last) if sample.time == last.time => {
                *last = sample;
                Ok(())
            }
            _ => {
                samples.push(sample);
                Ok(())
            }
        }
    }
}

/// Joint frames reflected in the plane x = 0, which makes a left hand right. Frames stay
/// right-handed with -z along the bone and +y out of the back.
pub fn mirrored(pose: &Pose) -> Pose {
    let (p, q) = (pose.position, pose.rotation.quaternion());
    let rotation = nalgebra::Quaternion::new(q.w, q.i, -q.j, -q.k);
    Pose::new(Vec3::new(-p.x, p.y, p.z), Quat::new_unchecked(rotation))
}

#[cfg(test)]
mod tests;
