//! `thenar haptics`: what touch does, without a device: how stiff a coupling may be, how the three
//! modes differ, and what a loosely held hand makes of a late tracker.

mod compare;
mod map;
mod rehearse;
mod replay;

use crate::error::CliError;

/// Looks into touch without a device.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Stiffness that a coupling may have, against rate and delay: simulated beside theory.
    Map(map::Args),
    /// The three modes of touch on one motion: stiffness, delay and energy.
    Compare(compare::Args),
    /// Close the loop with a virtual wearer and a late tracker.
    Rehearse(rehearse::Args),
    /// Make an incident again, bit for bit.
    Replay(replay::Args),
}

/// Runs the command.
///
/// # Errors
/// The request is wrong, or a file cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    match &args.command {
        Command::Map(args) => map::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Rehearse(args) => rehearse::run(args),
        Command::Replay(args) => replay::run(args),
    }
}
