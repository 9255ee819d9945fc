//! `thenar devices`: gloves and other devices of touch, before they meet a simulation.

mod calibrate;
mod check;
mod comfort;
mod feel;
mod keys;
mod latency;
mod list;
mod simulate;
mod speed;
mod test;

use crate::error::CliError;
use thenar_link::Driver;

/// List, test, calibrate and simulate gloves and other devices of touch.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: DevicesCommand,
}

#[derive(Debug, clap::Subcommand)]
enum DevicesCommand {
    /// List connected devices and all drivers.
    List,
    /// Check whether this machine is fit for touch, and how to mend what it lacks.
    Check(check::Args),
    /// Show live what a device sends.
    Test(test::Args),
    /// Fit a glove to its wearer.
    Calibrate(calibrate::Args),
    /// Find out how much force a wearer likes, finger by finger, with a stop at hand.
    Comfort(comfort::Args),
    /// Measure how late a tracker sees a hand, and keep it in its profile.
    Latency(latency::Args),
    /// Run a simulated device that a driver can open.
    Simulate(simulate::Args),
}

/// Runs one of them.
///
/// # Errors
/// The address is wrong, the device silent, or a file cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    match &args.what {
        DevicesCommand::List => list::run(),
        DevicesCommand::Check(args) => check::run(args),
        DevicesCommand::Test(args) => test::run(args),
        DevicesCommand::Calibrate(args) => calibrate::run(args),
        DevicesCommand::Comfort(args) => comfort::run(args),
        DevicesCommand::Latency(args) => latency::run(args),
        DevicesCommand::Simulate(args) => simulate::run(args),
    }
}

/// The driver of an address, and what follows its name.
fn driver_of(address: &str) -> Result<(Box<dyn Driver>, &str), CliError> {
    let (name, rest) = address.split_once(':').unwrap_or((address, ""));
    let found = thenar_link::drivers().into_iter().find(|driver| driver.name() == name);
    let unknown =
        || CliError::Input(format!("no driver is named `{name}`; see `thenar devices list`"));
    Ok((found.ok_or_else(unknown)?, rest))
}
