//! A twin behind a pseudo-terminal, with a cable that can be pulled.

use super::Twin;
use crate::now_ns;
use serialport::{SerialPort, TTYPort};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Longest pause between two looks at the line.
const PERIOD: Duration = Duration::from_micros(500);

struct Shared<T> {
    twin: Mutex<T>,
    plugged: AtomicBool,
    /// The terminal is as `plugged` says.
    settled: AtomicBool,
    stop: AtomicBool,
    /// Bytes that may still pass towards the host before the cable is pulled; `MAX` for ever.
    budget: AtomicU64,
    /// True while all that the twin says is lost.
    hushed: AtomicBool,
    /// Bytes for the host that are not the twin's.
    noise: Mutex<Vec<u8>>,
    /// All bytes that came from the host, the last million.
    heard: Mutex<Vec<u8>>,
}

/// A twin that runs until it is dropped.
pub struct PtyTwin<T: Twin + 'static> {
    path: PathBuf,
    shared: Arc<Shared<T>>,
    thread: Option<JoinHandle<()>>,
}

impl<T: Twin + 'static> PtyTwin<T> {
    /// Runs `twin`, plugged in, behind a link at `path` that always leads to its terminal.
    ///
    /// # Errors
    /// The system gives no pseudo-terminal, or something else is at `path`.
    pub fn start(twin: T, path: &Path) -> io::Result<Self> {
        let shared = Arc::new(Shared {
            twin: Mutex::new(twin),
            plugged: AtomicBool::new(true),
            settled: AtomicBool::new(false),
            stop: AtomicBool::new(false),
            budget: AtomicU64::new(u64::MAX),
            hushed: AtomicBool::new(false),
            noise: Mutex::new(Vec::new()),
            heard: Mutex::new(Vec::new()),
        });
        let mut line = Some(plug(path)?);
        lock(&shared.twin).power_on(now_ns());
        let (thread_shared, thread_path) = (shared.clone(), path.to_path_buf());
        let run = move || {
            while !thread_shared.stop.load(Ordering::Acquire) {
                turn(&thread_shared, &thread_path, &mut line);
            }
            let _ = std::fs::remove_file(&thread_path);
        };
        let thread = std::thread::Builder::new().name("twin".into()).spawn(run)?;
        Ok(Self { path: path.to_path_buf(), shared, thread: Some(thread) })
    }

    /// The port that a driver opens.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The twin, to look at and to move.
    pub fn twin(&self) -> MutexGuard<'_, T> {
        lock(&self.shared.twin)
    }

    /// Pulls the cable, or plugs it in again, and waits until that is done.
    pub fn plug(&self, plugged: bool) {
        self.shared.settled.store(false, Ordering::Release);
        self.shared.budget.store(u64::MAX, Ordering::Release);
        self.shared.plugged.store(plugged, Ordering::Release);
        while !self.shared.settled.load(Ordering::Acquire) && self.is_running() {
            std::thread::sleep(PERIOD);
        }
    }

    /// Pulls the cable after this number of further bytes to the host, in the midst of whatever it
    /// says.
    pub fn unplug_after(&self, bytes: u64) {
        self.shared.budget.store(bytes, Ordering::Release);
    }

    /// True while the cable is in.
    pub fn is_plugged(&self) -> bool {
        self.shared.plugged.load(Ordering::Acquire)
    }

    /// From now on, all that the twin says is lost on the way, or no longer.
    pub fn hush(&self, hushed: bool) {
        self.shared.hushed.store(hushed, Ordering::Release);
    }

    /// Bytes that the line adds by itself.
    pub fn add_noise(&self, bytes: &[u8]) {
        lock(&self.shared.noise).extend_from_slice(bytes);
    }

    /// All that the host has said since this was last asked.
    pub fn take_heard(&self) -> Vec<u8> {
        std::mem::take(&mut *lock(&self.shared.heard))
    }

    fn is_running(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }
}

impl<T: Twin + 'static> Drop for PtyTwin<T> {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Both ends of a terminal; ours keeps the other open, so that the line is there between hosts.
type Line = (TTYPort, TTYPort);

fn plug(path: &Path) -> io::Result<Line> {
    let (mut master, slave) = TTYPort::pair()?;
    master.set_timeout(PERIOD)?;
    crate::transport::serial::never_block(&master)?;
    let Some(name) = slave.name() else { return Err(io::ErrorKind::NotFound.into()) };
    // Only ever replaces a link, never a file.
    if path.is_symlink() {
        std::fs::remove_file(path)?;
    }
    std::os::unix::fs::symlink(name, path)?;
    Ok((master, slave))
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// One look at cable and line.
fn turn<T: Twin + 'static>(shared: &Shared<T>, path: &Path, line: &mut Option<Line>) {
    let plugged = shared.plugged.load(Ordering::Acquire);
    if plugged != line.is_some() {
        if plugged {
            lock(&shared.twin).power_on(now_ns());
            *line = plug(path).ok();
        } else {
            let _ = std::fs::remove_file(path);
            *line = None;
        }
    }
    let Some((master, _)) = line else {
        shared.settled.store(true, Ordering::Release);
        std::thread::sleep(PERIOD);
        return;
    };
    shared.settled.store(true, Ordering::Release);
    let mut buffer = [0; 4096];
    let received = master.read(&mut buffer).unwrap_or(0);
    let mut heard = lock(&shared.heard);
    if heard.len() < 1 << 20 {
        heard.extend_from_slice(&buffer[..received]);
    }
    drop(heard);
    let mut out = std::mem::take(&mut *lock(&shared.noise));
    let hushed = shared.hushed.load(Ordering::Acquire);
    lock(&shared.twin).step(now_ns(), &buffer[..received], &mut |bytes| {
        if !hushed {
            out.extend_from_slice(bytes);
        }
    });
    let budget = shared.budget.load(Ordering::Acquire);
    let passing = out.len().min(usize::try_from(budget).unwrap_or(usize::MAX));
    // What the host does not read is lost, as on a wire.
    let _ = master.write_all(&out[..passing]);
    if budget != u64::MAX {
        let left = budget - passing as u64;
        shared.budget.store(left, Ordering::Release);
        if left == 0 {
            // The bytes must arrive before the line goes dead.
            std::thread::sleep(Duration::from_millis(2));
            shared.plugged.store(false, Ordering::Release);
        }
    }
}
