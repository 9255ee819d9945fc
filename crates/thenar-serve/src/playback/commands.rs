//! Commands that clients may give to a recording.

use super::playback_clock::PlaybackClock;
use super::run::Loop;
use crate::hub::ClientId;
use crate::protocol::{Command, text};
use std::time::Instant;

/// Why nothing else acts.
const RECORDED: &str = "this is a recording: its scene, hands and settings are as they were; pause, speed and place can be \
     chosen";

impl Loop {
    /// A text message.
    pub(super) fn text(&mut self, client: ClientId, message: &str) {
        if !self.control.knows(client) {
            return;
        }
        let now = Instant::now();
        match Command::read(message) {
            Err(reason) => self.endpoint.refuse(client, &reason),
            Ok(Command::Ping { t }) => {
                self.endpoint.tell(client, text::pong(t, self.started.elapsed().as_secs_f64()));
            }
            Ok(Command::Control { take: true }) => {
                let before = self.control.holder().filter(|before| *before != client);
                self.control.take(client, now);
                if let Some(before) = before {
                    let reason = format!("viewer {} has taken control", client.0);
                    self.endpoint.tell(before, text::error(&reason));
                }
            }
            Ok(Command::Control { take: false }) => self.control.give_up(client, now),
            // No devices are open: nothing is held, and all is stopped.
            Ok(Command::Hold {} | Command::Stop {}) => {}
            Ok(command) => match self.control.may(client, now) {
                Ok(true) => self.act(client, command),
                Ok(false) => {}
                Err(reason) => self.endpoint.refuse(client, &reason),
            },
        }
    }

    /// A pose, of whatever kind.
    pub(super) fn pose(&mut self, client: ClientId) {
        if self.scold.is_due(Instant::now()) {
            self.endpoint.tell(client, text::error(RECORDED));
        }
    }

    fn act(&mut self, client: ClientId, command: Command) {
        match command {
            Command::Run { paused } => {
                self.paused = paused;
                self.clock = PlaybackClock::new(self.player.at(), Instant::now());
                self.show();
            }
            Command::Step {} if self.paused => {
                if self.make() {
                    self.show();
                }
            }
            Command::Step {} => {
                self.endpoint.tell(client, text::error("pause first, then go step by step"));
            }
            Command::Reset {} => self.seek(0.0),
            Command::Seek { time } => self.seek(time),
            Command::Speed { value } => {
                self.speed = value;
                self.clock = PlaybackClock::new(self.player.at(), Instant::now());
            }
            // The page says so whenever somebody lets go of the hand.
            Command::Script {} => {}
            // Not worth being sent away for.
            _ => self.endpoint.tell(client, text::error(RECORDED)),
        }
    }
}
