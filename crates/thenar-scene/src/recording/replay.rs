//! Makes a recorded session again, event by event.

use super::content::{Keyframe, SceneStart, StepMark};
use super::entry::Input;
use super::scene;
use super::verdict::{Difference, Loss, Moved, Verdict};
use crate::SceneError;
use crate::session::Session;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use thenar_record::{ChannelInfo, Frames, Gap, Header, Kind, OpenError, Record};

/// More steps than this are not made without a mark.
const UNMARKED_MAX: u64 = 10_000_000;

/// After damage so many steps are made to find out whether anything of the session is missing.
const DOUBTED_MAX: u64 = 100;

/// Whether the session is what was recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trust {
    /// As far as is known.
    Sound,
    /// Something is missing, of the session or of a channel only. So many steps were made since: the
    /// hash after one of them tells.
    Doubtful(u64),
    /// Something of the session is missing: steps are passed over up to a keyframe.
    Lost,
    /// The scene itself is missing: all is left out up to another.
    Foreign,
}

/// Why a recording cannot be replayed any further.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// It cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// Reading fails.
    #[error("cannot read the recording: {0}")]
    Read(#[from] io::Error),
    /// The scene cannot be built.
    #[error("the recorded scene cannot be built: {0}")]
    Scene(#[from] SceneError),
    /// The scene's files cannot be unpacked.
    #[error("cannot unpack the scene's files: {0}")]
    Asset(io::Error),
    /// A file was too large for the recording, and is gone or different.
    #[error("the recording needs {}, which is missing or not as it was", .0.display())]
    NotThere(PathBuf),
    /// A frame is whole, but not understood.
    #[error("the frame before byte {offset} makes no sense: {what}")]
    Content {
        /// Where it ends.
        offset: u64,
        /// What.
        what: &'static str,
    },
}

/// What happened in a replay. Times are those of the recording \[ns\].
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A session has begun.
    Scene {
        /// When.
        time_ns: u64,
    },
    /// Something entered, named as for a person.
    Entered {
        /// When.
        time_ns: u64,
        /// What.
        what: String,
        /// Of a kind that comes many times a second: a pose, or targets.
        often: bool,
    },
    /// A step was made.
    Stepped {
        /// When it was over.
        time_ns: u64,
        /// What it took when it was recorded \[ns\]; `None` where no mark was kept.
        cost_ns: Option<u32>,
    },
    /// A channel is announced.
    Channel(ChannelInfo),
    /// A record of a channel.
    Record {
        /// When.
        time_ns: u64,
        /// Channel.
        channel: u32,
        /// Values.
        values: Vec<f64>,
    },
    /// Frames are missing.
    Gap {
        /// When.
        time_ns: u64,
        /// What.
        gap: Gap,
    },
}

/// A recording being made again.
#[derive(Debug)]
pub struct Replay {
    header: Header,
    frames: Frames<BufReader<File>>,
    session: Option<Session>,
    /// Steps since the scene frame.
    number: u64,
    pending: Option<(u64, Item)>,
    /// Byte offset of the keyframe to begin after, if any.
    begin: Option<u64>,
    trust: Trust,
    verdict: Verdict,
}

/// A frame, understood.
#[derive(Debug)]
enum Item {
    Scene(Box<SceneStart>),
    Input(Box<Input>),
    Step(StepMark),
    Keyframe(Box<Keyframe>),
    Channel(ChannelInfo),
    Record(u32, Vec<f64>),
    Gap(Gap),
    Other,
}

impl Replay {
    /// Opens a recording.
    ///
    /// # Errors
    /// It cannot be opened, or not even its header is whole.
    pub fn open(file: &Path) -> Result<Self, ReplayError> {
        let (header, frames) = thenar_record::open(file)?;
        Ok(Self {
            header,
            frames,
            session: None,
            number: 0,
            pending: None,
            begin: None,
            trust: Trust::Sound,
            verdict: Verdict::default(),
        })
    }

