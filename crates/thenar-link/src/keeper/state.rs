//! Decides when a keeper lets go. Pure: time is an argument.

/// Time between two beats of the program \[ns\].
pub const BEAT_NS: u64 = 5_000_000;
/// A program that has been silent for so long is taken over \[ns\].
///
/// The wearer is to be free after 50 ms. Of these a glove with servos takes 15 to read the two
/// lines that may lie before the releasing one, at 7.5 ms each, and the system some 10 to wake the
/// keeper on a busy machine. The watchers within the program let go after 20 ms; the keeper gives
/// them that time.
pub const SILENCE_NS: u64 = 25_000_000;
/// Time between two releases \[ns\]: one may be lost, or follow half a message. A glove with servos
/// reads a line in 7.5 ms: more often they would pile up before it, and what it is sent later would
/// come late.
pub const AGAIN_NS: u64 = 10_000_000;
/// A program that is gone is outlived for so long \[ns\]; then the port is free for the next.
pub const GONE_NS: u64 = 1_000_000_000;

/// Actions of a keeper that are due now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeeperActions {
    /// Send the releasing bytes.
    pub release: bool,
    /// Say to the program that it was taken over.
    pub tell: bool,
    /// Nothing is left to do, ever.
    pub end: bool,
    /// Nothing else is due for so long \[ns\].
    pub wait_ns: u64,
}

/// The state of a keeper.
#[derive(Clone, Debug, Default)]
pub struct KeeperState {
    /// Time of the program's last beat \[ns\]; `None` before the first.
    heard_ns: Option<u64>,
    /// Time of the last release \[ns\]; `None` while the program holds the device.
    released_ns: Option<u64>,
    /// Time when the program was found gone \[ns\].
    gone_ns: Option<u64>,
    ended: bool,
}

impl KeeperState {
    /// A beat came.
    pub fn hear(&mut self, now_ns: u64) {
        (self.heard_ns, self.released_ns) = (Some(now_ns), None);
    }

    /// The program has let go by itself: nothing is left to do.
    pub fn end(&mut self) {
        self.ended = true;
    }

    /// The program is gone without a word.
    pub fn gone(&mut self, now_ns: u64) {
        self.gone_ns.get_or_insert(now_ns);
    }

    /// Actions due at this time.
    pub fn turn(&mut self, now_ns: u64) -> KeeperActions {
        let passed = |since: u64| now_ns.saturating_sub(since);
        let (release, tell) = (false, false);
        // A device that nobody spoke for holds nothing of ours.
        let outlived = self.gone_ns.is_some_and(|gone| passed(gone) >= GONE_NS);
        let Some(heard) = self.heard_ns.filter(|_| !self.ended && !outlived) else {
            let end = self.ended || self.gone_ns.is_some();
            return KeeperActions { release, tell, end, wait_ns: SILENCE_NS };
        };
        let silent = passed(heard) >= SILENCE_NS || self.gone_ns.is_some();
        if !silent {
            let wait_ns = SILENCE_NS - passed(heard);
            return KeeperActions { release, tell, end: false, wait_ns };
        }
        let since = self.released_ns.map(passed);
        match since.filter(|since| *since < AGAIN_NS) {
            Some(since) => KeeperActions { release, tell, end: false, wait_ns: AGAIN_NS - since },
            None => {
                self.released_ns = Some(now_ns);
                KeeperActions {
                    release: true,
                    tell: since.is_none(),
                    end: false,
                    wait_ns: AGAIN_NS,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// Times of the keeper's releases \[ms\], for a program that beats at these times; the watch is
    /// looked at whenever it asks to be.
    fn releases(beats: &[u64], gone: Option<u64>, until: u64) -> (Vec<u64>, Option<u64>) {
        let (mut watch, mut found, mut now) = (KeeperState::default(), Vec::new(), 0);
        let mut beats = beats.iter().map(|ms| ms * MS).peekable();
        while now <= until * MS {
            while beats.next_if(|beat| *beat <= now).is_some() {
                watch.hear(now);
            }
            if gone.is_some_and(|gone| gone * MS <= now) {
                watch.gone(now);
            }
            let turn = watch.turn(now);
            if turn.end {
                return (found, Some(now / MS));
            }
            found.extend(turn.release.then_some(now / MS));
            let next = [beats.peek().copied(), gone.map(|gone| gone * MS)];
            let next = next.into_iter().flatten().filter(|at| *at > now);
            now = next.fold(now + turn.wait_ns, u64::min);
        }
        (found, None)
    }

    #[test]
    fn a_program_that_lives_is_left_alone() {
        let beats: Vec<u64> = (0..400).map(|k| 5 * k).collect();
        assert_eq!(releases(&beats, None, 1990), (vec![], None));
        // Late ones too, and nobody's device.
        let beats: Vec<u64> = (0..80).map(|k| 24 * k).collect();
        assert_eq!(releases(&beats, None, 1890), (vec![], None));
        assert_eq!(releases(&[], None, 1000), (vec![], None));
        assert_eq!(releases(&[], Some(40), 1000), (vec![], Some(40)));
    }

    /// Stopped after its beat at 100 ms: released 25 ms later, every 10 ms from then on, until it
    /// is back; and again.
    #[test]
    fn a_program_that_stands_still_is_taken_over_until_it_is_back() {
        let (found, end) = releases(&[95, 100, 142, 147], None, 200);
        let first = [125, 135];
        let second: Vec<u64> = (172..=200).step_by(10).collect();
        assert_eq!(found, [&first[..], &second].concat());
        assert_eq!(end, None);
    }

    /// Killed: released at once, and for a second.
    #[test]
    fn a_program_that_is_gone_is_outlived_for_a_second() {
        let (found, end) = releases(&[95, 100], Some(103), 5000);
        assert_eq!(found, (103..1103).step_by(10).collect::<Vec<_>>());
        assert_eq!(end, Some(1103));
        // Stopped first, then killed.
        let (found, end) = releases(&[100], Some(132), 5000);
        // Whole periods of releases after that, until the second is over.
        assert_eq!((found[0], found[1], found[2], end), (125, 135, 145, Some(1135)));
    }

    /// The program learns of each take-over once.
    #[test]
    fn each_take_over_is_reported_once() {
        let mut watch = KeeperState::default();
        watch.hear(0);
        let told = |watch: &mut KeeperState, from: u64| {
            (from..from + 60).filter(|ms| watch.turn(ms * MS).tell).collect::<Vec<_>>()
        };
        assert_eq!(told(&mut watch, 1), [25]);
        watch.hear(61 * MS);
        assert_eq!(told(&mut watch, 61), [86]);
        watch.end();
        assert!(watch.turn(200 * MS).end && !watch.turn(200 * MS).release);
    }

    #[test]
    fn a_clock_that_goes_back_releases_nothing() {
        let mut watch = KeeperState::default();
        watch.hear(1000 * MS);
        assert!(!watch.turn(10 * MS).release);
        assert!(watch.turn(1025 * MS).release);
    }
}
