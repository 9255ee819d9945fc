//! Connections: taken in, counted, encrypted where asked, and handed to the site.

use super::connection_limiter::{ConnectionLimiter, ConnectionPermit};
use super::metered::Metered;
use super::site::Site;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use std::io::Result;
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::timeout;
use tokio_rustls::TlsAcceptor;

/// The most a request's head may hold.
const HEAD_BYTES: usize = 16 * 1024;

/// The first byte of a TLS connection: a handshake record.
const TLS_HANDSHAKE: u8 = 0x16;

/// Answer to plain HTTP where TLS is spoken.
const SPEAK_TLS: &[u8] = b"HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain\r\n\
    Connection: close\r\n\r\nThis server speaks HTTPS only: the address begins with https://\n";

/// Takes connections until the site stops.
pub async fn accept(listener: TcpListener, tls: Option<TlsAcceptor>, site: Arc<Site>) {
    let connection_limiter = Arc::new(ConnectionLimiter::default());
    loop {
        let accepted = tokio::select! {
            () = site.stopped() => return,
            accepted = listener.accept() => accepted,
        };
        let Ok((stream, peer)) = accepted else {
            // Out of descriptors, or the client has gone again: not to be retried at full speed.
            tokio::time::sleep(Duration::from_millis(20)).await;
            continue;
        };
        let peer = peer.ip().to_canonical();
        let place = connection_limiter.admit_pending(peer, &site.limits);
        let (tls, site, held) = (tls.clone(), site.clone(), place.clone());
        let serving = tokio::spawn(async move {
            // A connection that fails is over; there is nobody to tell.
            let _ = serve(stream, peer, tls, site, held).await;
        });
        place.served_by(serving.abort_handle());
    }
}

async fn serve(
    stream: TcpStream,
    peer: IpAddr,
    tls: Option<TlsAcceptor>,
    site: Arc<Site>,
    place: Arc<ConnectionPermit>,
) -> Result<()> {
    stream.set_nodelay(true)?;
    let limits = &site.limits;
    let Some(tls) = tls else {
        return requests(Metered::new(stream, limits), peer, site, place).await;
    };
    let mut first = [0];
    timeout(limits.head, stream.peek(&mut first)).await??;
    let mut stream = Metered::new(stream, limits);
    if first[0] != TLS_HANDSHAKE {
        stream.write_all(SPEAK_TLS).await?;
        return stream.shutdown().await;
    }
    let stream = timeout(limits.head, tls.accept(stream)).await??;
    requests(stream, peer, site, place).await
}

/// Answers the requests of one connection, until one of them turns it into a session.
async fn requests<S>(
    stream: S,
    peer: IpAddr,
    site: Arc<Site>,
    place: Arc<ConnectionPermit>,
) -> Result<()>
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let stopping = site.clone();
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(site.limits.head).max_buf_size(HEAD_BYTES);
    let service = service_fn(move |request| site.clone().answer(peer, place.clone(), request));
    let connection = http.serve_connection(TokioIo::new(stream), service).with_upgrades();
    let mut connection = std::pin::pin!(connection);
    tokio::select! {
        done = connection.as_mut() => return done.map_err(std::io::Error::other),
        () = stopping.stopped() => connection.as_mut().graceful_shutdown(),
    }
    connection.await.map_err(std::io::Error::other)
}
