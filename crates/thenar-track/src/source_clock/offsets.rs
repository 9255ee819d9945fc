//! Course of one clock beside another, from their least differences of late.
//!
//! Every way through a network adds to the difference of two clocks, none takes off it: the
//! differences lie above a line, whose slope is how much faster our clock runs. It is the edge of
//! their lower hull that spans their mean time (Moon, Skelly and Towsley 1999): the highest line
//! that lies below all of them.

/// Length of the times of each of which the least difference is kept \[ns\].
const WINDOW: u64 = 500_000_000;
/// Number of these: 20 s, over which a way that is uncertain by 1 ms tells the rate within 1e-4.
const WINDOWS: usize = 40;
/// The rate is found from differences that span so much \[ns\]; before, the clocks are taken to run
/// alike.
const SPAN: u64 = 2_000_000_000;
/// Largest difference of two clocks' rates. Quartz keeps within 2e-4; clocks that are being
/// corrected run off by 5e-4 (the limit of `adjtime` and NTP), and 1e-3 was asked for.
const RATE_MAX: f64 = 2e-3;
/// A difference this far below the line is no clock that runs off, but one that was put ahead, or a
/// shorter way \[ns\].
const STEP: i64 = 5_000_000;
/// Uncertainty of a rate: after a silence the line is raised by this part of the silence.
const UNSURE: f64 = 2e-4;

/// A difference of the clocks, and when it was seen by ours.
#[derive(Clone, Copy, Debug, Default)]
struct OffsetSample {
    at_ns: u64,
    difference: i64,
}

/// Offset of another clock: ours minus its.
#[derive(Clone, Debug)]
pub struct Offsets {
    /// The least of each half second, oldest first.
    least: [OffsetSample; WINDOWS],
    count: usize,
    /// The least of the present half second, and when that began \[ns\].
    present: OffsetSample,
    began_ns: u64,
    /// The line: where it was at a time, and its slope.
    line: OffsetSample,
    rate: f64,
    /// Offset that is reported, which follows the line without a step.
    told: OffsetSample,
}

impl Offsets {
    /// A clock that is seen for the first time.
    pub fn new(at_ns: u64, difference: i64) -> Self {
        let seen = OffsetSample { at_ns, difference };
        Self {
            least: [OffsetSample::default(); WINDOWS],
            count: 0,
            present: seen,
            began_ns: at_ns,
            line: seen,
            rate: 0.0,
            told: seen,
        }
    }

    fn line_at(&self, at_ns: u64) -> i64 {
        self.line.difference.saturating_add((self.rate * since(self.line.at_ns, at_ns)) as i64)
    }

    /// The offset at a time \[ns\], before a difference seen then is known. It moves no faster than
    /// clocks do.
    pub fn at(&self, now_ns: u64) -> i64 {
        let most = (RATE_MAX * since(self.told.at_ns, now_ns)) as i64;
        let told = self.told.difference;
        self.line_at(now_ns).clamp(told.saturating_sub(most), told.saturating_add(most))
    }

    /// Takes in a difference. One that is `late` says nothing of the clocks.
    pub fn take(&mut self, now_ns: u64, difference: i64, late: bool) -> i64 {
        let offset = self.at(now_ns).min(difference);
        self.told = OffsetSample { at_ns: now_ns, difference: offset };
        if late {
            return offset;
        }
        let seen = OffsetSample { at_ns: now_ns, difference };
        if difference < self.line_at(now_ns).saturating_sub(STEP) {
            // What was before says nothing of where the line is now; the clock runs as it ran.
            (self.count, self.began_ns, self.present, self.line) = (0, now_ns, seen, seen);
            return offset;
        }
        if since(self.began_ns, now_ns) >= WINDOW as f64 {
            self.keep(now_ns);
            (self.began_ns, self.present) = (now_ns, seen);
        } else {
            // By what is above the line: within half a second a clock may run on by more than a way
            // differs.
            let above =
                |seen: &OffsetSample| seen.difference.saturating_sub(self.line_at(seen.at_ns));
            if above(&seen) < above(&self.present) {
                self.present = seen;
            }
        }
        if difference < self.line_at(now_ns) {
            self.line = seen;
        }
        offset
    }

    /// The present half second is over.
    fn keep(&mut self, now_ns: u64) {
        let old =
            |seen: &OffsetSample| since(seen.at_ns, now_ns) > (WINDOWS as u64 * WINDOW) as f64;
        let stale = self.least[..self.count].iter().filter(|seen| old(seen)).count();
        let gone = stale.max(usize::from(self.count == WINDOWS));
        self.least.copy_within(gone..self.count, 0);
        self.count -= gone;
        if old(&self.present) {
            // Silence: the clock ran on as it did, as far as that is known.
            let silent = since(self.present.at_ns, now_ns);
            let difference = self.line_at(now_ns).saturating_add((UNSURE * silent) as i64);
            self.line = OffsetSample { at_ns: now_ns, difference };
            return;
        }
        self.least[self.count] = self.present;
        self.count += 1;
        self.fit();
    }

    /// The highest line at the mean time that no difference is below, of a slope that clocks have.
    fn fit(&mut self) {
        let kept = &self.least[..self.count];
        let (Some(first), Some(last)) = (kept.first(), kept.last()) else { return };
        if since(first.at_ns, last.at_ns) < SPAN as f64 {
            return;
        }
        let time = |seen: &OffsetSample| since(first.at_ns, seen.at_ns);
        let height = |seen: &OffsetSample| seen.difference.saturating_sub(first.difference) as f64;
        let mean = kept.iter().map(time).sum::<f64>() / kept.len() as f64;
        // Of the chords across the mean time the lowest there is an edge of the lower hull.
        let (mut lowest, mut slope) = (f64::INFINITY, 0.0);
        for a in kept.iter().filter(|seen| time(seen) < mean) {
            for b in kept.iter().filter(|seen| time(seen) >= mean) {
                let rises = (height(b) - height(a)) / (time(b) - time(a));
                let there = height(a) + rises * (mean - time(a));
                if there < lowest {
                    (lowest, slope) = (there, rises);
                }
            }
        }
        let rate = slope.clamp(-RATE_MAX, RATE_MAX);
        let below = kept.iter().map(|seen| height(seen) - rate * (time(seen) - mean));
        let there = below.fold(f64::INFINITY, f64::min);
        let difference = first.difference.saturating_add(there as i64);
        self.line = OffsetSample { at_ns: first.at_ns.saturating_add(mean as u64), difference };
        self.rate = rate;
    }
}

/// From one time to a later one \[ns\].
fn since(from_ns: u64, to_ns: u64) -> f64 {
    to_ns.saturating_sub(from_ns) as f64
}
