//! Messages from a client: bounded, and handed to the simulation without waiting for it.

use super::{End, Ingoing, ServerNotice};
use crate::http::rates::Bucket;
use crate::http::session_slots::SessionSlot;
use crate::http::site::Site;
use crate::hub::{ClientId, Event, Refused};
use crate::protocol::TEXT_BYTES_MAX;
use bytes::Bytes;
use futures_util::StreamExt;
use std::time::Duration;
use tokio::sync::{mpsc, watch};
use tokio::time::{Instant, sleep_until};
use tokio_tungstenite::tungstenite::{Error, Message};

/// The longest binary message that is looked at.
const BINARY_BYTES: usize = 1024;

/// Time until a pose is offered again to a busy simulation.
const RETRY: Duration = Duration::from_millis(2);

/// Least time between two reminders to a client that its texts are dropped.
const REMIND: Duration = Duration::from_secs(1);

/// The reading half of a session.
pub struct Reader<'a> {
    site: &'a Site,
    slot: &'a SessionSlot,
    id: ClientId,
    ingoing: &'a mut Ingoing,
    notices: mpsc::Sender<ServerNotice>,
    pongs: watch::Sender<u32>,
    messages: Bucket,
    texts: Bucket,
    poses: Bucket,
    reminded: Option<Instant>,
    /// The newest pose of each hand that could not be handed over yet.
    waiting: [Option<Bytes>; 2],
    /// Time of the next try.
    retry: Instant,
}

impl<'a> Reader<'a> {
    /// Reads for this client; answers to our pings are passed on as their numbers.
    pub fn new(
        site: &'a Site,
        slot: &'a SessionSlot,
        id: ClientId,
        ingoing: &'a mut Ingoing,
        notices: mpsc::Sender<ServerNotice>,
        pongs: watch::Sender<u32>,
    ) -> Self {
        let (limits, now) = (&site.limits, Instant::now());
        Self {
            site,
            slot,
            id,
            ingoing,
            notices,
            pongs,
            messages: Bucket::new(limits.messages, 2.0, now),
            texts: Bucket::new(limits.texts, 1.0, now),
            poses: Bucket::new(limits.poses, 0.1, now),
            reminded: None,
            waiting: [None, None],
            retry: now,
        }
    }

    /// Reads until the session ends. Pings are answered further down.
    pub async fn run(mut self) -> End {
        // Three signs of life asked for and none given.
        let patience = self.site.limits.ping * 3;
        let mut silent = Instant::now() + patience;
        loop {
            let message = tokio::select! {
                message = self.ingoing.next() => message,
                () = sleep_until(self.retry), if self.waiting.iter().any(Option::is_some) => {
                    match self.hand_over() {
                        Ok(()) => continue,
                        Err(end) => return end,
                    }
                }
                () = sleep_until(silent) => return End::Silent,
            };
            let message = match message {
                Some(Ok(message)) => message,
                Some(Err(error)) => return broken(error),
                None => return End::Gone,
            };
            let now = Instant::now();
            silent = now + patience;
            if !self.messages.take(1.0, now) {
                return End::Flood;
            }
            if let Err(end) = self.take(message, now) {
                return end;
            }
        }
    }

    fn take(&mut self, message: Message, now: Instant) -> Result<(), End> {
        match message {
            Message::Text(text) => self.text(text.as_str(), now),
            Message::Binary(bytes) => self.binary(bytes),
            Message::Pong(bytes) => {
                if let Some(number) = self.slot.answered(&bytes) {
                    self.pongs.send_replace(number);
                }
                Ok(())
            }
            Message::Close(_) => Err(End::Gone),
            Message::Ping(_) | Message::Frame(_) => Ok(()),
        }
    }

    fn text(&mut self, text: &str, now: Instant) -> Result<(), End> {
        if text.len() > TEXT_BYTES_MAX {
            self.notice("a text message has at most 4096 bytes", true);
            return Ok(());
        }
        if self.site.hub.heed(self.id, text) {
            return Ok(());
        }
        if !self.texts.take(1.0, now) {
            self.remind(now);
            return Ok(());
        }
        match self.site.hub.submit(Event::Text(self.id, text.to_owned())) {
            Ok(()) => Ok(()),
            Err(Refused::Ended) => Err(End::Ended),
            Err(Refused::Busy) => {
                self.remind(now);
                Ok(())
            }
        }
    }

    /// Tells the client, not too often, that texts of it were dropped.
    fn remind(&mut self, now: Instant) {
        if self.reminded.is_none_or(|last| now - last >= REMIND) {
            self.reminded = Some(now);
            self.notice("text messages come too fast: some were dropped", false);
        }
    }

    fn binary(&mut self, bytes: Bytes) -> Result<(), End> {
        if bytes.len() > BINARY_BYTES {
            self.notice("a binary message has at most 1024 bytes", true);
            return Ok(());
        }
        // Byte 2 says which hand; what is no pose waits in either place, to be refused later.
        let hand = usize::from(bytes.get(2).is_some_and(|hand| *hand != 0));
        self.waiting[hand] = Some(bytes);
        self.hand_over()
    }

    /// Hands waiting poses over as far as their rate and the simulation allow. A newer one takes
    /// the place of one that waits, so what arrives is always the newest.
    fn hand_over(&mut self) -> Result<(), End> {
        let now = Instant::now();
        for place in &mut self.waiting {
            let Some(bytes) = place else { continue };
            if !self.poses.take(1.0, now) {
                self.retry = self.poses.ready();
                return Ok(());
            }
            match self.site.hub.submit(Event::Binary(self.id, bytes.clone())) {
                Ok(()) => *place = None,
                Err(Refused::Ended) => return Err(End::Ended),
                Err(Refused::Busy) => {
                    self.retry = now + RETRY;
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    fn notice(&self, message: &str, refusal: bool) {
        // A client that does not listen misses remarks; that is its own loss.
        let _ = self.notices.try_send(ServerNotice::error(message, refusal));
    }
}

fn broken(error: Error) -> End {
    match error {
        Error::ConnectionClosed | Error::AlreadyClosed | Error::Io(_) => End::Gone,
        error => End::Broken(error),
    }
}
