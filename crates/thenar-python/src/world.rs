//! A world that Python steps.

use crate::claim::{Claim, Claims};
use crate::describe;
use crate::error;
use crate::numbers::{rows, table};
use crate::picture::{self, PictureSpec};
use crate::quantity::Quantity;
use crate::record::ActiveRecording;
use crate::report::StepReport;
use crate::running::Running;
use crate::taxels::Taxels;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::Duration;
use thenar_core::Vec3;
use thenar_core::world::Target;
use thenar_picture::Image;
use thenar_scene::flat::{pose, target};
use thenar_scene::grip::GripKind;
use thenar_scene::live::{LivePose, Mover};
use thenar_scene::recording::{go_on_from, snapshot};
use thenar_scene::session::{Session, Source};
use thenar_scene::tuning::SettingValue;

/// Python is asked so often whether Ctrl-C was pressed.
pub const SLICE: Duration = Duration::from_millis(20);

/// A session behind a lock. One thread has it at a time; another is refused, never kept waiting.
#[pyclass(frozen, module = "thenar._thenar")]
#[derive(Debug)]
pub struct World {
    claims: Claims,
    running: Mutex<Running>,
}

impl World {
    /// A session that was just opened from this source.
    pub fn new(session: Session, source: &Source) -> Self {
        Self { claims: Claims::default(), running: Mutex::new(Running::new(session, source)) }
    }

    /// Takes the world for one thread.
    ///
    /// # Errors
    /// The world is taken.
    pub fn claim(&self) -> PyResult<Claim<'_>> {
        self.claims.take().ok_or_else(error::busy)
    }

    /// The session, for whoever has the claim.
    ///
    /// # Errors
    /// A step has panicked.
    pub fn claimed(&self, _: &Claim<'_>) -> PyResult<MutexGuard<'_, Running>> {
        match self.running.try_lock() {
            Ok(running) => Ok(running),
            Err(TryLockError::WouldBlock) => Err(error::busy()),
            Err(TryLockError::Poisoned(_)) => Err(error::broken()),
        }
    }

    /// Does something with the session.
    fn with<T>(&self, act: impl FnOnce(&mut Running) -> PyResult<T>) -> PyResult<T> {
        let claim = self.claim()?;
        act(&mut *self.claimed(&claim)?)
    }

    /// Does something that makes all that was read stale.
    fn change<T>(&self, act: impl FnOnce(&mut Running) -> PyResult<T>) -> PyResult<T> {
        self.with(|running| {
            let done = act(running)?;
            running.generation += 1;
            Ok(done)
        })
    }
}

#[pymethods]
impl World {
    /// Makes `n` steps; other Python threads run meanwhile. The report is that of the last.
    fn step(&self, py: Python<'_>, n: u64) -> PyResult<StepReport> {
        let claim = self.claim()?;
        let mut left = n;
        while left > 0 {
            let made =
                py.detach(|| -> PyResult<u64> { Ok(self.claimed(&claim)?.advance(left, SLICE)) });
            left -= made?;
            py.check_signals()?;
        }
        Ok(self.claimed(&claim)?.session.report().into())
    }

    /// Back to the start.
    fn reset(&self) -> PyResult<()> {
        self.change(|running| {
            running.session.restart();
            Ok(())
        })
    }

    /// The report of the last step.
    fn report(&self) -> PyResult<StepReport> {
        self.with(|running| Ok(running.session.report().into()))
    }

    /// Simulated time [s], steps since the start, and steps taken back so far.
    fn progress(&self) -> PyResult<(f64, u64, u64)> {
        self.with(|running| {
            let session = &running.session;
            Ok((session.world().time(), session.steps(), running.taken_back))
        })
    }

    /// Time step [s].
    fn time_step(&self) -> PyResult<f64> {
        self.with(|running| Ok(running.session.world().time_step()))
    }

    /// A hash of every bit of the state.
    fn state_hash(&self) -> PyResult<u64> {
        self.with(|running| Ok(running.session.world().state_hash()))
    }

