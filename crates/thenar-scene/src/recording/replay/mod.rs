//! Makes a recorded session again, event by event.

mod error;
mod event;
mod index;
mod item;
mod keyframe;
mod pace;
mod seek;
mod step;
mod trust;

pub use error::ReplayError;
pub use event::Event;
pub use index::Index;

use super::content::{Keyframe, SceneStart};
use super::scene;
use super::verdict::Verdict;
use crate::session::Session;
use item::DecodedFrame;
use keyframe::is_forged;
use pace::FrameProgress;
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use thenar_record::{Frames, Header};
use trust::Trust;

/// A recording being made again.
#[derive(Debug)]
pub struct Replay {
    header: Header,
    frames: Frames<BufReader<File>>,
    session: Option<Session>,
    /// Offset of its scene in the file \[bytes\], and the session as it was built.
    beginning: Option<(u64, Keyframe)>,
    /// Hash of the state that its scene began with when it was recorded.
    start_hash: u64,
    /// Steps since the scene frame.
    number: u64,
    /// Number and hash of the mark that was read last, if nothing of the session came after it.
    mark: Option<(u64, u64)>,
    pace: FrameProgress,
    pending: Option<(u64, DecodedFrame)>,
    /// To be told before what comes next.
    told: VecDeque<Event>,
    /// Channels that were announced, and how many values their records have.
    channels: BTreeMap<u32, usize>,
    /// Byte offset of the keyframe to begin after, if any.
    begin: Option<u64>,
    trust: Trust,
    verdict: Verdict,
}

impl Replay {
    /// Opens a recording.
    ///
    /// # Errors
    /// It cannot be opened, or not even its header is whole.
    pub fn open(file: &Path) -> Result<Self, ReplayError> {
        let (header, frames) = thenar_record::open(file)?;
        Ok(Self {
            pace: FrameProgress::start(header.simulated_time),
            header,
            frames,
            session: None,
            beginning: None,
            start_hash: 0,
            number: 0,
            mark: None,
            pending: None,
            told: VecDeque::new(),
            channels: BTreeMap::new(),
            begin: None,
            trust: Trust::Sound,
            verdict: Verdict::default(),
        })
    }

    /// Header of the recording.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The session as it is now; `None` before the first scene.
    pub fn session(&self) -> Option<&Session> {
        self.session.as_ref()
    }

    /// The present session, mutable to evaluate probes.
    pub fn session_mut(&mut self) -> Option<&mut Session> {
        self.session.as_mut()
    }

    /// Findings up to now.
    pub fn verdict(&self) -> &Verdict {
        &self.verdict
    }

    /// Length of what has been read of the file \[bytes\].
    pub fn bytes_read(&self) -> u64 {
        self.frames.offset()
    }

    /// Goes on to the next event; `None` at the end of what can be read.
    ///
    /// # Errors
    /// The recording cannot be replayed any further.
    #[allow(clippy::should_implement_trait)] // the session is looked at in between
    pub fn next(&mut self) -> Result<Option<Event>, ReplayError> {
        if let Some(event) = self.told.pop_front() {
            return Ok(Some(event));
        }
        loop {
            let (time_ns, item) = match self.pending.take() {
                Some(pending) => pending,
                None => match self.read()? {
                    Some((time_ns, item)) if self.is_impossible(time_ns, &item)? => {
                        self.frames.reject();
                        self.meet_damage();
                        continue;
                    }
                    Some(item) => item,
                    None => {
                        self.verdict.ended = self.frames.ended();
                        return Ok(None);
                    }
                },
            };
            // Other frames may carry another clock.
            if item.is_of_session() {
                self.verdict.seconds = self.verdict.seconds.max(time_ns as f64 * 1e-9);
                self.pace.note(time_ns);
            }
            let of_session = item.is_of_session();
            let event = self.take(time_ns, item)?;
            if of_session && self.trust == Trust::Sound && self.pending.is_none() {
                self.pace.find(time_ns, self.header.simulated_time);
            }
            if event.is_some() {
                return Ok(event);
            }
        }
    }

