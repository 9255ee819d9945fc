//! The loop: events, steps of the recording, snapshots.

use super::PlaybackError;
use super::playback_clock::PlaybackClock;
use super::player::Player;
use crate::hub::{Event, HubEndpoint};
use crate::live::control::Control;
use crate::live::play::mover_flags;
use crate::live::publish::Publisher;
use crate::live::status::{Recorded, Status};
use crate::protocol::{self, Pace};
use crate::rounds::{EVENTS_AT_ONCE, SLEEP_MAX, STATUS_EVERY, Scold, pace};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use thenar_scene::hands::Hands;

/// Time between two reports of the place in the recording while it goes on.
const PLACE_EVERY: Duration = Duration::from_millis(200);
/// On the way to another place events are looked at so often.
const APPROACH: Duration = Duration::from_millis(20);
/// The end stays for so long before the recording begins again.
const HOLD: Duration = Duration::from_millis(1500);
/// Snapshots are at least so far apart.
const SNAPSHOT_EVERY: Duration = Duration::from_micros(8300);

/// All that the thread holds.
pub struct Loop {
    pub(super) endpoint: HubEndpoint,
    pub(super) control: Control,
    pub(super) player: Player,
    file: String,
    pub(super) paused: bool,
    pub(super) speed: f64,
    /// Time \[s\] of a step that was made and is not shown yet.
    made: Option<f64>,
    /// Since when the end has been shown.
    ended: Option<Instant>,
    pub(super) clock: PlaybackClock,
    publisher: Publisher,
    /// Scene whose model clients have.
    scene: u32,
    shown: Instant,
    told: Instant,
    pub(super) changed: bool,
    pub(super) problem: Option<String>,
    /// Notices that poses move nothing.
    pub(super) scold: Scold,
    pub(super) started: Instant,
}

impl Loop {
    /// A loop that waits for somebody to watch.
    ///
    /// # Errors
    /// The scene is too large for a page.
    pub fn new(endpoint: HubEndpoint, player: Player, file: String) -> Result<Self, PlaybackError> {
        let now = Instant::now();
        let mut new = Self {
            endpoint,
            control: Control::default(),
            clock: PlaybackClock::new(player.at(), now),
            player,
            file,
            paused: false,
            speed: 1.0,
            made: None,
            ended: None,
            publisher: Publisher::default(),
            scene: 0,
            shown: now,
            told: now,
            changed: true,
            problem: None,
            scold: Scold::default(),
            started: now,
        };
        new.show_scene()?;
        new.show();
        new.tell_status();
        Ok(new)
    }

    /// Runs until told to stop, or until all clients' ends are gone.
    pub fn run(mut self, stop: &AtomicBool) {
        while !stop.load(Ordering::Relaxed) && self.round() {}
    }

    /// Sleeps until something is due or comes. False when nothing can come any more.
    fn round(&mut self) -> bool {
        let Ok(mut event) = self.endpoint.wait(self.sleep()) else { return false };
        for _ in 0..EVENTS_AT_ONCE {
            let Some(one) = event else { break };
            self.take(one);
            event = self.endpoint.next();
        }
        if let Some(one) = event {
            self.take(one);
        }
        if self.player.is_seeking() {
            if self.player.approach(APPROACH) {
                self.arrive();
            }
        } else if self.is_running() {
            self.go_on();
        }
        let every = if self.changed { STATUS_EVERY } else { PLACE_EVERY };
        if (self.changed || self.is_running()) && self.told.elapsed() >= every {
            self.tell_status();
        }
        true
    }

    fn is_running(&self) -> bool {
        !self.paused && self.control.viewers() > 0
    }

    fn sleep(&self) -> Duration {
        match self.made {
            _ if self.player.is_seeking() => Duration::ZERO,
            Some(at) if self.is_running() => {
                let due = self.clock.due(at, self.speed);
                due.saturating_duration_since(Instant::now()).min(SLEEP_MAX)
            }
            None if self.is_running() && self.ended.is_none() => Duration::ZERO,
            _ if self.changed => STATUS_EVERY.saturating_sub(self.told.elapsed()),
            _ => SLEEP_MAX,
        }
    }

