//! `thenar devices calibrate`: a person takes poses, the profile learns.

use super::driver_of;
use crate::error::CliError;
use std::io::{BufRead, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use thenar_core::model::Side;
use thenar_link::Tracker;
use thenar_link::profile::{Address, save, user_file};
use thenar_scene::live::LivePose;
use thenar_scene::motion::ANGLES;
use toml::{Table, Value};

/// Fit a glove to its wearer: it asks for poses and writes the profile.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Driver and address, such as `cyberglove:/dev/ttyS0`.
    address: String,
    /// The profile to write; by default your own for this driver.
    #[arg(long)]
    output: Option<PathBuf>,
    /// Time for which each pose is watched [s].
    #[arg(long, default_value_t = 1.0, value_parser = super::test::seconds)]
    seconds: f64,
}

/// A pose is still when no sensor strays further than this from its mean, of its full range.
const STILL: f64 = 0.04;
/// A silent glove is given up after this.
const PATIENCE: Duration = Duration::from_secs(5);

/// Asks, watches, fits, writes.
///
/// # Errors
/// The device needs no calibration, is silent, or the profile cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    let (driver, rest) = driver_of(&args.address)?;
    let Some(calibrate) = driver.calibrate() else {
        return Err(CliError::Input(format!("{} needs no calibration", driver.name())));
    };
    let parsed = Address::parse(driver.name(), rest)?;
    let file = (args.output.clone())
        .or_else(|| parsed.profile.clone())
        .or_else(|| user_file(driver.name(), parsed.side));
    let Some(file) = file else {
        let text = "this system has no folder for settings: say --output FILE";
        return Err(CliError::Input(text.into()));
    };
    let mut device = calibrate.open_raw(rest)?;
    let Some(tracker) = &mut device.tracker else {
        return Err(CliError::Input(format!("{} sends no poses", args.address)));
    };
    let prompts = calibrate.prompts();
    let mut means = Vec::new();
    for (k, prompt) in prompts.iter().enumerate() {
        loop {
            println!(
                "{}/{} {}: {}. Enter when ready.",
                k + 1,
                prompts.len(),
                prompt.name,
                prompt.text
            );
            line()?;
            match watch(&mut **tracker, args)? {
                Some(mean) => {
                    means.push(mean);
                    break;
                }
                None => println!("That moved; again, please."),
            }
        }
    }
    let mut fitted = calibrate.fit(&means);
    println!(
        "Length of your hand, wrist crease to middle fingertip, in mm; Enter to keep what is set:"
    );
    let length = loop {
        match length(&line()?) {
            Ok(length) => break length,
            Err(told) => println!("{told}; again, please:"),
        }
    };
    if let Some(length) = length {
        let hand: Table = [("length".to_string(), Value::Float(length))].into_iter().collect();
        fitted.keys.insert("hand".into(), Value::Table(hand));
    }
    for remark in &fitted.remarks {
        println!("! {remark}");
    }
    if fitted.keys.is_empty() {
        return Err(CliError::Other("nothing was found; the profile is unchanged".into()));
    }
    save(&file, fitted.keys)?;
    println!("wrote {}", file.display());
    Ok(())
}

/// A line of the person; the end of input ends the calibration, and nothing is written.
fn line() -> Result<String, CliError> {
    let _ = std::io::stdout().flush();
    let mut text = String::new();
    let read = std::io::stdin().lock().read_line(&mut text);
    if read.map_err(|e| CliError::Other(e.to_string()))? == 0 {
        return Err(CliError::Other("not finished: the profile is unchanged".into()));
    }
    Ok(text.trim().to_string())
}

/// A hand's length \[m\] out of millimetres; `None` for an empty answer.
fn length(text: &str) -> Result<Option<f64>, String> {
    if text.is_empty() {
        return Ok(None);
    }
    match text.parse::<f64>() {
        Ok(mm) if (80.0..=300.0).contains(&mm) => Ok(Some(mm / 1e3)),
        _ => Err(format!("`{text}` mm is not the length of a hand, expected 80 to 300")),
    }
}

/// Mean sensor values over some time; `None` when the hand moved.
fn watch(tracker: &mut dyn Tracker, args: &Args) -> Result<Option<[f64; ANGLES]>, CliError> {
    // What was there before the person was ready does not count.
    for side in [Side::Left, Side::Right] {
        tracker.latest(side);
    }
    let mut samples: Vec<[f64; ANGLES]> = Vec::new();
    let start = Instant::now();
    while samples.is_empty() || start.elapsed().as_secs_f64() < args.seconds {
        for side in [Side::Left, Side::Right] {
            if let Some(LivePose::Angles { angles, .. }) =
                tracker.latest(side).and_then(|sample| sample.pose.as_ref())
            {
                samples.push(*angles);
            }
        }
        if samples.is_empty() && start.elapsed() > PATIENCE {
            let told = tracker.messages().join("; ");
            return Err(CliError::Other(format!("{} sends no pose: {told}", args.address)));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let mean: [f64; ANGLES] =
        std::array::from_fn(|k| samples.iter().map(|s| s[k]).sum::<f64>() / samples.len() as f64);
    let strays = |s: &[f64; ANGLES]| (0..ANGLES).any(|k| (s[k] - mean[k]).abs() > STILL);
    Ok((!samples.iter().any(strays)).then_some(mean))
}
