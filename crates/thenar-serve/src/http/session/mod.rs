//! A session: one client's WebSocket, from the upgrade to the goodbye.
//!
//! Reading and writing go on side by side in one task; whichever ends first ends the session.

mod reader;
mod writer;

use super::guard::Refusal;
use super::reply::{self, Reply};
use super::session_slots::SessionSlot;
use super::site::Site;
use crate::hub::{ClientId, Event};
use crate::protocol::text;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use hyper::http::request::Parts;
use hyper::upgrade::{OnUpgrade, Upgraded};
use hyper::{Method, Request, StatusCode};
use hyper_util::rt::TokioIo;
use reader::Reader;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::sync::{mpsc, watch};
use tokio::time::timeout;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::handshake::server::create_response_with_body;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::protocol::{CloseFrame, Role, WebSocketConfig};
use tokio_tungstenite::tungstenite::{Error, Message};
use writer::Writer;

/// Beyond this a message is not even read; within it a message that is too long gets a notice.
const MESSAGE_BYTES: usize = 16 * 1024;

/// Time that closing may take, on either side.
const CLOSING: Duration = Duration::from_secs(1);

type Socket = WebSocketStream<TokioIo<Upgraded>>;
type Outgoing = SplitSink<Socket, Message>;
type Ingoing = SplitStream<Socket>;

/// A notice that the server itself sends to its client.
#[derive(Debug)]
struct ServerNotice {
    text: String,
    refusal: bool,
}

impl ServerNotice {
    fn error(message: &str, refusal: bool) -> Self {
        Self { text: text::error(message), refusal }
    }
}

/// Why a session ends.
#[derive(Debug)]
enum End {
    /// The client went, in order or not.
    Gone,
    /// The client broke the rules of WebSocket, or exceeded a bound.
    Broken(Error),
    /// The client was refused too often.
    Refusals,
    /// The client sent more messages than anyone needs.
    Flood,
    /// The client gave no sign of life.
    Silent,
    /// A client that read nothing: another has its place.
    Displaced,
    /// The client took too long to take a message.
    Slow,
    /// The simulation has ended.
    Ended,
    /// The server ends.
    Stopping,
}

/// Turns a request into a session, or says why not.
pub fn open(site: &Arc<Site>, request: &Parts, upgrade: OnUpgrade) -> Reply {
    let mut bare = Request::new(());
    *bare.method_mut() = request.method.clone();
    *bare.version_mut() = request.version;
    *bare.headers_mut() = request.headers.clone();
    let accepted = create_response_with_body(&bare, Default::default);
    let Ok(reply) = accepted.and_then(|reply| match request.method == Method::GET {
        true => Ok(reply),
        false => Err(Error::ConnectionClosed),
    }) else {
        return reply::refuse(&Refusal(
            StatusCode::UPGRADE_REQUIRED,
            "This is the address of the live WebSocket; see docs/protocol.md.",
        ));
    };
    let Some(slot) = site.session_slots.acquire() else {
        return reply::refuse(&Refusal(
            StatusCode::SERVICE_UNAVAILABLE,
            "As many clients as this server takes are here already; try again later.",
        ));
    };
    let site = site.clone();
    tokio::spawn(async move {
        if let Ok(stream) = upgrade.await {
            run(&site, &slot, TokioIo::new(stream)).await;
        }
        drop(slot);
    });
    reply
}

async fn run(site: &Site, slot: &SessionSlot, stream: TokioIo<Upgraded>) {
    let config = WebSocketConfig::default()
        .max_message_size(Some(MESSAGE_BYTES))
        .max_frame_size(Some(MESSAGE_BYTES))
        .read_buffer_size(MESSAGE_BYTES);
    let socket = WebSocketStream::from_raw_socket(stream, Role::Server, Some(config)).await;
    let (mut outgoing, mut ingoing) = socket.split();
    let id = ClientId(site.clients.fetch_add(1, Ordering::Relaxed) + 1);
    // Before joining: no notice must be missed.
    let notes = site.hub.notes();
    let end = match site.hub.submit(Event::Joined(id)) {
        Err(_) => End::Ended,
        Ok(()) => {
            let (notices_in, notices) = mpsc::channel(16);
            let (pongs_in, pongs) = watch::channel(0);
            let reader = Reader::new(site, slot, id, &mut ingoing, notices_in, pongs_in);
            let writer = Writer::new(site, slot, id, &mut outgoing, notes, notices, pongs);
            let end = tokio::select! {
                end = reader.run() => end,
                end = writer.run() => end,
                () = slot.taken.notified() => End::Displaced,
            };
            // Where the simulation has ended, nobody needs to know.
            let _ = site.hub.submit(Event::Left(id));
            end
        }
    };
    goodbye(&end, outgoing, ingoing).await;
}

/// Says why, and gives the client a moment to hear it: a socket closed before all is read takes
/// the last words back.
async fn goodbye(end: &End, mut outgoing: Outgoing, ingoing: Ingoing) {
    if matches!(end, End::Slow | End::Displaced) {
        return;
    }
    let frame = CloseFrame { code: end.code(), reason: end.to_string().into() };
    let closing = async {
        // Fails where the client has said goodbye first; the rest is the same.
        let _ = outgoing.send(Message::Close(Some(frame))).await;
        let Ok(mut socket) = outgoing.reunite(ingoing) else { return };
        let stream = socket.get_mut();
        let mut rest = [0; 1024];
        if stream.shutdown().await.is_ok() {
            while stream.read(&mut rest).await.is_ok_and(|count| count > 0) {}
        }
    };
    let _ = timeout(CLOSING, closing).await;
}

impl End {
    fn code(&self) -> CloseCode {
        match self {
            Self::Gone => CloseCode::Normal,
            Self::Broken(Error::Capacity(_)) => CloseCode::Size,
            Self::Broken(Error::Utf8(_)) => CloseCode::Invalid,
            Self::Broken(_) => CloseCode::Protocol,
            Self::Refusals | Self::Flood | Self::Silent | Self::Displaced | Self::Slow => {
                CloseCode::Policy
            }
            Self::Ended => CloseCode::Error,
            Self::Stopping => CloseCode::Away,
        }
    }
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Gone => f.write_str(""),
            // A close frame holds 123 bytes at most; none of these texts comes near.
            Self::Broken(Error::Capacity(_)) => f.write_str("the message is too long"),
            Self::Broken(Error::Utf8(_)) => f.write_str("the text is not UTF-8"),
            Self::Broken(_) => f.write_str("this is not WebSocket"),
            Self::Refusals => f.write_str("too many messages were refused"),
            Self::Flood => f.write_str("too many messages"),
            Self::Silent => f.write_str("no sign of life"),
            Self::Displaced => f.write_str("another has the place"),
            Self::Slow => f.write_str("too slow"),
            Self::Ended => f.write_str("the simulation has ended"),
            Self::Stopping => f.write_str("the server ends"),
        }
    }
}