    /// Snapshot of everything that the next step depends on.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.with(|running| Ok(PyBytes::new(py, &snapshot(&running.session, running.start))))
    }

    /// Goes on from a state.
    fn set_state(&self, state: &[u8]) -> PyResult<()> {
        self.change(|running| {
            if running.writing.is_some() {
                let what =
                    "a world that is recorded takes no state: its recording would not know of it";
                return Err(error::StateError::new_err(what));
            }
            let Running { session, start, .. } = running;
            go_on_from(session, *start, state).map_err(error::state)
        })
    }

    /// Counts changes of the state.
    fn generation(&self) -> PyResult<u64> {
        self.with(|running| Ok(running.generation))
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
        self.with(|running| match running.generation == generation {
            true => running.read(py, what, index),
            false => Err(error::stale()),
        })
    }

    /// Taxels of a shipped layout on a hand: patches of `rows` rows and `columns` columns.
    fn taxels_of(
        &self,
        hand: usize,
        layout: &str,
        rows: usize,
        columns: usize,
        reach: f64,
    ) -> PyResult<Taxels> {
        self.with(|running| {
            Taxels::of_layout(&running.session, hand, layout, [rows, columns], reach)
        })
    }

    /// Taxels where bones' skin is nearest to points: names of bones, and rows of points in their
    /// frames.
    fn taxels_at(
        &self,
        hand: usize,
        points: Vec<(String, Vec<u8>)>,
        reach: f64,
    ) -> PyResult<Taxels> {
        self.with(|running| Taxels::at_points(&running.session, hand, &points, reach))
    }

    /// Readings of taxels of this world, if its state is still that of `generation`.
    fn read_taxels<'py>(
        &self,
        py: Python<'py>,
        taxels: &Taxels,
        generation: u64,
    ) -> PyResult<Bound<'py, PyBytes>> {
        self.with(|running| match running.generation == generation {
            true => taxels.read(py, running.session.world()),
            false => Err(error::stale()),
        })
    }

    /// A picture: rows from the top of 3 bytes each, sRGB.
    fn picture<'py>(
        &self,
        py: Python<'py>,
        size: [u32; 2],
        layers: &str,
        camera: Option<[f64; 7]>,
        quality: &str,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let wanted = PictureSpec::new(size, layers, camera, quality)?;
        Ok(PyBytes::new(py, &self.drawn(py, &wanted)?.rgb))
    }

    /// A picture as a PNG file.
    fn save_picture(
        &self,
        py: Python<'_>,
        file: PathBuf,
        size: [u32; 2],
        layers: &str,
        camera: Option<[f64; 7]>,
        quality: &str,
    ) -> PyResult<()> {
        let wanted = PictureSpec::new(size, layers, camera, quality)?;
        let image = self.drawn(py, &wanted)?;
        py.detach(|| picture::write(&image, file))
    }

    /// The constant part of the world, as JSON.
    fn describe(&self) -> PyResult<String> {
        self.with(|running| Ok(describe::json(&running.session)))
    }

    /// Corners of the triangles of a deformable body's surface, rows of three `u32`.
    fn triangles<'py>(&self, py: Python<'py>, soft: usize) -> PyResult<Bound<'py, PyBytes>> {
        self.with(|running| describe::triangles(py, &running.session, soft))
    }

    /// Moves a hand by its joints: 25 rows of position and quaternion, and 25 radii.
    fn follow_joints(
        &self,
        hand: usize,
        joints: &[u8],
        radii: &[u8],
        time: Option<f64>,
    ) -> PyResult<()> {
        let joints = table::<25, 7>(joints)?.each_ref().map(pose);
        let [radii] = table::<1, 25>(radii)?;
        self.follow(hand, &LivePose::Joints { joints, radii }, time)
    }

    /// Moves a hand by its wrist and twenty angles.
    fn follow_angles(
        &self,
        hand: usize,
        wrist: &[u8],
        angles: &[u8],
        time: Option<f64>,
    ) -> PyResult<()> {
        let [wrist] = table::<1, 7>(wrist)?;
        let [angles] = table::<1, 20>(angles)?;
        self.follow(hand, &LivePose::Angles { wrist: pose(&wrist), angles }, time)
    }

    /// Twenty angles with which a hand's pads come to places (thumb first; a place that is not
    /// finite is none), with the wrist there, and how far each pad ends from its place [m].
    fn reaching<'py>(
        &self,
        py: Python<'py>,
        hand: usize,
        wrist: &[u8],
        tips: &[u8],
    ) -> PyResult<(Bound<'py, PyBytes>, [f64; 5])> {
        let [wrist] = table::<1, 7>(wrist)?;
        let tips = table::<5, 3>(tips)?.map(|tip| Some(Vec3::from(tip)).filter(is_finite));
        self.with(|running| {
            let found = running.session.reaching(hand, pose(&wrist), &tips);
            let (found, misses) = found.map_err(|e| error::pose(&e))?;
            let LivePose::Angles { angles, .. } = found else {
                return Err(error::PoseError::new_err("digits were bent by no angles"));
            };
            let bytes: Vec<u8> = angles.iter().flat_map(|angle| angle.to_le_bytes()).collect();
            Ok((PyBytes::new(py, &bytes), misses))
        })
    }

    /// The hand is not tracked any more.
    fn lose(&self, hand: usize) -> PyResult<()> {
        self.with(|running| {
            running.session.live_lost(hand);
            Ok(())
        })
    }

    /// Hands a hand back to its script.
    fn follow_script(&self, hand: usize) -> PyResult<()> {
        self.with(|running| {
            running.session.follow_script(hand);
            Ok(())
        })
    }

    /// Lets a hand grip a body, or where none is named the nearest one under its pads; returns the
    /// body's name.
    fn grip(
        &self,
        hand: usize,
        object: Option<&str>,
        kind: &str,
        force: Option<f64>,
    ) -> PyResult<String> {
        let kinds = || GripKind::ALL.map(GripKind::name).join(", ");
        let kind = GripKind::named(kind).ok_or_else(|| {
            error::GripError::new_err(format!(
                "no kind of grip is named {kind:?}; there are {}",
                kinds()
            ))
        })?;
        self.with(|running| {
            running.session.grip(hand, object, kind, force).map_err(|e| error::grip(&e))
        })
    }

    /// Opens a hand that grips.
    fn release(&self, hand: usize) -> PyResult<()> {
        self.with(|running| running.session.release(hand).map_err(|e| error::grip(&e)))
    }

    /// Kind, phase, force asked and force felt [N] of what a hand grips, and what is amiss.
    #[allow(clippy::type_complexity)] // what the other half names
    fn grip_state(
        &self,
        hand: usize,
    ) -> PyResult<Option<(&'static str, &'static str, f64, f64, Option<String>)>> {
        self.with(|running| {
            let state = running.session.grip_state(hand);
            Ok(state.map(|state| {
                let trouble = running.session.grip_trouble(hand);
                let order = state.order;
                (order.kind.name(), state.phase.name(), order.force, state.force, trouble)
            }))
        })
    }

    /// Leads the bones of a hand: rows of pose, velocity and angular velocity.
    fn lead(&self, hand: usize, targets: &[u8]) -> PyResult<bool> {
        let targets: Vec<Target> = rows::<13>(targets)?.iter().map(target).collect();
        self.with(|running| Ok(running.session.lead(hand, targets.iter().copied())))
    }

    /// Leads a hand no more.
    fn let_go(&self, hand: usize) -> PyResult<()> {
        self.with(|running| {
            running.session.let_go(hand);
            Ok(())
        })
    }

    /// The hand's mover: `script`, `live` or `lost`.
    fn mover(&self, hand: usize) -> PyResult<&'static str> {
        self.with(|running| {
            Ok(match running.session.mover(hand) {
                Mover::Script => "script",
                Mover::Live => "live",
                Mover::Lost => "lost",
            })
        })
    }

    /// The settings that can be changed: key, value, unit and what a change does.
    #[allow(clippy::type_complexity)] // a row per setting, which the other half names
    fn settings(&self) -> PyResult<Vec<(&'static str, Setting, &'static str, &'static str)>> {
        self.with(|running| {
            let settings = running.session.settings().into_iter();
            Ok(settings.map(|s| (s.key, Setting::from(s.value), s.unit, s.help)).collect())
        })
    }

    /// Changes a setting.
    fn set(&self, key: &str, value: Setting) -> PyResult<()> {
        self.with(|running| running.session.set(key, &value.into()).map_err(|e| error::setting(&e)))
    }

    /// Records from now on.
    fn record(&self, file: PathBuf, keyframes: f64) -> PyResult<()> {
        self.with(|running| {
            if running.writing.is_some() {
                return Err(error::RecordingError::new_err("the world is being recorded already"));
            }
            if !running.is_fresh() {
                let what =
                    "a recording begins where its scene does: record a world that was just made";
                return Err(error::RecordingError::new_err(what));
            }
            let (writing, witness) = ActiveRecording::start(&file, keyframes)?;
            running.session.set_witness(witness);
            running.writing = Some(writing);
            Ok(())
        })
    }

    /// Ends the recording; its size [bytes], None when there was none.
    fn end_recording(&self, py: Python<'_>) -> PyResult<Option<u64>> {
        let writing = self.with(|running| {
            drop(running.session.take_witness());
            Ok(running.writing.take())
        })?;
        writing.map(|writing| py.detach(|| writing.finish())).transpose()
    }
}

