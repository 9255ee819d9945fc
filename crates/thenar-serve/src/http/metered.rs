//! A connection that may neither pour, nor fall silent, nor refuse to drain.

use super::options::RequestLimits;
use super::rates::Bucket;
use std::future::Future;
use std::io::{Error, ErrorKind, IoSlice, Result};
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep_until};

/// A byte stream within bounds; beyond one of them it fails.
#[derive(Debug)]
pub struct Metered<S> {
    stream: S,
    allowance: Bucket,
    silence: Watchdog,
    stuck: Watchdog,
    waiting: bool,
}

impl<S> Metered<S> {
    /// Bounds a stream from now on.
    pub fn new(stream: S, limits: &RequestLimits) -> Self {
        Self {
            stream,
            allowance: Bucket::new(limits.bytes, 4.0, Instant::now()),
            silence: Watchdog::new(limits.idle),
            stuck: Watchdog::new(limits.stuck),
            waiting: false,
        }
    }
}

/// Barks when it was not fed for some time.
#[derive(Debug)]
struct Watchdog {
    patience: Duration,
    fed: Instant,
    timer: Pin<Box<Sleep>>,
}

impl Watchdog {
    fn new(patience: Duration) -> Self {
        let fed = Instant::now();
        Self { patience, fed, timer: Box::pin(sleep_until(fed + patience)) }
    }

    fn feed(&mut self) {
        self.fed = Instant::now();
    }

    /// Ready when patience is over. The timer is set anew only when it fires: feeding is frequent.
    fn poll(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        loop {
            ready!(self.timer.as_mut().poll(cx));
            let deadline = self.fed + self.patience;
            if Instant::now() >= deadline {
                return Poll::Ready(());
            }
            self.timer.as_mut().reset(deadline);
        }
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Metered<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<Result<()>> {
        let before = buffer.filled().len();
        match Pin::new(&mut self.stream).poll_read(cx, buffer) {
            Poll::Ready(Ok(())) => {
                self.silence.feed();
                let came = (buffer.filled().len() - before) as f64;
                match self.allowance.take(came, Instant::now()) {
                    true => Poll::Ready(Ok(())),
                    false => Poll::Ready(Err(Error::other("too many bytes a second"))),
                }
            }
            Poll::Pending => {
                ready!(self.silence.poll(cx));
                Poll::Ready(Err(Error::new(ErrorKind::TimedOut, "the client fell silent")))
            }
            failed => failed,
        }
    }
}

impl<S: AsyncWrite + Unpin> Metered<S> {
    /// A write that moved is a sign of life; one that waits is watched from when it began to.
    fn watch_write<T>(&mut self, cx: &mut Context<'_>, done: Poll<Result<T>>) -> Poll<Result<T>> {
        match done {
            Poll::Ready(Ok(x)) => {
                self.silence.feed();
                self.waiting = false;
                Poll::Ready(Ok(x))
            }
            Poll::Pending => {
                if !std::mem::replace(&mut self.waiting, true) {
                    self.stuck.feed();
                }
                ready!(self.stuck.poll(cx));
                Poll::Ready(Err(Error::new(ErrorKind::TimedOut, "the client takes nothing")))
            }
            failed => failed,
        }
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Metered<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<Result<usize>> {
        let done = Pin::new(&mut self.stream).poll_write(cx, bytes);
        self.watch_write(cx, done)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        slices: &[IoSlice<'_>],
    ) -> Poll<Result<usize>> {
        let done = Pin::new(&mut self.stream).poll_write_vectored(cx, slices);
        self.watch_write(cx, done)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }
}
