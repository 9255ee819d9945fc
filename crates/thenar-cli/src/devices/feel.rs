//! A first force: at most 1 N, one finger after the other, through the same guard as ever.

use crate::error::CliError;
use crate::interrupt;
use std::io::{BufRead, Write};
use std::time::{Duration, Instant};
use thenar::haptic::safety::{Guard, Limits, Signal, Status};
use thenar::model::Side;
use thenar_link::{DIGITS, ForceDisplay, HandOutput, Rendering, Tracker, now_ns};

/// Largest force \[N\].
const FORCE: f64 = 1.0;
/// Time per finger \[s\].
const PER_FINGER: f64 = 1.5;
/// Where a finger is stopped, 0 open to 1 closed.
const STOP: f64 = 0.5;
const NAMES: [&str; DIGITS] =
    ["thumb", "index finger", "middle finger", "ring finger", "little finger"];

/// Asks, unless `arm`, then plays the force on every finger.
///
/// # Errors
/// The person does not agree, or the guard trips.
pub fn run(
    display: &mut dyn ForceDisplay,
    tracker: Option<&mut Box<dyn Tracker>>,
    arm: bool,
) -> Result<(), CliError> {
    println!("Research use only. Keep your other hand at the power switch.");
    if !arm && !agreed()? {
        return Err(CliError::Other("not armed: no force was shown".into()));
    }
    let limits = gentle(&display.limits());
    let mut guard =
        Guard::<DIGITS>::new(limits, 2000).map_err(|e| CliError::Other(e.to_string()))?;
    guard.arm();
    let side = tracker.map_or(Side::Right, |tracker| side_of(&mut **tracker));
    // The guard engages on small forces only, then opens over its ramp: begin with none.
    play(display, &mut guard, side, None, limits.ramp + 0.2)?;
    for (finger, name) in NAMES.into_iter().enumerate() {
        println!("{name}");
        play(display, &mut guard, side, Some(finger), PER_FINGER)?;
    }
    display.show(&HandOutput::released(side, now_ns()));
    println!("released");
    Ok(())
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

/// The hand that the tracker told of last, or soon tells of.
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

/// One finger, or none, for some seconds, at about 1 kHz.
fn play(
    display: &mut dyn ForceDisplay,
    guard: &mut Guard<DIGITS>,
    side: Side,
    finger: Option<usize>,
    seconds: f64,
) -> Result<(), CliError> {
    let stops = display.rendering() == Rendering::Stops;
    // Vibrating players need not answer; anything else that is not there must not be ready for it.
    let vibrates = display.rendering() == Rendering::Vibration;
    let start = Instant::now();
    while start.elapsed().as_secs_f64() < seconds {
        if interrupt::asked() {
            display.show(&HandOutput::released(side, now_ns()));
            return Err(CliError::Other("interrupted: forces are released".into()));
        }
        let now = now_ns();
        let mut wanted = [0.0; DIGITS];
        if let Some(finger) = finger {
            // Up and down again, without a jump.
            let phase = start.elapsed().as_secs_f64() / seconds;
            wanted[finger] = FORCE * (std::f64::consts::PI * phase).sin();
        }
        let signal = Signal {
            force: wanted,
            velocity: [0.0; DIGITS],
            simulation_ns: now,
            tracking_ns: now,
            device_ns: display.heard_ns().unwrap_or(if vibrates { now } else { 0 }),
            enabled: true,
        };
        let forces = guard.tick(now, &signal);
        if let Status::Tripped(reason) = guard.status() {
            display.show(&HandOutput::released(side, now));
            return Err(CliError::Other(format!("forces are released: {reason}")));
        }
        let mut output = HandOutput::released(side, now);
        for (digit, force) in output.digits.iter_mut().zip(forces) {
            digit.pad_force = force;
            digit.curl_at_contact = (stops && force > 0.05).then_some(STOP);
        }
        display.show(&output);
        std::thread::sleep(Duration::from_micros(900));
    }
    Ok(())
}
