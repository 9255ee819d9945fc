//! A client without a socket: it speaks to the hub directly.

#![allow(dead_code)] // each test file uses its part

use crate::decoder::{Model, Snapshot};
use serde_json::Value;
use std::time::{Duration, Instant};
use thenar_core::{Pose, Vec3};
use thenar_serve::hub::{ClientId, ClientNotice, Event, Hub, Refused};
use thenar_serve::live::{Live, Options, SceneSource};

/// Nothing that is waited for takes longer, however busy the machine.
const PATIENCE: Duration = Duration::from_secs(180);

pub fn start(scene: &str, overrides: &[&str]) -> (Live, Hub) {
    let options = Options {
        overrides: overrides.iter().map(|s| (*s).into()).collect(),
        ..Options::default()
    };
    Live::start(&SceneSource::Builtin(scene.into()), options).unwrap()
}

pub struct Visitor {
    pub hub: Hub,
    pub id: ClientId,
    notes: tokio::sync::broadcast::Receiver<ClientNotice>,
    number: u32,
}

impl Visitor {
    pub fn join(hub: &Hub, id: u32) -> Self {
        let (hub, id) = (hub.clone(), ClientId(id));
        let notes = hub.notes();
        hub.submit(Event::Joined(id)).unwrap();
        Self { hub, id, notes, number: 0 }
    }

    pub fn leave(self) {
        self.hub.submit(Event::Left(self.id)).unwrap();
    }

    pub fn say(&self, text: &str) {
        self.hub.submit(Event::Text(self.id, text.into())).unwrap();
    }

    pub fn send(&self, bytes: Vec<u8>) -> Result<(), Refused> {
        self.hub.submit(Event::Binary(self.id, bytes.into()))
    }

    /// The next remark to this visitor, waiting for it.
    pub fn note(&mut self) -> (Value, bool) {
        let since = Instant::now();
        loop {
            match self.notes.try_recv() {
                Ok(note) if note.client == self.id => {
                    return (serde_json::from_str(&note.text).unwrap(), note.refusal);
                }
                Ok(_) => {}
                Err(_) => self.nap(since, "a remark"),
            }
        }
    }

    pub fn status(&self) -> Value {
        serde_json::from_str(&self.hub.status.borrow()).unwrap()
    }

    pub fn snapshot(&self) -> Snapshot {
        Snapshot::read(&self.hub.snapshot.borrow())
    }

    pub fn model(&self) -> Model {
        Model::read(&self.hub.model.borrow())
    }

    /// Waits for a status.
    pub fn until_status(&self, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let since = Instant::now();
        loop {
            let text = self.hub.status.borrow().clone();
            match serde_json::from_str(&text) {
                Ok(status) if wanted(&status) => return status,
                _ => self.nap(since, what),
            }
        }
    }

    /// Waits for a snapshot.
    pub fn until(&self, what: &str, wanted: impl Fn(&Snapshot) -> bool) -> Snapshot {
        let since = Instant::now();
        loop {
            let snapshot = self.snapshot();
            if wanted(&snapshot) {
                return snapshot;
            }
            self.nap(since, what);
        }
    }

    fn nap(&self, since: Instant, what: &str) {
        assert!(
            since.elapsed() < PATIENCE,
            "waited in vain for {what}: {}",
            *self.hub.status.borrow()
        );
        std::thread::sleep(Duration::from_millis(2));
    }

    /// A pose message with angles; `hand` 0 is left, 1 right.
    pub fn angles(&mut self, hand: u8, wrist: &Pose, angles: [f64; 20], clock: f64) -> Vec<u8> {
        self.number += 1;
        let mut bytes = vec![17, 3, hand, 0];
        bytes.extend(self.number.to_le_bytes());
        bytes.extend(clock.to_le_bytes());
        let (p, q) = (wrist.position, wrist.rotation.coords);
        let numbers = [p.x, p.y, p.z, q.x, q.y, q.z, q.w];
        for x in numbers.into_iter().chain(angles) {
            bytes.extend((x as f32).to_le_bytes());
        }
        bytes
    }

    /// Number of the last pose message made.
    pub fn number(&self) -> u32 {
        self.number
    }
}

/// A pose as it travels.
pub fn pose([x, y, z, a, b, c, d]: [f64; 7]) -> Pose {
    let turn = thenar_core::Quat::new_normalize(nalgebra::Quaternion::new(d, a, b, c));
    Pose::new(Vec3::new(x, y, z), turn)
}

/// A list of numbers in JSON.
pub fn seven(value: &Value) -> [f64; 7] {
    std::array::from_fn(|k| value[k].as_f64().unwrap())
}
