//! Record of one tick, as the monitor gets it.

use super::actuators::Axis;
use crate::DIGITS;
use crate::safety::Status;
use serde::{Deserialize, Serialize};
use thenar_core::model::Side;

/// One tick of one hand and one display.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct TickRecord {
    /// Time at which the tick began \[ns\].
    pub time_ns: u64,
    /// Lateness of the tick at its beginning \[ns\].
    pub late_ns: u32,
    /// Cost of the tick before \[ns\].
    pub cost_ns: u32,
    /// Ticks that were left out before this one.
    pub missed: u32,
    /// First record of its tick; others of the same tick say nothing new about time.
    pub first: bool,
    /// The hand.
    pub side: Side,
    /// The tracker that moves it.
    pub tracker: Option<u8>,
    /// Reception time of the pose that this tick was the first to take, if it took one \[ns\].
    pub pose_ns: Option<u64>,
    /// A tracker moves it now.
    pub tracked: bool,
    /// The display; `None` when there is none.
    pub display: Option<u8>,
    /// Since the hand was tracked where it is, and since the simulation frame was begun \[s\].
    pub ages: [f32; 2],
    /// Simulated contacts that press, with shared constraints.
    pub contacts: u32,
    /// Stiffest that a blocked finger is felt \[N/m\], and the delay from motion to force that it
    /// was chosen for \[s\].
    pub stiffness: f32,
    /// See `stiffness`.
    pub delay: f32,
    /// Status of the guards.
    pub status: Status,
    /// Forces, thumb first; x, y, z for displays of one point.
    pub axes: [Axis; DIGITS],
}

/// Header of a table of records.
pub fn header() -> String {
    let mut text = String::from("time_s,late_us,cost_us,missed,side,display,status");
    text.push_str(",tracking_age_s,simulation_age_s");
    for k in 0..DIGITS {
        text.push_str(&format!(",wanted_{k}_N,velocity_{k}_m_per_s,output_{k}_N,energy_{k}_J"));
    }
    text
}

/// One line of it; times count from `zero_ns`.
pub fn line(record: &TickRecord, zero_ns: u64) -> String {
    let time = (record.time_ns as i64 - zero_ns as i64) as f64 * 1e-9;
    let side = match record.side {
        Side::Left => "left",
        Side::Right => "right",
    };
    let display = record.display.map_or(String::new(), |d| d.to_string());
    let [late, cost] = [record.late_ns, record.cost_ns].map(|ns| f64::from(ns) * 1e-3);
    let word = word(&record.status);
    let [tracking, simulation] = record.ages;
    let mut text = format!(
        "{time:.6},{late:.1},{cost:.1},{},{side},{display},{word},{tracking},{simulation}",
        record.missed
    );
    for a in &record.axes {
        text.push_str(&format!(",{},{},{},{}", a.wanted, a.velocity, a.output, a.energy));
    }
    text
}

/// A status in one word.
pub fn word(status: &Status) -> &'static str {
    match status {
        Status::Off => "dry-run",
        Status::Waiting { .. } => "waiting",
        Status::Ramping { .. } => "ramping",
        Status::Live => "live",
        Status::Tripped(_) => "tripped",
    }
}
