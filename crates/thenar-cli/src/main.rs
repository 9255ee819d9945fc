//! The `thenar` program.
//!
//! Every command is a module with `Args`, read by clap, and `run`, which does the work; the list
//! of commands is [`Command`]. Exit codes: 0 done, 2 bad usage or input, 1 anything else.

#[macro_use]
mod terminal;
mod ticker;

mod build;
mod building;
mod cache;
mod chart;
mod devices;
mod error;
mod files;
mod hand;
mod interrupt;
mod keeper;
mod lab;
mod page;
mod progress;
mod record;
mod recorder;
mod recording;
mod replay;
mod run;
mod scenes;
mod serve;
mod sweep;
mod touch;
mod words;

use clap::{Parser, Subcommand};
use lab::{bench, compare, fit, haptics, soak, validate};
use std::process::ExitCode;

/// Simulates a soft hand: a jointed skeleton inside deformable flesh, in frictional contact.
/// Without a command, serves the bread scene live to this computer's browser.
#[derive(Debug, Parser)]
#[command(name = "thenar", version)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Serve a scene live to browsers and headsets.
    Serve(serve::Args),
    /// Run a scene without a window.
    Run(run::Args),
    /// Run many cases of a scene, a row of a Parquet table each.
    Sweep(sweep::Args),
    /// Feel a scene through devices, without a page.
    Touch(touch::Args),
    /// Run a scene as fast as it can and record it.
    Record(record::Args),
    /// Replay a recorded session: verify it, export it.
    Replay(replay::Args),
    /// Build a simulation-ready model from a mesh.
    Build(build::Args),
    /// List the scenes that come with the program.
    Scenes(scenes::Args),
    /// List the names and ranges of a hand.
    Hand(hand::Args),
    /// List, test, calibrate and simulate gloves and other devices of touch.
    Devices(devices::Args),
    /// Compare the two-step scheme with the monolithic solver on one scene.
    Compare(compare::Args),
    /// Measure what a step costs.
    Bench(bench::Args),
    /// Study touch without a device: stability maps, the three modes compared, a virtual wearer.
    Haptics(haptics::Args),
    /// Find moduli from force and depth measured on a finger.
    Fit(fit::Args),
    /// Stress test: move a hand at random against table, car and bread.
    Soak(soak::Args),
    /// Compare computed figures with theory and with people.
    Validate(validate::Args),
}

impl Command {
    /// False where many hands are built once each: they would drive out those that are used again.
    fn keeps_hands(&self) -> bool {
        !matches!(self, Self::Sweep(_) | Self::Fit(_) | Self::Bench(_) | Self::Validate(_))
    }
}

fn main() -> ExitCode {
    #[cfg(unix)]
    if keeper::is_asked() {
        return keeper::run();
    }
    interrupt::hear();
    let cli = Cli::parse();
    if cli.command.as_ref().is_none_or(Command::keeps_hands) {
        cache::enable();
    }
    let done = match cli.command {
        Some(Command::Serve(args)) => serve::run(&args),
        Some(Command::Run(args)) => run::run(&args),
        Some(Command::Sweep(args)) => sweep::run(&args),
        Some(Command::Touch(args)) => touch::run(&args),
        Some(Command::Record(args)) => record::run(&args),
        Some(Command::Replay(args)) => replay::run(&args),
        Some(Command::Build(args)) => build::run(&args),
        Some(Command::Scenes(args)) => scenes::run(&args),
        Some(Command::Hand(args)) => hand::run(&args),
        Some(Command::Devices(args)) => devices::run(&args),
        Some(Command::Compare(args)) => compare::run(&args),
        Some(Command::Bench(args)) => return bench::run(&args),
        Some(Command::Haptics(args)) => haptics::run(&args),
        Some(Command::Fit(args)) => fit::run(&args),
        Some(Command::Soak(args)) => return soak::run(&args),
        Some(Command::Validate(args)) => validate::run(&args),
        None => serve::run(&serve::Args::of_scene(DEMO)),
    };
    match done.and_then(|()| terminal::complete()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", thenar_input::brief(&error.to_string()));
            error.exit_code()
        }
    }
}

/// The scene that is served when no other is named.
const DEMO: &str = "bread-grasp";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_demo_is_there_and_the_command_line_is_sound() {
        assert!(thenar_scene::session::builtin(DEMO).is_some());
        <Cli as clap::CommandFactory>::command().debug_assert();
    }

    /// Help shows units as `[s]`: rustdoc's escapes would be shown as they are.
    #[test]
    fn no_help_shows_a_backslash() {
        fn look(command: &mut clap::Command, escaped: &mut Vec<String>) {
            if command.render_long_help().to_string().contains("\\[") {
                escaped.push(command.get_name().into());
            }
            command.get_subcommands_mut().for_each(|command| look(command, escaped));
        }
        let mut escaped = Vec::new();
        look(&mut <Cli as clap::CommandFactory>::command(), &mut escaped);
        assert!(escaped.is_empty(), "{escaped:?}");
    }
}
