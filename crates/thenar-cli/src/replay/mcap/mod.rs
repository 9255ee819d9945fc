//! A recording as MCAP, for Foxglove and Rerun: Protobuf messages of Foxglove's schemas and schemas
//! of plain numbers, uncompressed.

mod dots;
mod figures;
mod message;
mod numbers;
mod picture;

use super::{Schedule, Sink};
use crate::error::CliError;
use ::mcap::records::MessageHeader;
use ::mcap::write::NoSeek;
use ::mcap::{McapError, WriteOptions, Writer};
use dots::Dots;
use foxglove::Encode;
use foxglove::messages::log::Level;
use foxglove::messages::{FrameTransforms, Log, PointCloud, SceneUpdate, Timestamp};
use numbers::Numbers;
use std::collections::BTreeMap;
use std::path::Path;
use thenar_output::Output;
use thenar_record::{ChannelInfo, Header};
use thenar_scene::recording::{Event, Replay};
use thenar_scene::session::Session;

/// Moments per second where nothing else is asked for: a hand is some 200 kB.
const RATE: f64 = 30.0;

/// A topic.
#[derive(Clone, Copy, Debug)]
struct Topic {
    id: u16,
    messages: u32,
}

/// The file.
pub struct Export {
    writer: Writer<NoSeek<Output>>,
    topics: BTreeMap<String, Topic>,
    every: Schedule,
    /// Start of the recording \[ns since 1970\].
    begun: u64,
    /// Time of the newest step in this scene \[ns\].
    last_step: Option<u64>,
    newest: u64,
    channels: BTreeMap<u32, ChannelInfo>,
    /// Topics of plain numbers.
    numbers: BTreeMap<String, Numbers>,
    /// Points on each deformable body of the scene.
    flesh_dots: Vec<Dots>,
    /// Topics of the scene's point clouds.
    clouds: Vec<String>,
}

