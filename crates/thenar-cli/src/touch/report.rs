//! Report on a session of touch, for a person.

use super::SimulationTiming;
use thenar_core::model::Side;
use thenar_link::haptic_loop::{Histogram, Status};

/// One line on how things stand.
pub fn line(elapsed: f64, status: &Status) {
    if status.ticks == 0 {
        return;
    }
    let hands = status.hands.iter().map(|hand| {
        let side = match hand.side {
            Side::Left => "left",
            Side::Right => "right",
        };
        let tracked = if hand.tracked { "tracked" } else { "not tracked" };
        let [wanted, sent] =
            [0, 1].map(|k| hand.forces.iter().map(|force| force[k]).fold(0.0_f64, f64::max));
        let late = match hand.display {
            Some(_) => {
                format!(", felt up to {:.0} N/m at {:.0} ms", hand.felt_stiffness, 1e3 * hand.delay)
            }
            None => String::new(),
        };
        format!("{side} {tracked}, {wanted:.2} N wanted, {sent:.2} N sent{late}")
    });
    let hands: Vec<_> = hands.collect();
    let reason = status.state.reason().map_or(String::new(), |reason| format!(" ({reason})"));
    println!(
        "{elapsed:6.0} s  {}{reason}  period p99.9 {}  missed {}  {}",
        status.state.word(),
        time(status.period.quantile(0.999)),
        status.missed,
        hands.join("; ")
    );
}

/// The whole session.
pub fn print(status: &Status, beside: &SimulationTiming) {
    println!();
    println!(
        "{} ticks at {} Hz, {} left out, {} times taken over by the watchdog",
        status.ticks, status.rate_hz, status.missed, status.barks
    );
    println!("{:22}{:>10}{:>10}{:>10}{:>10}", "", "median", "p99", "p99.9", "largest");
    row("period", &status.period);
    row("later than due", &status.late);
    row("a tick", &status.cost);
    row("pose to output", &status.latency);
    row("simulation's step", &beside.costs);
    println!("the simulation ran at {:.2} of real time", beside.speed);
    if status.lost > 0 {
        println!("{} records were lost: the figures above lack them", status.lost);
    }
}

fn row(what: &str, times: &Histogram) {
    let [median, p99, p999] = [0.5, 0.99, 0.999].map(|q| time(times.quantile(q)));
    println!("{what:22}{median:>10}{p99:>10}{p999:>10}{:>10}", time(times.max()));
}

/// A time in a unit that suits it.
pub fn time(ns: u64) -> String {
    match ns {
        0..100_000 => format!("{:.1} us", ns as f64 * 1e-3),
        100_000..1_000_000 => format!("{:.0} us", ns as f64 * 1e-3),
        _ => format!("{:.2} ms", ns as f64 * 1e-6),
    }
}
