//! The cases of a shard on threads: whoever is free takes the next.

use super::case::{CaseFailure, run_case};
use super::plan::Plan;
use super::record::Record;
use super::{Args, Scene, ShardFiles};
use crate::error::CliError;
use crate::interrupt;
use crate::progress::Meter;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};
use thenar_input::brief;

/// Most failures that are reported one by one: what a person reads.
const TOLD_MAX: u64 = 20;

/// Runs the cases that have no record yet and writes theirs.
///
/// # Errors
/// An output cannot be written, or the program was asked to end; records so far are whole.
pub fn run(
    args: &Args,
    scene: &Scene,
    plan: &Plan,
    place: &ShardFiles,
    threads: usize,
) -> Result<(), CliError> {
    std::fs::create_dir_all(&place.cases)
        .map_err(|e| CliError::Other(format!("cannot make {}: {e}", place.cases.display())))?;
    let all = args.shard.cases(plan.cases);
    let total = all.clone().count() as u64;
    let left: Vec<u64> = all.filter(|case| Record::read(&place.cases, *case).is_none()).collect();
    let there = total - left.len() as u64;
    if there > 0 && !args.quiet {
        eprintln!("note: {there} of {total} cases are there already");
    }
    let meter = Meter::of_cases(total, args.quiet);
    meter.at(there, there);
    let (next, done, failed) = (AtomicUsize::new(0), AtomicU64::new(there), AtomicU64::new(0));
    let stop = AtomicBool::new(false);
    let error = Mutex::new(None);
    let work = || {
        while let Some(&case) = left.get(next.fetch_add(1, Relaxed)) {
            let asked = || interrupt::asked() || stop.load(Relaxed);
            if asked() {
                return;
            }
            let overrides = plan.overrides(case);
            let record = run_case(args, scene, place, case, &overrides, asked);
            let written =
                record.and_then(|r| r.write(&place.cases).map(|()| r).map_err(CaseFailure::from));
            match written {
                Ok(record) => {
                    let done = 1 + done.fetch_add(1, Relaxed);
                    meter.at(done, done);
                    if let Some(reason) = &record.failed
                        && failed.fetch_add(1, Relaxed) < TOLD_MAX
                    {
                        let reason = brief(reason);
                        meter.suspend(|| eprintln!("warning: case {case} failed: {reason}"));
                    }
                }
                Err(CaseFailure::Asked) => return,
                Err(CaseFailure::Failed(cause)) => {
                    stop.store(true, Relaxed);
                    error.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(cause);
                    return;
                }
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..threads.min(left.len()) {
            scope.spawn(work);
        }
    });
    drop(meter);
    if let Some(error) = error.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    let done = done.into_inner();
    match done == total {
        true => Ok(()),
        false => Err(CliError::Other(format!(
            "interrupted with {done} of {total} cases done; the same command goes on with the others"
        ))),
    }
}
