//! Handles of a device for its callers.

use super::{CLOSING, DisplayTraits, Shared, TrackerTraits};
use crate::{
    ForceDisplay, HandOutput, HandSample, MessageSource, PresenceCheck, Rendering, Tracker,
};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use thenar_core::model::Side;
use thenar_touch::safety::Limits;
use thenar_touch::{LoopProfile, TrackerTiming};
use triple_buffer::{Input, Output};

/// Index of a side's slot.
pub fn slot(side: Side) -> usize {
    match side {
        Side::Left => 0,
        Side::Right => 1,
    }
}

/// Ends the thread when nobody holds the device any more.
pub struct WorkerHandle {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl WorkerHandle {
    pub fn new(shared: Arc<Shared>, thread: JoinHandle<()>) -> Self {
        Self { shared, thread: Some(thread) }
    }
}

impl Drop for WorkerHandle {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        let Some(thread) = self.thread.take() else { return };
        thread.thread().unpark();
        let start = Instant::now();
        while !thread.is_finished() && start.elapsed() < CLOSING {
            std::thread::sleep(Duration::from_micros(200));
        }
        // A thread that the system holds in some call is left behind: it ends after that call.
        if thread.is_finished() {
            let _ = thread.join();
        }
    }
}

/// The tracker's side.
pub struct DeviceTracker {
    closer: Arc<WorkerHandle>,
    samples: [Output<Option<HandSample>>; 2],
    traits: TrackerTraits,
}

impl DeviceTracker {
    pub fn boxed(
        closer: Arc<WorkerHandle>,
        samples: [Output<Option<HandSample>>; 2],
        traits: TrackerTraits,
    ) -> Box<dyn Tracker> {
        Box::new(Self { closer, samples, traits })
    }
}

impl Tracker for DeviceTracker {
    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        let samples = &mut self.samples[slot(side)];
        if samples.update() { samples.output_buffer().as_ref() } else { None }
    }

    fn heard_ns(&mut self) -> Option<u64> {
        self.closer.shared.heard()
    }

    fn hand_length(&self) -> Option<f64> {
        self.traits.hand_length
    }

    fn timing(&self) -> Option<TrackerTiming> {
        self.traits.timing
    }

    fn messages(&mut self) -> Vec<String> {
        self.closer.shared.messages().take()
    }

    fn message_source(&self) -> MessageSource {
        let shared = self.closer.shared.clone();
        Box::new(move || shared.messages().take())
    }

    fn presence_check(&self) -> PresenceCheck {
        let shared = self.closer.shared.clone();
        Box::new(move || vec![shared.presence()])
    }
}

/// The display's side.
pub struct DeviceDisplay {
    closer: Arc<WorkerHandle>,
    outputs: [Input<HandOutput>; 2],
    traits: DisplayTraits,
}

impl DeviceDisplay {
    pub fn boxed(
        closer: Arc<WorkerHandle>,
        outputs: [Input<HandOutput>; 2],
        traits: DisplayTraits,
    ) -> Box<dyn ForceDisplay> {
        Box::new(Self { closer, outputs, traits })
    }
}

impl Drop for DeviceDisplay {
    fn drop(&mut self) {
        self.closer.shared.display_closed.store(true, Ordering::Release);
    }
}

impl ForceDisplay for DeviceDisplay {
    fn rendering(&self) -> Rendering {
        self.traits.rendering
    }

    fn limits(&self) -> Limits {
        self.traits.limits
    }

    fn torque_limits(&self) -> Option<Limits> {
        self.traits.torque_limits
    }

    fn loop_profile(&self) -> LoopProfile {
        self.traits.loop_profile
    }

    fn show(&mut self, output: &HandOutput) {
        self.outputs[slot(output.side)].write(*output);
    }

    fn heard_ns(&mut self) -> Option<u64> {
        self.closer.shared.heard()
    }

    fn messages(&mut self) -> Vec<String> {
        self.closer.shared.messages().take()
    }

    fn message_source(&self) -> MessageSource {
        let shared = self.closer.shared.clone();
        Box::new(move || shared.messages().take())
    }

    fn presence_check(&self) -> PresenceCheck {
        let shared = self.closer.shared.clone();
        Box::new(move || vec![shared.presence()])
    }
}
