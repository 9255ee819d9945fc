//! A glove without a place of its own, on a wrist that another device tracks.

use crate::profile::Wrist;
use crate::{HandSample, LinkError, Lookout, Messenger, Opened, Tracker};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use thenar::Pose;
use thenar::model::Side;
use thenar_scene::live::LivePose;

/// Adds a tracker for the wrist to a glove, if profile or address name one. The profile's wrist pose
/// is where the wrist is in the frame of the tracker's wrist, if the profile names a tracker; else
/// it is a place in the world, and means nothing for a wrist that is tracked.
///
/// # Errors
/// The tracker cannot be opened, or tracks nothing.
pub fn with_wrist(
    mut glove: Opened,
    wrist: &Wrist,
    address: Option<&str>,
) -> Result<Opened, LinkError> {
    let address = address.unwrap_or(&wrist.tracker);
    if address.is_empty() {
        return Ok(glove);
    }
    let Some(fingers) = glove.tracker.take() else { return Ok(glove) };
    let Some(base) = crate::open(address)?.tracker else {
        let cause = "this device tracks no wrist".into();
        return Err(LinkError::Setting { what: format!("wrist.tracker = \"{address}\""), cause });
    };
    let pose_TW = if wrist.tracker.is_empty() { Pose::identity() } else { wrist.pose() };
    glove.tracker = Some(Box::new(Paired::new(fingers, base, pose_TW)));
    Ok(glove)
}

/// Fingers of one tracker on the wrist of another.
pub struct Paired {
    fingers: Box<dyn Tracker>,
    base: Box<dyn Tracker>,
    /// The glove's wrist in the frame of the tracked one.
    pose_TW: Pose,
    known: [Known; 2],
    stepped_back: [SteppedBack; 2],
}

/// Whether a tracker's times step back, although none may: what it then tells is old. Two clocks that
/// disagree are told of once, when it begins.
#[derive(Clone, Default)]
struct SteppedBack {
    newest_ns: u64,
    /// It does now.
    now: bool,
    /// It began, and nobody was told.
    news: Arc<AtomicBool>,
}

impl SteppedBack {
    /// A sample came.
    fn look(&mut self, time_ns: u64) {
        let back = time_ns < self.newest_ns;
        if back && !self.now {
            self.news.store(true, Ordering::Relaxed);
        }
        self.now = back;
        self.newest_ns = self.newest_ns.max(time_ns);
    }

    /// What there is to tell of the tracker called `who`.
    fn message(news: &AtomicBool, who: &str) -> Option<String> {
        news.swap(false, Ordering::Relaxed).then(|| {
            format!("the clock of the {who} stepped back: the hand stands still until it is right")
        })
    }
}

/// Names of the two trackers.
const NAMES: [&str; 2] = ["glove", "wrist's tracker"];

/// What is known of one side.
#[derive(Default)]
struct Known {
    /// The tracked wrist, and when.
    wrist: Option<(Pose, u64)>,
    /// The newest sample of the fingers.
    fingers: Option<HandSample>,
    /// What was given out last.
    told: Option<HandSample>,
}

impl Paired {
    /// Puts the two together.
    pub fn new(fingers: Box<dyn Tracker>, base: Box<dyn Tracker>, pose_TW: Pose) -> Self {
        Self { fingers, base, pose_TW, known: Default::default(), stepped_back: Default::default() }
    }
}

impl Tracker for Paired {
    /// New when either moved. Its time is the older one's: a hand is as stale as its stalest part.
    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        let known = &mut self.known[usize::from(side == Side::Right)];
        let [of_fingers, of_base] = &mut self.stepped_back;
        let mut new = false;
        if let Some(sample) = self.base.latest(side) {
            of_base.look(sample.time_ns);
            known.wrist = sample.pose.as_ref().map(|pose| {
                let wrist = match pose {
                    LivePose::Joints { joints, .. } => joints[0],
                    LivePose::Angles { wrist, .. } => *wrist,
                };
                (wrist, sample.time_ns)
            });
            new = true;
        }
        if let Some(sample) = self.fingers.latest(side) {
            of_fingers.look(sample.time_ns);
            known.fingers = Some(sample.clone());
            new = true;
        }
        let fingers = known.fingers.as_ref().filter(|_| new)?;
        let mut sample = HandSample { side, time_ns: fingers.time_ns, pose: None };
        // A wrist that is not seen is a hand that is not seen.
        if let (Some((wrist, time_ns)), Some(pose)) = (&known.wrist, &fingers.pose) {
            sample.time_ns = fingers.time_ns.min(*time_ns);
            let mut pose = pose.clone();
            if let LivePose::Angles { wrist: at, .. } = &mut pose {
                *at = *wrist * self.pose_TW;
            }
            sample.pose = Some(pose);
        }
        let last = known.told.as_ref().map_or(0, |told| told.time_ns);
        // Times never go back, whatever the two do; a repeated one would be no news to anyone.
        sample.time_ns = sample.time_ns.max(last.saturating_add(1));
        known.told = Some(sample);
        known.told.as_ref()
    }

    fn heard_ns(&mut self) -> Option<u64> {
        self.fingers.heard_ns()
    }

    fn hand_length(&self) -> Option<f64> {
        self.fingers.hand_length()
    }

    fn messages(&mut self) -> Vec<String> {
        let mut all = self.fingers.messages();
        all.extend(self.base.messages());
        let stepped = self.stepped_back.iter().zip(NAMES);
        all.extend(stepped.filter_map(|(s, who)| SteppedBack::message(&s.news, who)));
        all
    }

    fn messenger(&self) -> Messenger {
        let (mut fingers, mut base) = (self.fingers.messenger(), self.base.messenger());
        let news = self.stepped_back.each_ref().map(|stepped| stepped.news.clone());
        Box::new(move || {
            let mut all = fingers();
            all.extend(base());
            let stepped = news.iter().zip(NAMES);
            all.extend(stepped.filter_map(|(news, who)| SteppedBack::message(news, who)));
            all
        })
    }

    fn lookout(&self) -> Lookout {
        let (mut fingers, mut base) = (self.fingers.lookout(), self.base.lookout());
        Box::new(move || [fingers(), base()].concat())
    }
}

#[cfg(test)]
mod tests;
