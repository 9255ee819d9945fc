//! The real-time shell of touch: a thread that ticks at the device's rate, whatever the simulation
//! does.
//!
//! ```text
//!  trackers ──newest──► ┌──────────────┐ ──newest──► displays (each behind its guards)
//!                       │  the loop    │
//!  simulation ─frames─► │  1 kHz       │ ─proxies──► simulation
//!   (its own pace)      └──────┬───────┘
//!                       records│ring         watchdog: zeros when the loop misses 20 ms
//!                              ▼
//!                           monitor: histograms, status, what led to a trip
//! ```
//!
//! - The **loop** ([`HapticLoop`]) allocates nothing, waits for nobody, writes no log and makes no
//!   system call but the clock's; physics is in this crate, and what it takes and gives goes
//!   through slots that hold the newest value. Its memory is behind a mutex that it only ever
//!   *tries*: another thread may hold it for a moment, to put other hands in, and the loop then
//!   leaves out a tick and counts it.
//! - The **watchdog** is a thread of its own, of higher priority, that sends zeros when no tick has
//!   ended for 20 ms. Behind it each device's thread does the same for itself.
//! - The **monitor** is a thread without priority: it counts how late ticks are, keeps the last
//!   five seconds of signals and writes them into a file when the guards trip.
//! - Displays get zeros until [`Remote::arm`]: a dry run. Every way out sends zeros: the end of the
//!   program, a signal (with [`stop_all`] in its handler), a panic in any of the threads, a lost
//!   device, a lost simulation. A process that is killed outright can send nothing: a keeper
//!   (`thenar-link` has it) does it in its place, for devices that can be told.
//! - What entered in the last seconds is kept and written down at a trip ([`incident`]), so that it
//!   can be made again to the same bits.
//!
//! The simulation's side is a [`SimulationPort`]: called before and after each step, on whatever
//! thread steps.

mod actuators;
mod control;
mod core;
mod deadlines;
mod error;
mod exchange;
mod hand;
pub mod incident;
mod manual;
mod monitor;
mod page;
mod pauses;
mod port;
mod presence;
mod record;
mod settings;
mod simulation;
mod turning;
mod watchdog;

pub use actuators::{Actuators, Axis, Capability, Liveness};
pub use control::{DeviceStatus, HandStatus, Remote, STATEMENT, State, Status};
pub use core::{Core, TickTime};
pub use deadlines::{DeadlineTimer, Deadlines};
pub use error::LoopError;
pub use exchange::{FingerContact, Frame, Lead, LoopEndpoints, SimulationEndpoints, slots};
pub use hand::LoopHand;
pub use manual::ManualLoop;
pub use monitor::RecordCallback;
pub use page::{PagePoses, page_tracker};
pub use port::{LoopMode, PortError, SimulationPort};
pub use record::{TickRecord, header, line, word};
pub use settings::Settings;
pub use simulation::{SimulatedHand, Simulation};
pub use thenar_core::histogram::Histogram;

use crate::realtime::{PriorityClass, lock_memory, raise_priority, touch_stack};
use crate::safety::Trip;
use crate::{CouplingDesign, FeltBounds, ForceDisplay, Tracker, now_ns};
use control::Control;
use incident::{IncidentReader, IncidentWriter};
use monitor::Monitor;
use presence::PresenceChecks;
use rtrb::Consumer;
use settings::{bounds_of, fitted, limits_of};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError, TryLockError, Weak};
use std::thread::JoinHandle;
use std::time::Duration;

/// Records that may wait for the monitor.
const RECORDS: usize = 16_384;
/// Time that the threads have to end.
const ENDING: Duration = Duration::from_millis(500);
/// Time that the monitor has to end, perhaps with an incident of tens of MB to write; forces have
/// ended by then.
const WRITING: Duration = Duration::from_secs(10);
/// Name of the monitor's thread.
const MONITOR: &str = "monitor";

/// State that the threads share.
pub struct Shared {
    core: Mutex<Core>,
    displays: Mutex<Vec<Box<dyn ForceDisplay>>>,
    /// Abilities of each display.
    capabilities: Vec<Capability>,
    control: Arc<Control>,
    /// Frames of the last seconds, where incidents are kept.
    frames: Option<incident::Frames>,
    /// A thread ticks in real time; else whoever holds the loop says when.
    in_real_time: bool,
}

