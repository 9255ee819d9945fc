//! Recordings, made again step by step.

use crate::error;
use crate::quantity::Quantity;
use crate::{claim::Claims, describe};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, TryLockError};
use thenar_core::readout::ContactReadout;
use thenar_scene::recording::{Event, Replay};

/// A recording being made again.
#[derive(Debug)]
struct ActiveReplay {
    replay: Replay,
    generation: u64,
    /// Contact in other forms, of the present scene.
    readout: Option<ContactReadout>,
    read: bool,
}

/// A step of a recording: time in it [s], number of its scene, steps since that began, hash of the
/// state after it, whether that is the hash that was recorded (None: there was none).
type Step = (f64, u32, u64, u64, Option<bool>);

/// A recording being made again, behind a lock like a world.
#[pyclass(frozen, module = "thenar._thenar")]
#[derive(Debug)]
pub struct Recording {
    claims: Claims,
    making: Mutex<ActiveReplay>,
}

impl Recording {
    fn lock(&self) -> PyResult<MutexGuard<'_, ActiveReplay>> {
        match self.making.try_lock() {
            Ok(making) => Ok(making),
            Err(TryLockError::WouldBlock) => Err(error::busy()),
            Err(TryLockError::Poisoned(_)) => Err(error::broken()),
        }
    }

    fn with<T>(&self, act: impl FnOnce(&mut ActiveReplay) -> PyResult<T>) -> PyResult<T> {
        let _claim = self.claims.take().ok_or_else(error::busy)?;
        act(&mut *self.lock()?)
    }
}

#[pymethods]
impl Recording {
    /// Opens a recording.
    #[staticmethod]
    fn open(py: Python<'_>, file: PathBuf) -> PyResult<Self> {
        let replay = py.detach(|| Replay::open(&file)).map_err(|e| error::replay(&e))?;
        let making = ActiveReplay { replay, generation: 0, readout: None, read: false };
        Ok(Self { claims: Claims::default(), making: Mutex::new(making) })
    }

    /// The header: program, system, vector instructions, time of the beginning [ns since 1970].
    fn header(&self) -> PyResult<(String, String, String, u64)> {
        self.with(|making| {
            let header = making.replay.header();
            let (program, system) = (header.program.clone(), header.system.clone());
            Ok((program, system, header.vectors.clone(), header.created_unix_ns))
        })
    }

    /// Makes the next step; None at the end. Other Python threads run meanwhile.
    fn step(&self, py: Python<'_>) -> PyResult<Option<Step>> {
        let _claim = self.claims.take().ok_or_else(error::busy)?;
        loop {
            let step = py.detach(|| self.lock()?.step())?;
            py.check_signals()?;
            if let Some(step) = step {
                return Ok(step);
            }
        }
    }

    /// The verdict so far in words; same bits, ended, steps, and steps with the same bits.
    fn verdict(&self) -> PyResult<(String, bool, bool, u64, u64)> {
        self.with(|making| {
            let verdict = making.replay.verdict();
            let (same, ended) = (verdict.is_same(), verdict.ended);
            Ok((verdict.to_string(), same, ended, verdict.steps, verdict.same))
        })
    }

    /// Counts changes of the state.
    fn generation(&self) -> PyResult<u64> {
        self.with(|making| Ok(making.generation))
    }

    /// Numbers of the present state, if it is still that of `generation`.
    fn read<'py>(
        &self,
        py: Python<'py>,
        what: &str,
        index: usize,
        generation: u64,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let what = Quantity::named(what)?;
        self.with(|making| {
            if making.generation != generation {
                return Err(error::stale());
            }
            let session = making.replay.session().ok_or_else(no_scene)?;
            let readout =
                making.readout.get_or_insert_with(|| ContactReadout::new(session.world()));
            if what.is_of_contact() && !making.read {
                readout.read(session.world());
                making.read = true;
            }
            what.read(py, session, readout, index)
        })
    }

    /// The constant part of the present scene, as JSON; None before the first.
    fn describe(&self) -> PyResult<Option<String>> {
        self.with(|making| Ok(making.replay.session().map(describe::json)))
    }

    /// Corners of the triangles of a deformable body's surface, rows of three `u32`.
    fn triangles<'py>(&self, py: Python<'py>, soft: usize) -> PyResult<Bound<'py, PyBytes>> {
        self.with(|making| {
            let session = making.replay.session().ok_or_else(no_scene)?;
            describe::triangles(py, session, soft)
        })
    }
}

fn no_scene() -> PyErr {
    error::RecordingError::new_err("no scene of the recording has begun yet")
}

impl ActiveReplay {
    /// The next event: `None` for what is no step, and `Some(None)` at the end.
    fn step(&mut self) -> PyResult<Option<Option<Step>>> {
        let before = self.replay.verdict().clone();
        // Keyframes move the session even where no event follows.
        self.generation += 1;
        self.read = false;
        let Some(event) = self.replay.next().map_err(|e| error::replay(&e))? else {
            return Ok(Some(None));
        };
        match event {
            Event::Scene { .. } => self.readout = None,
            Event::Stepped { time_ns, .. } => return Ok(Some(self.made(time_ns, &before))),
            _ => {}
        }
        Ok(None)
    }

    fn made(&self, time_ns: u64, before: &thenar_scene::recording::Verdict) -> Option<Step> {
        let (session, verdict) = (self.replay.session()?, self.replay.verdict());
        let marked = verdict.unmarked == before.unmarked;
        let same = marked.then_some(verdict.same > before.same);
        let hash = session.world().state_hash();
        Some((time_ns as f64 * 1e-9, verdict.scenes, session.steps(), hash, same))
    }
}
