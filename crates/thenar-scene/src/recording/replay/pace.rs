//! Checks of the number and the time that a frame carries. Checksums tell what a disk has done to a
//! file; these tell what somebody has written into one, checksums included.
//!
//! Simulated time is the sum of the steps' times, so that every time in a run as fast as it can be
//! is known beforehand. By a clock on the wall times rise, and a frame that leaps ahead of those
//! behind it is found by looking at these.

use super::item::DecodedFrame;
use super::trust::Trust;
use super::{Replay, ReplayError};
use std::io::{self, Read, Seek};
use thenar_record::{Frame, FrameKind, Frames};

/// More steps than this are not made without a mark: at 1 kHz a disk that stands still for a
/// quarter of an hour.
pub const UNMARKED_MAX: u64 = 1_000_000;
/// No step is shorter, by either clock: the least time step of a scene \[ns\].
const STEP_NS_MIN: u64 = 100;
/// Leap of a session in time \[ns\], and below in steps, beyond which the frames behind are looked
/// at.
pub const LEAP_NS: u64 = 1_000_000_000;
const LEAP_STEPS: u64 = 1000;

/// Progress of the session's frames.
#[derive(Clone, Copy, Debug)]
pub struct FrameProgress {
    /// Time of the newest frame \[ns\].
    pub newest_ns: u64,
    /// Simulated time as it was summed up while recording \[s\]; `None` where it is not known.
    simulated: Option<f64>,
    /// Uncertainty of `simulated`, which was read from a frame \[ns\].
    slack_ns: u64,
}

impl FrameProgress {
    /// At the beginning of a recording.
    pub fn start(simulated_time: bool) -> Self {
        Self { newest_ns: 0, simulated: simulated_time.then_some(0.0), slack_ns: 0 }
    }

    /// At a frame from which a replay goes on.
    pub fn at(newest_ns: u64) -> Self {
        Self { newest_ns, simulated: None, slack_ns: 0 }
    }

    /// Takes in a step of `h` \[s\].
    pub fn step(&mut self, h: f64) {
        self.simulated = self.simulated.map(|t| t + h);
    }

    /// Takes in a frame that is trusted.
    pub fn note(&mut self, time_ns: u64) {
        self.newest_ns = time_ns;
    }

    /// Something may have been missed: only what frames say is known.
    pub fn lose(&mut self) {
        self.simulated = None;
    }

    /// The session is known again, at a frame of this time \[ns\].
    pub fn find(&mut self, time_ns: u64, simulated_time: bool) {
        // What was read once is read again at every frame, so that roundings do not add up.
        if simulated_time && (self.simulated.is_none() || self.slack_ns > 0) {
            (self.simulated, self.slack_ns) = (Some(time_ns as f64 * 1e-9), 2);
        }
    }

    /// True if a frame can be `steps` steps of `h` \[s\] after what is known.
    fn allows(&self, time_ns: u64, steps: u64, h: f64) -> bool {
        let Some(passed_ns) = time_ns.checked_sub(self.newest_ns) else { return false };
        if steps > passed_ns / STEP_NS_MIN + 1 {
            return false;
        }
        let Some(mut simulated) = self.simulated else { return true };
        // Summed up as it was while recording; `UNMARKED_MAX` steps take a few milliseconds.
        (0..steps.min(UNMARKED_MAX)).for_each(|_| simulated += h);
        let expected = (simulated * 1e9).round() as u64;
        // A sum of n numbers is off by n roundings at most.
        let rounding = steps as f64 * simulated * f64::EPSILON * 1e9;
        let slack = if self.slack_ns == 0 { 0 } else { self.slack_ns + rounding as u64 };
        expected.abs_diff(time_ns) <= slack
    }
}

/// Time and number of steps of a session's frame; the number is `None` where it begins anew.
fn of_session(frame: &Frame) -> Option<(u64, Option<u64>)> {
    let number = match frame.kind? {
        FrameKind::Scene => None,
        FrameKind::Input | FrameKind::Step | FrameKind::Keyframe => {
            DecodedFrame::of(frame)?.number()
        }
        _ => return None,
    };
    Some((frame.time_ns, number))
}

/// True if the frame that was read last, of this time and number, is ahead of those behind it.
pub fn is_ahead<R: Read + Seek>(
    frames: &mut Frames<R>,
    time_ns: u64,
    number: Option<u64>,
    simulated_time: bool,
) -> io::Result<bool> {
    let behind = frames.look_ahead(|frame| match frame.kind {
        // The end carries the time of the clock on the wall.
        Some(FrameKind::End) if !simulated_time => Some((frame.time_ns, None)),
        _ => of_session(frame),
    })?;
    let Some((next_ns, next)) = behind else { return Ok(false) };
    Ok(next_ns < time_ns || next.zip(number).is_some_and(|(next, number)| next < number))
}

impl Replay {
    /// True if a frame that was just read cannot be the session's next. What comes after damage is
    /// judged less strictly: any part of the session may be missing.
    pub(super) fn is_impossible(
        &mut self,
        time_ns: u64,
        item: &DecodedFrame,
    ) -> Result<bool, ReplayError> {
        let number = item.number();
        if number.is_none() && !matches!(item, DecodedFrame::Scene(_)) {
            return Ok(false);
        }
        let sound = self.trust == Trust::Sound;
        let steps = match number.map(|number| number.checked_sub(self.number)) {
            // Without a scene its number says nothing.
            _ if self.session.is_none() => 0,
            None => 0,
            Some(Some(steps)) => steps,
            Some(None) => return Ok(sound),
        };
        let h = self.session.as_ref().map_or(0.0, |session| session.world().time_step());
        if !self.pace.allows(time_ns, steps, h) || (sound && steps > UNMARKED_MAX) {
            return Ok(true);
        }
        let leaps = time_ns - self.pace.newest_ns > LEAP_NS || steps > LEAP_STEPS;
        let simulated_time = self.header.simulated_time;
        Ok(leaps && is_ahead(&mut self.frames, time_ns, number, simulated_time)?)
    }
}
