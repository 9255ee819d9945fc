//! `thenar devices latency`: how late, how often and how steadily a tracker sees a hand, kept in
//! its profile.

mod session;
#[cfg(test)]
mod tests;

use super::driver_of;
use super::keys::Keys;
use crate::error::CliError;
use crate::interrupt;
use session::Session;
use std::path::{Path, PathBuf};
use thenar_core::model::Side;
use thenar_link::latency::{
    ComparedPart, KEY_DELAY, KEY_DELAY_SPREAD, Lag, LatencyError, MeasuredDelay, lag, possible,
    stillness, taps,
};
use thenar_link::profile::{Tracking, save, states_timing, user_file};
use toml::{Table, Value};

/// Measure how late a tracker sees a hand, and keep it in its profile.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Driver and address of the tracker, such as `hts:9000`.
    address: String,
    /// A second tracker of the same hand, whose delay is known or small: the first one's is that
    /// and the lag between their motions. Without it you tap a key.
    #[arg(long, value_name = "NAME:ADDRESS")]
    with: Option<String>,
    /// Delay of the second tracker [s]; by default what its profile states.
    #[arg(long, value_name = "S", requires = "with", value_parser = delay)]
    reference_latency: Option<f64>,
    /// Motion to compare; by default that of the fingers, or of the wrist where they do not move.
    #[arg(long, value_enum, requires = "with")]
    of: Option<ComparedWord>,
    /// Time for which both are watched while you move [s].
    #[arg(long, value_name = "S", requires = "with", default_value_t = 20.0, value_parser = super::test::seconds)]
    seconds: f64,
    /// Number of times that you tap a key.
    #[arg(long, value_name = "COUNT", conflicts_with = "with", default_value_t = 20, value_parser = clap::value_parser!(u32).range(10..=1000))]
    taps: u32,
    /// The finger that taps.
    #[arg(long, value_enum, conflicts_with = "with", default_value_t)]
    finger: Finger,
    /// From your key to this program [s].
    #[arg(long, value_name = "S", conflicts_with = "with", default_value_t = KEY_DELAY, value_parser = delay)]
    key_delay: f64,
    /// Time for which the hand is held still for the noise [s]; 0 leaves the noise as it is stated.
    #[arg(long, value_name = "S", default_value_t = 4.0, value_parser = super::test::seconds)]
    still: f64,
    /// The hand, where a tracker sees both.
    #[arg(long, value_enum)]
    side: Option<LeftOrRight>,
    /// Keep the result without asking.
    #[arg(long)]
    keep: bool,
    /// The profile to write; by default your own for this driver.
    #[arg(long)]
    output: Option<PathBuf>,
}

/// Motion of a hand that is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum ComparedWord {
    /// Bend of the fingers.
    Fingers,
    /// Speed of the wrist.
    Wrist,
}

/// A hand, as on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum LeftOrRight {
    Left,
    Right,
}

/// A finger, as on the command line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum Finger {
    Thumb,
    #[default]
    Index,
    Middle,
    Ring,
    Little,
}

/// A delay that a device can have.
fn delay(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..=0.5).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds, 0 to 0.5".into()),
    }
}

/// Message of an unfinished measurement.
const UNFINISHED: &str = "not finished: the profile is unchanged";