impl Shared {
    /// Locks what hands brought along that are about to be felt. A loop that was refused it from
    /// the start has said so.
    fn lock_hands(&self) {
        if !self.in_real_time || self.control.unlocked.load(Ordering::Acquire) {
            return;
        }
        if let Err(cause) = lock_memory() {
            self.control.unlocked.store(true, Ordering::Release);
            let limit = "the limit of locked memory is too low for these hands";
            self.control.note(without("locked memory", &format!("{cause}: {limit}")));
        }
    }
}

/// A running loop; dropping it sends zeros, ends its threads and closes the devices.
pub struct HapticLoop {
    shared: Arc<Shared>,
    mode: LoopMode,
    design: CouplingDesign,
    bounds: FeltBounds,
    threads: Vec<JoinHandle<()>>,
}

impl HapticLoop {
    /// Starts the threads, without a hand: a [`SimulationPort`] puts them in.
    ///
    /// # Errors
    /// A setting or a device's limits make no sense, or the system gives no thread.
    pub fn start(
        settings: Settings,
        trackers: Vec<Box<dyn Tracker>>,
        displays: Vec<Box<dyn ForceDisplay>>,
    ) -> Result<Self, LoopError> {
        let Settings { rate_hz, mode, .. } = settings;
        let message_sources = (trackers.iter().map(|tracker| tracker.message_source()))
            .chain(displays.iter().map(|display| display.message_source()))
            .collect();
        let presence_checks = PresenceChecks::of(&trackers, &displays);
        let (design, too_stiff) = fitted(&settings, &displays);
        let limits = limits_of(&settings, &displays);
        let bounds = bounds_of(&settings, &displays);
        let (shared, monitored) = share(&settings, trackers, displays, true)?;
        let mut new = Self { shared, mode, design, bounds, threads: Vec::new() };
        let (told, warnings) = std::sync::mpsc::channel();
        let shared = new.shared.clone();
        let period = Duration::from_secs_f64(1.0 / rate_hz);
        new.spawn("haptics", move || {
            let urgent = raise_priority(PriorityClass::Loop);
            // The stack first, so that it is locked with the rest.
            touch_stack();
            let locked = lock_memory();
            shared.control.unlocked.store(locked.is_err(), Ordering::Release);
            let refused = [
                urgent.err().map(|cause| without("real-time priority", &cause)),
                locked.err().map(|cause| without("locked memory", &cause)),
            ];
            let _ = told.send(refused.into_iter().flatten().collect());
            drop(told);
            run(&shared, period);
        })?;
        let shared = new.shared.clone();
        new.spawn("watchdog", move || watchdog::run(&shared))?;
        let monitor = Monitor {
            shared: new.shared.clone(),
            records: monitored.records,
            incident_reader: monitored.incident_reader,
            watcher: settings.watcher,
            incidents: std::collections::VecDeque::new(),
            folder: settings.trip_folder,
            warnings: [too_stiff, warnings.recv_timeout(ENDING).unwrap_or_default()].concat(),
            message_sources,
            presence_checks,
            displays: limits,
            rate_hz,
        };
        new.shared.control.status().warnings.clone_from(&monitor.warnings);
        new.spawn(MONITOR, move || monitor.run())?;
        Ok(new)
    }

    fn spawn(&mut self, name: &str, work: impl FnOnce() + Send + 'static) -> Result<(), LoopError> {
        let remote = self.remote();
        let work = AssertUnwindSafe(work);
        let guarded = move || {
            // No force where nobody watches any more.
            if catch_unwind(work).is_err() {
                remote.stop();
            }
        };
        let thread = std::thread::Builder::new().name(name.into()).spawn(guarded);
        let failed = |e: std::io::Error| LoopError {
            what: "the haptic loop".into(),
            cause: format!("cannot start a thread: {e}"),
        };
        self.threads.push(thread.map_err(failed)?);
        Ok(())
    }

    /// Arms, stops and tells.
    pub fn remote(&self) -> Remote {
        Remote(self.shared.control.clone())
    }

