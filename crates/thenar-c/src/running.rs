//! A session behind a lock.

use crate::boundary::{Refusal, Status};
use std::ffi::CString;
use std::sync::{Mutex, TryLockError};
use thenar_core::readout::ContactReadout;
use thenar_scene::session::{Session, Source};

/// A running scene. Its inside is nobody's but its functions'.
#[derive(Debug)]
pub struct World {
    running: Mutex<Running>,
    /// Names of the rigid bodies, of the deformable ones, and of the hands.
    pub names: [Vec<CString>; 3],
}

/// A session, and what was read of it.
#[derive(Debug)]
pub struct Running {
    /// The session.
    pub session: Session,
    /// Hash of the state it started in, and of the scene's text and overrides.
    pub start: u64,
    /// Contact per vertex and part, as of the last [`Running::contact`].
    readout: ContactReadout,
}

/// The world has failed for good.
pub fn broken() -> Refusal {
    let words = "a step of this world has failed for good: make another from its scene".into();
    Refusal { status: Status::Broken, words }
}

impl World {
    /// A session that was just opened from this source.
    pub fn new(session: Session, source: &Source) -> Self {
        let desc = session.world().desc();
        // A scene's text has no NUL, as TOML forbids it.
        let name = |name: &String| CString::new(name.as_str()).unwrap_or_default();
        let names = [
            desc.rigids.iter().map(|rigid| name(&rigid.name)).collect(),
            desc.softs.iter().map(|soft| name(&soft.name)).collect(),
            session.hands().iter().map(|hand| name(&hand.name)).collect(),
        ];
        let readout = ContactReadout::new(session.world());
        let start = source.identity(session.world().state_hash());
        Self { running: Mutex::new(Running { session, start, readout }), names }
    }

    /// Does something with the session.
    ///
    /// # Errors
    /// Another thread has it, a step of it has panicked, or what is done refuses.
    pub fn with<T>(
        &self,
        act: impl FnOnce(&mut Running) -> Result<T, Refusal>,
    ) -> Result<T, Refusal> {
        match self.running.try_lock() {
            Ok(mut running) => act(&mut running),
            Err(TryLockError::WouldBlock) => {
                let words = "another thread steps this world at present".into();
                Err(Refusal { status: Status::Busy, words })
            }
            Err(TryLockError::Poisoned(_)) => Err(broken()),
        }
    }
}

impl Running {
    /// Contact of the last step, per vertex and part.
    pub fn contact(&mut self) -> &ContactReadout {
        self.readout.read(self.session.world());
        &self.readout
    }

    /// The index of a thing of which there are `count`.
    ///
    /// # Errors
    /// There are fewer.
    pub fn index(kind: &str, index: usize, count: usize) -> Result<u32, Refusal> {
        let refused =
            || Refusal::argument(format!("there is no {kind} {index}: there are {count}"));
        if index < count { u32::try_from(index).map_err(|_| refused()) } else { Err(refused()) }
    }

    /// The index of a hand.
    ///
    /// # Errors
    /// There is no such hand.
    pub fn hand(&self, hand: usize) -> Result<usize, Refusal> {
        Self::index("hand", hand, self.session.hands().len()).map(|index| index as usize)
    }
}