/// Asks, watches, tells, and keeps what was found if the person agrees.
///
/// # Errors
/// A device is wrong or silent, what was measured is too little or contradicts itself, or the
/// profile cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    interrupt::listen();
    let (driver, rest) = driver_of(&args.address)?;
    let file = profile_of(args, driver.name(), rest);
    let reference_latency = args.reference_latency;
    let mut session = Session::open(&args.address, args.with.as_deref())?;
    let known = match &mut session.reference {
        None => 0.0,
        Some(reference) => reference_latency
            .or_else(|| Some(reference.timing()?.latency))
            .ok_or_else(|| CliError::Input(UNKNOWN.into()))?,
    };
    let keys = Keys::hear();
    let side =
        args.side.map(|hand| if hand == LeftOrRight::Left { Side::Left } else { Side::Right });
    session.meet(side)?;
    let noise = hold_still(&mut session, args, &keys)?;
    let (found, how) = match &args.with {
        Some(name) => compare(&mut session, args, &keys, known, name)?,
        None => tap(&mut session, args, &keys)?,
    };
    let rate = session.rate().ok_or_else(|| CliError::Other("too few samples came".into()))?;
    tell(session.side, args, &found, &how, rate, noise);
    let stated = session.tracker.timing().map(|timing| timing.noise);
    // What stands stiller than its sensors' step is as noisy as was known.
    let noise = noise.filter(|noise| *noise > 0.0).or(stated).unwrap_or(0.0);
    let tracking = rounded(&Tracking { rate, latency: found.mean, noise });
    match file {
        Some(file) => keep(&file, &tracking, args.keep, &keys),
        None => {
            println!("{} has no profile with [tracking]: nothing is kept", driver.name());
            Ok(())
        }
    }
}

/// Why a reference is none.
const UNKNOWN: &str =
    "the second tracker's driver states no delay: say --reference-latency SECONDS";

/// The profile to write, if the driver has one that states delays.
fn profile_of(args: &Args, driver: &str, rest: &str) -> Option<PathBuf> {
    let options = rest.split_once('?').map_or("", |(_, options)| options);
    // Options after that are another device's.
    let options = options.split("wrist=").next().unwrap_or_default();
    let option =
        |key: &str| options.split('&').find_map(|o| o.strip_prefix(key)?.strip_prefix('='));
    let side = match option("side") {
        Some("left") => Some(Side::Left),
        Some("right") => Some(Side::Right),
        _ => None,
    };
    if !states_timing(driver) {
        return args.output.clone();
    }
    (args.output.clone())
        .or_else(|| option("profile").map(PathBuf::from))
        .or_else(|| user_file(driver, side))
}

/// The noise of a hand that is held still \[m\]; once more where it moved.
fn hold_still(session: &mut Session, args: &Args, keys: &Keys) -> Result<Option<f64>, CliError> {
    if args.still == 0.0 {
        return Ok(None);
    }
    loop {
        println!("Hold your hand still for {} s. Enter when ready.", args.still);
        keys.line(UNFINISHED)?;
        session.watch(args.still)?;
        match stillness(&session.trace.seen) {
            // What would be printed as nothing is nothing.
            Ok(noise) => return Ok(Some(if noise < 0.5e-6 { 0.0 } else { noise })),
            Err(moved @ LatencyError::Moved { .. }) => println!("{moved}. Again, please."),
            Err(doubt) => return Err(refused(&doubt)),
        }
    }
}

fn refused(doubt: &LatencyError) -> CliError {
    CliError::Other(format!("nothing is kept: {doubt}"))
}

/// The delay by a second tracker, and how it came about.
fn compare(
    session: &mut Session,
    args: &Args,
    keys: &Keys,
    known: f64,
    name: &str,
) -> Result<(MeasuredDelay, String), CliError> {
    println!(
        "Open and close your hand and move it about for {} s, now fast, now slowly, at no even beat. Enter begins.",
        args.seconds
    );
    keys.line(UNFINISHED)?;
    session.watch(args.seconds)?;
    let by = |part| lag(&session.trace, &session.second, part);
    let found = match args.of {
        Some(ComparedWord::Fingers) => by(ComparedPart::Fingers),
        Some(ComparedWord::Wrist) => by(ComparedPart::Wrist),
        None => by(ComparedPart::Fingers).or_else(|first| match first {
            LatencyError::TooFew { .. } => by(ComparedPart::Wrist).map_err(|_| first),
            _ => Err(first),
        }),
    };
    let Lag { measured, correlation } = found.map_err(|doubt| refused(&doubt))?;
    let total = MeasuredDelay { mean: measured.mean + known, ..measured };
    let advice = "the second tracker's own is stated wrongly, or the two see different motions";
    let total = possible(total, advice).map_err(|doubt| refused(&doubt))?;
    let how = format!(
        "{} seconds of motion, which correlate by {correlation:.3}: {:.1} ms after {name}, whose own delay is {} \
         {:.1} ms",
        measured.events,
        1e3 * measured.mean,
        if args.reference_latency.is_some() { "said to be" } else { "by its profile" },
        1e3 * known
    );
    Ok((total, how))
}