    /// For whoever steps the simulation.
    pub fn port(&self) -> SimulationPort {
        SimulationPort::new(self.shared.clone(), self.mode, self.design, self.bounds)
    }
}

impl Drop for HapticLoop {
    fn drop(&mut self) {
        self.shared.control.quit.store(true, Ordering::Release);
        for thread in self.threads.drain(..) {
            let begun = now_ns();
            let writes = thread.thread().name() == Some(MONITOR);
            if writes {
                watchdog::release(&self.shared);
            }
            let patience = if writes { WRITING } else { ENDING };
            while !thread.is_finished() && now_ns() - begun < patience.as_nanos() as u64 {
                std::thread::sleep(Duration::from_micros(200));
            }
            // One that hangs in a device is left behind; zeros go out below all the same.
            if thread.is_finished() {
                let _ = thread.join();
            }
        }
        watchdog::release(&self.shared);
        if let Ok(mut displays) = self.shared.displays.try_lock() {
            displays.clear();
        }
    }
}

/// Returns a warning of what the system refuses the loop, for a person.
fn without(what: &str, cause: &str) -> String {
    format!(
        "the haptic loop runs without {what} ({cause}): ticks will be late on a busy machine; \
         `thenar devices check` says how to allow it"
    )
}

/// The monitor's ends of what the loop hands on.
struct MonitorEndpoints {
    records: Consumer<TickRecord>,
    incident_reader: Option<IncidentReader>,
}

/// Builds what loop, watchdog and monitor share, and the monitor's ends.
fn share(
    settings: &Settings,
    trackers: Vec<Box<dyn Tracker>>,
    displays: Vec<Box<dyn ForceDisplay>>,
    in_real_time: bool,
) -> Result<(Arc<Shared>, MonitorEndpoints), LoopError> {
    let wrong = |what: &str, cause: String| LoopError { what: what.into(), cause };
    if let Some(grip) = settings.grip.filter(|grip| !(*grip > 0.0 && *grip <= 1000.0)) {
        let cause = format!("{grip} N s/m is not more than 0 and at most 1000");
        return Err(wrong("the damping of the loosest grip", cause));
    }
    // Guards begin anew after gaps of 20 ms.
    if !(settings.rate_hz >= 100.0 && settings.rate_hz <= 20_000.0) {
        let cause = format!("{} Hz is not between 100 and 20000", settings.rate_hz);
        return Err(wrong("the haptic rate", cause));
    }
    let limits = limits_of(settings, &displays);
    let (records, monitored) = rtrb::RingBuffer::new(RECORDS);
    let capabilities = limits.clone();
    let mut core = Core::new(trackers, limits, records)
        .map_err(|cause| wrong("a device's limits", cause.to_string()))?;
    // Single-rate has a whole simulation for a state.
    let kept = settings.trip_folder.is_some() && settings.mode != LoopMode::SingleRate;
    let incident_reader = kept.then(|| {
        let (incident_writer, incident_reader) = IncidentWriter::new();
        core.keep_by(incident_writer);
        incident_reader
    });
    let shared = Arc::new(Shared {
        core: Mutex::new(core),
        displays: Mutex::new(displays),
        capabilities,
        control: Arc::new(Control::default()),
        frames: kept.then(incident::Frames::default),
        in_real_time,
    });
    register(&shared);
    Ok((shared, MonitorEndpoints { records: monitored, incident_reader }))
}

/// The thread of the loop.
fn run(shared: &Shared, period: Duration) {
    let control = &shared.control;
    let ticks = AssertUnwindSafe(|| tick_on(shared, period));
    if catch_unwind(ticks).is_err() {
        control.failed.store(true, Ordering::Release);
    }
    watchdog::release(shared);
}

fn tick_on(shared: &Shared, period: Duration) {
    let control = &shared.control;
    let timer = DeadlineTimer::set();
    let mut deadlines = Deadlines::new(period, now_ns());
    let mut time = TickTime::default();
    while !control.quit.load(Ordering::Acquire) {
        timer.wait(deadlines.next_ns());
        time.now_ns = now_ns();
        time.late_ns = time.now_ns.saturating_sub(deadlines.next_ns());
        let ticked = tick(shared, &time);
        let ended_ns = now_ns();
        // A tick that was left out is no sign of life: whoever holds its memory may never let go.
        if ticked {
            control.beat_ns.store(ended_ns, Ordering::Release);
        }
        let (_, missed) = deadlines.advance(time.now_ns, ended_ns);
        // A tick that was left out counts with the next one that is not.
        time.missed = if ticked { missed } else { time.missed + 1 + missed };
        time.cost_ns = ended_ns - time.now_ns;
    }
}

