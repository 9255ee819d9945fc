//! `thenar bench`: what a step costs.

mod against;
mod goals;
mod haptic;
mod live;
mod machine;
mod memory;
mod paper;
mod roofline;
mod samples;
mod scaling;
mod works;

use std::process::ExitCode;

/// Measures what a step costs on this machine: without more, the goals and what is reached.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(subcommand)]
    what: Option<BenchCommand>,
    #[command(flatten)]
    goals: goals::Args,
}

#[derive(Debug, clap::Subcommand)]
enum BenchCommand {
    /// Another build of the program beside this one, by turns, on a machine that may have other
    /// work.
    Against(against::Args),
    /// The paper's table beside ours, on its bread scene and model sizes.
    Paper(paper::Args),
    /// Bytes and time of the live page's messages, and how late a pose shows.
    Live(live::Args),
    /// Cost over 600 to 17 000 tetrahedra and 0 to 100 contacts, with resident memory.
    Scaling(scaling::Args),
    /// Cost of a tick of the haptic loop.
    Haptics,
    /// Floor and measured time of each stage, with the machine's peaks measured in the same run.
    Roofline(roofline::Args),
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    let done = match &args.what {
        None => goals::run(&args.goals),
        Some(BenchCommand::Against(args)) => against::run(args),
        Some(BenchCommand::Paper(args)) => paper::run(args),
        Some(BenchCommand::Live(args)) => live::run(args),
        Some(BenchCommand::Scaling(args)) => scaling::run(args),
        Some(BenchCommand::Haptics) => haptic::run(),
        Some(BenchCommand::Roofline(args)) => roofline::run(args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::from(2)
        }
    }
}
