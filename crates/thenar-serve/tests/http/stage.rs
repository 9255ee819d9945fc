//! A server with a stand-in for the simulation, and clients for it.

use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;
use thenar_serve::http::{Options, Port, Reach, RequestLimits, Server};
use thenar_serve::hub::{ClientId, ClientNotice, Event, HubEndpoint, pair};
use tokio_tungstenite::tungstenite::client::{IntoClientRequest, client_with_config};
use tokio_tungstenite::tungstenite::protocol::WebSocketConfig;
use tokio_tungstenite::tungstenite::{Error, Message, WebSocket};

/// The status that stands there from the beginning.
pub const STATUS: &str = r#"{"type":"status"}"#;

/// Longer than anything here takes; reached only when a promise is broken.
pub const FOREVER: Duration = Duration::from_secs(60);

/// A server and what stands behind it.
pub struct Stage {
    pub server: Option<Server>,
    /// `127.0.0.1:PORT`
    pub host: String,
    pub shared: Arc<Shared>,
    endpoint: Option<JoinHandle<()>>,
}

/// What the stand-in and the test both see.
#[derive(Default)]
pub struct Shared {
    pub events: Mutex<Vec<Event>>,
    /// Number of the newest snapshot.
    pub number: AtomicU32,
    /// The present model.
    pub epoch: AtomicU32,
    /// Ends the stand-in.
    pub end: AtomicBool,
}

impl Stage {
    pub fn endpoint() -> Self {
        Self::new(Reach::Loopback, RequestLimits::default(), 1000)
    }

    pub fn with(limits: RequestLimits) -> Self {
        Self::new(Reach::Loopback, limits, 1000)
    }

    /// With a model of this many bytes.
    pub fn new(reach: Reach, limits: RequestLimits, model: usize) -> Self {
        let (hub, endpoint) = pair();
        let address = Some(IpAddr::from(Ipv4Addr::LOCALHOST));
        let options = Options { reach, address, port: Port::Exactly(0), limits };
        let shared = Arc::new(Shared::default());
        shared.epoch.store(1, Ordering::Relaxed);
        let told = shared.clone();
        endpoint.status.send_replace(STATUS.into());
        endpoint.model.send_replace(message(1, 1, 0, model).into());
        let endpoint = std::thread::spawn(move || play(&endpoint, &told, model));
        let server = Server::start(&options, hub).unwrap();
        let host = server.address().to_string();
        Self { server: Some(server), host, shared, endpoint: Some(endpoint) }
    }

