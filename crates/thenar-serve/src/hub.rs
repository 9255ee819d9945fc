//! Meeting place of the simulation thread and the clients: the newest model, snapshot and status go
//! out, commands and poses come in. Neither side ever waits for the other.

use crate::dead_man::DeadMan;
use crate::protocol::{Command, text};
use bytes::Bytes;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};
use tokio::sync::{broadcast, watch};

/// Messages of one client that may wait for the simulation; more are refused. A client that floods
/// fills its own share and nobody else's.
const WAITING_MAX: u32 = 64;
/// Shares. Two clients have the same one only when their numbers are a multiple of this apart.
const SHARES: usize = 1024;

/// A client, numbered from 1 in order of arrival.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ClientId(pub u32);

/// Action of a client.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A client came.
    Joined(ClientId),
    /// A client left.
    Left(ClientId),
    /// A client sent a text message, not yet looked at.
    Text(ClientId, String),
    /// A client sent a binary message, not yet looked at.
    Binary(ClientId, Bytes),
}

impl Event {
    /// The sender, when the event counts against that client's share. Coming and leaving does not:
    /// it must never get lost.
    fn sender(&self) -> Option<ClientId> {
        match self {
            Self::Joined(_) | Self::Left(_) => None,
            Self::Text(client, _) | Self::Binary(client, _) => Some(*client),
        }
    }
}

/// A notice to one client.
#[derive(Clone, Debug)]
pub struct ClientNotice {
    /// Whom it is for.
    pub client: ClientId,
    /// JSON text.
    pub text: String,
    /// True for a refusal: too many of them end the connection.
    pub refusal: bool,
}

/// A scene that a client may ask for.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct SceneName {
    /// Name to ask by.
    pub name: String,
    /// Title that people see.
    pub title: String,
}

/// Number of each client's messages that wait.
#[derive(Debug)]
struct PendingCounts([AtomicU32; SHARES]);

impl PendingCounts {
    fn of(&self, client: ClientId) -> &AtomicU32 {
        &self.0[client.0 as usize % SHARES]
    }

    /// Takes a place, if there is one.
    fn take(&self, client: ClientId) -> bool {
        let share = self.of(client);
        let had = share.fetch_add(1, Ordering::Relaxed);
        if had >= WAITING_MAX {
            share.fetch_sub(1, Ordering::Relaxed);
        }
        had < WAITING_MAX
    }

    fn give_back(&self, client: ClientId) {
        self.of(client).fetch_sub(1, Ordering::Relaxed);
    }
}

/// The clients' end: cheap to clone, safe to share.
#[derive(Clone, Debug)]
pub struct Hub {
    /// The newest model message; empty before the first.
    pub model: watch::Receiver<Bytes>,
    /// The newest snapshot message; empty before the first.
    pub snapshot: watch::Receiver<Bytes>,
    /// The newest status message; empty before the first.
    pub status: watch::Receiver<String>,
    /// Newest status of the devices; empty where there are none.
    pub touch: watch::Receiver<String>,
    devices: Option<DeadMan>,
    notes: broadcast::Sender<ClientNotice>,
    inbox: Sender<Event>,
    pending_counts: Arc<PendingCounts>,
    scenes: Arc<[SceneName]>,
}

/// The simulation's end.
#[derive(Debug)]
pub struct HubEndpoint {
    /// The newest model message.
    pub model: watch::Sender<Bytes>,
    /// The newest snapshot message.
    pub snapshot: watch::Sender<Bytes>,
    /// The newest status message.
    pub status: watch::Sender<String>,
    /// Newest status of the devices.
    pub touch: watch::Sender<String>,
    notes: broadcast::Sender<ClientNotice>,
    inbox: Receiver<Event>,
    pending_counts: Arc<PendingCounts>,
}

/// Why an event was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// Too many wait already.
    #[error("the simulation is busy; the message was dropped")]
    Busy,
    /// The simulation has ended.
    #[error("the simulation has ended")]
    Ended,
}

/// Two ends that belong together, without scenes to choose from.
pub fn pair() -> (Hub, HubEndpoint) {
    pair_with(Vec::new())
}

/// Two ends that belong together; clients may choose between `scenes`.
pub fn pair_with(scenes: Vec<SceneName>) -> (Hub, HubEndpoint) {
    let (model_in, model) = watch::channel(Bytes::new());
    let (snapshot_in, snapshot) = watch::channel(Bytes::new());
    let (status_in, status) = watch::channel(String::new());
    let (touch_in, touch) = watch::channel(String::new());
    let (notes, _) = broadcast::channel(256);
    let (sender, inbox) = channel();
    let pending_counts = Arc::new(PendingCounts(std::array::from_fn(|_| AtomicU32::new(0))));
    let hub = Hub {
        model,
        snapshot,
        status,
        touch,
        devices: None,
        notes: notes.clone(),
        inbox: sender,
        pending_counts: pending_counts.clone(),
        scenes: scenes.into(),
    };
    let (model, snapshot, status) = (model_in, snapshot_in, status_in);
    (hub, HubEndpoint { model, snapshot, status, touch: touch_in, notes, inbox, pending_counts })
}

