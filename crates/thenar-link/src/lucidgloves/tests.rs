//! Goal: the conversation keeps the glove's pace. Method: protocol and simulated firmware in
//! simulated time, with what may be in the way of it.

use super::{LucidGloves, LucidGlovesTwin, Profile, SHIPPED};
use crate::profile::{Address, load};
use crate::twin::Twin;
use crate::{Event, HandOutput, Protocol};
use std::sync::Arc;
use thenar_core::model::Side;

/// Between two looks at the line \[ns\].
const STEP_NS: u64 = 250_000;
/// A second.
const SECOND_NS: u64 = 1_000_000_000;

struct Talk {
    now_ns: u64,
    protocol: LucidGloves,
    glove: LucidGlovesTwin,
    /// Towards the glove, and from it.
    wires: [Vec<u8>; 2],
    samples: u64,
}

impl Talk {
    /// A host that opens a glove which runs, and waits, for three seconds already.
    fn new() -> Self {
        let profile: Profile = load("lucidgloves", SHIPPED, &Address::default()).unwrap();
        let mut glove = LucidGlovesTwin::new(false, false);
        glove.power_on(0);
        for k in 0..12_000 {
            glove.step(k * STEP_NS, &[], &mut |_| {});
        }
        let protocol = LucidGloves::new(Arc::new(profile));
        let wires = [Vec::new(), Vec::new()];
        let mut talk = Self { now_ns: 3 * SECOND_NS, protocol, glove, wires, samples: 0 };
        let out = &mut talk.wires[0];
        talk.protocol.start(talk.now_ns, &mut |bytes| out.extend_from_slice(bytes));
        talk
    }

    /// Lets time pass; `stops` are the curls at contact to show, given anew in each step.
    fn run(&mut self, seconds: f64, mut curl: impl FnMut(u64) -> Option<f64>) {
        let steps = (seconds * 1e9) as u64 / STEP_NS;
        for _ in 0..steps {
            self.now_ns += STEP_NS;
            let [to_glove, from_glove] = &mut self.wires;
            let heard = std::mem::take(to_glove);
            self.glove.step(self.now_ns, &heard, &mut |bytes| from_glove.extend_from_slice(bytes));
            let mut event = |event| self.samples += u64::from(matches!(event, Event::Sample(_)));
            let told = std::mem::take(from_glove);
            let mut send = |bytes: &[u8]| to_glove.extend_from_slice(bytes);
            self.protocol.receive(self.now_ns, &told, &mut event, &mut send);
            let output = curl(self.now_ns).map(|curl| {
                let mut output = HandOutput::released(Side::Right, self.now_ns);
                output.digits.iter_mut().for_each(|digit| digit.curl_at_contact = Some(curl));
                output
            });
            self.protocol.tick(self.now_ns, output.as_ref(), &mut event, &mut send);
        }
    }

    /// Samples per second of the next second.
    fn rate(&mut self) -> u64 {
        let before = self.samples;
        self.run(1.0, |_| None);
        self.samples - before
    }

    /// Time from a new stop to the servos \[s\].
    fn latency(&mut self, curl: f64) -> f64 {
        let start = self.now_ns;
        let wanted = [(1000.0 * (1.0 - curl)).round() as u16; 5];
        while self.glove.servos != wanted {
            assert!(self.now_ns - start < SECOND_NS, "{:?}, wanted {wanted:?}", self.glove.servos);
            self.run(1e-9 * STEP_NS as f64, |_| Some(curl));
        }
        (self.now_ns - start) as f64 * 1e-9
    }
}

/// A line of 24 bytes takes 2.1 ms at 115200 bit/s, the firmware's loop 1 ms, our look at the line
/// up to two steps: the glove speaks 250 times a second or more.
#[test]
fn the_glove_speaks_at_its_own_pace() {
    let mut talk = Talk::new();
    talk.run(0.1, |_| None);
    let rate = talk.rate();
    assert!((250..=330).contains(&rate), "{rate} lines in a second");
}

/// Two loops of the firmware at most: one line may lie before it.
#[test]
fn a_stop_is_told_within_two_loops() {
    let mut talk = Talk::new();
    talk.run(0.1, |_| None);
    for curl in [0.5, 0.25, 0.75, 0.1] {
        let latency = talk.latency(curl);
        assert!(latency < 10e-3, "{latency} s");
    }
    // Also while outputs change all the time.
    talk.run(2.0, |now| Some((now / STEP_NS % 100) as f64 / 100.0));
    let latency = talk.latency(0.5);
    assert!(latency < 10e-3, "{latency} s");
    assert!(talk.rate() >= 250);
}

