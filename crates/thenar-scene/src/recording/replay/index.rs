//! Index of places to replay a recording from.

use super::ReplayError;
use super::pace::{LEAP_NS, is_ahead};
use crate::text::plain;
use std::path::Path;
use thenar_record::{ChannelInfo, FrameKind, FramePlace};

/// A frame and its time \[ns\].
#[derive(Clone, Debug)]
pub(super) struct Mark {
    pub time_ns: u64,
    pub place: FramePlace,
    /// Scenes up to it, itself included; they count from 1.
    pub scene: u32,
}

/// Scenes, keyframes and channels of a recording. To find them all of it is read, and no step made.
#[derive(Clone, Debug, Default)]
pub struct Index {
    pub(super) scenes: Vec<Mark>,
    pub(super) keyframes: Vec<Mark>,
    pub(super) channels: Vec<(u64, ChannelInfo)>,
    end_ns: u64,
}

impl Index {
    /// Reads a recording through.
    ///
    /// # Errors
    /// It cannot be opened or read.
    pub fn of(file: &Path) -> Result<Self, ReplayError> {
        let (header, mut frames) = thenar_record::open(file)?;
        let mut index = Self::default();
        while let Some(frame) = frames.next()? {
            let (kind, time_ns) = (frame.kind, frame.time_ns);
            if kind == Some(FrameKind::Channel)
                && let Ok(info) = serde_json::from_slice(frame.body)
            {
                index.channels.push((frames.offset(), info));
            }
            // Other frames may carry another clock.
            if matches!(kind, Some(FrameKind::Scene | FrameKind::Input | FrameKind::Step)) {
                let leaps = time_ns > index.end_ns + LEAP_NS;
                if leaps && is_ahead(&mut frames, time_ns, None, header.simulated_time)? {
                    continue;
                }
                index.end_ns = index.end_ns.max(time_ns);
            }
            let mark = |scene| Mark { time_ns, place: frames.place(), scene };
            match kind {
                Some(FrameKind::Scene) => index.scenes.push(mark(index.scenes.len() as u32 + 1)),
                Some(FrameKind::Keyframe) => index.keyframes.push(mark(index.scenes.len() as u32)),
                _ => {}
            }
        }
        Ok(index)
    }

    /// Time of the last step, or of what entered after it \[s\].
    pub fn end(&self) -> f64 {
        self.end_ns as f64 * 1e-9
    }

    /// Checks that something is there to be replayed from `seconds` on.
    ///
    /// # Errors
    /// The recording ends before; says when.
    pub fn reach(&self, seconds: f64) -> Result<(), ReplayError> {
        // Saturates: what is farther than any time is beyond all of them.
        if (seconds * 1e9).round() as u64 > self.end_ns {
            return Err(ReplayError::Beyond { from: plain(seconds), end: self.end() });
        }
        Ok(())
    }

    /// Times from which a replay can begin \[s\], in order.
    pub fn beginnings(&self) -> Vec<f64> {
        let marks = self.scenes.iter().chain(&self.keyframes);
        let mut times: Vec<f64> = marks.map(|mark| mark.time_ns as f64 * 1e-9).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }

    /// The last scene that begins before `seconds`, or the first, and its last keyframe before
    /// then.
    pub(super) fn before(&self, seconds: f64) -> Option<(&Mark, Option<&Mark>)> {
        let early = |mark: &&Mark| mark.time_ns as f64 * 1e-9 <= seconds;
        let scene = self.scenes.iter().rev().find(early).or(self.scenes.first())?;
        let of_it = |mark: &&Mark| mark.scene == scene.scene;
        Some((scene, self.keyframes.iter().rev().filter(of_it).find(early)))
    }
}
