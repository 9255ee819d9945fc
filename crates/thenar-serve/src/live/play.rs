//! A scene that plays: its script over and over.

use crate::protocol::{PoseMessage, Value, flags};
use std::time::Instant;
use thenar::World;
use thenar_scene::session::Session;

/// After its end the script stays for so long before it starts again \[s\].
const HOLD: f64 = 1.5;

/// A session and what moves its hands.
#[derive(Debug)]
pub struct Play {
    session: Session,
    start: World,
}

impl Play {
    /// Begins with the script.
    pub fn new(session: Session) -> Self {
        Self { start: session.world().clone(), session }
    }

    /// The session.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Changes a setting.
    ///
    /// # Errors
    /// There is no such setting.
    pub fn set(&mut self, key: &str, _: &Value) -> Result<(), String> {
        Err(format!("no setting is named `{key}`"))
    }

    /// One step; the script starts again where it is due.
    pub fn step(&mut self, _: Instant) {
        let end = self.session.scene().duration + HOLD;
        if self.session.world().time() >= end {
            self.reset();
        }
        self.session.step(&mut ());
    }

    /// Back to the start.
    pub fn reset(&mut self) {
        *self.session.world_mut() = self.start.clone();
    }

    /// The script moves the hands again, from its start.
    pub fn follow_script(&mut self) {
        self.reset();
    }

    /// Hands cannot be moved yet.
    ///
    /// # Errors
    /// Always.
    pub fn pose(&mut self, _: &PoseMessage) -> Result<(), String> {
        Err("hands cannot be moved yet".into())
    }

    /// Whoever moved the hands does so no more.
    pub fn abandon(&mut self, _: Instant) {}

    /// Flags of a snapshot.
    pub fn flags(&self) -> u16 {
        flags::SCRIPT
    }

    /// Newest pose message that acts, 0 if none.
    pub fn newest_pose(&self) -> u32 {
        0
    }
}
