//! A first force: at most 1 N, one finger (or, of an arm, one direction) after the other, through
//! the same guard as ever.

use super::speed::Speeds;
use crate::error::CliError;
use crate::interrupt;
use std::io::{BufRead, Write};
use std::time::{Duration, Instant};
use thenar_core::Vec3;
use thenar_core::model::Side;
use thenar_link::{DIGITS, ForceDisplay, HandOutput, Rendering, Tracker, now_ns};
use thenar_touch::safety::{Guard, Limits, Signal, Status, Trip};

/// Largest force \[N\].
const FORCE: f64 = 1.0;
/// Time per finger \[s\].
const PER_FINGER: f64 = 1.5;
/// Length of a hand that no profile knows, wrist to middle fingertip \[m\].
const HAND_LENGTH: f64 = 0.19;
/// Fingers, thumb first.
pub const NAMES: [&str; DIGITS] =
    ["thumb", "index finger", "middle finger", "ring finger", "little finger"];
/// The world's axes, for devices that push the whole hand.
pub const DIRECTIONS: [&str; 3] = ["to the right", "up", "towards you"];

/// Asks, unless `arm`, then plays the force on every finger. Movement stops are at `stop`, a
/// fraction of the wearer's calibrated range: 0 open to 1 closed.
///
/// # Errors
/// The person does not agree, or the guard trips.
pub fn run(
    display: &mut dyn ForceDisplay,
    tracker: Option<&mut Box<dyn Tracker>>,
    arm: bool,
    stop: f64,
) -> Result<(), CliError> {
    println!("Research use only. Keep your other hand at the power switch.");
    if !arm && !agreed()? {
        return Err(CliError::Other("not armed: no force was shown".into()));
    }
    let limits = gentle(&display.rendering().limits(display.limits()));
    let mut trial = Trial::new(display, tracker, limits, stop)?;
    trial.begin(limits)?;
    // The guard engages on small forces only, then opens over its ramp: begin with none.
    trial.play(None, limits.ramp + 0.2)?;
    let pushes = trial.display.rendering() == Rendering::Wrench;
    let names = if pushes { &DIRECTIONS[..] } else { &NAMES[..] };
    for (axis, name) in names.iter().enumerate() {
        println!("{name}");
        trial.play(Some(axis), PER_FINGER)?;
    }
    trial.release();
    println!("released");
    Ok(())
}

/// A guard that is off.
fn guard(limits: Limits) -> Result<Guard<DIGITS>, CliError> {
    Guard::new(limits, 2000).map_err(|e| CliError::Other(e.to_string()))
}

/// The device's own limits, with no more than our force.
fn gentle(limits: &Limits) -> Limits {
    let user_fraction = limits.user_fraction.min(FORCE / limits.rated);
    Limits { user_fraction, ..*limits }
}

fn agreed() -> Result<bool, CliError> {
    print!("Wear the device, hand relaxed. Type `yes` to feel at most {FORCE} N: ");
    let _ = std::io::stdout().flush();
    let mut answer = String::new();
    let read = std::io::stdin().lock().read_line(&mut answer);
    read.map_err(|e| CliError::Other(e.to_string()))?;
    Ok(answer.trim() == "yes")
}

