//! The thread behind an open device.
//!
//! It runs a [`Protocol`] over a [`Transport`], takes the device up again whenever it returns, and
//! exchanges newest values with its callers through wait-free slots: no call of theirs waits for
//! it, nor it for them. What it guarantees, whatever device and callers do:
//!
//! - a sample is seen as soon as its last byte was read, an output is sent within a millisecond;
//! - samples of a hand have strictly increasing times, none in the future, and finite poses;
//! - what leaves for a display is finite, within its limits and its slew, and of one hand where it
//!   holds one (`Door`);
//! - the hand is released when no output came for [`OUTPUT_SILENCE_NS`], when the display is
//!   dropped, on [`release_all`], when the protocol panics, on every loss and at every start;
//! - a process of its own, the [keeper](crate::keeper), does that when this program is stopped or
//!   killed, where the device can be told and the program says how a keeper is started;
//! - a device that is away is asked for ever more rarely, once a second in the end; messages report
//!   absence, silence and garbage, at a bounded rate.

mod door;
mod handles;
#[cfg_attr(not(unix), path = "unkept.rs")]
mod kept;
mod messages;
mod notice;
mod run;
#[cfg(test)]
mod tests;

use crate::{LinkError, Opened, Presence, Protocol, Rendering, Transport};
pub use door::Door;
use handles::{DeviceDisplay, DeviceTracker, WorkerHandle};
use messages::Messages;
use run::{Worker, WorkerEndpoints};
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, Weak};
use std::time::{Duration, Instant};
use thenar_core::model::Side;
use thenar_touch::safety::Limits;
use thenar_touch::{LoopProfile, TrackerTiming, lock_soon};
use triple_buffer::triple_buffer;

/// Without a new output for so long, the hand is released \[ns\].
pub const OUTPUT_SILENCE_NS: u64 = 20_000_000;
/// Longest wait for bytes, hence the longest that an output waits for the thread.
const POLL: Duration = Duration::from_micros(500);
/// Pauses between attempts to reach a device that is away.
const BACK_OFF: [Duration; 2] = [Duration::from_millis(50), Duration::from_millis(1000)];
/// Longest that closing waits for the thread to say its last words.
const CLOSING: Duration = Duration::from_millis(1500);

/// Opens a transport, each time anew. Returns within a second or so; an error means that the device
/// is not there now.
pub type Connect = Box<dyn FnMut() -> io::Result<Box<dyn Transport>> + Send>;

/// Traits of a tracker that are known beforehand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackerTraits {
    /// Length of the wearer's hand, wrist to middle fingertip \[m\].
    pub hand_length: Option<f64>,
    /// Rate, delay and noise of the samples.
    pub timing: Option<TrackerTiming>,
}

/// Abilities of a display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayTraits {
    /// Kind of output that it renders.
    pub rendering: Rendering,
    /// Limits of its actuators.
    pub limits: Limits,
    /// Limits of its torque, if it turns anything.
    pub torque_limits: Option<Limits>,
    /// Bounds on the stiffness of a coupling to the display.
    pub loop_profile: LoopProfile,
}

/// A device about to be opened.
pub struct Device {
    /// Driver and address, as `lucidgloves:/dev/ttyUSB0`; begins every message.
    pub name: String,
    /// Opens a transport to the device.
    pub connect: Connect,
    /// Protocol of the device.
    pub protocol: Box<dyn Protocol>,
    /// Set if it tells where hands are.
    pub tracks: Option<TrackerTraits>,
    /// Set if it shows forces.
    pub display: Option<DisplayTraits>,
    /// True if it speaks on its own or answers, so that silence means something.
    pub speaks: bool,
}

impl Device {
    /// A device that only tells where hands are, and speaks on its own.
    pub fn tracker(name: String, connect: Connect, protocol: Box<dyn Protocol>) -> Self {
        let tracks = Some(TrackerTraits::default());
        Self { name, connect, protocol, tracks, display: None, speaks: true }
    }