/// One tick, unless somebody holds what it needs.
fn tick(shared: &Shared, time: &TickTime) -> bool {
    let control = &shared.control;
    let mut core = match shared.core.try_lock() {
        Ok(core) => core,
        Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
        Err(TryLockError::WouldBlock) => return false,
    };
    // Where two ask at the same moment, stopping wins.
    if control.arm.swap(false, Ordering::AcqRel) {
        core.arm();
    }
    if control.abandon.swap(false, Ordering::AcqRel) {
        core.fade_out(Trip::Abandoned);
    }
    if control.unanswered.swap(false, Ordering::AcqRel) {
        core.fade_out(Trip::Unanswered);
    }
    if control.stop.swap(false, Ordering::AcqRel) {
        core.trip(Trip::Requested);
    }
    if let Ok(mut displays) = shared.displays.try_lock() {
        for (index, display) in displays.iter_mut().enumerate() {
            core.hear(index, display.heard_ns(), time.now_ns);
        }
    }
    core.tick(time, control.enabled.load(Ordering::Acquire));
    control.lost.store(core.lost(), Ordering::Relaxed);
    if let Ok(mut displays) = shared.displays.try_lock() {
        core.show(&mut displays);
    }
    true
}

/// Every loop of this process.
fn all() -> &'static Mutex<Vec<Weak<Shared>>> {
    static ALL: Mutex<Vec<Weak<Shared>>> = Mutex::new(Vec::new());
    &ALL
}

fn register(shared: &Arc<Shared>) {
    let mut loops = all().lock().unwrap_or_else(PoisonError::into_inner);
    loops.retain(|known| known.strong_count() > 0);
    loops.push(Arc::downgrade(shared));
}

/// Stops the forces of every loop in this process, within a tick: for the thread that handles
/// signals, and for panic hooks. Waits for a loop that is just being made, for 20 ms at most.
pub fn stop_all() {
    let Some(loops) = crate::lock_soon(all()) else { return };
    for shared in loops.iter().filter_map(Weak::upgrade) {
        Remote(shared.control.clone()).stop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    fn until(what: &str, mut done: impl FnMut() -> bool) {
        let begun = Instant::now();
        while !done() {
            assert!(begun.elapsed() < Duration::from_secs(30), "waited in vain: {what}");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Whoever holds the loop's memory keeps it from ticking, but not the watchdog from noticing.
    #[test]
    fn a_loop_that_is_kept_from_ticking_is_taken_over() {
        let device = HapticLoop::start(Settings::default(), Vec::new(), Vec::new()).unwrap();
        let control = device.shared.control.clone();
        let beat = || control.beat_ns.load(Ordering::Acquire);
        until("a tick", || beat() > 0);
        let held = device.shared.core.lock().unwrap();
        // A tick that has just ended may still say so.
        std::thread::sleep(Duration::from_millis(5));
        let last = beat();
        until("the watchdog", || {
            control.barks.load(Ordering::Relaxed) > 0 && now_ns() > last + watchdog::PATIENCE_NS
        });
        assert_eq!(beat(), last, "no sign of life without a tick");
        drop(held);
        until("the next tick", || beat() > last);
    }

    #[test]
    fn stopping_wins_over_arming_at_the_same_moment() {
        let mut clock = ManualLoop::new(&Settings::default(), Vec::new(), Vec::new()).unwrap();
        let control = clock.shared.control.clone();
        control.arm.store(true, Ordering::Release);
        control.stop.store(true, Ordering::Release);
        assert!(clock.tick(1));
        assert_eq!(clock.core(|core| core.tripped()), Some(Trip::Requested));
        clock.remote().arm();
        assert!(clock.tick(2));
        assert_eq!(clock.core(|core| core.tripped()), None);
    }
}
