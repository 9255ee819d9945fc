//! `thenar devices check`: whether this machine is fit for touch, and what would make it so.

mod facts;
mod findings;
#[cfg(unix)]
mod release;
#[cfg(test)]
mod tests;

use crate::error::CliError;
use facts::Facts;
use findings::judge;
use std::path::Path;
use thenar_link::realtime::{PriorityClass, lock_memory, raise_priority, touch_stack};

/// Check whether this machine is fit for touch.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Instead, stop and kill a program that holds a simulated glove, each this often, and print
    /// how long its wearer is held on.
    #[cfg(unix)]
    #[arg(long, value_name = "TIMES", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    release: Option<u32>,
}

/// Prints how the machine stands, and for each thing that it lacks the command that mends it.
///
/// # Errors
/// The system gives no thread to try with, or no device to release.
pub fn run(args: &Args) -> Result<(), CliError> {
    #[cfg(unix)]
    if let Some(times) = args.release {
        crate::interrupt::listen();
        return release::measure(times);
    }
    #[cfg(not(unix))]
    let Args {} = args;
    if !cfg!(target_os = "linux") {
        println!("only priority and memory are looked at: this system is not Linux");
    }
    let findings = judge(&Facts::read(Path::new("/")), &tried()?);
    let mut lacking = 0;
    for finding in &findings {
        let word = if finding.mend.is_some() { "lacks" } else { "good" };
        println!("{word:6} {:27} {}", finding.what, finding.state);
        if let Some(mend) = &finding.mend {
            lacking += 1;
            println!("       {:27} {mend}", "");
        }
    }
    println!();
    match lacking {
        0 => println!("nothing is lacking"),
        1 => println!("1 thing is lacking; touch works without it, later and less evenly"),
        n => println!("{n} things are lacking; touch works without them, later and less evenly"),
    }
    Ok(())
}

/// Answers of the system to a thread that does as those of touch do.
fn tried() -> Result<[Result<(), String>; 2], CliError> {
    let trial = || {
        touch_stack();
        [raise_priority(PriorityClass::Keeper), lock_memory()]
    };
    let thread = std::thread::Builder::new().name("trial".into()).spawn(trial);
    let thread = thread.map_err(|e| CliError::Other(format!("cannot start a thread: {e}")))?;
    thread.join().map_err(|_| CliError::Other("the trial failed".into()))
}
