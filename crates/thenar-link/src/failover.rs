//! Two or more devices on one hand: the best that can be trusted moves it, one at a time.
//!
//! Devices are named in order of preference. A device is trusted while it sees the hand: its newest
//! sample has a finite pose and is not older than 100 ms. When the one that moves the hand is
//! trusted no more, the next best takes over at once; a better one must be trusted without a break
//! for half a second before the hand goes back to it, so that one on the edge does not make the
//! hand flicker. Left and right are chosen apart. Every change is reported.

use crate::{
    Driver, FoundDevice, HandSample, LinkError, MessageSource, Opened, PresenceCheck, Tracker,
    now_ns,
};
use rtrb::{Consumer, Producer, RingBuffer};
use std::sync::{Arc, Mutex, PoisonError};
use thenar_core::model::Side;
use thenar_touch::TrackerTiming;
use thenar_track::live::checked;
use thenar_track::tracker_clock::{ClockJump, TrackerClock};

/// A source is trusted so long after its newest good sample \[ns\].
const STALE_NS: u64 = 100_000_000;
/// A better source must be good for so long \[ns\].
const PROVEN_NS: u64 = 500_000_000;
/// Changes that are kept until somebody asks.
const CHANGES_MAX: usize = 32;
/// Most devices.
const SOURCES_MAX: usize = 8;

/// One device, and what is known of it for each hand.
struct Source {
    name: String,
    tracker: Box<dyn Tracker>,
    times: TrackerClock,
    /// Left, right.
    hands: [SightRecord; 2],
}

#[derive(Clone, Copy, Debug, Default)]
struct SightRecord {
    /// Time of its last sight of the hand, and start of unbroken sight \[ns\].
    good: Option<[u64; 2]>,
}

impl SightRecord {
    fn is_trusted(&self, now: u64) -> bool {
        self.good.is_some_and(|[last, _]| now.saturating_sub(last) <= STALE_NS)
    }

    fn is_proven(&self, now: u64) -> bool {
        let long = |[_, since]: [u64; 2]| now.saturating_sub(since) >= PROVEN_NS;
        self.is_trusted(now) && self.good.is_some_and(long)
    }

    fn hear(&mut self, sample: &HandSample) {
        let good = sample.pose.as_ref().is_some_and(|pose| checked(0.0, pose).is_ok());
        let time = sample.time_ns;
        self.good = match (good, self.good) {
            (false, _) => None,
            (true, Some([last, since])) if time.saturating_sub(last) <= STALE_NS => {
                Some([time.max(last), since])
            }
            (true, _) => Some([time, time]),
        };
    }
}

/// The tracker that moves a hand.
#[derive(Clone, Copy, Debug, Default)]
struct Choice {
    source: Option<usize>,
    /// Time of the last sample that was told \[ns\].
    told_ns: u64,
}

/// A change: side, from, to.
type Change = (Side, Option<usize>, usize);

/// The tracker of several.
pub struct Failover {
    sources: Vec<Source>,
    choices: [Choice; 2],
    newest: [Option<HandSample>; 2],
    changes: Producer<Change>,
    /// The other end, for whoever asks; choosing never waits for that.
    told: Arc<Mutex<Consumer<Change>>>,
    clock: fn() -> u64,
}

impl Failover {
    /// One tracker out of several, the preferred first.
    pub fn new(trackers: Vec<(String, Box<dyn Tracker>)>) -> Self {
        Self::with_clock(trackers, now_ns)
    }

    fn with_clock(trackers: Vec<(String, Box<dyn Tracker>)>, clock: fn() -> u64) -> Self {
        let source = |(name, tracker)| Source {
            name,
            tracker,
            times: TrackerClock::default(),
            hands: Default::default(),
        };
        let (changes, told) = RingBuffer::new(CHANGES_MAX);
        Self {
            sources: trackers.into_iter().map(source).collect(),
            choices: Default::default(),
            newest: [None, None],
            changes,
            told: Arc::new(Mutex::new(told)),
            clock,
        }
    }