    fn take(&mut self, event: Event) {
        self.changed |= !matches!(event, Event::Binary(..));
        match event {
            Event::Joined(client) => {
                // Whoever comes first sees it go on from where it was left.
                if self.control.viewers() == 0 {
                    self.clock = PlaybackClock::new(self.player.at(), Instant::now());
                }
                self.control.join(client);
            }
            Event::Left(client) => self.control.leave(client),
            Event::Text(client, text) => self.text(client, &text),
            Event::Binary(client, _) => self.pose(client),
        }
    }

    /// Shows what is due, and makes what comes next.
    fn go_on(&mut self) {
        let now = Instant::now();
        if let Some(since) = self.ended {
            if now - since >= HOLD {
                self.seek(0.0);
            }
            return;
        }
        if let Some(at) = self.made.filter(|at| now >= self.clock.due(*at, self.speed)) {
            self.made = None;
            self.clock.shown(at, self.speed, now);
            if now - self.shown >= SNAPSHOT_EVERY {
                self.show();
            }
        }
        if self.made.is_none() {
            self.make();
        }
    }

    /// Makes a step, to be shown when it is due. False at the end.
    pub(super) fn make(&mut self) -> bool {
        self.made = self.player.step();
        if self.made.is_none() {
            (self.ended, self.changed) = (Some(Instant::now()), true);
            self.show();
        }
        if self.scene != self.player.scene()
            && let Err(error) = self.show_scene()
        {
            (self.problem, self.paused) = (Some(error.to_string()), true);
        }
        let problem = self.player.problem();
        if self.problem != problem {
            (self.problem, self.changed) = (problem, true);
        }
        self.made.is_some()
    }

    /// Sets out for another place.
    pub(super) fn seek(&mut self, seconds: f64) {
        (self.made, self.ended, self.changed) = (None, None, true);
        if let Err(error) = self.player.seek(seconds) {
            (self.problem, self.paused) = (Some(error.to_string()), true);
        }
    }

    /// The place that was sought is reached.
    fn arrive(&mut self) {
        if self.scene != self.player.scene()
            && let Err(error) = self.show_scene()
        {
            (self.problem, self.paused) = (Some(error.to_string()), true);
        }
        self.problem = self.player.problem();
        self.changed = true;
        self.clock = PlaybackClock::new(self.player.at(), Instant::now());
        self.show();
    }

    /// Sends the model of the scene that has begun.
    fn show_scene(&mut self) -> Result<(), PlaybackError> {
        let session = self.player.session().ok_or(PlaybackError::Empty)?;
        let model = protocol::model(session, session.name(), 0)?;
        self.scene = self.player.scene();
        self.publisher.model(model, &self.endpoint);
        self.changed = true;
        Ok(())
    }

    /// Sends a snapshot of how things stand. What was made counts as shown.
    pub(super) fn show(&mut self) {
        self.shown = Instant::now();
        if self.paused {
            self.made = None;
        }
        let Some(session) = self.player.session() else { return };
        let h = session.world().time_step();
        let pace = pace(self.paused, self.speed, self.clock.speed(), h, self.player.cost());
        let pace = Pace { flags: pace.flags | mover_flags(session), ..pace };
        self.publisher.snapshot(session, pace, &self.endpoint);
    }

    fn tell_status(&mut self) {
        (self.changed, self.told) = (false, Instant::now());
        let Some(session) = self.player.session() else { return };
        let status = Status {
            control: self.control.holder().map(|client| client.0),
            viewers: self.control.viewers(),
            paused: self.paused,
            speed: self.speed,
            scene: session.name(),
            loading: None,
            hands: Hands::Scene,
            problem: self.problem.as_deref(),
            settings: session.settings(),
            recording: Some(Recorded {
                file: &self.file,
                time: self.player.at(),
                end: self.player.end(),
            }),
        };
        self.endpoint.show_status(status.text());
    }
}
