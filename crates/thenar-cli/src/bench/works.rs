//! The states that the goals are measured at, as sessions of scenes that come with the program.

use std::path::Path;
use thenar::model::SolverKind;
use thenar_scene::session::{Session, builtin};

/// Both solvers, with the names that scenes give them.
pub const SOLVERS: [(SolverKind, &str); 2] =
    [(SolverKind::Exact, "exact"), (SolverKind::TwoStep, "two-step")];

/// Stiffness of the springs that pull the hand's bones to the tracked pose [N/m]: what the search
/// for a number of contacts varies.
const GRIPS: [f64; 6] = [400.0, 200.0, 800.0, 100.0, 1600.0, 50.0];
/// When the hand of `free-motion` moves its fingers and none touches another [s].
const MOVING: f64 = 0.2;
/// When the hand of `table-press` has come to lie on the table and presses [s].
const PRESSED: f64 = 1.3;
/// For how long each of these lasts [s].
pub const LASTS: f64 = 0.5;
/// Steps that a session is given to settle at the time step that is measured.
const SETTLE: u32 = 40;

/// What a session is asked to be.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Tetrahedra of the hand.
    pub tets: u32,
    /// Time step that is measured [s].
    pub time_step: f64,
    /// Which solver.
    pub solver: &'static str,
}

fn open(scene: &str, overrides: &[String]) -> Result<Session, String> {
    let found = builtin(scene).ok_or(format!("no scene is named `{scene}`"))?;
    Session::from_text(found.text, Path::new(scene), overrides).map_err(|e| e.to_string())
}

fn settle(session: &mut Session, time_step: f64) {
    session.world_mut().set_time_step(time_step);
    for _ in 0..SETTLE {
        session.step(&mut ());
    }
}

/// A hand that closes in free air.
pub fn free(wanted: &Wanted) -> Result<Session, String> {
    let mut session = open(
        "free-motion",
        &[format!("hand.hand.tets={}", wanted.tets), format!("solver.kind={}", wanted.solver)],
    )?;
    while session.world().time() < MOVING {
        session.step(&mut ());
    }
    settle(&mut session, wanted.time_step);
    Ok(session)
}

/// A hand that lies on a table and is pressed down by springs that stiff.
pub fn press(wanted: &Wanted, grip: f64) -> Result<Session, String> {
    let mut session = open(
        "table-press",
        &[
            format!("hand.hand.tets={}", wanted.tets),
            format!("hand.hand.bone_drive.stiffness={grip}"),
            format!("solver.kind={}", wanted.solver),
        ],
    )?;
    while session.world().time() < PRESSED {
        session.step(&mut ());
    }
    settle(&mut session, wanted.time_step);
    Ok(session)
}

/// The springs at which the number of active contacts is nearest to `contacts`, with the session.
pub fn press_with(wanted: &Wanted, contacts: u32) -> Result<(f64, Session), String> {
    let mut best: Option<(u32, f64, Session)> = None;
    for grip in GRIPS {
        let session = press(wanted, grip)?;
        let off = session.report().contacts_active.abs_diff(contacts);
        if best.as_ref().is_none_or(|(least, ..)| off < *least) {
            best = Some((off, grip, session));
        }
        if best.as_ref().is_some_and(|(least, ..)| *least * 12 <= contacts) {
            break;
        }
    }
    best.map(|(_, grip, session)| (grip, session)).ok_or("no grip was tried".into())
}