/// Whatever was said to a glove that could not read, it soon speaks at its pace, and reads what is
/// new, not what is old.
#[test]
fn a_glove_that_was_silent_is_soon_in_step_again() {
    // Its board starts anew for two seconds while we nudge it; its port keeps what we said.
    let mut talk = Talk::new();
    let mut said = Vec::new();
    let glove = std::mem::replace(&mut talk.glove, LucidGlovesTwin::new(true, false));
    for _ in 0..8000 {
        talk.now_ns += STEP_NS;
        talk.protocol
            .tick(talk.now_ns, None, &mut |_| {}, &mut |bytes| said.extend_from_slice(bytes));
    }
    assert!(said.len() > 300, "it was nudged");
    talk.glove = glove;
    talk.wires[0] = said;
    talk.glove.power_on(talk.now_ns);
    talk.run(0.5, |_| None);
    assert!(talk.rate() >= 250);
    assert!(talk.latency(0.5) < 10e-3);
    // An answer gets lost on the way.
    for _ in 0..5 {
        talk.wires[0].clear();
        talk.run(0.004, |_| None);
    }
    talk.run(0.3, |_| None);
    assert!(talk.rate() >= 250);
    assert!(talk.latency(0.25) < 10e-3);
}

/// A release waits for nothing.
#[test]
fn a_release_is_sent_at_once() {
    let mut talk = Talk::new();
    talk.run(0.1, |_| None);
    talk.latency(0.5);
    let mut sent = Vec::new();
    let released = HandOutput::released(Side::Right, talk.now_ns);
    let mut send = |bytes: &[u8]| sent.extend_from_slice(bytes);
    talk.protocol.tick(talk.now_ns, Some(&released), &mut |_| {}, &mut send);
    assert_eq!(sent, b"A0B0C0D0E0\n");
}

/// Firmware without force feedback of its own, or with another reading of lines, never waits: it
/// gets stops all the same.
#[test]
fn a_glove_that_waits_for_no_answer_is_told_of_stops() {
    let mut talk = Talk::new();
    let (line, mut sent) = (talk.glove.line(), Vec::new());
    let mut output = HandOutput::released(Side::Right, talk.now_ns);
    output.digits[1].curl_at_contact = Some(0.5);
    for _ in 0..100 {
        talk.now_ns += 2_000_000;
        let mut send = |bytes: &[u8]| sent.extend_from_slice(bytes);
        talk.protocol.receive(talk.now_ns, line.as_bytes(), &mut |_| {}, &mut send);
        talk.protocol.tick(talk.now_ns, Some(&output), &mut |_| {}, &mut send);
    }
    let sent = String::from_utf8(sent).unwrap();
    assert!(sent.contains("A0B500C0D0E0\n"), "{sent}");
}

/// A wearer whose sensor goes from 0.2 to 0.8 of its range and is stopped at a quarter of the way:
/// at 0.35 of the servo's travel. One whose sensor is mounted the other way round, too.
#[test]
fn stops_are_in_the_wearers_own_range() {
    let mut profile: Profile = load("lucidgloves", SHIPPED, &Address::default()).unwrap();
    profile.index.raw = [0.2, 0.8];
    profile.middle.raw = [0.8, 0.2];
    let quarter = profile.stops([Some(0.25); 5]);
    assert_eq!(quarter, [750, 650, 650, 750, 750]);
    assert_eq!(profile.stops([None; 5]), [0; 5]);
    assert_eq!(profile.stops([Some(0.0); 5]), [1000, 800, 800, 1000, 1000]);
    assert_eq!(profile.stops([Some(f64::NAN); 5]), [0; 5]);
}

/// The program stops at any moment of the conversation, just after a beat; its keeper speaks in its
/// place. At the firmware's own pace all fingers are free within the 50 ms that a wearer may be
/// held on, and stay so.
#[test]
fn a_keeper_frees_the_fingers_within_fifty_milliseconds() {
    use crate::keeper::KeeperState;
    for phase in 0..40 {
        let mut talk = Talk::new();
        // Stops that move keep lines on their way.
        talk.run(2.0 + 2.5e-4 * f64::from(phase), |k| Some(0.3 + 0.2 * (k as f64 * 1e-3).sin()));
        assert!(talk.glove.servos.iter().all(|servo| *servo > 0), "{phase}");
        let stopped_ns = talk.now_ns;
        let (mut watch, mut free_ns) = (KeeperState::default(), None);
        watch.hear(stopped_ns);
        while talk.now_ns < stopped_ns + SECOND_NS {
            talk.now_ns += STEP_NS;
            let mut heard = std::mem::take(&mut talk.wires[0]);
            if watch.turn(talk.now_ns).release {
                talk.protocol.release(&mut |bytes| heard.extend_from_slice(bytes));
            }
            talk.glove.step(talk.now_ns, &heard, &mut |_| {});
            let free = talk.glove.servos == [0; 5];
            assert!(free || free_ns.is_none(), "{phase}: held again");
            free_ns = free_ns.or(free.then_some(talk.now_ns));
        }
        let late = (free_ns.unwrap() - stopped_ns) as f64 * 1e-6;
        assert!(late <= 50.0, "{phase}: {late} ms");
    }
}