    /// Opens a recording to be replayed from the last keyframe before `seconds` on. What comes
    /// before is read, but no step of it is made.
    ///
    /// # Errors
    /// As for [`Replay::open`].
    pub fn open_at(file: &Path, seconds: f64) -> Result<Self, ReplayError> {
        let mut replay = Self::open(file)?;
        let (_, mut frames) = thenar_record::open(file)?;
        while let Some(frame) = frames.next()? {
            let (kind, time_ns) = (frame.kind, frame.time_ns);
            if time_ns as f64 * 1e-9 > seconds {
                break;
            }
            match kind {
                Some(Kind::Keyframe) => replay.begin = Some(frames.offset()),
                // A scene that has no keyframe yet is replayed from its start.
                Some(Kind::Scene) => replay.begin = Some(frames.offset()),
                _ => {}
            }
        }
        Ok(replay)
    }

    /// What the recording says of itself.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The session as it is now; `None` before the first scene.
    pub fn session(&self) -> Option<&Session> {
        self.session.as_ref()
    }

    /// The same, to evaluate probes.
    pub fn session_mut(&mut self) -> Option<&mut Session> {
        self.session.as_mut()
    }

    /// What was found so far.
    pub fn verdict(&self) -> &Verdict {
        &self.verdict
    }

    /// Goes on to the next event; `None` at the end of what can be read.
    ///
    /// # Errors
    /// The recording cannot be replayed any further.
    #[allow(clippy::should_implement_trait)] // the session is looked at in between
    pub fn next(&mut self) -> Result<Option<Event>, ReplayError> {
        loop {
            let (time_ns, item) = match self.pending.take() {
                Some(pending) => pending,
                None => match self.read()? {
                    Some(item) => item,
                    None => {
                        self.verdict.ended = self.frames.ended();
                        return Ok(None);
                    }
                },
            };
            // Other frames may carry another clock.
            if matches!(item, Item::Scene(_) | Item::Input(_) | Item::Step(_)) {
                self.verdict.seconds = self.verdict.seconds.max(time_ns as f64 * 1e-9);
            }
            if let Some(event) = self.take(time_ns, item)? {
                return Ok(Some(event));
            }
        }
    }

    /// The next frame.
    fn read(&mut self) -> Result<Option<(u64, Item)>, ReplayError> {
        let Some(frame) = self.frames.next()? else {
            self.meet_damage();
            return Ok(None);
        };
        let (time_ns, body) = (frame.time_ns, frame.body);
        let item = match frame.kind {
            Some(Kind::Scene) => postcard::from_bytes(body).ok().map(|s| Item::Scene(Box::new(s))),
            Some(Kind::Input) => postcard::from_bytes(body).ok().map(|i| Item::Input(Box::new(i))),
            Some(Kind::Step) => StepMark::read(body).map(Item::Step),
            Some(Kind::Keyframe) => {
                postcard::from_bytes(body).ok().map(|k| Item::Keyframe(Box::new(k)))
            }
            Some(Kind::Channel) => serde_json::from_slice(body).ok().map(Item::Channel),
            Some(Kind::Record) => Record::read(body)
                .map(|record| Item::Record(record.channel, record.values().collect())),
            Some(Kind::Gap) => Gap::read(body).map(Item::Gap),
            Some(Kind::Header | Kind::End) | None => Some(Item::Other),
        };
        let what = "its body cannot be decoded";
        let item = item.ok_or(ReplayError::Content { offset: self.frames.offset(), what })?;
        self.meet_damage();
        Ok(Some((time_ns, item)))
    }

    /// Takes note of what has been left out before the frame that was read.
    fn meet_damage(&mut self) {
        let met = self.verdict.losses.len();
        for damage in &self.frames.damages()[met..] {
            let from = self.verdict.seconds;
            self.verdict.losses.push(Loss { damage: *damage, from, until: None });
            if self.trust == Trust::Sound {
                self.trust = Trust::Doubtful(0);
            }
        }
    }

