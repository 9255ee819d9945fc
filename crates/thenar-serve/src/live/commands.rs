//! Commands from clients, and what comes of them.

use super::builder::BuildRequest;
use super::run::Loop;
use super::source::{LiveError, SceneSpec};
use crate::hub::ClientId;
use crate::protocol::{Command, PoseMessage, text};
use std::time::Instant;

/// Why nothing can be armed or stopped.
const NO_DEVICES: &str = "no device is open; `thenar serve --device` opens one";

impl Loop {
    /// A text message.
    pub(super) fn text(&mut self, client: ClientId, message: &str) {
        if !self.control.knows(client) {
            return;
        }
        match Command::read(message) {
            Err(reason) => self.endpoint.refuse(client, &reason),
            Ok(Command::Ping { t }) => {
                self.endpoint.tell(client, text::pong(t, self.started.elapsed().as_secs_f64()));
            }
            // It has acted already, where it came in; but an `arm` from before it may have waited
            // until now.
            Ok(Command::Stop {}) => match &self.devices {
                Some(devices) => devices.stop(),
                None => self.endpoint.refuse(client, NO_DEVICES),
            },
            // Heeded where it came in.
            Ok(Command::Hold {}) => {}
            Ok(Command::Control { take }) => self.pass_control(client, take),
            Ok(command) if self.may(client) => {
                if let Err(reason) = self.act(client, command) {
                    self.endpoint.refuse(client, &reason);
                }
            }
            Ok(_) => {}
        }
    }

    /// A binary message.
    pub(super) fn binary(&mut self, client: ClientId, message: &[u8]) {
        if !self.control.knows(client) || !self.may(client) {
            return;
        }
        let message = match PoseMessage::read(message) {
            Ok(message) => message,
            Err(reason) => return self.endpoint.refuse(client, &reason.to_string()),
        };
        // Each hand by itself: where messages wait, one hand's may overtake the other's.
        let last = &mut self.pose_numbers[message.side as usize];
        if message.number <= *last {
            let reason = format!("pose message {} after {last}: numbers rise", message.number);
            return self.endpoint.refuse(client, &reason);
        }
        *last = message.number;
        if let Some(haptics) = &mut self.haptics {
            haptics.pose(&message);
            return;
        }
        let Some(play) = &mut self.play else { return };
        if let Err(reason) = play.pose(&message) {
            // A headset tracks both hands whatever the scene has: that is no offence.
            if self.scold.is_due(Instant::now()) {
                self.endpoint.tell(client, text::error(&reason));
            }
        }
    }

    /// True for who holds control. Others are refused, but for what they sent before they knew
    /// that they had lost it.
    fn may(&self, client: ClientId) -> bool {
        self.control.may(client, Instant::now()).unwrap_or_else(|reason| {
            self.endpoint.refuse(client, &reason);
            false
        })
    }

    fn pass_control(&mut self, client: ClientId, take: bool) {
        let (before, now) = (self.control.holder(), Instant::now());
        if take {
            self.control.take(client, now);
        } else {
            self.control.give_up(client, now);
        }
        if self.control.holder() == before {
            return;
        }
        self.hands_off();
        if let Some(before) = before.filter(|before| *before != client) {
            self.endpoint
                .tell(before, text::error(&format!("viewer {} has taken control", client.0)));
        }
    }

    fn act(&mut self, client: ClientId, command: Command) -> Result<(), String> {
        if !matches!(command, Command::Set { .. }) {
            self.apply_settings();
        }
        match command {
            Command::Run { paused } => {
                self.paused = paused;
                self.pacer.resume(Instant::now());
                self.show();
            }
            Command::Step {} if self.paused => self.step(),
            Command::Step {} => {
                self.endpoint.tell(client, text::error("pause first, then go step by step"));
            }
            Command::Reset {} => {
                if let Some(play) = &mut self.play {
                    play.reset();
                }
                self.show();
            }
            Command::Seek { .. } => {
                self.endpoint.tell(client, text::error("only a recording has places to go to"));
            }
            Command::Speed { value } => {
                self.speed = value;
                self.pacer.resume(Instant::now());
            }
            Command::Script {} => {
                if let Some(play) = &mut self.play {
                    play.follow_script();
                }
                self.show();
            }
            Command::Grip { kind, object, force, side } => {
                let Some(play) = &mut self.play else { return Ok(()) };
                // Nothing under the hand is no offence.
                if let Err(reason) = play.grip(side, object.as_deref(), kind, force) {
                    self.endpoint.tell(client, text::error(&reason));
                }
            }
            Command::Release { side } => {
                if let Some(play) = &mut self.play {
                    play.release(side);
                }
            }
            Command::Scene { name } => {
                if !self.builder.catalogue().has(&name) {
                    return Err(LiveError::Unknown(name).to_string());
                }
                self.request(client, |spec| spec.scene = name);
            }
            Command::Hands { which, lengths } => {
                self.request(client, |spec| (spec.hands, spec.lengths) = (which, lengths));
            }
            Command::Set { key, value } => {
                // A slider sends many values, and each costs as much as a step: the last counts.
                self.to_set.retain(|(_, known, _)| *known != key);
                self.to_set.push((client, key, value));
            }
            Command::Arm { keep } => match &self.devices {
                Some(devices) => devices.arm(client, keep, Instant::now()),
                None => return Err(NO_DEVICES.into()),
            },
            Command::Control { .. }
            | Command::Ping { .. }
            | Command::Stop {}
            | Command::Hold {} => {}
        }
        Ok(())
    }

    /// Sets what is to be set.
    pub(super) fn apply_settings(&mut self) {
        for (client, key, value) in std::mem::take(&mut self.to_set) {
            let Some(play) = &mut self.play else { return };
            match play.set(&key, &value) {
                Err(reason) => self.endpoint.refuse(client, &reason),
                Ok(()) => {
                    self.set.retain(|(known, _)| *known != key);
                    self.set.push((key, value));
                }
            }
        }
    }

    /// Has a scene made ready that differs in something from what plays or is being made.
    fn request(&mut self, client: ClientId, change: impl FnOnce(&mut SceneSpec)) {
        let mut spec = self.builder.requested().unwrap_or(&self.spec).clone();
        change(&mut spec);
        self.builder.request(BuildRequest { client: Some(client), spec });
    }
}