    /// A connection without anything said.
    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(FOREVER)).unwrap();
        stream.set_nodelay(true).unwrap();
        stream
    }

    /// Sends bytes and reads all that comes until the server closes.
    pub fn exchange(&self, bytes: &[u8]) -> String {
        let mut stream = self.connect();
        // The server may close before it has read all.
        let _ = stream.write_all(bytes);
        rest(&mut stream)
    }

    /// The reply to `GET path` with further header lines.
    pub fn get(&self, path: &str, headers: &str) -> String {
        let host = &self.host;
        self.exchange(
            format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{headers}\r\n")
                .as_bytes(),
        )
    }

    /// A session.
    pub fn join(&self) -> Client {
        self.try_join().unwrap()
    }

    /// A session, or the status with which it was refused.
    pub fn try_join(&self) -> Result<Client, u16> {
        let request = format!("ws://{}/live", self.host).into_client_request().unwrap();
        let config = WebSocketConfig::default().max_message_size(None).max_frame_size(None);
        match client_with_config(request, self.connect(), Some(config)) {
            Ok((socket, _)) => Ok(Client(socket)),
            Err(tokio_tungstenite::tungstenite::HandshakeError::Failure(Error::Http(reply))) => {
                Err(reply.status().as_u16())
            }
            Err(error) => panic!("{error}"),
        }
    }

    /// A session opened by hand, for bytes that no library would send.
    pub fn join_raw(&self) -> TcpStream {
        let mut stream = self.connect();
        write!(stream, "{}", upgrade(&self.host, "")).unwrap();
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).unwrap();
            head.push(byte[0]);
        }
        assert!(head.starts_with(b"HTTP/1.1 101"), "{}", String::from_utf8_lossy(&head));
        stream
    }

    /// Waits until something is so.
    pub fn wait(&self, what: &str, mut so: impl FnMut(&Shared) -> bool) {
        let start = std::time::Instant::now();
        while !so(&self.shared) {
            assert!(start.elapsed() < FOREVER, "{what}");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Waits until so many clients have left.
    pub fn wait_left(&self, count: usize) {
        self.wait("clients leave", |shared| {
            let events = shared.events.lock().unwrap();
            events.iter().filter(|e| matches!(e, Event::Left(_))).count() >= count
        });
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.server.take();
        self.shared.end.store(true, Ordering::Relaxed);
        if let Some(endpoint) = self.endpoint.take() {
            let _ = endpoint.join();
        }
    }
}

/// The head of an upgrade, with further header lines.
pub fn upgrade(host: &str, headers: &str) -> String {
    format!(
        "GET /live HTTP/1.1\r\nHost: {host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n{headers}\r\n"
    )
}

/// All that comes until the other side closes, in order or not.
pub fn rest(stream: &mut impl Read) -> String {
    let mut bytes = Vec::new();
    match stream.read_to_end(&mut bytes) {
        Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => panic!("it stays open"),
        _ => String::from_utf8_lossy(&bytes).into_owned(),
    }
}

/// A message of this kind, epoch and number.
fn message(kind: u8, epoch: u32, number: u32, length: usize) -> Vec<u8> {
    let mut bytes = vec![0; length];
    (bytes[0], bytes[1]) = (kind, 3);
    bytes[4..8].copy_from_slice(&epoch.to_le_bytes());
    bytes[8..12].copy_from_slice(&number.to_le_bytes());
    bytes
}

/// The stand-in: publishes a snapshot every millisecond or so, and answers texts: what begins with
/// `no` is refused, everything else said back.
fn play(endpoint: &HubEndpoint, shared: &Shared, model: usize) {
    let mut epoch = 1;
    while !shared.end.load(Ordering::Relaxed) {
        while let Some(event) = endpoint.next() {
            if let Event::Text(client, text) = &event {
                let refusal = text.starts_with("no");
                endpoint.note(ClientNotice {
                    client: *client,
                    text: format!("heard {text}"),
                    refusal,
                });
            }
            shared.events.lock().unwrap().push(event);
        }
        let wanted = shared.epoch.load(Ordering::Relaxed);
        if wanted != epoch {
            epoch = wanted;
            endpoint.model.send_replace(message(1, epoch, 0, model).into());
        }
        let number = shared.number.fetch_add(1, Ordering::Relaxed) + 1;
        endpoint.snapshot.send_replace(message(2, epoch, number, 10_000).into());
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A client's end of a session.
pub struct Client(pub WebSocket<TcpStream>);

/// What a client got.
#[derive(Debug, PartialEq)]
pub enum Got {
    Text(String),
    Model { epoch: u32 },
    Snapshot { epoch: u32, number: u32 },
    Closed { code: u16, reason: String },
}

impl Client {
    /// The next thing that comes; pings are answered on the way.
    pub fn next(&mut self) -> Got {
        loop {
            let u32_at =
                |b: &[u8], at: usize| u32::from_le_bytes(b[at..at + 4].try_into().unwrap());
            match self.0.read() {
                Ok(Message::Text(text)) => return Got::Text(text.to_string()),
                Ok(Message::Binary(b)) if b[0] == 1 => return Got::Model { epoch: u32_at(&b, 4) },
                Ok(Message::Binary(b)) => {
                    return Got::Snapshot { epoch: u32_at(&b, 4), number: u32_at(&b, 8) };
                }
                Ok(Message::Close(frame)) => {
                    let frame = frame.expect("a close frame has a code");
                    let (code, reason) = (frame.code.into(), frame.reason.to_string());
                    return Got::Closed { code, reason };
                }
                Ok(_) => {}
                Err(error) => panic!("{error}"),
            }
        }
    }

    /// The next thing that is no snapshot.
    pub fn news(&mut self) -> Got {
        loop {
            match self.next() {
                Got::Snapshot { .. } => {}
                got => return got,
            }
        }
    }

    /// The code with which the server closes.
    pub fn closed(&mut self) -> u16 {
        loop {
            if let Got::Closed { code, .. } = self.next() {
                return code;
            }
        }
    }

    /// The number of the next snapshot.
    pub fn snapshot(&mut self) -> u32 {
        loop {
            match self.next() {
                Got::Snapshot { number, .. } => return number,
                Got::Closed { code, reason } => panic!("closed: {code} {reason}"),
                _ => {}
            }
        }
    }

    /// Takes so many snapshots, each newer than the one before.
    pub fn watch(&mut self, count: u32) {
        let mut last = self.snapshot();
        for _ in 1..count {
            let number = self.snapshot();
            assert!(number > last, "{number} after {last}");
            last = number;
        }
    }

    pub fn text(&mut self, text: &str) {
        self.0.send(Message::text(text)).unwrap();
    }

    /// Sends what the server may not wait for.
    pub fn pour(&mut self, message: Message) -> Result<(), Error> {
        self.0.send(message)
    }
}

/// The events of one client.
pub fn events_of(shared: &Shared, client: ClientId) -> Vec<Event> {
    let of = |e: &&Event| match e {
        Event::Joined(c) | Event::Left(c) | Event::Text(c, _) | Event::Binary(c, _) => *c == client,
    };
    shared.events.lock().unwrap().iter().filter(of).cloned().collect()
}
