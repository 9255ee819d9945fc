//! A display in memory, for tests.

use std::sync::{Arc, Mutex};
use thenar_link::{ForceDisplay, HandOutput, Rendering};
use thenar_touch::LoopProfile;
use thenar_touch::safety::Limits;

/// A millisecond \[ns\].
pub const MS: u64 = 1_000_000;

/// A display of which all that it shows is kept.
pub struct Display {
    pub rendering: Rendering,
    pub heard_ns: Arc<Mutex<u64>>,
    pub shown: Arc<Mutex<Vec<HandOutput>>>,
}

impl ForceDisplay for Display {
    fn rendering(&self) -> Rendering {
        self.rendering
    }

    fn limits(&self) -> Limits {
        // Arms push both ways.
        let unilateral = self.rendering != Rendering::Wrench;
        Limits { ramp: 0.1, unilateral, ..Limits::cybergrasp() }
    }

    fn loop_profile(&self) -> LoopProfile {
        unreachable!("a trial has no coupling")
    }

    fn show(&mut self, output: &HandOutput) {
        self.shown.lock().unwrap().push(*output);
    }

    fn heard_ns(&mut self) -> Option<u64> {
        Some(*self.heard_ns.lock().unwrap())
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}
