//! Looks after the loop from another thread: counts, tells, and writes down what led to a trip.

use super::control::{HandStatus, State, Status};
use super::incident::IncidentReader;
use super::pauses::Pauses;
use super::presence::PresenceChecks;
use super::record::{self, TickRecord};
use super::{Capability, Shared};
use crate::{MessageSource, now_ns, safety};
use rtrb::Consumer;
use std::collections::VecDeque;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Between two looks.
const EVERY: Duration = Duration::from_millis(10);
/// Looks of the monitor between two requests for the devices' messages.
const MESSAGES_EVERY: u32 = 50;
/// Looks of the monitor between two looks at the devices.
const DEVICES_EVERY: u32 = 10;
/// Messages that are kept.
const MESSAGES: usize = 50;
/// Time before a trip that is written down \[ns\].
const KEPT_NS: u64 = 5_000_000_000;
/// Incidents of one session that stay: each takes some tens of MB.
const INCIDENTS: usize = 4;
/// Records kept at most, whatever the number of displays.
const RECORDS_MAX: usize = 60_000;

/// Is shown every record, in order; must not take long.
pub type RecordCallback = Box<dyn FnMut(&TickRecord) + Send>;

/// The thread.
pub struct Monitor {
    pub shared: std::sync::Arc<Shared>,
    pub records: Consumer<TickRecord>,
    /// Inputs of the last seconds, where incidents are kept.
    pub incident_reader: Option<IncidentReader>,
    pub watcher: Option<RecordCallback>,
    /// Incidents written so far that are still there.
    pub incidents: VecDeque<PathBuf>,
    /// Folder for records of trips; `None` to keep no files.
    pub folder: Option<PathBuf>,
    pub warnings: Vec<String>,
    /// Devices are asked through these, so that the loop has them to itself.
    pub message_sources: Vec<MessageSource>,
    /// Through these the monitor sees which devices are there.
    pub presence_checks: PresenceChecks,
    /// Rendering of each display, and its limits.
    pub displays: Vec<Capability>,
    pub rate_hz: f64,
}

impl Monitor {
    /// Until the loop ends.
    pub fn run(mut self) {
        let mut status = Status {
            rate_hz: self.rate_hz,
            warnings: std::mem::take(&mut self.warnings),
            ..Status::default()
        };
        let mut kept = VecDeque::with_capacity(RECORDS_MAX);
        let mut tripped = false;
        let mut last_ns = None;
        let mut pauses = Pauses::default();
        for look in 0_u32.. {
            let quit = self.shared.control.quit.load(Ordering::Acquire);
            if let Some(incident_reader) = &mut self.incident_reader {
                incident_reader.drain();
            }
            self.take_records(&mut status, &mut kept, &mut last_ns, &mut pauses);
            status.messages.extend(pauses.tell());
            status.messages.extend(self.shared.control.take_notes());
            self.judge(&mut status, &kept);
            if look.is_multiple_of(MESSAGES_EVERY) || quit {
                self.gather_messages(&mut status);
            }
            if look.is_multiple_of(DEVICES_EVERY) {
                status.devices = self.presence_checks.look(now_ns());
            }
            let now_tripped = matches!(status.state, State::Tripped(_) | State::Failed);
            if now_tripped && !tripped {
                self.write_down(&mut status, &kept);
            }
            tripped = now_tripped;
            self.shared.control.status().clone_from(&status);
            if quit {
                return;
            }
            std::thread::sleep(EVERY);
        }
    }

    fn take_records(
        &mut self,
        status: &mut Status,
        kept: &mut VecDeque<TickRecord>,
        last_ns: &mut Option<u64>,
        pauses: &mut Pauses,
    ) {
        while let Ok(record) = self.records.pop() {
            pauses.see(&record);
            if let Some(watcher) = &mut self.watcher {
                watcher(&record);
            }
            if record.first {
                status.ticks += 1;
                status.missed += u64::from(record.missed);
                status.late.add(u64::from(record.late_ns));
                if let Some(last) = last_ns.replace(record.time_ns) {
                    status.period.add(record.time_ns.saturating_sub(last));
                    status.cost.add(u64::from(record.cost_ns));
                }
            }
            if let Some(pose_ns) = record.pose_ns {
                // This tick's own cost is not known yet; the one before's is like it.
                let age = record.time_ns.saturating_sub(pose_ns);
                status.latency.add(age + u64::from(record.cost_ns));
            }
            let old = |r: &TickRecord| record.time_ns.saturating_sub(r.time_ns) > KEPT_NS;
            while kept.len() >= RECORDS_MAX || kept.front().is_some_and(old) {
                kept.pop_front();
            }
            kept.push_back(record);
        }
    }

