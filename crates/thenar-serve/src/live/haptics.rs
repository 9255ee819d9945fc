//! Devices beside the page: the haptic loop's simulation side, and poses from the page as one of
//! its trackers.

use crate::dead_man::DeadMan;
use crate::protocol::{PoseBody, PoseMessage, text};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use thenar_core::model::Side;
use thenar_link::haptic_loop::{PagePoses, Remote, SimulationPort};
use thenar_link::now_ns;
use thenar_scene::live::LivePose;
use thenar_scene::session::Session;
use tokio::sync::watch;

/// Between two reports to the page.
const TELL_EVERY: Duration = Duration::from_millis(250);

/// Parts that let a live simulation be felt.
pub struct Haptics {
    /// The simulation's side of the loop.
    pub port: SimulationPort,
    /// Arms, stops and tells.
    pub remote: Remote,
    /// Takes poses from the page.
    pub poses: PagePoses,
}

impl std::fmt::Debug for Haptics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Haptics").finish_non_exhaustive()
    }
}

impl Haptics {
    /// Puts the hands of another session into the loop.
    ///
    /// # Errors
    /// They cannot be felt; the text says why.
    pub fn attach(&mut self, session: &Session) -> Result<(), String> {
        self.port.attach(session).map_err(|error| error.to_string())
    }

    /// One step of the session, led by the loop.
    ///
    /// # Errors
    /// As [`Haptics::attach`]. The step was made all the same.
    pub fn step(&mut self, session: &mut Session) -> Result<(), String> {
        let led = self.port.before_step(session, now_ns());
        session.step(&mut ());
        self.port.after_step(session, now_ns());
        led.map_err(|error| error.to_string())
    }

    /// Takes a pose of the page.
    pub fn pose(&mut self, message: &PoseMessage) {
        let pose = match &message.body {
            PoseBody::Lost => None,
            PoseBody::Joints { poses, radii } => {
                Some(LivePose::Joints { joints: **poses, radii: **radii })
            }
            PoseBody::Angles { wrist, angles } => {
                Some(LivePose::Angles { wrist: *wrist, angles: **angles })
            }
        };
        self.poses.put(message.side, pose);
    }

    /// The page moves no hand any more.
    pub fn lose(&mut self) {
        [Side::Left, Side::Right].into_iter().for_each(|side| self.poses.put(side, None));
    }
}

/// Reports to the page, and looks whether who armed still answers, until told to end; whatever
/// the simulation does.
pub fn report(devices: &DeadMan, to: &watch::Sender<String>, stop: &Arc<AtomicBool>) {
    while !stop.load(Ordering::Relaxed) {
        devices.look(Instant::now());
        to.send_replace(text::touch(&devices.status(), devices.armed_by()));
        std::thread::sleep(TELL_EVERY);
    }
}
