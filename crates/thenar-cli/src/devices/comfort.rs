//! `thenar devices comfort`: how much force a wearer likes, finger by finger, with a stop at hand.

mod force_ramp;
#[cfg(test)]
mod tests;

use super::driver_of;
use super::feel::{DIRECTIONS, NAMES, Trial};
use super::keys::Keys;
use crate::error::CliError;
use crate::interrupt;
use force_ramp::{ForceRamp, RampEnd};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use thenar_link::wearer::{Comfort, SOMEBODY, Wearer, keep, wearer_file};
use thenar_link::{DIGITS, ForceDisplay, HandOutput, Rendering, now_ns};
use thenar_touch::safety::Limits;

/// Find out how much force a wearer likes: it rises in small steps until you stop it, and is never
/// more from then on.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Driver and address of the force display, such as `cybergrasp:127.0.0.1:7070`.
    address: String,
    /// Name of the wearer: settings are kept for each. Without one they are those of whoever is not
    /// named.
    #[arg(long, value_name = "NAME", default_value = SOMEBODY)]
    wearer: String,
    /// Part of the rated force that it may rise to, 0 to 1, where that is less than the device's
    /// profile allows.
    #[arg(long, value_name = "PART", value_parser = super::test::fraction)]
    force: Option<f64>,
    /// Part of the stiffness that is felt from now on, 0 to 1; by default what was kept before.
    #[arg(long, value_name = "PART", value_parser = super::test::fraction)]
    stiffness: Option<f64>,
    /// Time in which force comes up after arming from now on, where it is longer than the device's
    /// [s].
    #[arg(long, value_name = "S", value_parser = ramp)]
    ramp: Option<f64>,
    /// Duration of each step [s].
    #[arg(long, value_name = "S", default_value_t = 1.5, value_parser = step)]
    seconds: f64,
    /// Position of stops, as a fraction of your calibrated range: 0 open to 1 closed.
    #[arg(long, value_name = "FRACTION", default_value_t = 0.5, value_parser = super::test::fraction)]
    stop_at: f64,
    /// Do not ask before the first finger.
    #[arg(long)]
    arm: bool,
    /// The file to write; by default the wearer's own.
    #[arg(long)]
    output: Option<PathBuf>,
}

fn ramp(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..=60.0).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds, 0 to 60".into()),
    }
}

/// A step that is felt before the next one, and ends some time.
fn step(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.1..=30.0).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds, 0.1 to 30".into()),
    }
}

/// Part of the last comfortable step that is kept.
const MARGIN: f64 = 0.8;
/// A finger that was disturbed, by this program or by the device, begins again at most so often.
const AGAIN: usize = 3;
/// A device that is not there is given up after this.
const PATIENCE: Duration = Duration::from_secs(5);
/// One that went and does not come back within this is lost.
const RETURNS: Duration = Duration::from_secs(1);
/// Silence after which a device counts as absent \[ns\].
const PRESENT_NS: u64 = 300_000_000;
/// Keys in so short a time after a stop belong to it \[s\].
const PANIC: f64 = 1.0;

/// Message where it ends without a result.
const UNFINISHED: &str = "not finished: forces are released and nothing is kept";

/// Asks, raises the force on one finger after the other, keeps what was comfortable.
///
/// # Errors
/// The device is wrong, silent or lost, a guard trips, the person ends it, or the file cannot be
/// written.
pub fn run(args: &Args) -> Result<(), CliError> {
    interrupt::listen();
    crate::keeper::enable();
    driver_of(&args.address)?;
    let Some(file) =
        args.output.clone().map_or_else(|| wearer_file(&args.wearer), |file| Ok(Some(file)))?
    else {
        let text = "this system has no folder for settings: say --output FILE";
        return Err(CliError::Input(text.into()));
    };
    let before = if file.exists() { Wearer::read(&file)? } else { Wearer::default() };
    let device = thenar_link::open(&args.address)?;
    let Some(mut display) = device.display else {
        return Err(CliError::Input(format!("{} shows no forces", args.address)));
    };
    let driver = driver_name(&*display, &args.address);
    let limits = allowed(&display.rendering().limits(display.limits()), args.force);
    meet(&mut *display, &args.address)?;
    let keys = Keys::hear();
    introduce(display.rendering(), limits.force_max());
    if !args.arm {
        println!("Wear the device, hand relaxed. Type `yes` to begin:");
        if keys.line(UNFINISHED)? != "yes" {
            return Err(CliError::Other("not armed: no force was shown".into()));
        }
    }
    let mut tracker = device.tracker;
    let mut trial = Trial::new(&mut *display, tracker.as_mut(), limits, args.stop_at)?;
    let found = every_finger(&mut trial, args, limits, &keys);
    trial.release();
    let side = trial.side;
    drop(trial);
    display.show(&HandOutput::released(side, now_ns()));
    let old = before.with(&driver).copied();
    let old = old.unwrap_or(Comfort { force: [0.0; DIGITS], ramp: 0.0, stiffness: 1.0 });
    let comfort = Comfort {
        force: found?,
        ramp: args.ramp.unwrap_or(old.ramp),
        stiffness: args.stiffness.unwrap_or(old.stiffness),
    };
    keep(&file, &driver, &comfort)?;
    println!("wrote {}: {driver} {comfort}", file.display());
    Ok(())
}