impl Hub {
    /// This hub with devices, whose forces end with a client's `stop`, or when it leaves.
    pub(crate) fn with_devices(self, devices: Option<DeadMan>) -> Self {
        Self { devices, ..self }
    }

    /// Does what this message of a client says if it is about ending forces: at once, past
    /// everything that waits for the simulation. True when nobody else needs to hear of it.
    pub fn heed(&self, client: ClientId, text: &str) -> bool {
        let urgent = text.contains("stop") || text.contains("hold");
        let Some(devices) = self.devices.as_ref().filter(|_| urgent) else { return false };
        match Command::read(text) {
            Ok(Command::Stop {}) => devices.stop(),
            Ok(Command::Hold {}) => {
                devices.hold(client, Instant::now());
                return true;
            }
            _ => {}
        }
        false
    }

    /// Hands an event to the simulation, without waiting. Joining and leaving is always taken.
    ///
    /// # Errors
    /// Too many messages of this client wait, or the simulation has ended.
    pub fn submit(&self, event: Event) -> Result<(), Refused> {
        if let (Event::Left(client), Some(devices)) = (&event, &self.devices) {
            devices.leave(*client);
        }
        let sender = event.sender();
        if sender.is_some_and(|client| !self.pending_counts.take(client)) {
            return Err(Refused::Busy);
        }
        self.inbox.send(event).map_err(|_| Refused::Ended)
    }

    /// Remarks to clients from now on; each connection picks its own.
    pub fn notes(&self) -> broadcast::Receiver<ClientNotice> {
        self.notes.subscribe()
    }

    /// The first message to a client.
    pub fn welcome(&self, client: ClientId) -> String {
        text::welcome(client, &self.scenes)
    }
}

impl HubEndpoint {
    /// The next event, if one waits.
    pub fn next(&self) -> Option<Event> {
        self.inbox.try_recv().ok().inspect(|event| self.took(event))
    }

    /// The next event, waiting for it at most this long.
    ///
    /// # Errors
    /// All clients' ends are gone: nothing will ever come.
    pub fn wait(&self, longest: Duration) -> Result<Option<Event>, Refused> {
        match self.inbox.recv_timeout(longest) {
            Ok(event) => {
                self.took(&event);
                Ok(Some(event))
            }
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(Refused::Ended),
        }
    }

    fn took(&self, event: &Event) {
        if let Some(client) = event.sender() {
            self.pending_counts.give_back(client);
        }
    }

    /// Shows a status, if it is another than the last.
    pub fn show_status(&self, text: String) {
        self.status.send_if_modified(|last| {
            let changed = *last != text;
            if changed {
                *last = text;
            }
            changed
        });
    }

    /// Remarks something to a client.
    pub fn tell(&self, client: ClientId, text: String) {
        self.note(ClientNotice { client, text, refusal: false });
    }

    /// Refuses what a client sent.
    pub fn refuse(&self, client: ClientId, reason: &str) {
        self.note(ClientNotice { client, text: text::error(reason), refusal: true });
    }

    /// Hands a notice to the client that it is for.
    pub fn note(&self, note: ClientNotice) {
        // Nobody listening is fine: the client has left.
        let _ = self.notes.send(note);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_fills_its_own_share_only_and_joining_is_never_refused() {
        let (hub, endpoint) = pair();
        let (loud, calm) = (ClientId(1), ClientId(2));
        let text = |client| Event::Text(client, "{}".into());
        let taken = (0..10_000).filter(|_| hub.submit(text(loud)).is_ok()).count();
        assert_eq!(taken, 64);
        assert_eq!(hub.submit(text(loud)), Err(Refused::Busy));
        assert_eq!(hub.submit(text(calm)), Ok(()));
        assert_eq!(hub.submit(Event::Left(loud)), Ok(()));
        // Order is kept, and places come back as messages are taken.
        for _ in 0..64 {
            assert_eq!(endpoint.next(), Some(text(loud)));
        }
        assert_eq!(endpoint.next(), Some(text(calm)));
        assert_eq!(endpoint.next(), Some(Event::Left(loud)));
        assert_eq!(endpoint.next(), None);
        assert_eq!(hub.submit(text(loud)), Ok(()));
    }

    #[test]
    fn each_end_learns_that_the_other_has_gone() {
        let (hub, endpoint) = pair();
        drop(endpoint);
        assert_eq!(hub.submit(Event::Joined(ClientId(1))), Err(Refused::Ended));
        let (hub, endpoint) = pair();
        drop(hub);
        assert_eq!(endpoint.wait(Duration::from_secs(9)), Err(Refused::Ended));
    }
}