    /// The device, of whose samples its profile states this.
    pub fn timed(mut self, timing: TrackerTiming) -> Self {
        let timing = Some(timing);
        self.tracks = self.tracks.map(|traits| TrackerTraits { timing, ..traits });
        self
    }

    /// Starts its thread. A device that is away is taken up when it comes.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn open(self) -> Result<Opened, LinkError> {
        let shared = Arc::new(Shared::new(&self.name));
        let [sample_left, sample_right] = [(); 2].map(|()| triple_buffer(&None));
        let [output_left, output_right] =
            [Side::Left, Side::Right].map(|s| triple_buffer(&crate::HandOutput::released(s, 0)));
        let ends = WorkerEndpoints {
            samples: [sample_left.0, sample_right.0],
            outputs: [output_left.1, output_right.1],
        };
        let (tracks, display) = (self.tracks, self.display);
        let name = self.name.clone();
        let worker = Worker::new(self, shared.clone(), ends);
        let thread =
            std::thread::Builder::new().name("device".into()).spawn(move || worker.run()).map_err(
                |e| LinkError::Open { device: name, cause: format!("cannot start a thread: {e}") },
            )?;
        shared.register();
        let closer = Arc::new(WorkerHandle::new(shared, thread));
        Ok(Opened {
            tracker: tracks.map(|traits| {
                DeviceTracker::boxed(closer.clone(), [sample_left.1, sample_right.1], traits)
            }),
            display: display
                .map(|d| DeviceDisplay::boxed(closer.clone(), [output_left.0, output_right.0], d)),
        })
    }
}

/// State that thread and callers share besides the slots.
struct Shared {
    /// The thread shall end.
    stop: AtomicBool,
    /// The display is gone: outputs mean nothing any more.
    display_closed: AtomicBool,
    /// The thread has said its last words.
    ended: AtomicBool,
    /// Time when the device was last heard \[ns\]; 0 for never.
    heard_ns: AtomicU64,
    /// The transport is open.
    connected: AtomicBool,
    name: String,
    messages: Mutex<Messages>,
}

impl Shared {
    fn new(name: &str) -> Self {
        Self {
            stop: AtomicBool::new(false),
            display_closed: AtomicBool::new(false),
            ended: AtomicBool::new(false),
            heard_ns: AtomicU64::new(0),
            connected: AtomicBool::new(false),
            name: name.into(),
            messages: Mutex::new(Messages::new(name)),
        }
    }

    /// The messages; a panic elsewhere while they were held does no harm to them.
    fn messages(&self) -> std::sync::MutexGuard<'_, Messages> {
        self.messages.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    fn heard(&self) -> Option<u64> {
        Some(self.heard_ns.load(Ordering::Relaxed)).filter(|ns| *ns > 0)
    }

    fn presence(&self) -> Presence {
        let connected = self.connected.load(Ordering::Relaxed);
        Presence { name: self.name.clone(), connected, heard_ns: self.heard() }
    }

    fn register(self: &Arc<Self>) {
        let mut open = all().lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        open.retain(|device| device.strong_count() > 0);
        open.push(Arc::downgrade(self));
    }
}

/// Every device that is open in this process.
fn all() -> &'static Mutex<Vec<Weak<Shared>>> {
    static ALL: Mutex<Vec<Weak<Shared>>> = Mutex::new(Vec::new());
    &ALL
}

/// Releases every hand and ends every device's thread, for ways out that drop nothing: a signal, a
/// panic hook, `exit`. Waits until the last words are said, or for `wait`; true when all were.
pub fn release_all(wait: Duration) -> bool {
    // A panic may come while the list is held by this very thread: then the 20 ms of silence
    // release the hand.
    let Some(open) = lock_soon(all()) else { return false };
    let devices: Vec<_> = open.iter().filter_map(Weak::upgrade).collect();
    drop(open);
    devices.iter().for_each(|device| device.stop.store(true, Ordering::Release));
    let start = Instant::now();
    let ended = || devices.iter().all(|device| device.ended.load(Ordering::Acquire));
    while !ended() && start.elapsed() < wait {
        std::thread::sleep(Duration::from_micros(200));
    }
    ended()
}
