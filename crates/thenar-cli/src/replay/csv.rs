//! Tables: a row per step.

use super::{Schedule, Sink};
use crate::error::CliError;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};
use thenar_core::model::Digit;
use thenar_output::Output;
use thenar_record::ChannelInfo;
use thenar_scene::recording::{Event, Replay};
use thenar_scene::session::{HandLoad, Session};

/// Tables of the scenes and channels of a recording.
pub struct Tables {
    file: PathBuf,
    every: Schedule,
    scenes: u32,
    scene: Output,
    /// Tables that are complete.
    done: Vec<Output>,
    channels: BTreeMap<u32, Output>,
    line: String,
}

fn failed(error: &std::io::Error) -> CliError {
    CliError::Other(format!("cannot write the table: {error}"))
}

/// `table.csv` and `-x` make `table-x.csv`.
fn beside(file: &Path, suffix: &str) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let ending = file.extension().map_or("csv".into(), |e| e.to_string_lossy());
    file.with_file_name(format!("{stem}-{suffix}.{ending}"))
}

/// A text as a cell.
fn cell(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.into(),
    }
}

impl Tables {
    /// Starts the first table.
    ///
    /// # Errors
    /// It cannot be created.
    pub fn create(file: &Path, rate: Option<f64>) -> Result<Self, CliError> {
        Ok(Self {
            file: file.into(),
            every: Schedule::at_most(rate),
            scenes: 0,
            scene: Output::create(file)?,
            done: Vec::new(),
            channels: BTreeMap::new(),
            line: String::new(),
        })
    }

    fn begin_scene(&mut self, session: &Session) -> Result<(), CliError> {
        self.scenes += 1;
        if self.scenes > 1 {
            let next = Output::create(&beside(&self.file, &self.scenes.to_string()))?;
            self.done.push(std::mem::replace(&mut self.scene, next));
        }
        let mut names: Vec<String> =
            ["time [s]", "simulated [s]", "contacts [1]", "penetration [m]", "energy [J]"]
                .map(String::from)
                .into();
        for rigid in &session.world().desc().rigids {
            let units = ["x [m]", "y [m]", "z [m]", "qx [1]", "qy [1]", "qz [1]", "qw [1]"];
            names.extend(units.map(|unit| format!("{}.{unit}", rigid.name)));
        }
        for hand in session.hands().iter().filter(|hand| hand.flesh().is_some()) {
            for finger in Digit::FINGERS {
                let of =
                    |(figure, unit)| format!("{}.{}.{figure} [{unit}]", hand.name, finger.name());
                names.extend(HandLoad::FIGURES.map(of));
            }
        }
        names.extend(session.columns().iter().map(|c| format!("probe.{} [{}]", c.name, c.unit)));
        let cells: Vec<String> = names.iter().map(|name| cell(name)).collect();
        writeln!(self.scene, "{}", cells.join(",")).map_err(|e| failed(&e))
    }

    fn row(&mut self, time_ns: u64, session: &mut Session) -> Result<(), CliError> {
        let line = &mut self.line;
        line.clear();
        let world = session.world();
        let report = session.report();
        let energy = world.energy(session.input()).total();
        let _ = write!(
            line,
            "{},{},{},{},{energy}",
            time_ns as f64 / 1e9,
            world.time(),
            report.contacts_active,
            report.penetration_max
        );
        // Writing into a text cannot fail.
        let mut put = |x: f64| _ = write!(line, ",{x}");
        for b in 0..world.desc().rigids.len() {
            let pose = world.rigid_pose(b as u32);
            pose.position.iter().chain(pose.rotation.coords.iter()).for_each(|x| put(*x));
        }
        for (k, hand) in session.hands().iter().enumerate() {
            if hand.flesh().is_some() {
                let [_, fingers @ ..] = session.hand_loads(k);
                fingers.iter().flat_map(HandLoad::figures).for_each(&mut put);
            }
        }
        session.probe().iter().for_each(|x| put(*x));
        writeln!(self.scene, "{line}").map_err(|e| failed(&e))
    }

    fn begin_channel(&mut self, info: &ChannelInfo) -> Result<(), CliError> {
        // A name from a file must not lead anywhere.
        let name: String =
            info.name.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
        let mut output = Output::create(&beside(&self.file, &format!("{}-{name}", info.id)))?;
        let fields =
            info.fields.iter().map(|f| format!(",{}", cell(&format!("{} [{}]", f.name, f.unit))));
        writeln!(output, "time [s]{}", fields.collect::<String>()).map_err(|e| failed(&e))?;
        self.channels.insert(info.id, output);
        Ok(())
    }
}

impl Sink for Tables {
    fn take(&mut self, event: &Event, replay: &mut Replay) -> Result<(), CliError> {
        match (event, replay.session_mut()) {
            (Event::Scene { .. }, Some(session)) => self.begin_scene(session),
            (Event::Stepped { time_ns, .. }, Some(session)) if self.every.is_due(*time_ns) => {
                self.row(*time_ns, session)
            }
            (Event::Channel(info), _) => self.begin_channel(info),
            (Event::Record { time_ns, channel, values }, _) => {
                let Some(output) = self.channels.get_mut(channel) else { return Ok(()) };
                let values: String = values.iter().map(|x| format!(",{x}")).collect();
                writeln!(output, "{}{values}", *time_ns as f64 / 1e9).map_err(|e| failed(&e))
            }
            _ => Ok(()),
        }
    }

    fn finish(self: Box<Self>, _: &Replay) -> Result<(), CliError> {
        let channels = self.channels.into_values();
        let mut all = self.done.into_iter().chain([self.scene]).chain(channels);
        Ok(all.try_for_each(Output::finish)?)
    }
}
