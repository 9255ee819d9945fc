//! A glove without a place of its own, on a wrist that another device tracks.

use crate::profile::{Address, Wrist, profile_name};
use crate::{
    HandSample, LinkError, MessageSource, Opened, PresenceCheck, Tracker, nesting, now_ns,
};
use thenar_core::Pose;
use thenar_core::model::Side;
use thenar_input::quoted;
use thenar_touch::TrackerTiming;
use thenar_track::live::LivePose;
use thenar_track::tracker_clock::TrackerClock;

/// Adds a tracker for the wrist to a glove, if profile or address name one. The profile's wrist
/// pose is where the wrist is in the frame of the tracker's wrist, if the profile names a tracker;
/// else it is a place in the world, and means nothing for a wrist that is tracked.
///
/// # Errors
/// The tracker cannot be opened, is the glove itself, or tracks nothing.
pub fn with_wrist(
    mut glove: Opened,
    wrist: &Wrist,
    driver: &str,
    parsed: &Address,
) -> Result<Opened, LinkError> {
    let address = parsed.wrist.as_deref().unwrap_or(&wrist.tracker);
    if address.is_empty() {
        return Ok(glove);
    }
    let refuse = |cause: &str| {
        let named = match &parsed.wrist {
            Some(_) => format!("device `{driver}:{}`, wrist", parsed.place),
            None => format!("{}, wrist.tracker", profile_name(driver, parsed)),
        };
        LinkError::Setting { what: format!("{named} = {}", quoted(address)), cause: cause.into() }
    };
    let Some(fingers) = glove.tracker.take() else { return Ok(glove) };
    if nesting::is_opening(address) {
        return Err(refuse("this is the device whose wrist it is to track"));
    }
    let Some(base) = crate::open(address)?.tracker else {
        return Err(refuse("this device tracks no wrist"));
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
    known: [PairedSide; 2],
    /// The two trackers' times.
    clocks: [TrackerClock; 2],
    clock: fn() -> u64,
}

/// Names of the two trackers.
const NAMES: [&str; 2] = ["the glove", "the wrist's tracker"];

/// Newest samples of one hand by both trackers.
#[derive(Default)]
struct PairedSide {
    /// The tracked wrist, and when.
    wrist: Option<(Pose, u64)>,
    /// The newest sample of the fingers.
    fingers: Option<HandSample>,
    /// Sample given out last.
    told: Option<HandSample>,
}

impl Paired {
    /// Puts the two together.
    pub fn new(fingers: Box<dyn Tracker>, base: Box<dyn Tracker>, pose_TW: Pose) -> Self {
        Self::with_clock(fingers, base, pose_TW, now_ns)
    }

    fn with_clock(
        fingers: Box<dyn Tracker>,
        base: Box<dyn Tracker>,
        pose_TW: Pose,
        clock: fn() -> u64,
    ) -> Self {
        let (known, clocks) = Default::default();
        Self { fingers, base, pose_TW, known, clocks, clock }
    }
}

impl Tracker for Paired {
    /// A hand is as late as its later part.
    fn timing(&self) -> Option<TrackerTiming> {
        let both = [self.fingers.timing(), self.base.timing()];
        both.into_iter().flatten().max_by(|a, b| a.delay().total_cmp(&b.delay()))
    }

    /// New when either moved. Its time is the older one's: a hand is as stale as its stalest part.
    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        let known = &mut self.known[usize::from(side == Side::Right)];
        let [of_fingers, of_base] = &mut self.clocks;
        let now = (self.clock)();
        let mut new = false;
        if let Some(sample) = self.base.latest(side) {
            let time_ns = of_base.follow(side, now, sample.time_ns);
            known.wrist = sample.pose.as_ref().map(|pose| {
                let wrist = match pose {
                    LivePose::Joints { joints, .. } => joints[0],
                    LivePose::Angles { wrist, .. } => *wrist,
                };
                (wrist, time_ns)
            });
            new = true;
        }
        if let Some(sample) = self.fingers.latest(side) {
            let time_ns = of_fingers.follow(side, now, sample.time_ns);
            known.fingers = Some(HandSample { time_ns, ..sample.clone() });
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
        all.extend(self.clocks.iter().zip(NAMES).filter_map(|(clock, who)| clock.news().take(who)));
        all
    }

    fn message_source(&self) -> MessageSource {
        let (mut fingers, mut base) = (self.fingers.message_source(), self.base.message_source());
        let news = self.clocks.each_ref().map(TrackerClock::news);
        Box::new(move || {
            let mut all = fingers();
            all.extend(base());
            all.extend(news.iter().zip(NAMES).filter_map(|(news, who)| news.take(who)));
            all
        })
    }

    fn presence_check(&self) -> PresenceCheck {
        let (mut fingers, mut base) = (self.fingers.presence_check(), self.base.presence_check());
        Box::new(move || [fingers(), base()].concat())
    }
}

#[cfg(test)]
mod tests;