    /// The session is known again, from a time on \[s\].
    fn settle(&mut self, seconds: f64) {
        self.trust = Trust::Sound;
        let open = |loss: &&mut Loss| loss.until.is_none();
        self.verdict.losses.iter_mut().filter(open).for_each(|loss| loss.until = Some(seconds));
    }

    /// The session is not known any more.
    fn lose(&mut self) {
        if let Trust::Doubtful(made) = self.trust {
            self.verdict.lost += made;
        }
        self.trust = Trust::Lost;
    }

    fn take(&mut self, time_ns: u64, item: Item) -> Result<Option<Event>, ReplayError> {
        let early = self.begin.is_some_and(|begin| self.frames.offset() < begin);
        let passing = early || self.trust == Trust::Lost;
        match item {
            Item::Scene(start) => return self.start(time_ns, &start).map(Some),
            Item::Channel(info) => return Ok(Some(Event::Channel(info))),
            Item::Record(..) if early => {}
            Item::Record(channel, values) => {
                return Ok(Some(Event::Record { time_ns, channel, values }));
            }
            Item::Gap(gap) => {
                self.verdict.gaps.push((time_ns as f64 * 1e-9, gap));
                return Ok(Some(Event::Gap { time_ns, gap }));
            }
            Item::Other => {}
            // What belongs to a scene that is missing.
            Item::Input(_) | Item::Step(_) | Item::Keyframe(_) if self.is_foreign(&item) => {}
            Item::Input(input) => {
                if self.behind(input.number)? {
                    self.pending = Some((time_ns, Item::Input(input)));
                    return Ok(self.step(passing, time_ns, None));
                }
                return Ok(self.enter(time_ns, &input).filter(|_| !early));
            }
            Item::Step(mark) => {
                if self.behind(mark.number.saturating_sub(1))? {
                    self.pending = Some((time_ns, Item::Step(mark)));
                    return Ok(self.step(passing, time_ns, None));
                }
                return Ok(self.step(passing, time_ns, Some(mark)));
            }
            Item::Keyframe(keyframe) => {
                // From here on nothing depends on what is missing.
                if matches!(self.trust, Trust::Doubtful(_)) {
                    self.lose();
                }
                let passing = early || self.trust == Trust::Lost;
                if self.behind(keyframe.number)? {
                    self.pending = Some((time_ns, Item::Keyframe(keyframe)));
                    return Ok(self.step(passing, time_ns, None));
                }
                self.compare(early, time_ns, &keyframe);
            }
        }
        Ok(None)
    }

    /// True for what belongs to a scene that damage has hidden.
    fn is_foreign(&mut self, item: &Item) -> bool {
        let number = match item {
            Item::Input(input) => input.number,
            Item::Step(mark) => mark.number.saturating_sub(1),
            Item::Keyframe(keyframe) => keyframe.number,
            _ => return false,
        };
        let follows = self.session.is_some()
            && number.checked_sub(self.number).is_some_and(|missing| missing <= UNMARKED_MAX);
        if self.trust != Trust::Sound && !follows {
            self.lose();
            self.trust = Trust::Foreign;
        }
        self.trust == Trust::Foreign
    }

    fn start(&mut self, time_ns: u64, start: &SceneStart) -> Result<Event, ReplayError> {
        let session = scene::session(start)?;
        self.verdict.scenes += 1;
        self.number = 0;
        if session.world().state_hash() != start.hash {
            self.differs(0, time_ns);
        }
        self.session = Some(session);
        if self.trust != Trust::Sound {
            self.lose();
            self.settle(time_ns as f64 * 1e-9);
        }
        Ok(Event::Scene { time_ns })
    }

