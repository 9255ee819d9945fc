//! The states that the goals are measured at, as sessions of scenes that come with the program.

use std::path::Path;
use thenar_core::model::SolverKind;
use thenar_scene::session::{Session, builtin};

/// Both solvers, with the names that scenes give them.
pub const SOLVERS: [(SolverKind, &str); 2] =
    [(SolverKind::Monolithic, "monolithic"), (SolverKind::TwoStep, "two-step")];

/// Firmness of a press, which the search for a number of contacts varies. Small meshes have few
/// vertices below the hand and need soft flesh on a high table.
#[derive(Clone, Copy, Debug)]
pub struct Press {
    /// Height of the table above that of the scene [m].
    table: f64,
    /// Young's modulus of the flesh [Pa].
    young: f64,
    /// Stiffness of the bonds between bones and flesh [N/m⁴].
    coupling: f64,
    /// Stiffness of the springs that pull the bones to the tracked pose [N/m].
    drive: f64,
}

const PRESSES: [Press; 5] = [
    Press { table: 0.015, young: 10e3, coupling: 3e8, drive: 800.0 },
    Press { table: 0.010, young: 20e3, coupling: 5e8, drive: 600.0 },
    Press { table: 0.010, young: 30e3, coupling: 1e9, drive: 400.0 },
    Press { table: 0.005, young: 40e3, coupling: 2e9, drive: 400.0 },
    Press { table: 0.0, young: 40e3, coupling: 2e9, drive: 400.0 },
];
/// Time from which the hand of `free-motion` moves its fingers and none touches another [s].
const MOVING: f64 = 0.2;
/// Times from which the hand of `table-press` comes down on the table, and from which it lies there
/// and presses [s].
const LANDS: f64 = 0.9;
const PRESSED: f64 = 1.3;
/// Time from which the hand of `bread-grasp` holds the loaf in the air [s].
const HOLDS: f64 = 3.0;
/// For how long each of these lasts [s].
pub const LASTS: f64 = 0.5;
/// Steps that a session is given to settle at the time step that is measured.
const SETTLE: u32 = 40;

/// Session that a bench asks for.
#[derive(Clone, Copy, Debug)]
pub struct SessionSpec {
    /// Tetrahedra of the hand.
    pub tets: u32,
    /// Time step that is measured [s].
    pub time_step: f64,
    /// Name of the solver.
    pub solver: &'static str,
}

/// Tables of speed go by numbers of tetrahedra of one size, held as in the paper.
const PAPER: &str = "hand.hand.preset=paper";
/// On the way to what is measured steps are of 5 ms.
const STEP: &str = "time_step=0.005";

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
pub fn free(wanted: &SessionSpec) -> Result<Session, String> {
    let mut session = open(
        "free-motion",
        &[
            PAPER.into(),
            STEP.into(),
            format!("hand.hand.tets={}", wanted.tets),
            format!("solver.kind={}", wanted.solver),
        ],
    )?;
    while session.world().time() < MOVING {
        session.step(&mut ());
    }
    settle(&mut session, wanted.time_step);
    Ok(session)
}

/// A hand that lies on a table and is pressed down.
pub fn press(wanted: &SessionSpec, press: &Press) -> Result<Session, String> {
    pressed_until(wanted, press, PRESSED)
}

/// A hand that comes down on a table, so that contacts come and move.
pub fn land(wanted: &SessionSpec, press: &Press) -> Result<Session, String> {
    pressed_until(wanted, press, LANDS)
}

/// The hand that comes with the program, in free air.
pub fn default_free(wanted: &SessionSpec) -> Result<Session, String> {
    default_hand("free-motion", wanted, MOVING)
}

/// The hand that comes with the program, with a loaf of bread in it.
pub fn default_holds(wanted: &SessionSpec) -> Result<Session, String> {
    default_hand("bread-grasp", wanted, HOLDS)
}

fn default_hand(scene: &str, wanted: &SessionSpec, until: f64) -> Result<Session, String> {
    let mut session = open(scene, &[format!("solver.kind={}", wanted.solver)])?;
    while session.world().time() < until {
        session.step(&mut ());
    }
    settle(&mut session, wanted.time_step);
    Ok(session)
}

fn pressed_until(wanted: &SessionSpec, press: &Press, until: f64) -> Result<Session, String> {
    let mut session = open(
        "table-press",
        &[
            PAPER.into(),
            STEP.into(),
            format!("hand.hand.tets={}", wanted.tets),
            format!("hand.hand.bone_drive.stiffness={}", press.drive),
            format!("hand.hand.material={{young={}}}", press.young),
            format!("hand.hand.coupling_stiffness={}", press.coupling),
            format!("rigid.table.position=[0,{},0]", press.table),
            format!("solver.kind={}", wanted.solver),
        ],
    )?;
    while session.world().time() < until {
        session.step(&mut ());
    }
    settle(&mut session, wanted.time_step);
    Ok(session)
}

/// The press at which the number of active contacts is nearest to `contacts`, with the session.
pub fn press_with(wanted: &SessionSpec, contacts: u32) -> Result<(Press, Session), String> {
    let mut best: Option<(u32, Press, Session)> = None;
    for hard in PRESSES {
        let session = press(wanted, &hard)?;
        let off = session.report().contacts_active.abs_diff(contacts);
        if best.as_ref().is_none_or(|(least, ..)| off < *least) {
            best = Some((off, hard, session));
        }
        if best.as_ref().is_some_and(|(least, ..)| *least * 12 <= contacts) {
            break;
        }
    }
    best.map(|(_, hard, session)| (hard, session)).ok_or("no press was tried".into())
}
