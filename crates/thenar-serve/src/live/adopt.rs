//! Scenes that come: one that was requested, or the same again after a failure.

use super::builder::BuildRequest;
use super::play::Play;
use super::run::Loop;
use super::source::ReadyScene;
use crate::protocol::text;
use std::any::Any;
use std::time::{Duration, Instant};

/// A simulation that fails so often within [`FAILURES_WITHIN`] is left alone.
const FAILURES_MAX: usize = 3;
const FAILURES_WITHIN: Duration = Duration::from_secs(30);

impl Loop {
    /// Puts a scene on that has been made ready.
    pub(super) fn adopt(&mut self, ready: ReadyScene) {
        let same = ready.spec.scene == self.spec.scene;
        let felt = self.haptics.as_mut().map_or(Ok(()), |haptics| haptics.attach(&ready.session));
        self.free_witness();
        let mut play = Play::new(ready.session);
        if let Some(witness) = self.witness.take() {
            play.set_witness(witness);
        }
        if !same {
            self.set.clear();
        }
        // What the scene with other hands does not take is forgotten.
        self.set.retain(|(key, value)| play.set(key, value).is_ok());
        self.spec = ready.spec;
        self.paused &= same;
        self.problem = felt.err();
        self.changed = true;
        self.publisher.model(ready.model, &self.endpoint);
        self.play = Some(play);
        self.pacer.resume(Instant::now());
        self.show();
    }

    /// Takes the witness from the session that ends.
    fn free_witness(&mut self) {
        if let Some(witness) = self.play.as_mut().and_then(Play::take_witness) {
            self.witness = Some(witness);
        }
    }

    pub(super) fn adopt_what_is_made(&mut self) {
        match self.builder.take() {
            None => {}
            Some((_, Ok(ready))) => self.adopt(*ready),
            Some((BuildRequest { client, .. }, Err(problem))) => {
                self.changed = true;
                if let Some(client) = client {
                    self.endpoint.tell(client, text::error(&problem));
                }
                if self.play.is_none() {
                    self.problem = Some(problem);
                }
            }
        }
    }

    /// After a panic: says so, and makes the scene again, without what clients have set in it.
    pub(super) fn recover(&mut self, panic: &(dyn Any + Send)) {
        let now = Instant::now();
        let cause = panic
            .downcast_ref::<String>()
            .map(String::as_str)
            .or_else(|| panic.downcast_ref::<&str>().copied())
            .unwrap_or("unknown cause");
        self.free_witness();
        self.play = None;
        self.set.clear();
        self.failures.retain(|then| now - *then < FAILURES_WITHIN);
        self.failures.push(now);
        if self.failures.len() < FAILURES_MAX {
            self.problem = Some(format!("the simulation failed and starts again: {cause}"));
            let spec = self.spec.clone();
            self.builder.request(BuildRequest { client: None, spec });
        } else {
            self.problem = Some(format!("the simulation fails again and again: {cause}"));
        }
        self.tell_status();
    }
}
