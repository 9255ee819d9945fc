//! Poses from the page (WebXR, webcam) as a tracker.

use crate::{HandSample, Tracker, TrackerTiming, now_ns};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use thenar_core::model::Side;
use thenar_track::live::LivePose;
use triple_buffer::{Input, Output, triple_buffer};

/// Inlet for whoever receives poses.
pub struct PagePoses {
    samples: [Input<Option<HandSample>>; 2],
    heard_ns: Arc<AtomicU64>,
}

/// The tracker that tells of them.
struct PageTracker {
    samples: [Output<Option<HandSample>>; 2],
    heard_ns: Arc<AtomicU64>,
    timing: TrackerTiming,
}

/// Both ends, of a page whose poses come so often and so late (a profile of the page says how): a
/// page sees hands through a headset's cameras, or a webcam, and tells nobody when it saw them.
pub fn page_tracker(timing: TrackerTiming) -> (PagePoses, Box<dyn Tracker>) {
    let [(left_in, left_out), (right_in, right_out)] = [(); 2].map(|()| triple_buffer(&None));
    let heard_ns = Arc::new(AtomicU64::new(0));
    (
        PagePoses { samples: [left_in, right_in], heard_ns: heard_ns.clone() },
        Box::new(PageTracker { samples: [left_out, right_out], heard_ns, timing }),
    )
}

impl PagePoses {
    /// Takes a pose that has just come; `None` when the page has lost the hand.
    pub fn put(&mut self, side: Side, pose: Option<LivePose>) {
        let time_ns = now_ns();
        self.samples[side as usize].write(Some(HandSample { side, time_ns, pose }));
        self.heard_ns.store(time_ns, Ordering::Relaxed);
    }
}

impl Tracker for PageTracker {
    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        let samples = &mut self.samples[side as usize];
        if samples.update() { samples.output_buffer_mut().as_ref() } else { None }
    }

    fn heard_ns(&mut self) -> Option<u64> {
        Some(self.heard_ns.load(Ordering::Relaxed)).filter(|ns| *ns > 0)
    }

    fn timing(&self) -> Option<TrackerTiming> {
        Some(self.timing)
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}
