//! What the tests share: folders, the program, and what it said.

use std::path::PathBuf;
use std::process::{Child, Command, Output};
use std::time::{Duration, Instant};

/// An empty folder of its own for each test.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("thenar-cli-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_thenar"));
        command.args(args).current_dir(&self.0);
        command
    }

    pub fn thenar(&self, args: &[&str]) -> Output {
        self.command(args).output().unwrap()
    }

    /// Names of what is in it, in order.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let names = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    pub fn text(&self, file: &str) -> String {
        std::fs::read_to_string(self.0.join(file)).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

pub fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Errors and warnings, without the progress that only slow machines tell.
pub fn err(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr);
    let told = |line: &str| line.ends_with(" %\n") || line.ends_with(" s so far\n");
    let progress = |line: &str| told(line) && !line.starts_with("error");
    text.split_inclusive('\n').filter(|line| !progress(line)).collect()
}

/// The hash that a summary ends with.
pub fn state(output: &Output) -> String {
    let text = out(output);
    let hash = text.lines().rev().find_map(|line| line.trim().strip_prefix("state "));
    hash.unwrap_or_else(|| panic!("{text}{}", err(output))).into()
}

/// Ends a program the hard way when the test ends.
pub struct Running(pub Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Waits until a name with this in it is in a folder.
#[track_caller]
#[allow(dead_code)] // for the tests of outputs
pub fn wait_for_name(folder: &std::path::Path, part: &str) {
    let begun = Instant::now();
    let is_there = || {
        let mut names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
        names.any(|name| name.to_string_lossy().contains(part))
    };
    while !is_there() {
        assert!(begun.elapsed() < Duration::from_secs(120), "no {part} in {}", folder.display());
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Waits until a file has grown beyond so many bytes.
#[track_caller]
pub fn wait_for(file: &std::path::Path, bytes: u64) {
    let begun = Instant::now();
    while std::fs::metadata(file).map_or(0, |m| m.len()) < bytes {
        assert!(begun.elapsed() < Duration::from_secs(120), "{} does not grow", file.display());
        std::thread::sleep(Duration::from_millis(5));
    }
}
