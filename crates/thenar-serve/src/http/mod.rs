//! The server: sockets on one side, the [`Hub`] on the other.
//!
//! One thread of its own serves everybody, so that clients together never take more than one core
//! from the simulation. Guaranteed: no client makes the simulation or another client wait; what a
//! client may cost is bounded by [`RequestLimits`]; pages of other origins and, with
//! [`Reach::Lan`], everyone without the pairing token get a refusal and nothing else. Not
//! guaranteed: that a visitor with the token is well-meaning, or that a flood of packets leaves the
//! network usable.

mod certificate;
mod connection;
mod connection_limiter;
mod guard;
mod listen;
mod metered;
mod options;
mod qr;
mod rates;
mod reply;
mod session;
mod session_slots;
mod site;
mod token;

pub use options::{Options, Port, Reach, RequestLimits};

use crate::hub::Hub;
use crate::page;
use certificate::Certificate;
use session_slots::SessionSlots;
use site::{Access, Site};
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::AtomicU32;
use std::thread::JoinHandle;
use std::time::Duration;
use token::{Token, WrongTokens};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::watch;

/// Time that sessions get to say goodbye.
const GOODBYE: Duration = Duration::from_secs(2);

/// Why there is no server.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// Another program has the port.
    #[error("port {0} is in use by another program; choose another with --port")]
    PortTaken(u16),
    /// The port cannot be listened on for another reason.
    #[error("cannot listen on port {port}: {source}")]
    Listen {
        /// The port that was asked for.
        port: u16,
        /// Cause that the system reports.
        source: std::io::Error,
    },
    /// A certificate for HTTPS could not be made.
    #[error("cannot make a certificate: {0}")]
    Certificate(Box<dyn std::error::Error + Send + Sync>),
    /// The system refuses a thread, an event queue or random numbers.
    #[error("cannot start the server: {0}")]
    System(#[from] std::io::Error),
}

/// A running server; it ends when dropped.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    urls: Vec<String>,
    fingerprint: Option<String>,
    stop: watch::Sender<bool>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Starts to serve.
    ///
    /// # Errors
    /// The port is taken or may not be used, or the system lacks something.
    pub fn start(options: &Options, hub: Hub) -> Result<Self, StartError> {
        let listener = listen::bind(options).map_err(|source| cannot_listen(options, source))?;
        let address = listener.local_addr()?;
        let names = listen::names();
        let (access, certificate) = access(options, address, &names)?;
        let urls = urls(&access, address, &names);
        let fingerprint = certificate.as_ref().map(|c| c.fingerprint.clone());
        let (stop, stopping) = watch::channel(false);
        let site = Arc::new(Site {
            hub,
            assets: page::assets(),
            access,
            limits: options.limits.clone(),
            session_slots: SessionSlots::new(options.limits.clients),
            clients: AtomicU32::new(0),
            stopping,
        });
        let runtime = Builder::new_current_thread().enable_all().build()?;
        let thread = std::thread::Builder::new()
            .name("thenar-serve".into())
            .spawn(move || serve(&runtime, listener, certificate, site))?;
        Ok(Self { address, urls, fingerprint, stop, thread: Some(thread) })
    }

    /// Address on which the server listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Addresses of the page, the likeliest to work first; with [`Reach::Lan`] they carry the
    /// pairing token.
    pub fn urls(&self) -> &[String] {
        &self.urls
    }

    /// SHA-256 of the certificate, with [`Reach::Lan`].
    pub fn fingerprint(&self) -> Option<&str> {
        self.fingerprint.as_deref()
    }

    /// The first address as a QR code for a terminal.
    pub fn qr_code(&self) -> Option<String> {
        qr::code(self.urls.first()?)
    }

    /// Says goodbye to everyone, frees the port and waits until that is done.
    pub fn stop(mut self) {
        self.end();
    }

    fn end(&mut self) {
        let _ = self.stop.send(true);
        if let Some(thread) = self.thread.take() {
            // A panic over there has been printed there.
            let _ = thread.join();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.end();
    }
}

fn cannot_listen(options: &Options, source: std::io::Error) -> StartError {
    let (Port::Exactly(port) | Port::From(port)) = options.port;
    match source.kind() {
        std::io::ErrorKind::AddrInUse => StartError::PortTaken(port),
        _ => StartError::Listen { port, source },
    }
}

fn access(
    options: &Options,
    address: SocketAddr,
    names: &[String],
) -> Result<(Access, Option<Certificate>), StartError> {
    if options.reach == Reach::Loopback {
        return Ok((Access::Loopback, None));
    }
    let mut known: Vec<String> = ["localhost", "127.0.0.1", "::1"].map(String::from).into();
    known.extend(names.iter().cloned());
    let certificate = certificate::make(known).map_err(StartError::Certificate)?;
    let cookie = format!("thenar_{}", address.port());
    let access = Access::Lan { token: Token::new()?, cookie, wrong_tokens: WrongTokens::default() };
    Ok((access, Some(certificate)))
}

/// Addresses of the page.
fn urls(access: &Access, address: SocketAddr, names: &[String]) -> Vec<String> {
    let port = address.port();
    let Access::Lan { token, .. } = access else { return vec![format!("http://{address}/")] };
    let own = [address.ip().to_string()];
    let names = if address.ip().is_unspecified() { names } else { &own };
    let names = if names.is_empty() { &["localhost".to_owned()] } else { names };
    let bracketed =
        |name: &String| if name.contains(':') { format!("[{name}]") } else { name.clone() };
    names
        .iter()
        .map(|name| format!("https://{}:{port}/?token={}", bracketed(name), token.text()))
        .collect()
}

/// The server's thread.
fn serve(
    runtime: &Runtime,
    listener: TcpListener,
    certificate: Option<Certificate>,
    site: Arc<Site>,
) {
    runtime.block_on(async {
        // Cannot fail: the listener is a fresh one that does not block.
        let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
        connection::accept(listener, certificate.map(|c| c.acceptor), site.clone()).await;
        // Each session gives its place back when it has ended.
        let _ = tokio::time::timeout(GOODBYE, site.session_slots.empty(site.limits.clients)).await;
    });
}
