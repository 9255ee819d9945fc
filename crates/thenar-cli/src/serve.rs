//! `thenar serve`: a scene live, for pages and headsets.

use crate::error::CliError;
use crate::recording::{RecordOptions, Recording};
use crate::run::{Found, find};
use crate::touch::{DeviceOptions, Teller, WavingGlove, tick_recorder};
use crate::{files, interrupt};
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::time::Duration;
use thenar_link::haptic_loop::{HapticLoop, page_tracker};
use thenar_scene::recording::TimeOf;
use thenar_serve::http::{Limits, Options, Port, Reach, Server, StartError};
use thenar_serve::live::{self, Haptics, Live, LiveError, SceneSource};
use thenar_serve::page;

/// The port where nothing else is asked for.
const PORT: u16 = 8014;

/// Serve a scene live to browsers and headsets.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene file, or the name of a built-in scene (see `thenar scenes`).
    #[arg(default_value = crate::DEMO)]
    scene: PathBuf,
    /// Listen on this port, or fail; without it on 8014 or the next free one.
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    /// Let headsets and other computers on the network in: HTTPS, with a pairing token.
    #[arg(long)]
    lan: bool,
    /// Open the page in a browser, whether or not this looks like a desktop.
    #[arg(long, overrides_with = "no_open")]
    open: bool,
    /// Do not open a browser.
    #[arg(long, overrides_with = "open")]
    no_open: bool,
    /// Change a value of the scene, e.g. solver.cone=linearised; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Time step of the scene [s]; short for --set time_step=S.
    #[arg(long, value_name = "S")]
    time_step: Option<f64>,
    /// Devices to feel it with.
    #[command(flatten)]
    devices: DeviceOptions,
    /// Recording.
    #[command(flatten)]
    recording: RecordOptions,
}

impl Args {
    /// A built-in scene with nothing else asked for.
    pub fn of_scene(scene: &str) -> Self {
        Self {
            scene: scene.into(),
            port: None,
            lan: false,
            open: false,
            no_open: false,
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
        Found::File(path) => SceneSource::File(path),
        Found::Builtin(known) => SceneSource::Builtin(known.name.into()),
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
    announce(args, &server);
    if wants_browser(args) {
        // Where there is none, the address stands there to be clicked on.
        let _ = server.urls().first().map(open::that_detached);
    }
    let mut teller = Teller::default();
    while !interrupt::asked() {
        std::thread::sleep(Duration::from_millis(50));
        if let Some((device, _)) = &device {
            teller.tell(&device.remote());
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

/// The loop with its simulated gloves.
type Device = (HapticLoop, Vec<WavingGlove>);

/// Opens the devices, if there are any. The page's poses are a tracker beside theirs.
fn feel(
    options: &DeviceOptions,
    recording: Option<&mut Recording>,
) -> Result<(Option<Device>, Option<Haptics>), CliError> {
    if options.devices.is_empty() {
        return Ok((None, None));
    }
    let (poses, page) = page_tracker();
    let (device, twins) = options.start(vec![page], recording.map(tick_recorder))?;
    let (port, remote) = (device.port(), device.remote());
    options.arm_if_asked(&remote);
    Ok((Some((device, twins)), Some(Haptics { port, remote, poses })))
}

fn start(
    args: &Args,
    source: &SceneSource,
    live_options: live::Options,
    recording: Option<&mut Recording>,
) -> Result<(Option<Device>, Live, Server), CliError> {
    let (device, haptics) = feel(&args.devices, recording)?;
    let live_options = live::Options { haptics, ..live_options };
    let (live, hub) = Live::start(source, live_options)?;
    let options = Options {
        reach: if args.lan { Reach::Lan } else { Reach::Desk },
        address: None,
        port: args.port.map_or(Port::From(PORT), Port::Exactly),
        limits: Limits::default(),
    };
    let server = Server::start(&options, hub)?;
    Ok((device, live, server))
}

fn announce(args: &Args, server: &Server) {
    let port = server.address().port();
    if args.port.is_none() && port != PORT {
        println!("Port {PORT} is taken, so this is on {port}.");
    }
    println!("{} is live at", args.scene.display());
    for url in server.urls() {
        println!("  {url}");
    }
    if !page::BUILT {
        println!("Its page was not built; open the address to see why.");
    }
    if let Some(code) = args.lan.then(|| server.qr_code()).flatten() {
        print_code(&code);
    }
    if let Some(fingerprint) = server.fingerprint() {
        println!(
            "Whoever has such an address can watch, and move the hand. The browser will warn, as \
             nobody\nvouches for a certificate made just now. Its SHA-256 fingerprint:\n  \
             {fingerprint}"
        );
    }
    println!("Ctrl-C ends it.");
}

/// Whatever the terminal's colours, the code is light on dark there.
fn print_code(code: &str) {
    let (begin, end) = match std::io::stdout().is_terminal() {
        true => ("\x1b[97;40m", "\x1b[0m"),
        false => ("", ""),
    };
    for line in code.lines() {
        println!("{begin}{line}{end}");
    }
}

/// A browser is opened on a desktop, by a person, for this computer's own address.
fn wants_browser(args: &Args) -> bool {
    if args.open || args.no_open {
        return args.open;
    }
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let windows = cfg!(any(windows, target_os = "macos"));
    let desktop = windows || set("DISPLAY") || set("WAYLAND_DISPLAY");
    let person = std::io::stdout().is_terminal() && !set("CI") && !set("SSH_CONNECTION");
    !args.lan && desktop && person
}

impl From<LiveError> for CliError {
    fn from(error: LiveError) -> Self {
        match error {
            LiveError::Thread(_) => Self::Other(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<StartError> for CliError {
    fn from(error: StartError) -> Self {
        match error {
            StartError::PortTaken(_) | StartError::Listen { .. } => Self::Input(error.to_string()),
            _ => Self::Other(error.to_string()),
        }
    }
}
