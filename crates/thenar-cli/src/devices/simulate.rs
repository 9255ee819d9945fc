//! `thenar devices simulate`: a device without hardware.

use crate::error::CliError;
#[cfg(unix)]
use crate::interrupt;
use std::path::PathBuf;

/// Run a simulated device that a driver can open.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Which; without it, what there is.
    name: Option<String>,
    /// Where its port appears; by default in the folder for temporary files.
    #[arg(long)]
    port: Option<PathBuf>,
    /// For how long [s]; by default until Ctrl-C.
    #[arg(long, value_parser = super::test::seconds)]
    seconds: Option<f64>,
}

/// Runs it: its hand opens and closes every four seconds.
///
/// # Errors
/// There is none of that name, or the system has no pseudo-terminals.
#[cfg(unix)]
pub fn run(args: &Args) -> Result<(), CliError> {
    use std::time::{Duration, Instant};
    use thenar_link::twin::{SIMULATIONS, simulate};

    let Some(name) = &args.name else {
        SIMULATIONS.iter().for_each(|(name, _)| println!("{name}"));
        return Ok(());
    };
    let known = SIMULATIONS.iter().find(|(known, _)| known == name);
    let Some((_, driver)) = known else {
        let names = SIMULATIONS.map(|(name, _)| name).join(", ");
        return Err(CliError::Input(format!(
            "no device is simulated as `{name}`; there are {names}"
        )));
    };
    interrupt::listen();
    let default = || std::env::temp_dir().join(format!("thenar-{name}-{}", std::process::id()));
    let path = args.port.clone().unwrap_or_else(default);
    let failed =
        |e: std::io::Error| CliError::Other(format!("cannot simulate at {}: {e}", path.display()));
    let device = match simulate(name, &path) {
        Some(started) => started.map_err(failed)?,
        None => return Err(CliError::Other(format!("`{name}` cannot be simulated here"))),
    };
    println!("{driver}:{}", path.display());
    println!("in another terminal: thenar devices test {driver}:{}", path.display());
    let start = Instant::now();
    let mut felt = [0.0; 5];
    while !interrupt::asked() && args.seconds.is_none_or(|s| start.elapsed().as_secs_f64() < s) {
        let phase = start.elapsed().as_secs_f64() * std::f64::consts::TAU / 4.0;
        device.set_curls([0.5 - 0.5 * phase.cos(); 5]);
        let now = device.felt();
        if now != felt {
            felt = now;
            let [t, i, m, r, l] = felt.map(|x| (x * 100.0).round());
            println!("felt: thumb {t}%, index {i}%, middle {m}%, ring {r}%, little {l}%");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}

/// There are no pseudo-terminals here.
///
/// # Errors
/// Always.
#[cfg(not(unix))]
pub fn run(_: &Args) -> Result<(), CliError> {
    Err(CliError::Other("this system has no pseudo-terminals to simulate a device with".into()))
}
