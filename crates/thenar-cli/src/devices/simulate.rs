//! `thenar devices simulate`: a device without hardware.

use crate::error::CliError;
use crate::interrupt;
use std::time::{Duration, Instant};
use thenar_link::twin::SIMULATIONS;

/// Run a simulated device that a driver can open.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Which; without it, what there is.
    name: Option<String>,
    /// Address of the device: a path for gloves on serial ports, by default in the folder for
    /// temporary files; HOST:PORT for the others, by default where their driver looks first.
    #[arg(long)]
    port: Option<String>,
    /// Hold the hand still, so far closed: 0 open to 1 closed. By default it opens and closes.
    #[arg(long, value_parser = super::test::fraction)]
    still: Option<f64>,
    /// Age of what it reports [s]: all simulated hands that are not still move as one, by this
    /// computer's clock.
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = late)]
    late: f64,
    /// For how long [s]; by default until Ctrl-C.
    #[arg(long, value_parser = super::test::seconds)]
    seconds: Option<f64>,
}

/// Time in which the hand opens and closes \[s\].
const PERIOD: f64 = 4.0;

/// A delay that a tracker can have.
fn late(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..=0.5).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds, 0 to 0.5".into()),
    }
}

/// Time of this computer, the same for all programs \[s\].
fn clock() -> f64 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    // Whole periods are left out, for the digits.
    now.map_or(0.0, |time| time.as_secs_f64() % (1e6 * PERIOD))
}

/// Runs it.
///
/// # Errors
/// There is none of that name, or its place is taken.
pub fn run(args: &Args) -> Result<(), CliError> {
    let Some(name) = &args.name else {
        for kind in SIMULATIONS {
            println!("{:20} {}:{}", kind.name, kind.driver, kind.place.unwrap_or("PORT"));
        }
        return Ok(());
    };
    let Some(kind) = SIMULATIONS.iter().find(|kind| kind.name == name) else {
        let names: Vec<_> = SIMULATIONS.iter().map(|kind| kind.name).collect();
        return Err(CliError::Input(format!(
            "no device is simulated as `{name}`; there are {}",
            names.join(", ")
        )));
    };
    interrupt::listen();
    let file = || std::env::temp_dir().join(format!("thenar-{name}-{}", std::process::id()));
    let default = || kind.place.map_or_else(|| file().display().to_string(), str::to_owned);
    let place = args.port.clone().unwrap_or_else(default);
    let device = kind
        .start(&place)
        .map_err(|e| CliError::Other(format!("cannot simulate {name} at {place}: {e}")))?;
    let address = format!("{}:{place}", kind.driver);
    println!("{address}");
    println!("in another terminal: thenar devices test {address}");
    let start = Instant::now();
    let mut felt = device.felt();
    while !interrupt::asked() && args.seconds.is_none_or(|s| start.elapsed().as_secs_f64() < s) {
        let phase = (clock() - args.late) / PERIOD * std::f64::consts::TAU;
        device.set_curls([args.still.unwrap_or(0.5 - 0.5 * phase.cos()); 5]);
        let now = device.felt();
        if now != felt {
            println!("felt: {now}");
            felt = now;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(())
}