    /// True when steps are missing before this number of them.
    fn behind(&self, number: u64) -> Result<bool, ReplayError> {
        let sound = |what| ReplayError::Content { offset: self.frames.offset(), what };
        if self.session.is_none() {
            return Err(sound("it belongs to a scene that is not in the recording"));
        }
        match number.checked_sub(self.number) {
            Some(missing @ 0..=UNMARKED_MAX) => Ok(missing > 0),
            _ => Err(sound("its step number does not follow")),
        }
    }

    /// Makes a step, whose mark may have been dropped.
    fn step(&mut self, passing: bool, time_ns: u64, mark: Option<StepMark>) -> Option<Event> {
        let session = self.session.as_mut()?;
        self.number += 1;
        if passing {
            session.pass(mark.is_some_and(|mark| mark.taken_back));
            match self.trust {
                Trust::Lost => self.verdict.lost += 1,
                _ => self.verdict.passed += 1,
            }
            return None;
        }
        session.step(&mut ());
        let hash = session.world().state_hash();
        if let Trust::Doubtful(made) = self.trust {
            return self.try_step(made + 1, time_ns, mark, hash);
        }
        self.verdict.steps += 1;
        match mark {
            None => self.verdict.unmarked += 1,
            Some(mark) if mark.hash == hash => self.verdict.same += 1,
            Some(mark) => self.differs(mark.number, time_ns),
        }
        Some(Event::Stepped { time_ns, cost_ns: mark.map(|mark| mark.cost_ns) })
    }

    /// After damage: nothing is told before a hash agrees.
    fn try_step(
        &mut self,
        made: u64,
        time_ns: u64,
        mark: Option<StepMark>,
        hash: u64,
    ) -> Option<Event> {
        self.trust = Trust::Doubtful(made);
        match mark {
            Some(mark) if mark.hash == hash => {
                let from = self.verdict.losses.iter().find(|loss| loss.until.is_none());
                let from = from.map_or(0.0, |loss| loss.from);
                self.settle(from);
                self.verdict.steps += made;
                self.verdict.unmarked += made - 1;
                self.verdict.same += 1;
                return Some(Event::Stepped { time_ns, cost_ns: Some(mark.cost_ns) });
            }
            None if made < DOUBTED_MAX => {}
            _ => self.lose(),
        }
        None
    }

    fn enter(&mut self, time_ns: u64, input: &Input) -> Option<Event> {
        let session = self.session.as_mut()?;
        let entered = input.what.with_entry(|entry| session.enter(entry));
        let refused = match entered {
            Some(Ok(())) => None,
            Some(Err(reason)) => Some(reason),
            None => Some("a pose has the wrong number of joints or angles".into()),
        };
        // What is refused where the session is not known says nothing.
        self.verdict.refused.extend(refused.filter(|_| self.trust == Trust::Sound));
        let (what, often) = (input.what.to_string(), input.what.is_often());
        Some(Event::Entered { time_ns, what, often })
    }

    /// At a keyframe the replay is right, or is put right.
    fn compare(&mut self, early: bool, time_ns: u64, keyframe: &Keyframe) {
        let Some(session) = &mut self.session else { return };
        // On the way to a later beginning only the last one counts.
        let last = self.begin.is_some_and(|begin| self.frames.offset() == begin);
        if early || keyframe.number != self.number {
            return;
        }
        if self.trust == Trust::Lost {
            match session.resume(&keyframe.state) {
                true => self.settle(time_ns as f64 * 1e-9),
                false => self.trust = Trust::Foreign,
            }
            return;
        }
        let state = session.world().state();
        if state.hash() == keyframe.state.hash() {
            return;
        }
        let moved = Moved::between(state, &keyframe.state);
        if session.resume(&keyframe.state) && !last {
            let (times, most) = &mut self.verdict.put_right;
            *times += 1;
            *most = most.max(moved);
        }
    }

    fn differs(&mut self, step: u64, time_ns: u64) {
        let scene = self.verdict.scenes;
        let time = time_ns as f64 * 1e-9;
        self.verdict.first.get_or_insert(Difference { scene, step, time });
    }
}
