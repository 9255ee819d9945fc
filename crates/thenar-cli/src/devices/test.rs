//! `thenar devices test`: what a device tells, live, and a first gentle force.

use super::feel;
use crate::error::CliError;
use crate::interrupt;
use std::io::Write;
use std::time::{Duration, Instant};
use thenar_core::model::Side;
use thenar_link::wearer::{Wearer, limited_to_comfort};
use thenar_link::{HandSample, Tracker, now_ns};
use thenar_scene::live::LivePose;

/// Show live what a device sends.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Driver and address, such as `lucidgloves:/dev/ttyUSB0`.
    address: String,
    /// For how long [s].
    #[arg(long, default_value_t = 5.0, value_parser = crate::devices::test::seconds)]
    seconds: f64,
    /// Then let each finger feel at most 1 N (or a stop) in turn; an arm pushes along its three
    /// axes.
    #[arg(long)]
    feel: bool,
    /// Position of stops, as a fraction of your calibrated range: 0 open to 1 closed.
    #[arg(long, requires = "feel", default_value_t = 0.5, value_parser = fraction)]
    stop_at: f64,
    /// Do not ask before `--feel`.
    #[arg(long, requires = "feel")]
    arm: bool,
}

/// A time that a person can mean.
pub fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..=86_400.0).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds, 0 to 86400".into()),
    }
}

/// A part of a whole.
pub fn fraction(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(fraction) if (0.0..=1.0).contains(&fraction) => Ok(fraction),
        _ => Err("expected a fraction, 0 to 1".into()),
    }
}

/// Between lines.
const SHOW: Duration = Duration::from_millis(200);

/// Between words of one who still waits for a first pose \[s\].
const PATIENCE: f64 = 1.0;

/// Prints five lines a second; before the first pose it says once a second, on the error output,
/// how long it still listens.
///
/// # Errors
/// The address is wrong, or the device says nothing.
pub fn run(args: &Args) -> Result<(), CliError> {
    interrupt::listen();
    if args.feel {
        crate::keeper::enable();
    }
    let mut device = thenar_link::open(&args.address)?;
    if let Some(tracker) = &mut device.tracker {
        watch(&mut **tracker, args)?;
    } else {
        println!("{} sends no poses", args.address);
    }
    if args.feel {
        let Some(display) = device.display.take() else {
            return Err(CliError::Input(format!("{} shows no forces", args.address)));
        };
        let (mut display, comfort) =
            limited_to_comfort(display, &args.address, &Wearer::load(None)?);
        if let Some(comfort) = comfort {
            println!("for you {comfort}");
        }
        feel::run(&mut *display, device.tracker.as_mut(), args.arm, args.stop_at)?;
    }
    Ok(())
}

/// Samples of a test.
#[derive(Default)]
struct Tally {
    count: u64,
    /// Since the last line.
    recent: u64,
    intervals_ns: Vec<u64>,
    last_ns: Option<u64>,
    /// Samples whose time was before that of the last.
    back: u64,
}

impl Tally {
    fn take(&mut self, sample: &HandSample) {
        if let Some(last) = self.last_ns.replace(sample.time_ns) {
            match sample.time_ns.checked_sub(last) {
                Some(interval) => self.intervals_ns.push(interval),
                None => self.back += 1,
            }
        }
        self.count += 1;
        self.recent += 1;
    }

    /// Median, 99th percentile and largest interval \[ms\].
    fn intervals_ms(&mut self) -> [f64; 3] {
        self.intervals_ns.sort_unstable();
        let last = self.intervals_ns.len().saturating_sub(1);
        [last / 2, last * 99 / 100, last]
            .map(|k| self.intervals_ns.get(k).map_or(0.0, |ns| *ns as f64 * 1e-6))
    }
}

fn watch(tracker: &mut dyn Tracker, args: &Args) -> Result<(), CliError> {
    let mut tallies = [Tally::default(), Tally::default()];
    let mut newest: [Option<HandSample>; 2] = [None, None];
    if let Some(length) = tracker.hand_length() {
        println!("hand length {:.0} mm, by the profile", length * 1e3);
    }
    let (start, mut shown) = (Instant::now(), Instant::now());
    let mut waits = PATIENCE;
    while start.elapsed().as_secs_f64() < args.seconds && !interrupt::asked() {
        for (k, side) in [Side::Left, Side::Right].into_iter().enumerate() {
            if let Some(sample) = tracker.latest(side) {
                tallies[k].take(sample);
                newest[k] = Some(sample.clone());
            }
        }
        if start.elapsed().as_secs_f64() >= waits && tallies.iter().all(|tally| tally.count == 0) {
            let left = args.seconds - waits;
            if left > 0.0 {
                eprintln!("{}: no pose yet, listening for {left:.1} s more", args.address);
            }
            waits += PATIENCE;
        }
        if shown.elapsed() >= SHOW {
            for message in tracker.messages() {
                println!("! {message}");
            }
            for (k, sample) in newest.iter().enumerate() {
                if let Some(sample) = sample {
                    let rate = tallies[k].recent as f64 / shown.elapsed().as_secs_f64();
                    println!("{}", line(sample, rate));
                }
                tallies[k].recent = 0;
            }
            shown = Instant::now();
            let _ = std::io::stdout().flush();
        }
        std::thread::sleep(Duration::from_micros(500));
    }
    for message in tracker.messages() {
        println!("! {message}");
    }
    for (tally, side) in tallies.iter_mut().zip(["left", "right"]) {
        if tally.count > 0 {
            let [median, p99, worst] = tally.intervals_ms();
            println!(
                "{side} hand: {} samples, interval {median:.2} ms median, {p99:.2} ms p99, {worst:.2} ms worst",
                tally.count
            );
        }
        if tally.back > 0 {
            println!("! its time stepped back {} times", tally.back);
        }
    }
    if tallies.iter().all(|tally| tally.count == 0) {
        return Err(CliError::Other(format!("{} sent no pose", args.address)));
    }
    Ok(())
}

/// A sample on one line: rate, age, wrist, and per finger the three flexions in degrees.
fn line(sample: &HandSample, rate: f64) -> String {
    let side = if sample.side == Side::Left { "left" } else { "right" };
    let age = now_ns().saturating_sub(sample.time_ns) as f64 * 1e-6;
    let head = format!("{side:5} {rate:5.0} Hz {age:5.1} ms old");
    match &sample.pose {
        None => format!("{head}  not seen"),
        Some(LivePose::Joints { joints, .. }) => {
            let [x, y, z] = joints[0].position.into();
            format!("{head}  wrist {x:.3} {y:.3} {z:.3} m, 25 joints")
        }
        Some(LivePose::Angles { wrist, angles }) => {
            let [x, y, z] = wrist.position.into();
            let mut text = format!("{head}  wrist {x:.3} {y:.3} {z:.3} m");
            for (name, digit) in ["T", "I", "M", "R", "L"].into_iter().zip(angles.chunks(4)) {
                let [base, spread, second, third] =
                    [0, 1, 2, 3].map(|k| digit.get(k).map_or(0.0, |a: &f64| a.to_degrees()));
                text += &format!("  {name} {base:3.0} {second:3.0} {third:3.0} ({spread:+.0})");
            }
            text
        }
    }
}
