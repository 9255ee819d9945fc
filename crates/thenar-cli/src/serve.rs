//! `thenar serve`: a scene live, for pages and headsets.

use crate::building::told;
use crate::error::CliError;
use crate::page::PageOptions;
use crate::recording::{RecordOptions, Recording};
use crate::run::{SceneLocation, find, tell_overlaps};
use crate::touch::{DeviceOptions, MessagePrinter, Simulated, tick_recorder};
use crate::{files, interrupt};
use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;
use thenar_link::haptic_loop::{HapticLoop, page_tracker};
use thenar_link::profile::page_timing;
use thenar_scene::recording::TimeOf;
use thenar_serve::http::Server;
use thenar_serve::live::{self, Haptics, Live, LiveError, SceneSource};

/// Serve a scene live to browsers and headsets.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene file, or the name of a built-in scene (see `thenar scenes`).
    #[arg(default_value = crate::DEMO)]
    scene: PathBuf,
    /// Options of its page: where it is, and for whom.
    #[command(flatten)]
    page: PageOptions,
    /// Change a value of the scene, e.g. solver.cone=linearised; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Time step of the scene [s]; short for --set time_step=S.
    #[arg(long, value_name = "S")]
    time_step: Option<f64>,
    /// Devices to feel it with.
    #[command(flatten)]
    devices: DeviceOptions,
    /// Options of the recording.
    #[command(flatten)]
    recording: RecordOptions,
}

impl Args {
    /// A built-in scene with nothing else asked for.
    pub fn of_scene(scene: &str) -> Self {
        Self {
            scene: scene.into(),
            page: PageOptions::default(),
            set: Vec::new(),
            time_step: None,
            devices: DeviceOptions::default(),
            recording: RecordOptions { record: None, keyframes: 1.0 },
        }
    }
}

/// Serves until Ctrl-C.
///
/// # Errors
/// The scene is wrong, or the port cannot be had.
pub fn run(args: &Args) -> Result<(), CliError> {
    interrupt::listen();
    let mut overrides = args.set.clone();
    overrides.extend(args.time_step.map(|s| format!("time_step={s}")));
    let source = match find(&args.scene)? {
        SceneLocation::File(path) => SceneSource::File(path),
        SceneLocation::Builtin(known) => SceneSource::Builtin(known.name.into()),
    };
    let (mut recording, witness) = match Recording::start(&args.recording, TimeOf::Clock)? {
        Some((recording, witness)) => (Some(recording), Some(witness)),
        None => (None, None),
    };
    let live_options = live::Options { overrides, witness, ..live::Options::default() };
    let (device, live, server) = match start(args, &source, live_options, recording.as_mut()) {
        Ok(started) => started,
        Err(error) => {
            recording.map(Recording::discard).unwrap_or_default();
            return Err(error);
        }
    };
    live.warnings().iter().for_each(|warning| eprintln!("warning: {warning}"));
    tell_overlaps(live.start_overlaps());
    args.page.announce(&format!("{} is live", args.scene.display()), &server);
    let mut message_printer = MessagePrinter::default();
    while !interrupt::asked() {
        std::thread::sleep(Duration::from_millis(50));
        if let Some((device, _)) = &device {
            message_printer.tell(&device.remote());
        }
        if let Some(recording) = &mut recording {
            recording.complain();
        }
    }
    server.stop();
    drop(live);
    if let Some(recording) = recording {
        let file = recording.file().display().to_string();
        let bytes = recording.finish()?;
        // Whoever read the address may have stopped reading.
        let _ = writeln!(std::io::stdout(), "recorded {file}, {}", files::size(bytes));
    }
    // Whoever read the address may have stopped reading.
    let _ = writeln!(std::io::stdout(), "ended");
    Ok(())
}

/// The loop with what is simulated for it.
type Device = (HapticLoop, Simulated);

/// Opens the devices, if there are any. The page's poses are a tracker beside theirs.
fn feel(
    options: &DeviceOptions,
    recording: Option<&mut Recording>,
) -> Result<(Option<Device>, Option<Haptics>), CliError> {
    if options.devices.is_empty() {
        return Ok((None, None));
    }
    let (poses, page) = page_tracker(page_timing()?);
    let (device, simulated) = options.start(vec![page], recording.map(tick_recorder))?;
    let (port, remote) = (device.port(), device.remote());
    options.arm_if_asked(&remote);
    Ok((Some((device, simulated)), Some(Haptics { port, remote, poses })))
}

fn start(
    args: &Args,
    source: &SceneSource,
    live_options: live::Options,
    recording: Option<&mut Recording>,
) -> Result<(Option<Device>, Live, Server), CliError> {
    let (device, haptics) = feel(&args.devices, recording)?;
    let live_options = live::Options { haptics, ..live_options };
    let (live, hub) = told(|| Ok(Live::start(source, live_options)?))?;
    Ok((device, live, args.page.serve(hub)?))
}

impl From<LiveError> for CliError {
    fn from(error: LiveError) -> Self {
        match error {
            LiveError::Thread(_) => Self::Other(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}
