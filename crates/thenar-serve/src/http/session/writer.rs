//! Messages to a client: the welcome, then always the newest of everything.

use super::{End, Outgoing, ServerNotice};
use crate::http::rates::Refusals;
use crate::http::session_slots::SessionSlot;
use crate::http::site::Site;
use crate::hub::{ClientId, ClientNotice};
use bytes::Bytes;
use futures_util::SinkExt;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{broadcast, mpsc, watch};
use tokio::time::{Instant, sleep_until, timeout};
use tokio_tungstenite::tungstenite::Message;

/// Snapshots on their way at a time. Each is followed by a ping; what lies in buffers along the
/// way is then never more than these, however slowly a client reads.
const UNDERWAY: u32 = 4;

/// The writing half of a session.
pub struct Writer<'a> {
    site: &'a Site,
    slot: &'a SessionSlot,
    id: ClientId,
    outgoing: &'a mut Outgoing,
    notes: broadcast::Receiver<ClientNotice>,
    notices: mpsc::Receiver<ServerNotice>,
    status: watch::Receiver<String>,
    touch: watch::Receiver<String>,
    model: watch::Receiver<Bytes>,
    snapshot: watch::Receiver<Bytes>,
    /// Number of the newest ping that was answered.
    pongs: watch::Receiver<u32>,
    /// Number of the last ping.
    pings: u32,
    pinged: Instant,
    /// The epoch of the model that the client has.
    epoch: Option<u32>,
    refusals: Refusals,
}

impl<'a> Writer<'a> {
    /// Writes for this client.
    pub fn new(
        site: &'a Site,
        slot: &'a SessionSlot,
        id: ClientId,
        outgoing: &'a mut Outgoing,
        notes: broadcast::Receiver<ClientNotice>,
        notices: mpsc::Receiver<ServerNotice>,
        pongs: watch::Receiver<u32>,
    ) -> Self {
        let hub = site.hub.clone();
        let refusals = Refusals::new(site.limits.refusals, site.limits.refusal_window);
        let (status, touch) = (hub.status, hub.touch);
        let (model, snapshot) = (hub.model, hub.snapshot);
        let pinged = Instant::now();
        Self {
            site,
            slot,
            id,
            outgoing,
            notes,
            notices,
            status,
            touch,
            model,
            snapshot,
            pongs,
            pings: 0,
            pinged,
            epoch: None,
            refusals,
        }
    }

    /// Writes until the session ends.
    pub async fn run(mut self) -> End {
        let mut done = self.send(Message::text(self.site.hub.welcome(self.id))).await;
        // What was there before the client came is news to it.
        self.status.mark_changed();
        self.touch.mark_changed();
        self.model.mark_changed();
        self.snapshot.mark_changed();
        loop {
            if let Err(end) = done {
                return end;
            }
            done = self.next().await;
        }
    }

    /// Waits for the most urgent news and sends it.
    async fn next(&mut self) -> Result<(), End> {
        let site = self.site;
        let answered = self.pongs.has_changed().unwrap_or(false);
        let waiting = self.pings.wrapping_sub(*self.pongs.borrow_and_update());
        self.slot.wait(waiting, answered);
        let full = waiting >= UNDERWAY;
        // Other signs of life may come from who reads nothing.
        let patience = self.site.limits.ping * 3;
        let silent =
            self.slot.waits_since().map_or(self.pinged + patience, |since| since + patience);
        tokio::select! {
            biased;
            () = site.stopped() => Err(End::Stopping),
            note = self.notes.recv() => match note {
                Ok(note) if note.client == self.id => self.say(note.text, note.refusal).await,
                Err(RecvError::Closed) => Err(End::Ended),
                Ok(_) | Err(RecvError::Lagged(_)) => Ok(()),
            },
            Some(notice) = self.notices.recv() => self.say(notice.text, notice.refusal).await,
            changed = self.status.changed() => {
                changed.map_err(|_| End::Ended)?;
                let text = self.status.borrow_and_update().clone();
                if text.is_empty() { Ok(()) } else { self.send(Message::text(text)).await }
            }
            changed = self.touch.changed() => {
                changed.map_err(|_| End::Ended)?;
                let text = self.touch.borrow_and_update().clone();
                if text.is_empty() { Ok(()) } else { self.send(Message::text(text)).await }
            }
            changed = self.model.changed() => {
                changed.map_err(|_| End::Ended)?;
                self.send_model().await
            }
            changed = self.snapshot.changed(), if !full => {
                changed.map_err(|_| End::Ended)?;
                self.send_snapshot().await
            }
            _ = self.pongs.changed() => {
                self.pongs.mark_changed();
                Ok(())
            }
            () = sleep_until(silent) => Err(End::Silent),
            () = sleep_until(self.pinged + self.site.limits.ping) => self.ping().await,
        }
    }

    async fn say(&mut self, text: String, refusal: bool) -> Result<(), End> {
        self.send(Message::text(text)).await?;
        match refusal && self.refusals.count(Instant::now()) {
            true => Err(End::Refusals),
            false => Ok(()),
        }
    }

    async fn send_model(&mut self) -> Result<(), End> {
        let model = self.model.borrow_and_update().clone();
        if model.is_empty() {
            return Ok(());
        }
        self.epoch = epoch(&model);
        self.send(Message::Binary(model)).await
    }

    async fn send_snapshot(&mut self) -> Result<(), End> {
        let snapshot = self.snapshot.borrow_and_update().clone();
        // The model is published before the first snapshot of it, so here it is visible at last.
        if self.model.has_changed().map_err(|_| End::Ended)? {
            self.send_model().await?;
        }
        if snapshot.is_empty() || epoch(&snapshot) != self.epoch {
            return Ok(());
        }
        self.feed(Message::Binary(snapshot)).await?;
        self.ping().await
    }

    async fn ping(&mut self) -> Result<(), End> {
        self.pings = self.pings.wrapping_add(1);
        self.pinged = Instant::now();
        self.slot.wait(self.pings.wrapping_sub(*self.pongs.borrow()), false);
        self.send(Message::Ping(Bytes::copy_from_slice(&self.slot.ping(self.pings)))).await
    }

    async fn send(&mut self, message: Message) -> Result<(), End> {
        match timeout(self.site.limits.send, self.outgoing.send(message)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(End::Gone),
            Err(_) => Err(End::Slow),
        }
    }

    /// Like `send`, but leaves with what follows.
    async fn feed(&mut self, message: Message) -> Result<(), End> {
        match timeout(self.site.limits.send, self.outgoing.feed(message)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(End::Gone),
            Err(_) => Err(End::Slow),
        }
    }
}

/// The epoch in the head of a binary message.
fn epoch(message: &[u8]) -> Option<u32> {
    message.get(4..8)?.try_into().ok().map(u32::from_le_bytes)
}
