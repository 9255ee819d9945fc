//! Requests to the loop, from any thread and at any time, and its answers.

use crate::Rendering;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use thenar_core::histogram::Histogram;
use thenar_core::model::Side;

/// Statement of what arming a device means, shown to the user who does it.
pub const STATEMENT: &str = "Research use only. This program and its safety limits are certified \
                             for nothing. Arm a device only if you can take the hand out of it, or \
                             switch it off, at any moment.";

/// Requests to the loop, and its heartbeat.
#[derive(Debug)]
pub struct Control {
    pub(super) arm: AtomicBool,
    pub(super) stop: AtomicBool,
    /// Whoever armed has gone.
    pub(super) abandon: AtomicBool,
    /// Whoever armed does not answer.
    pub(super) unanswered: AtomicBool,
    pub(super) quit: AtomicBool,
    /// A dead-man switch is held, or there is none.
    pub(super) enabled: AtomicBool,
    /// The loop has ended by a panic.
    pub(super) failed: AtomicBool,
    /// Time at which the last tick ended \[ns\]; 0 before the first.
    pub(super) beat_ns: AtomicU64,
    /// Number of times that the watchdog had to step in.
    pub(super) barks: AtomicU64,
    /// Records that found no room.
    pub(super) lost: AtomicU64,
    /// The system has refused to lock memory.
    pub(super) unlocked: AtomicBool,
    /// Reports of threads without a place in the status.
    notes: Mutex<Vec<String>>,
    pub(super) status: Mutex<Status>,
}

impl Default for Control {
    fn default() -> Self {
        Self {
            arm: AtomicBool::new(false),
            stop: AtomicBool::new(false),
            abandon: AtomicBool::new(false),
            unanswered: AtomicBool::new(false),
            quit: AtomicBool::new(false),
            enabled: AtomicBool::new(true),
            failed: AtomicBool::new(false),
            beat_ns: AtomicU64::new(0),
            barks: AtomicU64::new(0),
            lost: AtomicU64::new(0),
            unlocked: AtomicBool::new(false),
            notes: Mutex::default(),
            status: Mutex::default(),
        }
    }
}

impl Control {
    /// A panic while the status was held did no harm to it.
    pub(super) fn status(&self) -> MutexGuard<'_, Status> {
        self.status.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Leaves a message for the monitor. Not for the loop.
    pub(super) fn note(&self, message: String) {
        self.notes.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    }

    /// Messages left since this was last asked.
    pub(super) fn take_notes(&self) -> Vec<String> {
        std::mem::take(&mut *self.notes.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Arms and stops; cheap to clone, for any thread. None of it waits for the simulation.
#[derive(Clone, Debug)]
pub struct Remote(pub(super) Arc<Control>);

impl Remote {
    /// Lets forces through from the next tick on, after the guards' wait and ramp. Who asks for it
    /// has shown [`STATEMENT`].
    pub fn arm(&self) {
        self.0.stop.store(false, Ordering::Release);
        self.0.abandon.store(false, Ordering::Release);
        self.0.unanswered.store(false, Ordering::Release);
        self.0.arm.store(true, Ordering::Release);
    }

    /// Zero from the next tick on, until armed.
    pub fn stop(&self) {
        self.0.arm.store(false, Ordering::Release);
        self.0.stop.store(true, Ordering::Release);
    }

    /// Whoever armed has gone: forces fade as fast as their slew limits let them, and are stopped
    /// once they are zero, until armed.
    pub fn abandon(&self) {
        self.0.arm.store(false, Ordering::Release);
        self.0.abandon.store(true, Ordering::Release);
    }

    /// Whoever armed does not answer any more: as [`Remote::abandon`].
    pub fn unanswered(&self) {
        self.0.arm.store(false, Ordering::Release);
        self.0.unanswered.store(true, Ordering::Release);
    }

    /// Says whether a dead-man switch is held. Released, forces fade; held again they return
    /// through wait and ramp.
    pub fn hold(&self, held: bool) {
        self.0.enabled.store(held, Ordering::Release);
    }

    /// Returns the loop's status some hundredths of a second ago.
    pub fn status(&self) -> Status {
        self.0.status().clone()
    }
}

/// State of the displays.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum State {
    /// Nothing has been armed: zeros go out.
    #[default]
    DryRun,
    /// Armed; no force yet, or no more for now, and why.
    Waiting(String),
    /// Growing to full force.
    Ramping,
    /// Full force.
    Live,
    /// Stopped until armed again, and why.
    Tripped(String),
    /// The loop is dead.
    Failed,
}

impl State {
    /// In one word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::DryRun => "dry-run",
            Self::Waiting(_) => "waiting",
            Self::Ramping => "ramping",
            Self::Live => "live",
            Self::Tripped(_) => "tripped",
            Self::Failed => "failed",
        }
    }

    /// Why, where there is a reason.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Waiting(why) | Self::Tripped(why) if !why.is_empty() => Some(why),
            _ => None,
        }
    }
}

/// One device, as of some tenths of a second ago.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceStatus {
    /// Address of the device, such as `lucidgloves:/dev/ttyUSB0`.
    pub name: String,
    /// True while the device is reached.
    pub connected: bool,
    /// Since it last said something that made sense \[s\]; `None` before the first time.
    pub silence: Option<f64>,
    /// True if the device tracks hands.
    pub tracks: bool,
    /// True if the device shows forces.
    pub shows: bool,
}

/// One hand, as of the last tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandStatus {
    /// Side of the hand.
    pub side: Side,
    /// A tracker moves it now.
    pub tracked: bool,
    /// Index of that tracker among the devices that track.
    pub tracker: Option<u8>,
    /// Age of the simulation's frame \[s\].
    pub simulation_age: f64,
    /// The display that the hand feels, by its number, and what that display renders.
    pub display: Option<(u8, Rendering)>,
    /// Stiffest that a blocked finger is felt \[N/m\], and the delay from motion to force that
    /// bounds it \[s\].
    pub felt_stiffness: f64,
    /// See `felt_stiffness`.
    pub delay: f64,
    /// Largest force that the display may be sent, per finger or in all \[N\].
    pub force_max: f64,
    /// Forces asked for and sent \[N\]: thumb first, or x, y and z of a display of one point.
    pub forces: [[f64; 2]; crate::DIGITS],
}

/// Status of the loop.
#[derive(Clone, Debug, Default)]
pub struct Status {
    /// State of the display that passes least.
    pub state: State,
    /// Ticks per second wanted.
    pub rate_hz: f64,
    /// Ticks so far, ticks left out, and ticks whose record was lost.
    pub ticks: u64,
    /// Deadlines that passed without a tick.
    pub missed: u64,
    /// Records that found no room: the monitor was kept waiting.
    pub lost: u64,
    /// Number of times that the watchdog stepped in.
    pub barks: u64,
    /// Time between ticks \[ns\].
    pub period: Histogram,
    /// Lateness of ticks at their beginning \[ns\].
    pub late: Histogram,
    /// Cost of a tick \[ns\].
    pub cost: Histogram,
    /// From the reception of a pose to the output that was computed from it \[ns\].
    pub latency: Histogram,
    /// The devices that have a name.
    pub devices: Vec<DeviceStatus>,
    /// The hands.
    pub hands: Vec<HandStatus>,
    /// Refusals by the system, such as of real-time priority.
    pub warnings: Vec<String>,
    /// Messages of devices and of the loop since the start, the last few.
    pub messages: Vec<String>,
}