/// The driver of the device itself, where the address is of one that holds others.
fn driver_name(display: &dyn ForceDisplay, address: &str) -> String {
    let names = display.presence_check()().into_iter().map(|presence| presence.name);
    let name = names.into_iter().next().unwrap_or_else(|| address.to_string());
    name.split(':').next().unwrap_or(&name).to_string()
}

/// The device's own limits, with no more than this session allows.
fn allowed(own: &Limits, part: Option<f64>) -> Limits {
    let user_fraction = part.map_or(own.user_fraction, |part| part.min(own.user_fraction));
    Limits { user_fraction, ..*own }
}

/// Waits for a device that answers.
fn meet(display: &mut dyn ForceDisplay, address: &str) -> Result<(), CliError> {
    let start = Instant::now();
    while display.rendering() != Rendering::Vibration && !is_there(display) {
        if start.elapsed() > PATIENCE || interrupt::asked() {
            let told = display.messages().join("; ");
            return Err(CliError::Other(format!("{address} does not answer: {told}")));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(())
}

fn is_there(display: &mut dyn ForceDisplay) -> bool {
    display.heard_ns().is_some_and(|heard| now_ns().saturating_sub(heard) < PRESENT_NS)
}

fn introduce(rendering: Rendering, most: f64) {
    println!("Research use only. Keep your other hand at the power switch.");
    println!(
        "Force rises in small steps on one finger after the other, to {most:.2} N at most. Any key stops it at once: press \
         one before it becomes unpleasant. Ctrl-C or closing the terminal ends all, and nothing is kept."
    );
    if rendering == Rendering::Stops {
        println!(
            "A stop holds a finger and has no strength of its own: a finger that you stop is not stopped any more."
        );
    }
}

/// Finds the comfortable force for each finger; of an arm, the least of its three directions for
/// all.
fn every_finger(
    trial: &mut Trial,
    args: &Args,
    limits: Limits,
    keys: &Keys,
) -> Result<[f64; DIGITS], CliError> {
    let rendering = trial.display.rendering();
    let names = if rendering == Rendering::Wrench { &DIRECTIONS[..] } else { &NAMES[..] };
    let mut found = [0.0; DIGITS];
    for (axis, name) in names.iter().enumerate() {
        if axis > 0 {
            println!("Next: {name}. Type n to go on; anything else ends, and nothing is kept.");
            if keys.line(UNFINISHED)? != "n" {
                return Err(CliError::Other(UNFINISHED.into()));
            }
        }
        println!("{name}: rising");
        found[axis] = one_finger(trial, axis, args, limits, keys)?;
        println!("{name}: {:.2} N", found[axis]);
    }
    if rendering == Rendering::Wrench {
        found = [found[..DIRECTIONS.len()].iter().copied().fold(f64::INFINITY, f64::min); DIGITS];
    }
    Ok(found)
}

/// Finds the comfortable force for a finger \[N\].
fn one_finger(
    trial: &mut Trial,
    axis: usize,
    args: &Args,
    limits: Limits,
    keys: &Keys,
) -> Result<f64, CliError> {
    let most = limits.force_max();
    for _ in 0..AGAIN {
        trial.begin(limits)?;
        let ended = ForceRamp::new(axis, most, args.seconds, limits.ramp).run(trial, keys)?;
        trial.release();
        match ended {
            RampEnd::Top => return Ok(rounded_down(most)),
            RampEnd::Stopped { comfortable } => {
                println!("stopped");
                pause_output(trial, keys)?;
                // A stop is there or not.
                let stops = trial.display.rendering() == Rendering::Stops;
                return Ok(if stops { 0.0 } else { rounded_down(MARGIN * comfortable) });
            }
            RampEnd::HeldUp => println!("this program was held up: the same again, from nothing"),
            RampEnd::Silent => {
                returns(trial, keys)?;
                println!("the device was silent for a moment: the same again, from nothing");
            }
        }
    }
    let told = "it was disturbed too often; forces are released and nothing is kept";
    Err(CliError::Other(told.into()))
}

/// Force as a person reads it: the next hundredth of a newton below.
fn rounded_down(force: f64) -> f64 {
    // What is a hundredth but for its binary digits is one.
    (force * 100.0 + 1e-9).floor() / 100.0
}

/// Waits for a device that fell silent; one that is gone ends it.
fn returns(trial: &mut Trial, keys: &Keys) -> Result<(), CliError> {
    let start = Instant::now();
    // What was heard before it fell silent is not news.
    let silent_since = trial.display.heard_ns();
    while trial.display.heard_ns() == silent_since {
        trial.release();
        if start.elapsed() > RETURNS {
            let told = trial.display.messages().join("; ");
            return Err(CliError::Other(format!(
                "the device is lost, and nothing is kept: {told}"
            )));
        }
        ended(keys)?;
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(())
}

/// Shows nothing for a moment; keys of somebody who presses more than once belong to the stop.
fn pause_output(trial: &mut Trial, keys: &Keys) -> Result<(), CliError> {
    let start = Instant::now();
    while start.elapsed().as_secs_f64() < PANIC {
        trial.release();
        ended(keys)?;
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(())
}

/// Takes keys that mean nothing now.
fn ended(keys: &Keys) -> Result<(), CliError> {
    while let Some(key) = keys.heard() {
        if key == super::keys::Key::Closed {
            return Err(CliError::Other(UNFINISHED.into()));
        }
    }
    match interrupt::asked() {
        true => Err(CliError::Other(UNFINISHED.into())),
        false => Ok(()),
    }
}