/// The delay by keys that are tapped, and how it came about.
fn tap(
    session: &mut Session,
    args: &Args,
    keys: &Keys,
) -> Result<(MeasuredDelay, String), CliError> {
    let finger = args.finger as usize;
    println!(
        "Tap a key with your {}, {} times, about once a second: from a few centimetres above, briskly, and rest on it \
         for a moment. It begins now.",
        super::feel::NAMES[finger],
        args.taps
    );
    let told = session.watch_keys(args.taps as usize, keys)?;
    let late = taps(&session.trace, finger, &told).map_err(|doubt| refused(&doubt))?;
    let total = MeasuredDelay { mean: late.mean + args.key_delay, ..late };
    let advice = "the key's own is stated wrongly, or another finger taps";
    let total = possible(total, advice).map_err(|doubt| refused(&doubt))?;
    let how = format!(
        "{} taps: the finger is seen to stop {:.1} ms after its key, whose own delay is taken for {:.0} ms. Keyboards \
         differ by some {:.0} ms either way, which the standard error does not know",
        late.events,
        1e3 * late.mean,
        1e3 * args.key_delay,
        1e3 * KEY_DELAY_SPREAD
    );
    Ok((total, how))
}

fn tell(side: Side, args: &Args, found: &MeasuredDelay, how: &str, rate: f64, noise: Option<f64>) {
    let hand = if side == Side::Left { "left" } else { "right" };
    println!("{hand} hand of {}", args.address);
    println!(
        "latency {:.1} ms from motion to sample, standard error {:.1} ms, by {how}",
        1e3 * found.mean,
        1e3 * found.error
    );
    println!("rate    {rate:.1} samples per second");
    match noise {
        None => println!("noise   not measured"),
        Some(noise) if noise > 0.0 => {
            println!("noise   {:.3} mm of a fingertip held still", 1e3 * noise)
        }
        Some(_) => println!("noise   none: the hand stood stiller than a step of its sensors"),
    }
}

/// Numbers that a person can read: a tenth of a millisecond, of a sample and two digits of the
/// noise.
fn rounded(tracking: &Tracking) -> Tracking {
    let to = |x: f64, step: f64| (x / step).round() * step;
    let digits = |x: f64| if x > 0.0 { to(x, 10_f64.powf(x.log10().floor() - 1.0)) } else { 0.0 };
    // Once more through text: multiples of a tenth are no binary numbers.
    let plain = |x: f64| format!("{x:.7}").parse().unwrap_or(x);
    Tracking {
        rate: plain(to(tracking.rate, 0.1)),
        latency: plain(to(tracking.latency, 1e-4)),
        noise: plain(digits(tracking.noise)),
    }
}

/// Writes it into the profile, if the person agrees.
fn keep(file: &Path, tracking: &Tracking, agreed: bool, keys: &Keys) -> Result<(), CliError> {
    tracking
        .check()
        .map_err(|(key, cause)| CliError::Other(format!("nothing is kept: {key} {cause}")))?;
    if !agreed {
        println!("Type `yes` to keep this in {}:", file.display());
        if keys.line(UNFINISHED)? != "yes" {
            println!("the profile is unchanged");
            return Ok(());
        }
    }
    let numbers =
        [("rate", tracking.rate), ("latency", tracking.latency), ("noise", tracking.noise)];
    let table: Table =
        numbers.map(|(key, x)| (key.to_string(), Value::Float(x))).into_iter().collect();
    save(file, std::iter::once(("tracking".to_string(), Value::Table(table))).collect())?;
    println!("wrote {}", file.display());
    Ok(())
}
