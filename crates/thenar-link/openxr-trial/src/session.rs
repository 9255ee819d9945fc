//! State of the runtime: one instance, its session, and the events that wait to be reported.

use crate::script::{Script, log};
use openxr_sys::{Result as XrResult, SessionState};
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Event that `xrPollEvent` gives.
#[derive(Clone, Copy, Debug)]
pub enum RuntimeEvent {
    /// The session's new state.
    State(SessionState),
    /// The instance goes away.
    InstanceLoss,
}

/// The instance.
#[derive(Debug, Default)]
pub struct Instance {
    pub handle: u64,
    pub extensions: Vec<String>,
    pub session: Option<Session>,
    pub told: VecDeque<RuntimeEvent>,
    /// The instance's loss was told.
    pub lost: bool,
}

/// A session of the runtime, and what has become of it.
#[derive(Debug)]
pub struct Session {
    pub handle: u64,
    pub state: SessionState,
    pub running: bool,
    /// Handles of spaces, and how far above the floor each one's origin is \[m\].
    pub spaces: Vec<(u64, f32)>,
    /// Handles of trackers, their hands, and how often each was asked.
    pub trackers: Vec<(u64, usize, u64)>,
}

/// Everything that the runtime has handed out.
#[derive(Debug, Default)]
pub struct RuntimeHandles {
    last_handle: u64,
    pub instance: Option<Instance>,
}

impl RuntimeHandles {
    /// A handle that was never given before.
    pub fn handle(&mut self) -> u64 {
        self.last_handle += 1;
        self.last_handle
    }

    /// The instance of this handle.
    pub fn instance(&mut self, handle: u64) -> Result<&mut Instance, XrResult> {
        let found = self.instance.as_mut().filter(|instance| instance.handle == handle);
        found.ok_or(XrResult::ERROR_HANDLE_INVALID)
    }

    /// The session of this handle.
    pub fn session(&mut self, handle: u64) -> Result<&mut Session, XrResult> {
        let found = self.any_session().filter(|session| session.handle == handle);
        found.ok_or(XrResult::ERROR_HANDLE_INVALID)
    }

    /// The session, if there is one.
    pub fn any_session(&mut self) -> Option<&mut Session> {
        self.instance.as_mut()?.session.as_mut()
    }
}

/// The one of this process.
pub fn known() -> MutexGuard<'static, RuntimeHandles> {
    static KNOWN: Mutex<RuntimeHandles> =
        Mutex::new(RuntimeHandles { last_handle: 0, instance: None });
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Instance {
    /// The session is in this state from now on, and that is to be told.
    pub fn enter(&mut self, states: &[SessionState]) {
        for state in states {
            if let Some(session) = &mut self.session {
                session.state = *state;
            }
            self.told.push_back(RuntimeEvent::State(*state));
        }
    }

    /// Follows the script, one transition at a time as the specification allows them.
    pub fn follow(&mut self, script: &Script) {
        if script.session == "lose_instance" && !std::mem::replace(&mut self.lost, true) {
            self.told.push_back(RuntimeEvent::InstanceLoss);
        }
        let Some(session) = &self.session else { return };
        let wish = script.session.as_str();
        use SessionState as S;
        match session.state {
            S::LOSS_PENDING | S::EXITING | S::STOPPING => {}
            _ if wish == "lose" => self.enter(&[S::LOSS_PENDING]),
            S::FOCUSED if wish != "run" => {
                self.enter(&[S::VISIBLE, S::SYNCHRONIZED, S::STOPPING]);
            }
            S::IDLE if wish == "exit" => self.enter(&[S::EXITING]),
            S::IDLE if wish == "run" => self.enter(&[S::READY]),
            _ => {}
        }
    }
}

/// Writes down what was done against the specification.
pub fn violation(what: &str) -> XrResult {
    log(&format!("violation: {what}"));
    XrResult::ERROR_VALIDATION_FAILURE
}