    fn take(&mut self, time_ns: u64, item: DecodedFrame) -> Result<Option<Event>, ReplayError> {
        let early = self.begin.is_some_and(|begin| self.frames.offset() < begin);
        let passing = early || self.trust == Trust::Lost;
        let before = match &item {
            DecodedFrame::Step(mark) => self.mark.replace((mark.number, mark.hash)),
            item if item.is_of_session() => self.mark.take(),
            _ => None,
        };
        match item {
            DecodedFrame::Scene(start) => {
                let offset = self.frames.place().offset();
                return self.start(time_ns, offset, &start).map(Some);
            }
            DecodedFrame::Channel(info) => {
                self.channels.insert(info.id, info.fields.len());
                return Ok(Some(Event::Channel(info)));
            }
            DecodedFrame::Record(..) if early => {}
            DecodedFrame::Record(channel, values)
                if self.channels.get(&channel) != Some(&values.len()) =>
            {
                self.verdict.strays += 1;
            }
            DecodedFrame::Record(channel, values) => {
                return Ok(Some(Event::Record { time_ns, channel, values }));
            }
            DecodedFrame::Gap(gap) => {
                self.verdict.gaps.push((time_ns as f64 * 1e-9, gap));
                return Ok(Some(Event::Gap { time_ns, gap }));
            }
            DecodedFrame::Other => {}
            // What belongs to a scene that is missing.
            DecodedFrame::Input(_) | DecodedFrame::Step(_) | DecodedFrame::Keyframe(_)
                if self.is_foreign(&item) => {}
            DecodedFrame::Input(input) => {
                if self.missing(input.number)? > 0 {
                    self.pending = Some((time_ns, DecodedFrame::Input(input)));
                    return Ok(self.step(passing, time_ns, None));
                }
                return Ok(self.enter(time_ns, &input).filter(|_| !early));
            }
            DecodedFrame::Step(mark) => {
                if self.missing(mark.number.saturating_sub(1))? > 0 {
                    self.pending = Some((time_ns, DecodedFrame::Step(mark)));
                    return Ok(self.step(passing, time_ns, None));
                }
                return Ok(self.step(passing, time_ns, Some(mark)));
            }
            DecodedFrame::Keyframe(keyframe) if is_forged(&keyframe, before) => self.leave_out(),
            DecodedFrame::Keyframe(keyframe) => {
                // From here on nothing depends on what is missing.
                if matches!(self.trust, Trust::Doubtful(_)) {
                    self.lose();
                }
                let passing = early || self.trust == Trust::Lost;
                if passing && keyframe.kept.is_some() {
                    self.pass_to(&keyframe);
                } else if self.missing(keyframe.number)? > 0 {
                    self.pending = Some((time_ns, DecodedFrame::Keyframe(keyframe)));
                    return Ok(self.step(passing, time_ns, None));
                }
                self.compare(early, time_ns, &keyframe);
            }
        }
        Ok(None)
    }

    /// Begins a scene that stands at this byte of the file.
    fn start(&mut self, time_ns: u64, at: u64, start: &SceneStart) -> Result<Event, ReplayError> {
        let known = self.beginning.as_ref().filter(|(known, _)| *known == at);
        let back = |session: &mut Session| {
            known.is_some_and(|(_, beginning)| keyframe::put(session, beginning))
        };
        // Building a hand takes a second; a scene that has been built already goes back.
        if !self.session.as_mut().is_some_and(back) {
            let session = scene::session(start)?;
            self.beginning = Keyframe::of(&session, start.hash).map(|beginning| (at, beginning));
            self.session = Some(session);
        }
        self.verdict.scenes += 1;
        (self.number, self.start_hash) = (0, start.hash);
        if self.session.as_ref().is_some_and(|session| !start.is_of(session)) {
            self.differs(0, time_ns);
        }
        if self.trust != Trust::Sound {
            self.lose();
            self.settle(time_ns as f64 * 1e-9);
        }
        Ok(Event::Scene { time_ns })
    }
}