impl World {
    /// Draws it; other Python threads run meanwhile.
    fn drawn(&self, py: Python<'_>, wanted: &PictureSpec) -> PyResult<Image> {
        let claim = self.claim()?;
        py.detach(|| Ok(wanted.draw(&self.claimed(&claim)?.session)))
    }

    fn follow(&self, hand: usize, pose: &LivePose, time: Option<f64>) -> PyResult<()> {
        self.with(|running| {
            let time = time.unwrap_or_else(|| running.session.world().time());
            running.session.live_pose(hand, time, pose).map_err(|e| error::pose(&e))
        })
    }
}

fn is_finite(v: &Vec3) -> bool {
    v.iter().all(|x| x.is_finite())
}

/// A setting's value: a number or a word.
#[derive(Clone, Debug, FromPyObject, IntoPyObject)]
pub enum Setting {
    /// A number, in the setting's unit.
    Number(f64),
    /// A choice, for settings that are words.
    Choice(String),
}

impl From<SettingValue> for Setting {
    fn from(value: SettingValue) -> Self {
        match value {
            SettingValue::Number(number) => Self::Number(number),
            SettingValue::Choice(word) => Self::Choice(word),
        }
    }
}

impl From<Setting> for SettingValue {
    fn from(value: Setting) -> Self {
        match value {
            Setting::Number(number) => Self::Number(number),
            Setting::Choice(word) => Self::Choice(word),
        }
    }
}