    /// State and hands, by the records of the last tick.
    fn judge(&self, status: &mut Status, kept: &VecDeque<TickRecord>) {
        let control = &self.shared.control;
        status.lost = control.lost.load(Ordering::Relaxed);
        status.barks = control.barks.load(Ordering::Relaxed);
        let Some(last) = kept.back().map(|record| record.time_ns) else { return };
        status.hands.clear();
        let mut state = None;
        for record in kept.iter().rev().take_while(|record| record.time_ns == last) {
            if record.display.is_some() {
                state = Some(worse(state, &record.status));
            }
            if status.hands.iter().any(|hand| hand.side == record.side) {
                continue;
            }
            let display =
                record.display.and_then(|k| Some((k, self.displays.get(usize::from(k))?)));
            status.hands.push(HandStatus {
                side: record.side,
                tracked: record.tracked,
                tracker: record.tracker,
                display: display.map(|(k, able)| (k, able.rendering)),
                force_max: display.map_or(0.0, |(_, able)| able.limits.force_max()),
                simulation_age: f64::from(record.ages[1]),
                felt_stiffness: f64::from(record.stiffness),
                delay: f64::from(record.delay),
                forces: record.axes.map(|axis| [axis.wanted, axis.output]),
            });
        }
        status.hands.reverse();
        status.state = match state {
            _ if control.failed.load(Ordering::Acquire) => State::Failed,
            None | Some(safety::Status::Off) => State::DryRun,
            Some(safety::Status::Waiting { pause, .. }) => {
                State::Waiting(pause.map_or(String::new(), |pause| pause.to_string()))
            }
            Some(safety::Status::Ramping { .. }) => State::Ramping,
            Some(safety::Status::Live) => State::Live,
            Some(safety::Status::Tripped(reason)) => State::Tripped(reason.to_string()),
        };
    }

    fn gather_messages(&mut self, status: &mut Status) {
        status.messages.extend(self.message_sources.iter_mut().flat_map(|ask| ask()));
        forget_old(status);
    }

    fn write_down(&mut self, status: &mut Status, kept: &VecDeque<TickRecord>) {
        let reason = status.state.reason().unwrap_or("the haptic loop failed").to_owned();
        let mut message = format!("forces stopped: {reason}");
        if let Some(folder) = self.folder.clone() {
            match write_trip(&folder, &reason, kept) {
                Ok(path) => {
                    message += &format!("; what led to it is in {}", path.display());
                    message += &self.write_incident(&path.with_extension("touch"), &reason, kept);
                }
                Err(error) => message += &format!("; it could not be written down: {error}"),
            }
        }
        status.messages.push(message);
        forget_old(status);
    }
}

impl Monitor {
    /// Writes all that entered beside the table of signals; what there is to say of that.
    fn write_incident(&mut self, path: &Path, reason: &str, kept: &VecDeque<TickRecord>) -> String {
        let (Some(incident_reader), Some(frames)) = (&self.incident_reader, &self.shared.frames)
        else {
            return String::new();
        };
        let records: Vec<_> = kept.iter().copied().collect();
        let Some(incident) = incident_reader.incident(reason, &self.displays, frames, &records)
        else {
            return "; what entered was not kept long enough to be made again".into();
        };
        match incident.write(path) {
            Ok(()) => {
                self.incidents.push_back(path.to_owned());
                if self.incidents.len() > INCIDENTS {
                    // One that somebody has moved away is theirs.
                    if let Some(oldest) = self.incidents.pop_front() {
                        let _ = std::fs::remove_file(oldest);
                    }
                }
                format!(", and to make it again in {}", path.display())
            }
            Err(error) => format!("; what entered could not be written down: {error}"),
        }
    }
}

fn forget_old(status: &mut Status) {
    let surplus = status.messages.len().saturating_sub(MESSAGES);
    status.messages.drain(..surplus);
}

/// The one that passes less.
fn worse(one: Option<safety::Status>, other: &safety::Status) -> safety::Status {
    let rank = |status: &safety::Status| match status {
        safety::Status::Tripped(_) => 0,
        safety::Status::Off => 1,
        safety::Status::Waiting { .. } => 2,
        safety::Status::Ramping { .. } => 3,
        safety::Status::Live => 4,
    };
    match one {
        Some(one) if rank(&one) <= rank(other) => one,
        _ => *other,
    }
}

/// Writes the last seconds into a new file of `folder`; times count back from the trip.
fn write_trip(folder: &Path, reason: &str, kept: &VecDeque<TickRecord>) -> io::Result<PathBuf> {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let path = folder.join(format!("thenar-trip-{}.csv", since.as_millis()));
    let mut file = io::BufWriter::new(std::fs::File::create_new(&path)?);
    let trip = kept.iter().find(|r| matches!(r.status, safety::Status::Tripped(_)));
    let zero_ns = trip.or(kept.back()).map_or(0, |record| record.time_ns);
    writeln!(file, "# forces stopped: {reason}")?;
    writeln!(file, "{}", record::header())?;
    for record in kept {
        writeln!(file, "{}", record::line(record, zero_ns))?;
    }
    file.flush()?;
    Ok(path)
}
