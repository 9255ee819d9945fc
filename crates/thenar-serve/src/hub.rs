//! Where the simulation thread and the clients meet: the newest model, snapshot and status go out,
//! commands and poses come in. Neither side ever waits for the other.

use bytes::Bytes;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use tokio::sync::watch;

/// Messages from clients that may wait for the simulation; more are refused.
const INBOX: usize = 256;

/// A client, numbered from 1 in order of arrival.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ClientId(pub u32);

/// What a client did.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// It came.
    Joined(ClientId),
    /// It left.
    Left(ClientId),
    /// It sent a text message, not yet looked at.
    Text(ClientId, String),
    /// It sent a binary message, not yet looked at.
    Binary(ClientId, Bytes),
}

/// A remark to one client.
#[derive(Clone, Debug)]
pub struct Note {
    /// Whom it is for.
    pub client: ClientId,
    /// JSON text.
    pub text: String,
    /// It was a refusal: too many of them end the connection.
    pub refusal: bool,
}

/// The clients' end: cheap to clone, safe to share.
#[derive(Clone, Debug)]
pub struct Hub {
    /// The newest model message.
    pub model: watch::Receiver<Bytes>,
    /// The newest snapshot message.
    pub snapshot: watch::Receiver<Bytes>,
    /// The newest status message.
    pub status: watch::Receiver<String>,
    notes: tokio::sync::broadcast::Sender<Note>,
    inbox: SyncSender<Event>,
}

/// The simulation's end.
#[derive(Debug)]
pub struct Desk {
    /// The newest model message.
    pub model: watch::Sender<Bytes>,
    /// The newest snapshot message.
    pub snapshot: watch::Sender<Bytes>,
    /// The newest status message.
    pub status: watch::Sender<String>,
    notes: tokio::sync::broadcast::Sender<Note>,
    inbox: Receiver<Event>,
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

/// Two ends that belong together.
pub fn pair() -> (Hub, Desk) {
    let (model_in, model) = watch::channel(Bytes::new());
    let (snapshot_in, snapshot) = watch::channel(Bytes::new());
    let (status_in, status) = watch::channel(String::new());
    let (notes, _) = tokio::sync::broadcast::channel(256);
    let (sender, inbox) = sync_channel(INBOX);
    let hub = Hub { model, snapshot, status, notes: notes.clone(), inbox: sender };
    (hub, Desk { model: model_in, snapshot: snapshot_in, status: status_in, notes, inbox })
}

impl Hub {
    /// Hands an event to the simulation, without waiting.
    ///
    /// # Errors
    /// Too many wait, or the simulation has ended.
    pub fn submit(&self, event: Event) -> Result<(), Refused> {
        self.inbox.try_send(event).map_err(|error| match error {
            TrySendError::Full(_) => Refused::Busy,
            TrySendError::Disconnected(_) => Refused::Ended,
        })
    }

    /// Remarks to clients from now on; each connection picks its own.
    pub fn notes(&self) -> tokio::sync::broadcast::Receiver<Note> {
        self.notes.subscribe()
    }
}

impl Desk {
    /// The next event, if one waits.
    pub fn next(&self) -> Option<Event> {
        self.inbox.try_recv().ok()
    }

    /// Remarks something to a client.
    pub fn note(&self, note: Note) {
        // Nobody listening is fine: the client has left.
        let _ = self.notes.send(note);
    }
}
