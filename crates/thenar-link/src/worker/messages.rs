//! Messages of a device's thread to a person: bounded, whatever the device does.

use std::collections::VecDeque;

/// Messages kept until somebody asks; older ones give way, and their number is reported.
const CAPACITY: usize = 64;
/// Longest message, in characters.
const LENGTH: usize = 200;
/// Least time between reports of refused bytes, and between repeats of a note \[ns\].
const REPEATED_EVERY_NS: u64 = 1_000_000_000;

/// The queue.
pub struct Messages {
    name: String,
    queue: VecDeque<String>,
    lost: u64,
    /// Time of the last report of refused bytes, and the number of refusals since.
    refused_ns: Option<u64>,
    refused: u64,
    /// Last report of the device on itself, and its time.
    note: Option<(String, u64)>,
}

impl Messages {
    /// Messages of the device with this name.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.into(),
            queue: VecDeque::new(),
            lost: 0,
            refused_ns: None,
            refused: 0,
            note: None,
        }
    }

    /// Adds one.
    pub fn tell(&mut self, text: &str) {
        if self.queue.len() == CAPACITY {
            self.queue.pop_front();
            self.lost += 1;
        }
        // What a device says of itself may be anything.
        let shown = text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c });
        let text: String = shown.take(LENGTH).collect();
        self.queue.push_back(format!("{}: {text}", self.name));
    }

    /// A report of the device itself; repeats pass at most once a second.
    pub fn note(&mut self, now_ns: u64, text: &str) {
        let again = |(last, at): &(String, u64)| {
            last == text && now_ns.saturating_sub(*at) < REPEATED_EVERY_NS
        };
        if !self.note.as_ref().is_some_and(again) {
            self.note = Some((text.into(), now_ns));
            self.tell(text);
        }
    }

    /// Bytes were refused: tells the first time, then once a second at most.
    pub fn refuse(&mut self, now_ns: u64, why: &str) {
        self.refused += 1;
        if self.refused_ns.is_some_and(|last| now_ns.saturating_sub(last) < REPEATED_EVERY_NS) {
            return;
        }
        let times = self.refused;
        match times {
            1 => self.tell(why),
            _ => self.tell(&format!("{why} ({times} times)")),
        }
        self.refused_ns = Some(now_ns);
        self.refused = 0;
    }

    /// All that there is, oldest first.
    pub fn take(&mut self) -> Vec<String> {
        let mut all = Vec::with_capacity(self.queue.len() + 1);
        if self.lost > 0 {
            all.push(format!("{}: {} earlier messages were left out", self.name, self.lost));
            self.lost = 0;
        }
        all.extend(self.queue.drain(..));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floods_are_bounded_and_counted() {
        let mut messages = Messages::new("d");
        for k in 0..1000 {
            messages.tell(&format!("{k}{}", "x".repeat(1000)));
        }
        let told = messages.take();
        assert_eq!(told.len(), CAPACITY + 1);
        assert_eq!(told[0], "d: 936 earlier messages were left out");
        assert!(told.iter().all(|m| m.chars().count() <= LENGTH + 3));
        assert!(told[1].starts_with("d: 936x") && told[CAPACITY].starts_with("d: 999x"));
        assert!(messages.take().is_empty());
    }

    #[test]
    fn notes_that_are_repeated_are_told_once_a_second() {
        let mut messages = Messages::new("d");
        (0..2500).for_each(|ms| messages.note(ms * 1_000_000, "jumped"));
        assert_eq!(messages.take(), ["d: jumped"; 3]);
        ["a", "b", "a"].iter().for_each(|text| messages.note(2_500_000_000, text));
        assert_eq!(messages.take(), ["d: a", "d: b", "d: a"]);
    }

    #[test]
    fn refusals_are_told_once_a_second_with_their_number() {
        let mut messages = Messages::new("d");
        for ms in 0..2500 {
            messages.refuse(ms * 1_000_000, "no line");
        }
        assert_eq!(
            messages.take(),
            ["d: no line", "d: no line (1000 times)", "d: no line (1000 times)"]
        );
        messages.tell("bell \u{7} and \n");
        assert_eq!(messages.take(), ["d: bell \u{fffd} and \u{fffd}"]);
    }
}
