//! A recording as MCAP, for Foxglove: JSON messages of Foxglove's schemas, uncompressed.

mod figures;
mod message;
mod picture;

use super::{Every, Sink};
use crate::error::CliError;
use crate::files::Draft;
use ::mcap::records::MessageHeader;
use ::mcap::write::NoSeek;
use ::mcap::{McapError, WriteOptions, Writer};
use message::{Level, Log, Time};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use thenar_record::{ChannelInfo, Header};
use thenar_scene::recording::{Event, Replay};
use thenar_scene::session::Session;

/// Moments per second where nothing else is asked for: a surface is some 50 kB of text.
const RATE: f64 = 30.0;

// MIT, from the npm package @foxglove/schemas 2.1.0.
const SCENE_UPDATE: &str = include_str!("foxglove/SceneUpdate.json");
const FRAME_TRANSFORMS: &str = include_str!("foxglove/FrameTransforms.json");
const LOG: &str = include_str!("foxglove/Log.json");

/// A topic.
#[derive(Clone, Copy, Debug)]
struct Topic {
    id: u16,
    messages: u32,
}

/// The file.
pub struct Export {
    writer: Writer<NoSeek<Draft>>,
    topics: BTreeMap<String, Topic>,
    every: Every,
    /// When the recording began \[ns since 1970\].
    begun: u64,
    /// Time of the newest step in this scene \[ns\].
    last_step: Option<u64>,
    newest: u64,
    channels: BTreeMap<u32, ChannelInfo>,
}

fn failed(error: &McapError) -> CliError {
    CliError::Other(format!("cannot write the MCAP file: {error}"))
}

impl Export {
    /// Starts the file.
    ///
    /// # Errors
    /// It cannot be created.
    pub fn create(file: &Path, rate: Option<f64>, header: &Header) -> Result<Self, CliError> {
        let options = WriteOptions::new()
            .compression(None)
            .disable_seeking(true)
            .library(concat!("thenar ", env!("CARGO_PKG_VERSION")));
        let draft = NoSeek::new(Draft::create(file)?);
        let mut export = Self {
            writer: options.create(draft).map_err(|e| failed(&e))?,
            topics: BTreeMap::new(),
            every: Every::at_most(Some(rate.unwrap_or(RATE))),
            begun: header.created_unix_ns,
            last_step: None,
            newest: 0,
            channels: BTreeMap::new(),
        };
        export.topic("/tf", "foxglove.FrameTransforms", FRAME_TRANSFORMS)?;
        for topic in ["/objects", "/flesh", "/forces"] {
            export.topic(topic, "foxglove.SceneUpdate", SCENE_UPDATE)?;
        }
        export.topic("/log", "foxglove.Log", LOG)?;
        export.own("/haptics/force", "thenar.Force", &figures::force_schema())?;
        export.own("/sim/timing", "thenar.Timing", &figures::timing_schema())?;
        export.own("/sim/step", "thenar.Step", &figures::step_schema())?;
        Ok(export)
    }

    /// Announces a topic; a second time it gets this schema from then on.
    fn topic(&mut self, topic: &str, name: &str, schema: &str) -> Result<(), CliError> {
        let mut add = || {
            let schema = self.writer.add_schema(name, "jsonschema", schema.as_bytes())?;
            self.writer.add_channel(schema, topic, "json", &BTreeMap::new())
        };
        let id = add().map_err(|e| failed(&e))?;
        let messages = self.topics.get(topic).map_or(0, |topic| topic.messages);
        self.topics.insert(topic.into(), Topic { id, messages });
        Ok(())
    }

    fn own(&mut self, topic: &str, name: &str, schema: &Value) -> Result<(), CliError> {
        self.topic(topic, name, &schema.to_string())
    }

    fn time(&self, ns: u64) -> Time {
        Time::of(self.begun + ns)
    }

    /// Writes a message to a topic that has been announced.
    fn write(&mut self, topic: &str, ns: u64, message: &impl Serialize) -> Result<(), CliError> {
        let Some(known) = self.topics.get_mut(topic) else { return Ok(()) };
        known.messages += 1;
        let at = self.begun + ns;
        let header = MessageHeader {
            channel_id: known.id,
            sequence: known.messages,
            log_time: at,
            publish_time: at,
        };
        let bytes = serde_json::to_vec(message).map_err(|e| CliError::Other(e.to_string()))?;
        self.writer.write_to_known_channel(&header, &bytes).map_err(|e| failed(&e))
    }

