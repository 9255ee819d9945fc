//! The file's end: a thread that writes what comes through the rings.

use crate::channel::{Channel, ChannelInfo, Field};
use crate::frame::{FrameKind, append, begin_payload, prologue};
use crate::frame_writer::{BIG, FrameWriter};
use crate::{Clock, Header, RecordError};
use rtrb::{Consumer, RingBuffer};
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Rings are emptied so often: what is lost by `kill -9` is no older.
const ROUND: Duration = Duration::from_millis(10);
/// Time between two flushes to the disk: what is lost with the power is no older.
const SYNC_EVERY: Duration = Duration::from_secs(5);
/// Room of the session's ring \[bytes\]: a minute of a usual session.
const SESSION_RING: usize = 8 << 20;
/// Longest frame of the session that costs no allocation \[bytes\].
const SESSION_FRAME: usize = 1 << 20;

/// A source's ring, as the thread sees it.
struct Source {
    ring: Consumer<u8>,
    big: Receiver<Vec<u8>>,
}

/// State that both sides share.
#[derive(Debug, Default)]
struct Shared {
    stop: AtomicBool,
    bytes: AtomicU64,
    trouble: Mutex<Option<String>>,
}

impl Shared {
    fn trouble(&self) -> Option<String> {
        self.trouble.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// A recording that is being written. It ends, properly, when this is finished or dropped.
#[derive(Debug)]
pub struct Recorder {
    file: PathBuf,
    clock: Clock,
    sources: Sender<Source>,
    channels: u32,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// Outcome of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// Size of the file \[bytes\].
    pub bytes: u64,
}

impl Recorder {
    /// Creates the file, writes its header and starts the thread.
    ///
    /// # Errors
    /// There is such a file, it cannot be created, or the thread cannot be started.
    pub fn create(file: &Path, header: &Header) -> Result<Self, RecordError> {
        let failed = |cause: io::Error| match cause.kind() {
            io::ErrorKind::AlreadyExists => RecordError::Exists(file.into()),
            _ => RecordError::Write { file: file.into(), cause },
        };
        let mut out = OpenOptions::new().write(true).create_new(true).open(file).map_err(failed)?;
        let (start, mut sum) = prologue();
        let mut bytes = start.to_vec();
        let mut payload = Vec::new();
        begin_payload(&mut payload, FrameKind::Header, 0);
        // Texts and numbers always have a JSON form.
        payload.extend(serde_json::to_vec(header).unwrap_or_default());
        append(&mut bytes, &mut sum, &payload);
        out.write_all(&bytes).and_then(|()| out.sync_all()).map_err(|cause| {
            // Made by us a moment ago; without its header it is of no use.
            let _ = std::fs::remove_file(file);
            failed(cause)
        })?;

        let shared = Arc::new(Shared::default());
        shared.bytes.store(bytes.len() as u64, Ordering::Relaxed);
        let (sources, incoming) = channel();
        let clock = Clock::start();
        let mut writer = Writer {
            out,
            sum,
            clock,
            incoming,
            sources: Vec::new(),
            payload: Vec::new(),
            batch: Vec::new(),
            shared: shared.clone(),
        };
        let thread = std::thread::Builder::new()
            .name("recording".into())
            .spawn(move || writer.run())
            .map_err(RecordError::Thread)?;
        Ok(Self { file: file.into(), clock, sources, channels: 0, shared, thread: Some(thread) })
    }

    /// The clock of its frames.
    pub fn clock(&self) -> Clock {
        self.clock
    }

    /// The writer of the session's frames. There is one.
    pub fn session(&self) -> FrameWriter {
        self.frame_writer(0, SESSION_RING, SESSION_FRAME)
    }

    /// A channel with these fields, with room for `waiting` records that the disk has not taken
    /// yet: a thousand is one second of haptic ticks. For the beginning: it allocates.
    pub fn channel(&mut self, name: &str, fields: &[Field], waiting: usize) -> Channel {
        self.channels += 1;
        let info = ChannelInfo { id: self.channels, name: name.into(), fields: fields.into() };
        let longest = 17 + 8 * fields.len();
        let ring = (waiting * longest).max(4096);
        let mut frame_writer = self.frame_writer(info.id, ring, longest);
        frame_writer.big_frame(FrameKind::Channel, self.clock.now_ns(), |body| {
            body.extend(serde_json::to_vec(&info).unwrap_or_default());
        });
        Channel::new(frame_writer, &info)
    }

    fn frame_writer(&self, source: u32, ring: usize, longest: usize) -> FrameWriter {
        let (producer, consumer) = RingBuffer::new(ring);
        let (big, coming) = channel();
        // Where the thread has ended, frames go nowhere and `trouble` says why.
        let _ = self.sources.send(Source { ring: consumer, big: coming });
        FrameWriter::new(producer, big, source, longest)
    }

    /// Why nothing is written any more, if so.
    pub fn trouble(&self) -> Option<String> {
        self.shared.trouble()
    }

    /// Bytes written so far.
    pub fn bytes(&self) -> u64 {
        self.shared.bytes.load(Ordering::Relaxed)
    }

    /// Writes what waits, marks the end and closes the file.
    ///
    /// # Errors
    /// Not all could be written; what was written can be read.
    pub fn finish(mut self) -> Result<Written, RecordError> {
        self.close();
        match self.trouble() {
            None => Ok(Written { bytes: self.bytes() }),
            Some(cause) => {
                Err(RecordError::Write { file: self.file.clone(), cause: io::Error::other(cause) })
            }
        }
    }

    fn close(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // It does not panic; should it, what is in the file can be read.
            let _ = thread.join();
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.close();
    }
}

/// The thread.
struct Writer {
    out: File,
    sum: u32,
    clock: Clock,
    incoming: Receiver<Source>,
    sources: Vec<Source>,
    /// A frame's payload, and frames ready to be written.
    payload: Vec<u8>,
    batch: Vec<u8>,
    shared: Arc<Shared>,
}

impl Writer {
    fn run(&mut self) {
        if let Err(error) = self.write_all() {
            let mut trouble = self.shared.trouble.lock().unwrap_or_else(PoisonError::into_inner);
            *trouble = Some(error.to_string());
        }
    }

    fn write_all(&mut self) -> io::Result<()> {
        let mut synced = Instant::now();
        loop {
            // What came before the order to stop is still written.
            let stop = self.shared.stop.load(Ordering::Acquire);
            self.round()?;
            if stop {
                break;
            }
            if synced.elapsed() >= SYNC_EVERY {
                self.out.sync_data()?;
                synced = Instant::now();
            }
            std::thread::park_timeout(ROUND);
        }
        self.payload.clear();
        begin_payload(&mut self.payload, FrameKind::End, self.clock.now_ns());
        append(&mut self.batch, &mut self.sum, &self.payload);
        self.flush()?;
        self.out.sync_all()
    }

    /// Writes what waits in all rings.
    fn round(&mut self) -> io::Result<()> {
        self.sources.extend(self.incoming.try_iter());
        let mut kept = 0;
        while kept < self.sources.len() {
            // Asked before the ring is emptied, so that nothing comes after.
            let gone = self.sources[kept].ring.is_abandoned();
            while self.take(kept) {
                append(&mut self.batch, &mut self.sum, &self.payload);
                if self.batch.len() > 1 << 20 {
                    self.flush()?;
                }
            }
            if gone {
                let source = self.sources.remove(kept);
                for payload in source.big.try_iter() {
                    append(&mut self.batch, &mut self.sum, &payload);
                }
            } else {
                kept += 1;
            }
        }
        self.flush()
    }

    /// Takes one payload out of a ring.
    fn take(&mut self, source: usize) -> bool {
        let Source { ring, big } = &mut self.sources[source];
        let mut length = [0; 4];
        if ring.pop_entire_slice(&mut length).is_err() {
            return false;
        }
        // A frame is pushed as one, so that all of it is there.
        match u32::from_le_bytes(length) {
            BIG => match big.try_recv() {
                Ok(payload) => {
                    self.payload = payload;
                    true
                }
                Err(_) => false,
            },
            length => {
                self.payload.resize(length as usize, 0);
                ring.pop_entire_slice(&mut self.payload).is_ok()
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.write_all(&self.batch)?;
        self.shared.bytes.fetch_add(self.batch.len() as u64, Ordering::Relaxed);
        self.batch.clear();
        Ok(())
    }
}
