//! A person at a terminal of their own, with the program in it.

use super::{PATIENCE, lines, thenar};
use nix::fcntl::OFlag;
use nix::pty::{PtyMaster, grantpt, posix_openpt, ptsname_r, unlockpt};
use std::fs::File;
use std::io::Write;
use std::process::{Child, Stdio};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

/// The program, what it says, and the terminal that it hears.
pub struct Person {
    pub process: Child,
    pub said: Receiver<String>,
    terminal: Option<PtyMaster>,
}

impl Person {
    /// Starts the program with these arguments; its settings are in this folder.
    pub fn start(args: &[&str], settings: &std::path::Path) -> Self {
        let terminal = posix_openpt(OFlag::O_RDWR | OFlag::O_NOCTTY | OFlag::O_CLOEXEC).unwrap();
        grantpt(&terminal).unwrap();
        unlockpt(&terminal).unwrap();
        let slave = ptsname_r(&terminal).unwrap();
        let slave = File::options().read(true).write(true).open(slave).unwrap();
        let mut process = thenar(args)
            .env("THENAR_CONFIG", settings)
            .stdin(Stdio::from(slave))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let said = lines(process.stdout.take().unwrap());
        Self { process, said, terminal: Some(terminal) }
    }

    /// Presses keys.
    pub fn press(&mut self, keys: &str) {
        self.terminal.as_mut().unwrap().write_all(keys.as_bytes()).unwrap();
    }

    /// Closes the terminal.
    pub fn close(&mut self) {
        self.terminal = None;
    }

    /// The exit code, what is left of what it said, and its errors.
    pub fn end(&mut self) -> (Option<i32>, String) {
        let start = Instant::now();
        let code = loop {
            if let Some(status) = self.process.try_wait().unwrap() {
                break status.code();
            }
            assert!(
                start.elapsed() < PATIENCE,
                "it never ended: {:?}",
                self.said.try_iter().collect::<Vec<_>>()
            );
            std::thread::sleep(Duration::from_millis(5));
        };
        let errors = self.process.stderr.take().map(std::io::read_to_string);
        let said: Vec<String> = self.said.iter().collect();
        (code, said.join("\n") + &errors.unwrap().unwrap())
    }
}

impl Drop for Person {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Waits until it is so.
pub fn until(what: &str, is_so: impl Fn() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < PATIENCE, "never: {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}
