//! Many worlds stepped at once, each by one thread at a time: the same bits as alone.

use crate::claim::Claim;
use crate::report::StepReport;
use crate::world::{SLICE, World};
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::scope;

/// Makes `n` steps of each world on `threads` threads. All worlds are taken first: when another
/// thread has one of them, or one is in the list twice, none is stepped.
#[pyfunction]
pub fn step_all(
    py: Python<'_>,
    worlds: Vec<Py<World>>,
    n: u64,
    threads: usize,
) -> PyResult<Vec<StepReport>> {
    let worlds: Vec<&World> = worlds.iter().map(Py::get).collect();
    let claims: Vec<Claim<'_>> =
        worlds.iter().map(|world| world.claim()).collect::<PyResult<_>>()?;
    let held: Vec<(&World, Claim<'_>)> = worlds.into_iter().zip(claims).collect();
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let work = || -> PyResult<()> {
        while let Some((world, claim)) = held.get(next.fetch_add(1, Ordering::Relaxed)) {
            let mut left = n;
            while left > 0 && !stop.load(Ordering::Relaxed) {
                left -= world.claimed(claim)?.advance(left, SLICE);
            }
        }
        Ok(())
    };
    let threads = threads.clamp(1, held.len().max(1));
    let done: Vec<PyResult<()>> = py.detach(|| {
        scope(|scope| {
            let (alive, all_gone) = channel::<()>();
            let handles: Vec<_> = (0..threads)
                .map(|_| {
                    let (alive, work) = (alive.clone(), &work);
                    scope.spawn(move || {
                        let _alive = alive;
                        work()
                    })
                })
                .collect();
            drop(alive);
            let heard = listen(&all_gone, &stop);
            let joined = handles
                .into_iter()
                .map(|handle| handle.join().unwrap_or_else(|_| Err(crate::error::broken())));
            joined.chain([heard]).collect()
        })
    });
    done.into_iter().collect::<PyResult<()>>()?;
    let report = |(world, claim): &(&World, Claim<'_>)| -> PyResult<StepReport> {
        Ok(world.claimed(claim)?.session.report().into())
    };
    held.iter().map(report).collect()
}

/// Waits until all threads have gone; Ctrl-C stops them, each between two steps.
fn listen(all_gone: &Receiver<()>, stop: &AtomicBool) -> PyResult<()> {
    let mut heard = Ok(());
    while let Err(RecvTimeoutError::Timeout) = all_gone.recv_timeout(SLICE) {
        if heard.is_ok() {
            heard = Python::attach(|py| py.check_signals());
            stop.store(heard.is_err(), Ordering::Relaxed);
        }
    }
    heard
}
