//! `thenar bench`: what a step costs.

mod live;
mod memory;
mod paper;
mod samples;
mod scaling;

use std::process::ExitCode;

/// Measures what a step costs on this machine.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    /// The paper's table beside ours, on its bread scene and model sizes.
    Paper(paper::Args),
    /// Bytes and time of the live page's messages, and how late a pose shows.
    Live(live::Args),
    /// Cost over 600 to 17 000 tetrahedra and 0 to 100 contacts, with resident memory.
    Scaling(scaling::Args),
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    let done = match &args.what {
        What::Paper(args) => paper::run(args),
        What::Live(args) => live::run(args),
        What::Scaling(args) => scaling::run(args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::from(2)
        }
    }
}