    fn log(&mut self, ns: u64, level: Level, message: String) -> Result<(), CliError> {
        let log = Log::new(self.time(ns), level, message);
        self.write("/log", ns, &log)
    }

    fn scene(&mut self, ns: u64, session: &Session) -> Result<(), CliError> {
        self.last_step = None;
        if !session.columns().is_empty() {
            self.own("/probes", "thenar.Probes", &figures::probes_schema(session.columns()))?;
        }
        let objects = picture::objects(session, self.time(ns));
        self.write("/objects", ns, &objects)?;
        // What the scene before had must not stay.
        let gone = message::Deletion::all(self.time(ns));
        let gone = message::SceneUpdate { deletions: vec![gone], entities: Vec::new() };
        self.write("/flesh", ns, &gone)?;
        self.log(ns, Level::Info, format!("scene {}", session.name()))?;
        self.moment(ns, session)
    }

    /// What is to be seen now.
    fn moment(&mut self, ns: u64, session: &Session) -> Result<(), CliError> {
        let time = self.time(ns);
        self.write("/tf", ns, &picture::transforms(session, time))?;
        self.write("/flesh", ns, &picture::flesh(session, time))?;
        self.write("/forces", ns, &picture::forces(session, time))?;
        self.write("/haptics/force", ns, &figures::force(session, time))?;
        self.write("/sim/step", ns, &figures::step(session, time))
    }

    fn step(
        &mut self,
        ns: u64,
        cost_ns: Option<u32>,
        session: &mut Session,
    ) -> Result<(), CliError> {
        let time = self.time(ns);
        let cost = cost_ns.map(|ns| f64::from(ns) * 1e-9);
        let period = self.last_step.map(|last| ns.saturating_sub(last) as f64 * 1e-9);
        self.last_step = Some(ns);
        self.write("/sim/timing", ns, &figures::timing(session, time, cost, period))?;
        if self.every.is_due(ns) {
            self.moment(ns, session)?;
            if !session.columns().is_empty() {
                self.write("/probes", ns, &figures::probes(session, time))?;
            }
        }
        Ok(())
    }
}

impl Sink for Export {
    fn take(&mut self, event: &Event, replay: &mut Replay) -> Result<(), CliError> {
        match (event, replay.session_mut()) {
            (Event::Scene { time_ns }, Some(session)) => self.scene(*time_ns, session)?,
            (Event::Stepped { time_ns, cost_ns }, Some(session)) => {
                self.newest = self.newest.max(*time_ns);
                self.step(*time_ns, *cost_ns, session)?;
            }
            // Poses and targets come by the hundred, and are seen in the transforms.
            (Event::Entered { often: false, time_ns, what }, _) => {
                self.log(*time_ns, Level::Info, what.clone())?;
            }
            (Event::Channel(info), _) => {
                let topic = format!("/channel/{}", info.name);
                let schema = figures::channel_schema(info);
                self.own(&topic, &format!("thenar.channel.{}", info.name), &schema)?;
                self.channels.insert(info.id, info.clone());
            }
            (Event::Record { time_ns, channel, values }, _) => {
                if let Some(info) = self.channels.get(channel) {
                    let message = figures::record(info, values, self.time(*time_ns));
                    let topic = format!("/channel/{}", info.name);
                    self.write(&topic, *time_ns, &message)?;
                }
            }
            (Event::Gap { time_ns, gap }, _) => {
                let what = format!("{} frames are missing before this", gap.frames);
                self.log(*time_ns, Level::Warning, what)?;
            }
            _ => {}
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>, replay: &Replay) -> Result<(), CliError> {
        let verdict = replay.verdict();
        let newest = self.newest;
        if !verdict.is_same() {
            self.log(newest, Level::Warning, verdict.to_string())?;
        }
        if let Some(damage) = &verdict.damage {
            self.log(newest, Level::Warning, damage.to_string())?;
        }
        self.writer.finish().map_err(|e| failed(&e))?;
        self.writer.into_inner().into_inner().finish()
    }
}
