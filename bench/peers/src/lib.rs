//! What the drivers of both engines share: the job they read and the outcome they write.
//!
//! A job is made by `peers/jobs.py`, which documents its fields. Units are SI.

pub mod job;
pub mod outcome;
pub mod simple;

pub use job::Job;
pub use outcome::Outcome;

use std::process::ExitCode;

/// `driver JOB.json OUTCOME.json`: reads, runs, writes.
pub fn drive(run: impl Fn(&Job) -> Result<Outcome, String>) -> ExitCode {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let [job, outcome] = files.as_slice() else {
        eprintln!("usage: driver JOB.json OUTCOME.json");
        return ExitCode::from(2);
    };
    let done = Job::read(job).and_then(|job| run(&job)).and_then(|done| done.write(outcome));
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("{problem}");
            ExitCode::FAILURE
        }
    }
}
