//! The loop: events, steps, snapshots.

use super::StepCallback;
use super::builder::Builder;
use super::control::Control;
use super::haptics::Haptics;
use super::pacer::Pacer;
use super::play::Play;
use super::publish::Publisher;
use super::source::{ReadyScene, SceneSpec};
use super::status::Status;
use crate::dead_man::DeadMan;
use crate::hub::{ClientId, Event, HubEndpoint};
use crate::protocol::{Pace, text};
use crate::rounds::{EVENTS_AT_ONCE, SLEEP_MAX, STATUS_EVERY, Scold, pace};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use thenar_scene::session::Witness;
use thenar_scene::tuning::SettingValue;

/// Nobody watching, the simulation rests after so long.
const REST_AFTER: Duration = Duration::from_secs(5);

/// Everything that the simulation's thread holds.
pub struct Loop {
    pub(super) endpoint: HubEndpoint,
    pub(super) builder: Builder,
    pub(super) control: Control,
    /// `None` after a failure, until the scene has been made again.
    pub(super) play: Option<Play>,
    /// Recipe that plays, or played last.
    pub(super) spec: SceneSpec,
    pub(super) paused: bool,
    pub(super) speed: f64,
    /// Settings that clients have made in the scene, to be made again when its hands change.
    pub(super) set: Vec<(String, SettingValue)>,
    /// Settings to be made before the next step, and for whom.
    pub(super) to_set: Vec<(ClientId, String, SettingValue)>,
    /// Something of the status may have changed.
    pub(super) changed: bool,
    /// Time of the last status message.
    told: Instant,
    /// Number of the last pose message of whoever holds control, of the left and right hand.
    pub(super) pose_numbers: [u32; 2],
    /// Notices that there is no such hand.
    pub(super) scold: Scold,
    pub(super) pacer: Pacer,
    pub(super) publisher: Publisher,
    cost: Duration,
    watcher: Option<StepCallback>,
    pub(super) haptics: Option<Haptics>,
    /// Arms and stops what feels.
    pub(super) devices: Option<DeadMan>,
    /// While no session has it.
    pub(super) witness: Option<Box<dyn Witness>>,
    pub(super) started: Instant,
    resting: bool,
    empty_since: Option<Instant>,
    pub(super) problem: Option<String>,
    pub(super) failures: Vec<Instant>,
}

impl Loop {
    /// A loop that rests at the start of a scene.
    pub fn new(
        endpoint: HubEndpoint,
        builder: Builder,
        first: ReadyScene,
        watcher: Option<StepCallback>,
        haptics: Option<Haptics>,
        devices: Option<DeadMan>,
        witness: Option<Box<dyn Witness>>,
    ) -> Self {
        let now = Instant::now();
        let mut new = Self {
            endpoint,
            builder,
            control: Control::default(),
            play: None,
            spec: first.spec.clone(),
            paused: false,
            speed: 1.0,
            set: Vec::new(),
            to_set: Vec::new(),
            changed: true,
            told: now,
            pose_numbers: [0; 2],
            scold: Scold::default(),
            pacer: Pacer::new(now),
            publisher: Publisher::default(),
            cost: Duration::ZERO,
            watcher,
            haptics,
            devices,
            witness,
            started: now,
            resting: true,
            empty_since: None,
            problem: None,
            failures: Vec::new(),
        };
        new.adopt(first);
        new.tell_status();
        new
    }

    /// Runs until told to stop, or until all clients' ends are gone.
    pub fn run(mut self, stop: &AtomicBool) {
        while !stop.load(Ordering::Relaxed) {
            match catch_unwind(AssertUnwindSafe(|| self.round())) {
                Ok(true) => {}
                Ok(false) => return,
                Err(panic) => self.recover(panic.as_ref()),
            }
        }
    }