fn failed(error: &McapError) -> CliError {
    CliError::Other(match error {
        // Names the file.
        McapError::Io(cause) => format!("cannot write the MCAP file: {cause}"),
        error => format!("cannot write the MCAP file: {error}"),
    })
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
        let output = NoSeek::new(Output::create(file)?);
        let mut export = Self {
            writer: options.create(output).map_err(|e| failed(&e))?,
            topics: BTreeMap::new(),
            every: Schedule::at_most(Some(rate.unwrap_or(RATE))),
            begun: header.created_unix_ns,
            last_step: None,
            newest: 0,
            channels: BTreeMap::new(),
            numbers: BTreeMap::new(),
            flesh_dots: Vec::new(),
            clouds: Vec::new(),
        };
        export.known::<FrameTransforms>("/tf")?;
        for topic in ["/objects", "/flesh", "/forces"] {
            export.known::<SceneUpdate>(topic)?;
        }
        for topic in ["/points/contacts", "/points/forces"] {
            export.known::<PointCloud>(topic)?;
        }
        export.known::<Log>("/log")?;
        export.own("/sim/timing", figures::timing_numbers())?;
        export.own("/sim/step", figures::step_numbers())?;
        Ok(export)
    }

    /// Announces a topic; a second time it gets this schema from then on.
    fn topic(
        &mut self,
        topic: &str,
        name: &str,
        schema: &[u8],
        metadata: &BTreeMap<String, String>,
    ) -> Result<(), CliError> {
        let mut add = || {
            let schema = self.writer.add_schema(name, "protobuf", schema)?;
            self.writer.add_channel(schema, topic, "protobuf", metadata)
        };
        let id = add().map_err(|e| failed(&e))?;
        let messages = self.topics.get(topic).map_or(0, |topic| topic.messages);
        self.topics.insert(topic.into(), Topic { id, messages });
        Ok(())
    }

    /// A topic of one of Foxglove's messages.
    fn known<M: Encode>(&mut self, topic: &str) -> Result<(), CliError> {
        let Some(schema) = M::get_schema() else { return Ok(()) };
        self.topic(topic, &schema.name, &schema.data, &BTreeMap::new())
    }

    /// A topic of plain numbers.
    fn own(&mut self, topic: &str, numbers: Numbers) -> Result<(), CliError> {
        self.topic(topic, &numbers.schema_name(), &numbers.schema(), &numbers.units())?;
        self.numbers.insert(topic.into(), numbers);
        Ok(())
    }

    fn time(&self, ns: u64) -> Timestamp {
        message::time(self.begun + ns)
    }

    /// Writes a message to a topic that has been announced.
    fn write_bytes(&mut self, topic: &str, ns: u64, bytes: &[u8]) -> Result<(), CliError> {
        let Some(known) = self.topics.get_mut(topic) else { return Ok(()) };
        known.messages += 1;
        let at = self.begun + ns;
        let header = MessageHeader {
            channel_id: known.id,
            sequence: known.messages,
            log_time: at,
            publish_time: at,
        };
        self.writer.write_to_known_channel(&header, bytes).map_err(|e| failed(&e))
    }

    fn write<M: Encode>(&mut self, topic: &str, ns: u64, message: &M) -> Result<(), CliError> {
        let mut bytes = Vec::with_capacity(message.encoded_len().unwrap_or(0));
        message.encode(&mut bytes).map_err(|e| CliError::Other(e.to_string()))?;
        self.write_bytes(topic, ns, &bytes)
    }

    fn write_numbers(
        &mut self,
        topic: &str,
        ns: u64,
        values: impl IntoIterator<Item = f64>,
    ) -> Result<(), CliError> {
        let Some(numbers) = self.numbers.get(topic) else { return Ok(()) };
        let bytes = numbers.encode(values);
        self.write_bytes(topic, ns, &bytes)
    }

    fn log(&mut self, ns: u64, level: Level, message: String) -> Result<(), CliError> {
        let log = message::log(self.time(ns), level, message);
        self.write("/log", ns, &log)
    }

    /// Writes a cloud of a body to a topic of its own.
    fn cloud(
        &mut self,
        kind: &str,
        ns: u64,
        (name, cloud): (String, PointCloud),
    ) -> Result<(), CliError> {
        let topic = format!("/points/{kind}/{name}");
        if !self.topics.contains_key(&topic) {
            self.known::<PointCloud>(&topic)?;
        }
        self.write(&topic, ns, &cloud)?;
        if !self.clouds.contains(&topic) {
            self.clouds.push(topic);
        }
        Ok(())
    }

    fn scene(&mut self, ns: u64, session: &Session) -> Result<(), CliError> {
        self.last_step = None;
        self.own("/haptics/force", figures::force_numbers(session))?;
        if !session.columns().is_empty() {
            self.own("/probes", figures::probe_numbers(session))?;
        }
        // What the scene before had must not stay.
        let gone = SceneUpdate { deletions: vec![message::clear(self.time(ns))], entities: vec![] };
        self.write("/flesh", ns, &gone)?;
        for topic in std::mem::take(&mut self.clouds) {
            self.write(&topic, ns, &dots::none(self.begun + ns))?;
        }
        let objects = picture::objects(session, self.time(ns));
        self.write("/objects", ns, &objects)?;
        for object in dots::objects(session, self.begun + ns) {
            self.cloud("objects", ns, object)?;
        }
        self.flesh_dots = dots::flesh_dots(session);
        self.log(ns, Level::Info, format!("scene {}", session.name()))?;
        self.moment(ns, session)
    }

    /// Writes what is to be seen now.
    fn moment(&mut self, ns: u64, session: &Session) -> Result<(), CliError> {
        let (now, at) = (self.time(ns), self.begun + ns);
        self.write("/tf", ns, &picture::transforms(session, now))?;
        self.write("/flesh", ns, &picture::flesh(session, now))?;
        self.write("/forces", ns, &picture::forces(session, now))?;
        for flesh in dots::flesh(session, &self.flesh_dots, at) {
            self.cloud("flesh", ns, flesh)?;
        }
        self.write("/points/contacts", ns, &dots::contacts(session, at))?;
        self.write("/points/forces", ns, &dots::forces(session, at))?;
        self.write_numbers("/haptics/force", ns, figures::force(session))?;
        self.write_numbers("/sim/step", ns, figures::step(session))
    }

    fn step(
        &mut self,
        ns: u64,
        cost_ns: Option<u32>,
        session: &mut Session,
    ) -> Result<(), CliError> {
        let cost = cost_ns.map(|ns| f64::from(ns) * 1e-9);
        let period = self.last_step.map(|last| ns.saturating_sub(last) as f64 * 1e-9);
        self.last_step = Some(ns);
        self.write_numbers("/sim/timing", ns, figures::timing(session, cost, period))?;
        if self.every.is_due(ns) {
            self.moment(ns, session)?;
            if !session.columns().is_empty() {
                self.write_numbers("/probes", ns, session.probe().iter().copied())?;
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
                self.own(&topic, figures::channel_numbers(info))?;
                self.channels.insert(info.id, info.clone());
            }
            (Event::Record { time_ns, channel, values }, _) => {
                if let Some(info) = self.channels.get(channel) {
                    let topic = format!("/channel/{}", info.name);
                    self.write_numbers(&topic, *time_ns, values.iter().copied())?;
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
        for loss in &verdict.losses {
            self.log(newest, Level::Warning, loss.to_string())?;
        }
        self.writer.finish().map_err(|e| failed(&e))?;
        Ok(self.writer.into_inner().into_inner().finish()?)
    }
}