    /// Chooses the tracker that moves this hand from now on.
    fn choose(&mut self, side: Side, now: u64) -> Option<usize> {
        let k = side as usize;
        let trusted = |source: &Source| source.hands[k].is_trusted(now);
        let current = self.choices[k].source;
        let holds = current.filter(|i| trusted(&self.sources[*i]));
        let next = match holds {
            Some(i) => {
                let better = self.sources[..i].iter().position(|s| s.hands[k].is_proven(now));
                better.or(holds)
            }
            // Nobody else: whoever had the hand says that it is lost.
            None => self.sources.iter().position(trusted).or(current),
        };
        if let Some(to) = next.filter(|to| current != Some(*to)) {
            // Those that nobody asked for in time are left out.
            let _ = self.changes.push((side, current, to));
            self.choices[k].source = Some(to);
        }
        next
    }
}

impl Tracker for Failover {
    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        let (now, k) = ((self.clock)(), side as usize);
        let mut fresh: [Option<HandSample>; SOURCES_MAX] = Default::default();
        for (source, fresh) in self.sources.iter_mut().zip(&mut fresh) {
            if let Some(sample) = source.tracker.latest(side) {
                let time_ns = source.times.follow(side, now, sample.time_ns);
                let sample = HandSample { time_ns, ..sample.clone() };
                source.hands[k].hear(&sample);
                *fresh = Some(sample);
            }
        }
        let chosen = self.choose(side, now)?;
        let sample = fresh.get_mut(chosen)?.take()?;
        // Devices differ in delay: what the other one saw later has been told already.
        if sample.time_ns <= self.choices[k].told_ns {
            return None;
        }
        self.choices[k].told_ns = sample.time_ns;
        self.newest[k] = Some(sample);
        self.newest[k].as_ref()
    }

    fn heard_ns(&mut self) -> Option<u64> {
        self.sources.iter_mut().filter_map(|source| source.tracker.heard_ns()).max()
    }

    fn timing(&self) -> Option<TrackerTiming> {
        let all = self.sources.iter().filter_map(|source| source.tracker.timing());
        all.max_by(|a, b| a.delay().total_cmp(&b.delay()))
    }

    fn hand_length(&self) -> Option<f64> {
        self.sources.iter().find_map(|source| source.tracker.hand_length())
    }

    fn messages(&mut self) -> Vec<String> {
        let mut all: Vec<_> =
            self.sources.iter_mut().flat_map(|source| source.tracker.messages()).collect();
        all.extend(self.sources.iter().filter_map(|source| source.times.news().take(&source.name)));
        tell_changes(&self.told, &mut all, |i| &self.sources[i].name);
        all
    }

    fn message_source(&self) -> MessageSource {
        let mut sources: Vec<_> =
            self.sources.iter().map(|source| source.tracker.message_source()).collect();
        let names: Vec<_> = self.sources.iter().map(|source| source.name.clone()).collect();
        let news: Vec<ClockJump> = self.sources.iter().map(|source| source.times.news()).collect();
        let told = self.told.clone();
        Box::new(move || {
            let mut all: Vec<_> = sources.iter_mut().flat_map(|ask| ask()).collect();
            all.extend(news.iter().zip(&names).filter_map(|(news, name)| news.take(name)));
            tell_changes(&told, &mut all, |i| &names[i]);
            all
        })
    }

    fn presence_check(&self) -> PresenceCheck {
        let mut sources: Vec<_> =
            self.sources.iter().map(|source| source.tracker.presence_check()).collect();
        Box::new(move || sources.iter_mut().flat_map(|look| look()).collect())
    }
}

/// Adds what changed since it was last told.
fn tell_changes<'a>(
    told: &Mutex<Consumer<Change>>,
    all: &mut Vec<String>,
    name: impl Fn(usize) -> &'a str,
) {
    let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
    while let Ok((side, from, to)) = told.pop() {
        let hand = match side {
            Side::Left => "left",
            Side::Right => "right",
        };
        let to = name(to);
        all.push(match from {
            None => format!("the {hand} hand is moved by {to}"),
            Some(from) => {
                format!("the {hand} hand is moved by {to}, no longer by {}", name(from))
            }
        });
    }
}

/// Driver of addresses `either:DEVICE||DEVICE`.
pub struct FailoverDriver;