    /// Sleeps until a step is due or something comes. False when nothing can come any more.
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
        self.apply_settings();
        self.adopt_what_is_made();
        self.rest_or_wake();
        if self.is_running() && Instant::now() >= self.pacer.due() {
            self.step();
        }
        if self.changed && self.told.elapsed() >= STATUS_EVERY {
            self.tell_status();
        }
        true
    }

    fn is_running(&self) -> bool {
        !self.paused && !self.resting && self.play.is_some()
    }

    fn sleep(&self) -> Duration {
        let due = self.pacer.due().saturating_duration_since(Instant::now());
        let longest =
            if self.changed { STATUS_EVERY.saturating_sub(self.told.elapsed()) } else { SLEEP_MAX };
        if self.is_running() { due.min(longest) } else { longest }
    }

    fn take(&mut self, event: Event) {
        self.changed |= !matches!(event, Event::Binary(..));
        match event {
            Event::Joined(client) => self.control.join(client),
            Event::Left(client) => {
                // An `arm` of it may have waited until now.
                if let Some(devices) = &self.devices {
                    devices.leave(client);
                }
                let held = self.control.holder() == Some(client);
                self.control.leave(client);
                if held {
                    self.hands_off();
                }
            }
            Event::Text(client, text) => self.text(client, &text),
            Event::Binary(client, bytes) => self.binary(client, &bytes),
        }
    }

    /// Control has passed on: whoever moved the hands does so no more.
    pub(super) fn hands_off(&mut self) {
        self.pose_numbers = [0; 2];
        if let Some(haptics) = &mut self.haptics {
            haptics.lose();
        }
        if let Some(play) = &mut self.play {
            play.abandon(Instant::now());
        }
    }

    /// One step, and a snapshot of it.
    pub(super) fn step(&mut self) {
        let Some(play) = &mut self.play else { return };
        let begun = Instant::now();
        if let Err(problem) = play.step(begun, self.haptics.as_mut())
            && self.problem.as_ref() != Some(&problem)
        {
            (self.problem, self.changed) = (Some(problem), true);
        }
        self.cost = begun.elapsed();
        if let (Some(news), Some(holder)) = (play.grip_news(), self.control.holder()) {
            self.endpoint.tell(holder, text::error(&news));
        }
        let Some(play) = &mut self.play else { return };
        if let Some(watcher) = &mut self.watcher {
            watcher(play.session());
        }
        let h = play.session().world().time_step();
        let period = Duration::from_secs_f64(h / self.speed);
        self.pacer.stepped(h, period, begun);
        if self.publisher.is_due(period) || self.paused {
            self.show();
        }
    }

    /// Sends a snapshot of how things stand.
    pub(super) fn show(&mut self) {
        let Some(play) = &self.play else { return };
        let h = play.session().world().time_step();
        let pace = pace(self.paused, self.speed, self.pacer.speed(), h, self.cost);
        let pace = Pace { flags: pace.flags | play.flags(), pose: play.newest_pose(), ..pace };
        self.publisher.snapshot(play.session(), pace, &self.endpoint);
    }

    /// Rests when nobody has watched for a while; wakes at the scene's start.
    fn rest_or_wake(&mut self) {
        let now = Instant::now();
        // Whoever wears a glove may look elsewhere.
        if self.control.viewers() > 0 || self.haptics.is_some() {
            self.empty_since = None;
            if std::mem::take(&mut self.resting) {
                self.pacer.resume(now);
            }
            return;
        }
        let since = *self.empty_since.get_or_insert(now);
        if !self.resting && now - since >= REST_AFTER {
            self.resting = true;
            (self.paused, self.speed, self.changed) = (false, 1.0, true);
            if let Some(play) = &mut self.play {
                play.follow_script();
            }
            self.show();
        }
    }

    pub(super) fn tell_status(&mut self) {
        (self.changed, self.told) = (false, Instant::now());
        let status = Status {
            control: self.control.holder().map(|client| client.0),
            viewers: self.control.viewers(),
            paused: self.paused,
            speed: self.speed,
            scene: &self.spec.scene,
            loading: self.builder.requested().map(|spec| &spec.scene[..]),
            hands: self.spec.hands,
            problem: self.problem.as_deref(),
            settings: self.play.as_ref().map_or(Vec::new(), |play| play.session().settings()),
            recording: None,
        };
        self.endpoint.show_status(status.text());
    }
}
