//! Ticks of the haptic loop, into a recording.

use crate::recording::Recording;
use thenar_core::model::Side;
use thenar_link::haptic_loop::{RecordCallback, TickRecord};
use thenar_link::{DIGITS, now_ns};
use thenar_record::{Channel, Field};

/// Records that may wait for the disk: four seconds of two hands.
const WAITING: usize = 8000;

/// Takes every record of the loop into the channel `haptic` of a recording.
pub fn recorder(recording: &mut Recording) -> RecordCallback {
    let mut fields: Vec<Field> = [
        ("late", "s"),
        ("cost", "s"),
        ("missed", "1"),
        ("right", "1"),
        ("display", "1"),
        ("tracking_age", "s"),
        ("simulation_age", "s"),
        ("contacts", "1"),
    ]
    .map(|(name, unit)| Field::new(name, unit))
    .into();
    for k in 0..DIGITS {
        let axis = [("wanted", "N"), ("velocity", "m/s"), ("output", "N"), ("energy", "J")];
        fields.extend(axis.map(|(name, unit)| Field::new(&format!("{name}_{k}"), unit)));
    }
    let (mut channel, clock) = recording.channel("haptic", &fields, WAITING);
    // The loop has a clock of its own.
    let ahead = now_ns() as i64 - clock.now_ns() as i64;
    let mut values = Vec::with_capacity(fields.len());
    Box::new(move |record| take(&mut channel, &mut values, ahead, record))
}

fn take(channel: &mut Channel, values: &mut Vec<f64>, ahead: i64, record: &TickRecord) {
    let seconds = |ns: u32| f64::from(ns) * 1e-9;
    let [tracking, simulation] = record.ages.map(f64::from);
    values.clear();
    values.extend([
        seconds(record.late_ns),
        seconds(record.cost_ns),
        f64::from(record.missed),
        if record.side == Side::Right { 1.0 } else { 0.0 },
        record.display.map_or(-1.0, f64::from),
        tracking,
        simulation,
        f64::from(record.contacts),
    ]);
    for axis in &record.axes {
        values.extend([axis.wanted, axis.velocity, axis.output, axis.energy]);
    }
    let at = (record.time_ns as i64 - ahead).max(0) as u64;
    // What does not fit is counted, and the recording says so.
    let _ = channel.record(at, values);
}