/// The hand that the tracker reported last, or reports soon.
fn side_of(tracker: &mut dyn Tracker) -> Side {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(1) {
        if tracker.latest(Side::Left).is_some() {
            return Side::Left;
        }
        if tracker.latest(Side::Right).is_some() {
            return Side::Right;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Side::Right
}

/// Trial of a display: the tracker, the guard and the hand that take part.
pub struct Trial<'a> {
    /// The display.
    pub display: &'a mut dyn ForceDisplay,
    tracker: Option<&'a mut Box<dyn Tracker>>,
    guard: Guard<DIGITS>,
    speeds: Speeds,
    /// The hand.
    pub side: Side,
    /// Curl at which fingers are stopped.
    stop: f64,
}

impl<'a> Trial<'a> {
    /// Nothing is shown before it [begins](Trial::begin).
    ///
    /// # Errors
    /// The limits make no sense.
    pub fn new(
        display: &'a mut dyn ForceDisplay,
        mut tracker: Option<&'a mut Box<dyn Tracker>>,
        limits: Limits,
        stop: f64,
    ) -> Result<Self, CliError> {
        let guard = guard(limits)?;
        let side = tracker.as_mut().map_or(Side::Right, |tracker| side_of(&mut ***tracker));
        let length = tracker.as_ref().and_then(|tracker| tracker.hand_length());
        let speeds = Speeds::new(side, length.unwrap_or(HAND_LENGTH));
        Ok(Self { display, tracker, guard, speeds, side, stop })
    }

    /// Arms anew: from nothing, through the guard's wait and ramp.
    ///
    /// # Errors
    /// The limits make no sense.
    pub fn begin(&mut self, limits: Limits) -> Result<(), CliError> {
        self.guard = guard(limits)?;
        self.guard.arm();
        Ok(())
    }

    /// State of the guard.
    pub fn status(&self) -> Status {
        self.guard.status()
    }

    /// Nothing from now on, until it begins anew.
    pub fn release(&mut self) {
        self.guard.trip(Trip::Requested);
        self.display.show(&HandOutput::released(self.side, now_ns()));
    }

    /// One finger or direction, or none, for some seconds, at about 1 kHz.
    fn play(&mut self, axis: Option<usize>, seconds: f64) -> Result<(), CliError> {
        let start = Instant::now();
        loop {
            let phase = start.elapsed().as_secs_f64() / seconds;
            if phase >= 1.0 {
                return Ok(());
            }
            if interrupt::asked() {
                self.display.show(&HandOutput::released(self.side, now_ns()));
                return Err(CliError::Other("interrupted: forces are released".into()));
            }
            self.tick(now_ns(), axis, phase)?;
            std::thread::sleep(Duration::from_micros(900));
        }
    }

    /// Shows the force of this moment; `phase` goes from 0 to 1.
    fn tick(&mut self, now: u64, axis: Option<usize>, phase: f64) -> Result<(), CliError> {
        let mut wanted = [0.0; DIGITS];
        if let Some(axis) = axis {
            // Up and down again, without a jump.
            wanted[axis] = FORCE * (std::f64::consts::PI * phase).sin();
        }
        self.show(now, wanted)
    }

    /// Shows these forces, as far as the guard lets them through.
    ///
    /// # Errors
    /// The guard trips: forces are released.
    pub fn show(&mut self, now: u64, wanted: [f64; DIGITS]) -> Result<(), CliError> {
        let rendering = self.display.rendering();
        // Vibrating players need not answer; anything else that is not there must not be ready for
        // it.
        let vibrates = rendering == Rendering::Vibration;
        if let Some(sample) = self.tracker.as_mut().and_then(|t| t.latest(self.side)) {
            self.speeds.take(sample);
        }
        let signal = Signal {
            force: wanted,
            velocity: velocity(&self.speeds, rendering, now),
            simulation_ns: now,
            tracking_ns: now,
            device_ns: self.display.heard_ns().unwrap_or(if vibrates { now } else { 0 }),
            enabled: true,
        };
        let forces = self.guard.tick(now, &signal);
        if let Status::Tripped(reason) = self.guard.status() {
            self.display.show(&HandOutput::released(self.side, now));
            return Err(CliError::Other(format!("forces are released: {reason}")));
        }
        self.display.show(&self.output(rendering, forces, now));
        Ok(())
    }

    fn output(&self, rendering: Rendering, forces: [f64; DIGITS], now: u64) -> HandOutput {
        let mut output = HandOutput::released(self.side, now);
        if rendering == Rendering::Wrench {
            output.force_W = Vec3::new(forces[0], forces[1], forces[2]);
            return output;
        }
        for (digit, force) in output.digits.iter_mut().zip(forces) {
            digit.pad_force = force;
            let stops = rendering == Rendering::Stops && force > 0.05;
            digit.curl_at_contact = stops.then_some(self.stop);
        }
        output
    }
}

/// Along the axes that forces act on \[m/s\].
fn velocity(speeds: &Speeds, rendering: Rendering, now_ns: u64) -> [f64; DIGITS] {
    match rendering {
        Rendering::Wrench => {
            let v = speeds.wrist(now_ns);
            [v.x, v.y, v.z, 0.0, 0.0]
        }
        Rendering::Tendons | Rendering::Stops | Rendering::Vibration => speeds.opening(now_ns),
    }
}

#[cfg(test)]
pub mod fake;
#[cfg(test)]
mod tests;
