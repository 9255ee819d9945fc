//! The `thenar` program.

#[allow(dead_code, unused_imports)]
mod picture;
mod validate;

use clap::Parser;
use std::process::ExitCode;

/// A soft hand that grasps.
#[derive(Debug, Parser)]
#[command(name = "thenar", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Compares figures that theory gives with those that we compute.
    Validate(validate::Args),
}

fn main() -> ExitCode {
    match Arguments::parse().command {
        Command::Validate(args) => validate::run(&args),
    }
}
