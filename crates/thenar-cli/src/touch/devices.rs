//! Devices on the command line, and what the loop has to tell.

use super::simulated::Simulated;
use crate::error::CliError;
use std::path::PathBuf;
use thenar_link::haptic_loop::{
    HapticLoop, LoopError, LoopMode, RecordCallback, Remote, STATEMENT, Settings,
};
use thenar_link::wearer::{Wearer, limited_to_comfort};
use thenar_link::{ForceDisplay, LinkError, Tracker};

/// Devices, and how they are felt.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct DeviceOptions {
    /// A tracker, a force display, or both, e.g. lucidgloves:/dev/ttyUSB0 (see `thenar devices`);
    /// may be given several times. For trying without hardware `simulated` is a glove that opens
    /// and closes by itself, and `simulated:cybergrasp` the paper's: a CyberGlove with a CyberGrasp
    /// on it.
    #[arg(long = "device", value_name = "NAME:ADDRESS")]
    pub devices: Vec<String>,
    /// Mode in which touch joins the tracked hand and the simulation.
    #[arg(long, value_enum, default_value_t, requires = "devices")]
    pub mode: ModeWord,
    /// Let forces through from the start. Without it the displays get zeros until somebody arms
    /// them: a dry run.
    #[arg(long, requires = "devices")]
    pub arm: bool,
    /// Ticks of the haptic loop per second.
    #[arg(long, value_name = "HZ", default_value_t = 1000.0, requires = "devices")]
    pub rate: f64,
    /// Part of a device's rated force that is allowed, 0 to 1, where it is less than the device's
    /// profile allows.
    #[arg(long, value_name = "PART", requires = "devices")]
    pub force: Option<f64>,
    /// Name of the wearer: no more force than `thenar devices comfort` found for that name. Without
    /// a name it is what was found for whoever is not named, if anything was.
    #[arg(long, value_name = "NAME", requires = "devices")]
    pub wearer: Option<String>,
    /// Start no keepers: processes that let the wearer go when this program is stopped or killed.
    #[arg(long, requires = "devices")]
    pub no_keeper: bool,
    /// Folder to which the last seconds of signals are written when the safety limits stop the
    /// forces.
    #[arg(long, value_name = "DIR", default_value = ".", requires = "devices")]
    pub trips: PathBuf,
}

/// A mode, as on the command line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum ModeWord {
    /// Proxies beside a slower simulation, as in the paper.
    Multirate,
    /// The whole simulation within each tick of the loop.
    SingleRate,
    /// Proxies, with contact solved in each tick on what the simulation publishes; as `multirate`
    /// where its solver publishes nothing.
    #[default]
    Shared,
}

impl From<ModeWord> for LoopMode {
    fn from(word: ModeWord) -> Self {
        match word {
            ModeWord::Multirate => Self::Multirate,
            ModeWord::SingleRate => Self::SingleRate,
            ModeWord::Shared => Self::Shared,
        }
    }
}

impl DeviceOptions {
    /// Opens the devices and starts the loop with them, and with `more` trackers; `watcher` sees
    /// every tick.
    ///
    /// # Errors
    /// A device or a setting is wrong.
    pub fn start(
        &self,
        more: Vec<Box<dyn Tracker>>,
        watcher: Option<RecordCallback>,
    ) -> Result<(HapticLoop, Simulated), CliError> {
        if self.force.is_some_and(|part| !(0.0..=1.0).contains(&part)) {
            return Err(CliError::Input("--force must be 0 to 1".into()));
        }
        if !self.trips.is_dir() {
            let folder = self.trips.display();
            return Err(CliError::Input(format!("--trips {folder} is not a folder")));
        }
        let wearer = Wearer::load(self.wearer.as_deref())?;
        if !self.no_keeper {
            crate::keeper::enable();
        }
        let mut simulated = Simulated::default();
        let (mut trackers, mut displays) = (Vec::new(), Vec::<Box<dyn ForceDisplay>>::new());
        for address in &self.devices {
            for address in simulated.addresses(address)? {
                let opened = thenar_link::open(&address)?;
                trackers.extend(opened.tracker);
                displays.extend(opened.display.map(|display| dressed(display, &address, &wearer)));
            }
        }
        trackers.extend(more);
        let settings = Settings {
            rate_hz: self.rate,
            mode: self.mode.into(),
            user_fraction: self.force,
            trip_folder: Some(self.trips.clone()),
            watcher,
            ..Settings::default()
        };
        let device = HapticLoop::start(settings, trackers, displays)?;
        for warning in device.remote().status().warnings {
            eprintln!("warning: {warning}");
        }
        Ok((device, simulated))
    }

    /// Says what arming means, and arms if that was asked for.
    pub fn arm_if_asked(&self, remote: &Remote) {
        if self.arm {
            println!("ARMED. {STATEMENT}");
            remote.arm();
        } else {
            println!("Dry run: displays get zeros until they are armed.");
        }
    }
}

/// The display as its wearer wants it; prints the wearer's choice.
fn dressed(
    display: Box<dyn ForceDisplay>,
    address: &str,
    wearer: &Wearer,
) -> Box<dyn ForceDisplay> {
    let (display, comfort) = limited_to_comfort(display, address, wearer);
    if let (Some(comfort), Some(file)) = (comfort, &wearer.file) {
        println!("{address}: {comfort}, by {}", file.display());
    }
    display
}

/// Prints what devices and loop have to tell, each once.
#[derive(Debug, Default)]
pub struct MessagePrinter {
    told: Vec<String>,
}

impl MessagePrinter {
    /// Prints what is new.
    pub fn tell(&mut self, remote: &Remote) {
        let messages = remote.status().messages;
        // The list only ever loses its oldest: what was told last is somewhere in it.
        let overlap = (0..=messages.len().min(self.told.len()))
            .rev()
            .find(|&n| messages[..n] == self.told[self.told.len() - n..])
            .unwrap_or(0);
        for message in &messages[overlap..] {
            eprintln!("{message}");
        }
        self.told = messages;
    }
}

impl From<LoopError> for CliError {
    fn from(error: LoopError) -> Self {
        LinkError::from(error).into()
    }
}

impl From<LinkError> for CliError {
    fn from(error: LinkError) -> Self {
        match error {
            LinkError::Setting { .. } | LinkError::Open { .. } => Self::Input(error.to_string()),
            _ => Self::Other(error.to_string()),
        }
    }
}
