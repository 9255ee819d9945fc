//! Stepping, states and settings.
#![allow(unsafe_code)] // exported by name, and handed pointers

use crate::boundary::{Refusal, Status, guard};
use crate::pointer;
use crate::running::World;
use std::ffi::c_char;
use thenar_core::world::StepReport;
use thenar_scene::recording::{go_on_from, snapshot};
use thenar_scene::tuning::SettingValue;

/// Counts changes of what is in the header that programs must be built again for.
pub const THENAR_ABI_VERSION: u32 = 1;

/// The report of a step.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Report {
    /// Contact points, near or touching.
    pub contacts: u32,
    /// Contact points that bear load.
    pub contacts_active: u32,
    /// Contact points left out for want of room; the deepest are kept.
    pub contacts_dropped: u32,
    /// Parts in which the step was made: 1 unless contact did not carry it through.
    pub parts: u32,
    /// Deepest penetration at the end of the step [m].
    pub penetration_max: f64,
    /// Velocity error that contact leaves, as estimated [m/s].
    pub contact_residual: f64,
    /// Contact missed the accuracy asked for.
    pub contact_unconverged: bool,
    /// A stand-in made the step, because the chosen solver could not.
    pub fell_back: bool,
    /// A number was not finite: what hangs together with it is where it was, at rest.
    pub non_finite: bool,
    /// Everything was taken back so, and no time passed.
    pub taken_back: bool,
}

impl From<&StepReport> for Report {
    fn from(report: &StepReport) -> Self {
        Self {
            contacts: report.contacts,
            contacts_active: report.contacts_active,
            contacts_dropped: report.contacts_dropped,
            parts: report.parts,
            penetration_max: report.penetration_max,
            contact_residual: report.contact_residual,
            contact_unconverged: report.contact_unconverged,
            fell_back: report.fell_back,
            non_finite: report.non_finite,
            taken_back: report.taken_back,
        }
    }
}

/// The `THENAR_ABI_VERSION` that the library was built with: compare it with the header's.
#[unsafe(no_mangle)]
pub extern "C" fn thenar_abi_version() -> u32 {
    THENAR_ABI_VERSION
}

/// Makes `steps` steps. `report`, unless it is NULL, gets that of the last one.
///
/// # Safety
/// `world` is NULL or a live handle; `report` is NULL or has room for a report.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_step(
    world: *const World,
    steps: u64,
    report: *mut Report,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            for _ in 0..steps {
                running.session.step(&mut ());
            }
            if report.is_null() {
                return Ok(());
            }
            // SAFETY: the caller's word.
            unsafe { pointer::put("report", report, Report::from(running.session.report())) }
        })
    })
}

/// Back to the start: time 0, bodies in their start states, scripts from the beginning. Settings
/// stay, and so does who moves the hands.
///
/// # Safety
/// `world` is NULL or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_reset(world: *const World) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            running.session.restart();
            Ok(())
        })
    })
}

/// Simulated time since the start [s], time step [s], steps since the start, and a hash of every
/// bit of the state, as recordings have it. What is not wanted is NULL.
///
/// # Safety
/// `world` is NULL or a live handle; the others are NULL or have room for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_progress(
    world: *const World,
    time: *mut f64,
    time_step: *mut f64,
    steps: *mut u64,
    state_hash: *mut u64,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word, for each pointer that is there.
        unsafe { pointer::world(world) }?.with(|running| unsafe {
            let (session, world) = (&running.session, running.session.world());
            optional("time", time, world.time())?;
            optional("time_step", time_step, world.time_step())?;
            optional("steps", steps, session.steps())?;
            if state_hash.is_null() {
                return Ok(());
            }
            pointer::put("state_hash", state_hash, world.state_hash())
        })
    })
}

/// Writes a value where one is wanted.
///
/// # Safety
/// As of [`pointer::put`].
unsafe fn optional<T>(name: &str, pointer: *mut T, value: T) -> Result<(), Refusal> {
    match pointer.is_null() {
        true => Ok(()),
        // SAFETY: the caller's word.
        false => unsafe { pointer::put(name, pointer, value) },
    }
}

/// Changes a setting from the next step on, such as `friction` to 0.4; SI units.
///
/// # Safety
/// `world` is NULL or a live handle; `key` is NULL or ends with a NUL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_set(
    world: *const World,
    key: *const c_char,
    value: f64,
) -> Status {
    // SAFETY: the caller's word.
    guard(|| unsafe { set(world, key, &SettingValue::Number(value)) })
}

/// Changes a setting that is a word, such as `solver` to `two-step`.
///
/// # Safety
/// `world` is NULL or a live handle; `key` and `word` are NULL or end with a NUL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_set_word(
    world: *const World,
    key: *const c_char,
    word: *const c_char,
) -> Status {
    // SAFETY: the caller's word.
    guard(|| unsafe {
        let word = pointer::text("word", word)?.to_owned();
        set(world, key, &SettingValue::Choice(word))
    })
}

/// Changes a setting.
///
/// # Safety
/// As of [`pointer::world`] and [`pointer::text`].
unsafe fn set(
    world: *const World,
    key: *const c_char,
    value: &SettingValue,
) -> Result<(), Refusal> {
    // SAFETY: the caller's word.
    let (world, key) = unsafe { (pointer::world(world)?, pointer::text("key", key)?) };
    world.with(|running| {
        let refused = |e: thenar_scene::tuning::SettingError| Refusal {
            status: Status::Setting,
            words: e.to_string(),
        };
        running.session.set(key, value).map_err(refused)
    })
}

/// Everything that the next steps depend on, as bytes. `*count` gets how many there are; `state`,
/// unless it is NULL, gets them, and `room` says how many it can take.
///
/// # Safety
/// `world` is NULL or a live handle; `state` is NULL or has room for `room` bytes, `count` for a
/// number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_state(
    world: *const World,
    state: *mut u8,
    room: usize,
    count: *mut usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let bytes = snapshot(&running.session, running.start);
            // SAFETY: the caller's word.
            unsafe { pointer::list("state", state, room, count, &bytes) }
        })
    })
}

/// Goes on from a state of this world, or of another of the same scene, with the same bits.
///
/// # Safety
/// `world` is NULL or a live handle; `state` is NULL or of `count` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_set_state(
    world: *const World,
    state: *const u8,
    count: usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        let (world, state) =
            unsafe { (pointer::world(world)?, pointer::slice("state", state, count)?) };
        world.with(|running| {
            let refused = |e: thenar_scene::recording::SnapshotError| Refusal {
                status: Status::State,
                words: e.to_string(),
            };
            go_on_from(&mut running.session, running.start, state).map_err(refused)
        })
    })
}
