//! `thenar touch`: a scene felt through devices, without a page.

mod devices;
mod report;
mod simulated;
mod ticks;

pub use devices::{DeviceOptions, MessagePrinter, ModeWord};
pub use simulated::Simulated;
pub use ticks::recorder as tick_recorder;

use crate::error::CliError;
use crate::interrupt;
use crate::recording::{RecordOptions, Recording};
use crate::run::{open_live, tell};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use thenar_link::haptic_loop::{DeadlineTimer, Deadlines, Histogram, Remote, SimulationPort};
use thenar_link::now_ns;
use thenar_scene::recording::TimeOf;
use thenar_scene::session::Session;

/// Feel a scene through devices, without a page.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene file, or the name of a built-in scene (see `thenar scenes`).
    scene: PathBuf,
    /// End after so long [s]; without it Ctrl-C does.
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Change a value of the scene, e.g. solver.cone=linearised; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Options of devices.
    #[command(flatten)]
    devices: DeviceOptions,
    /// Options of the recording.
    #[command(flatten)]
    recording: RecordOptions,
    /// No line per second.
    #[arg(long, short)]
    quiet: bool,
}

/// Performance of the simulation beside the loop.
pub struct SimulationTiming {
    /// Time of each step, with its frame \[ns\].
    pub costs: Histogram,
    /// Simulated over real time.
    pub speed: f64,
}

/// Runs until its time is over, or Ctrl-C.
///
/// # Errors
/// Scene or device is wrong, or the loop failed.
pub fn run(args: &Args) -> Result<(), CliError> {
    let sound = |s: f64| s > 0.0 && s <= 1e9;
    if args.seconds.is_some_and(|s| !sound(s)) {
        return Err(CliError::Input("--seconds must be more than 0 s and at most 1e9 s".into()));
    }
    if args.devices.devices.is_empty() {
        let advice = "no --device is given; `thenar devices` lists what there is";
        return Err(CliError::Input(advice.into()));
    }
    let mut session = open_live(&args.scene, &args.set)?;
    tell(&session);
    interrupt::listen();
    let mut recording = match Recording::start(&args.recording, TimeOf::Clock)? {
        Some((recording, witness)) => {
            session.set_witness(witness);
            Some(recording)
        }
        None => None,
    };
    let ticks = recording.as_mut().map(tick_recorder);
    let (device, _simulated) = match args.devices.start(Vec::new(), ticks) {
        Ok(started) => started,
        Err(error) => {
            recording.map(Recording::discard).unwrap_or_default();
            return Err(error);
        }
    };
    let (remote, mut port) = (device.remote(), device.port());
    if let Err(error) = port.attach(&session) {
        drop((session, device));
        recording.map(Recording::discard).unwrap_or_default();
        return Err(CliError::Input(error.to_string()));
    }
    args.devices.arm_if_asked(&remote);
    let beside = simulate(&mut session, &mut port, &remote, args, recording.as_mut())?;
    let status = remote.status();
    drop(device);
    drop(session.take_witness());
    let recorded = recording.map(Recording::finish).transpose();
    // What was found out is worth telling even when the disk was full.
    report::print(&status, &beside);
    recorded?;
    match status.state.word() {
        "failed" => Err(CliError::Other("the haptic loop failed".into())),
        _ => Ok(()),
    }
}

/// Steps the scene in real time; where a step costs more than it may, in slow motion.
fn simulate(
    session: &mut Session,
    port: &mut SimulationPort,
    remote: &Remote,
    args: &Args,
    mut recording: Option<&mut Recording>,
) -> Result<SimulationTiming, CliError> {
    let timer = DeadlineTimer::set();
    let period = Duration::from_secs_f64(session.world().time_step());
    let mut deadlines = Deadlines::new(period, now_ns());
    let (begun, mut simulated, mut message_printer) =
        (Instant::now(), 0.0, MessagePrinter::default());
    let mut costs = Histogram::default();
    let mut second = 1;
    loop {
        let elapsed = begun.elapsed().as_secs_f64();
        if interrupt::asked() || args.seconds.is_some_and(|end| elapsed >= end) {
            return Ok(SimulationTiming { costs, speed: simulated / elapsed.max(1e-9) });
        }
        if elapsed >= f64::from(second) {
            second += 1;
            message_printer.tell(remote);
            if !args.quiet {
                report::line(elapsed, &remote.status());
            }
        }
        if let Some(recording) = &mut recording {
            recording.complain();
        }
        timer.wait(deadlines.next_ns());
        let began = now_ns();
        port.before_step(session, began).map_err(|error| CliError::Input(error.to_string()))?;
        session.step(&mut ());
        port.after_step(session, now_ns());
        let ended = now_ns();
        costs.add(ended - began);
        simulated += session.world().time_step();
        deadlines.advance(began, ended);
    }
}
