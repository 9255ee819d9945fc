//! A process that lets the wearer go when the program cannot: stopped (`SIGSTOP`, Ctrl-Z, a
//! debugger) or killed.
//!
//! ```text
//!  program: device's thread ──── bytes ────────────────► port or socket of the device
//!                │ every 5 ms: the bytes that set it free      ▲
//!                ▼                                             │ those bytes, again and again
//!  keeper: ──────┴─ silent for 25 ms, or gone ─────────────────┘
//! ```
//!
//! Each device that a protocol knows to set free ([`Protocol::release`]) has a keeper of its own:
//! the same program started anew, with a second handle of the device's port or socket as standard
//! output and a line to the program as standard input. It adds nothing to what the device is sent
//! while the device's thread beats. It stands in a process group of its own, so that what stops the
//! program from a terminal does not stop it.
//!
//! Programs that open devices say once how a keeper is started ([`use_program`]), and call `run`
//! when they are started so.

mod state;

#[cfg(unix)]
mod line;
#[cfg(unix)]
mod process;

#[cfg(unix)]
pub(crate) use line::KeeperProcess;
#[cfg(unix)]
pub use process::run;
pub use state::{AGAIN_NS, BEAT_NS, GONE_NS, KeeperActions, KeeperState, SILENCE_NS};

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The one argument that starts the program as a keeper.
pub const ARGUMENT: &str = "keep-device";

static PROGRAM: OnceLock<PathBuf> = OnceLock::new();

/// From now on devices that are opened have keepers: this program, started with [`ARGUMENT`] alone.
/// Without it there are none.
pub fn use_program(path: PathBuf) {
    // A second call is of the same program.
    let _ = PROGRAM.set(path);
}

/// Program that is started as a keeper.
pub fn program() -> Option<&'static Path> {
    PROGRAM.get().map(PathBuf::as_path)
}

#[cfg(doc)]
use crate::Protocol;
