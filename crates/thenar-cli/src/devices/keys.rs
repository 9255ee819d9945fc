//! Keys of the person at the terminal, each with the time at which it came.

use crate::error::CliError;
use crate::interrupt;
use std::io::{Read, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, channel};
use std::time::Duration;
use thenar_link::now_ns;

/// Between two looks at whether the program is to end.
const LOOK: Duration = Duration::from_millis(20);

/// Action of a person at the terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// A key, and when it came \[ns\].
    Pressed(u64),
    /// The terminal was closed, or the input has ended.
    Closed,
}

/// The standard input, heard on a thread of its own.
pub struct Keys(Receiver<(u64, u8)>);

impl Keys {
    /// Begins to hear. Once only: what one hears the others lack.
    pub fn hear() -> Self {
        let (to, from) = channel();
        std::thread::spawn(move || {
            let mut byte = [0];
            while let Ok(1) = std::io::stdin().lock().read(&mut byte) {
                if to.send((now_ns(), byte[0])).is_err() {
                    return;
                }
            }
        });
        Self(from)
    }

    /// Returns what happened since the last time, one at a time, without waiting.
    pub fn heard(&self) -> Option<Key> {
        match self.0.try_recv() {
            Ok((time_ns, _)) => Some(Key::Pressed(time_ns)),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Key::Closed),
        }
    }

    /// A line of the person.
    ///
    /// # Errors
    /// The input ends, or the program is to: `unfinished` says what of that.
    pub fn line(&self, unfinished: &str) -> Result<String, CliError> {
        let _ = std::io::stdout().flush();
        let mut line = Vec::new();
        while !interrupt::asked() {
            match self.0.recv_timeout(LOOK) {
                Ok((_, b'\n')) => return Ok(String::from_utf8_lossy(&line).trim().to_string()),
                Ok((_, byte)) if line.len() < 1000 => line.push(byte),
                Ok(_) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        Err(CliError::Other(unfinished.into()))
    }
}

/// While this lives any key counts as soon as it is down, where there is a terminal; without one,
/// whatever comes.
pub struct AnyKey(#[cfg(unix)] Option<nix::sys::termios::Termios>);

#[cfg(unix)]
impl AnyKey {
    /// From now on.
    pub fn counts() -> Self {
        use nix::sys::termios::{LocalFlags, SetArg, tcgetattr, tcsetattr};
        let Ok(before) = tcgetattr(STDIN) else { return Self(None) };
        let mut now = before.clone();
        now.local_flags.remove(LocalFlags::ICANON | LocalFlags::ECHO);
        let set = tcsetattr(STDIN, SetArg::TCSANOW, &now).is_ok();
        Self(set.then_some(before))
    }
}

#[cfg(unix)]
const STDIN: std::os::fd::RawFd = 0;

#[cfg(unix)]
impl Drop for AnyKey {
    fn drop(&mut self) {
        if let Some(before) = &self.0 {
            use nix::sys::termios::{SetArg, tcsetattr};
            // A terminal that is gone needs nothing.
            let _ = tcsetattr(STDIN, SetArg::TCSANOW, before);
        }
    }
}

#[cfg(not(unix))]
impl AnyKey {
    /// Enter has to end each line there.
    pub fn counts() -> Self {
        Self()
    }
}