impl Driver for FailoverDriver {
    fn name(&self) -> &'static str {
        "either"
    }

    fn about(&self) -> &'static str {
        "several trackers of the same hands, the preferred first: either:hts:9000||poses:9010; \
         the first display among them is the display"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        Vec::new()
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        let names: Vec<_> = address.split("||").map(str::trim).collect();
        if !(2..=SOURCES_MAX).contains(&names.len()) {
            return Err(LinkError::Setting {
                what: format!("device `either:{address}`"),
                cause: format!("expected 2 to {SOURCES_MAX} devices with || between them"),
            });
        }
        let (mut trackers, mut display) = (Vec::new(), None);
        for name in names {
            let opened = crate::open(name)?;
            trackers.extend(opened.tracker.map(|tracker| (name.to_owned(), tracker)));
            display = display.or(opened.display);
        }
        Ok(Opened { tracker: Some(Box::new(Failover::new(trackers))), display })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use std::sync::{Arc, Mutex};
    use thenar_core::Pose;
    use thenar_track::ANGLES;
    use thenar_track::live::LivePose;

    const MS: u64 = 1_000_000;

    thread_local! {
        static NOW: Cell<u64> = const { Cell::new(0) };
    }

    /// Sample that the next call returns.
    type Next = Arc<Mutex<Option<HandSample>>>;

    struct Fake(Next, Option<HandSample>);

    impl Tracker for Fake {
        fn latest(&mut self, side: Side) -> Option<&HandSample> {
            let mut next = self.0.lock().unwrap();
            if next.as_ref()?.side != side {
                return None;
            }
            self.1 = next.take();
            self.1.as_ref()
        }

        fn heard_ns(&mut self) -> Option<u64> {
            self.1.as_ref().map(|sample| sample.time_ns)
        }

        fn messages(&mut self) -> Vec<String> {
            Vec::new()
        }
    }

    /// Source `x` sees the hand at x metres.
    fn bench() -> (Failover, [Next; 2]) {
        let nexts: [Next; 2] = Default::default();
        let name = ["good".to_owned(), "spare".to_owned()];
        let trackers = name
            .into_iter()
            .zip(&nexts)
            .map(|(name, next)| -> (String, Box<dyn Tracker>) {
                (name, Box::new(Fake(next.clone(), None)))
            })
            .collect();
        (Failover::with_clock(trackers, || NOW.get()), nexts)
    }

    fn sample(x: f64) -> HandSample {
        let pose =
            LivePose::Angles { wrist: Pose::translation(x, 0.0, 0.0), angles: [0.0; ANGLES] };
        HandSample { side: Side::Right, time_ns: NOW.get(), pose: Some(pose) }
    }

    /// Runs from one time to another in steps of 10 ms; both sources say what `says` tells. Returns
    /// who moved the hand, without repetition, and since when \[ms\].
    fn run(
        failover: &mut Failover,
        nexts: &[Next; 2],
        [from, to]: [u64; 2],
        says: &dyn Fn(u64) -> [Option<f64>; 2],
    ) -> Vec<(u64, f64)> {
        let mut seen: Vec<(u64, f64)> = Vec::new();
        let mut last_ns = 0;
        for ms in (from..to).step_by(10) {
            NOW.set(ms * MS);
            for (next, x) in nexts.iter().zip(says(ms)) {
                *next.lock().unwrap() = x.map(sample);
            }
            let Some(sample) = failover.latest(Side::Right) else { continue };
            assert!(sample.time_ns > last_ns, "times rise");
            last_ns = sample.time_ns;
            let Some(LivePose::Angles { wrist, .. }) = &sample.pose else { continue };
            if seen.last().is_none_or(|(_, x)| *x != wrist.position.x) {
                seen.push((ms, wrist.position.x));
            }
        }
        seen
    }

    #[test]
    fn the_spare_takes_over_at_once_and_gives_back_late() {
        let (mut failover, nexts) = bench();
        let seen = run(&mut failover, &nexts, [1000, 4000], &|ms| {
            // The good one is silent for a second, then flickers once.
            let silent = (2000..3000).contains(&ms) || (3200..3310).contains(&ms);
            [(!silent).then_some(1.0), Some(2.0)]
        });
        // 100 ms after the last sample at 1990; back 500 ms after it came again at 3310.
        assert_eq!(seen, [(1000, 1.0), (2100, 2.0), (3810, 1.0)]);
        // As the loop's monitor asks, while the loop has the tracker.
        let told = failover.message_source()();
        assert!(failover.messages().is_empty(), "each is told once");
        assert_eq!(
            told,
            [
                "the right hand is moved by good",
                "the right hand is moved by spare, no longer by good",
                "the right hand is moved by good, no longer by spare",
            ]
        );
    }

    #[test]
    fn a_source_that_is_on_and_off_never_gets_the_hand_back() {
        let (mut failover, nexts) = bench();
        let seen = run(&mut failover, &nexts, [1000, 9000], &|ms| {
            let on = ms < 1100 || (ms / 300) % 2 == 0;
            [on.then_some(1.0), Some(2.0)]
        });
        assert_eq!(seen.len(), 2, "{seen:?}");
    }

    #[test]
    fn poses_that_are_none_are_not_trusted() {
        let (mut failover, nexts) = bench();
        let seen = run(&mut failover, &nexts, [1000, 2000], &|ms| {
            [Some(if ms < 1500 { 1.0 } else { f64::NAN }), Some(2.0)]
        });
        assert_eq!(seen, [(1000, 1.0), (1500, 2.0)]);
        // Each hand by itself.
        assert!(failover.latest(Side::Left).is_none());
    }

    #[test]
    fn without_any_trusted_source_the_loss_is_told() {
        let (mut failover, nexts) = bench();
        run(&mut failover, &nexts, [1000, 1200], &|_| [Some(1.0), None]);
        NOW.set(1210 * MS);
        *nexts[0].lock().unwrap() = Some(HandSample { pose: None, ..sample(1.0) });
        assert_eq!(failover.latest(Side::Right).unwrap().pose, None);
    }

    /// A sample of tomorrow held all later ones up; a clock put back for good does no more harm
    /// than half a second with the spare.
    #[test]
    fn a_clock_that_jumps_by_a_day_is_followed() {
        const DAY_MS: i64 = 86_400_000;
        for (by, spare) in [(DAY_MS, None), (-DAY_MS, Some([2100, 3000]))] {
            let (mut failover, nexts) = bench();
            let begin = 2 * DAY_MS as u64;
            let seen =
                run(&mut failover, &nexts, [begin, begin + 5000], &|_| [Some(1.0), Some(2.0)]);
            assert_eq!(seen, [(begin, 1.0)]);
            let mut seen = Vec::new();
            for ms in (begin + 5000..begin + 9000).step_by(10) {
                NOW.set(ms * MS);
                let mut jumped = sample(1.0);
                jumped.time_ns = jumped.time_ns.saturating_add_signed(by * MS as i64);
                *nexts[0].lock().unwrap() = Some(jumped);
                *nexts[1].lock().unwrap() = Some(sample(2.0));
                let Some(sample) = failover.latest(Side::Right) else { continue };
                assert_eq!(sample.time_ns, ms * MS, "fresh");
                let Some(LivePose::Angles { wrist, .. }) = &sample.pose else { panic!() };
                if seen.last().is_none_or(|(_, x)| *x != wrist.position.x) {
                    seen.push((ms - begin - 3000, wrist.position.x));
                }
            }
            // 100 ms after the last good one at 4990; back 500 ms after it was believed at 5500.
            let want = spare.map_or(vec![(2000, 1.0)], |[from, to]| vec![(from, 2.0), (to, 1.0)]);
            assert_eq!(seen, want, "{by}");
            let told = failover.messages();
            assert!(told.contains(&"the clock of good has jumped; it is followed".into()));
        }
    }

    #[test]
    fn addresses_are_read_strictly() {
        let told = |address| crate::open(address).map(|_| ()).unwrap_err().to_string();
        assert!(told("either:null:left").contains("expected 2 to 8 devices"));
        assert!(told("either:null:left||nul").contains("no driver has that name"));
        assert!(crate::open("either:null:left||null:right").unwrap().display.is_some());
    }
}
