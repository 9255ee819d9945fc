//! What every driver passes, together with its twin behind a real pseudo-terminal.
//!
//! Nothing here is timed more tightly than half a minute, except where a promise is a time: then
//! its violation on an idle machine is what fails, not a slow one.

#![allow(dead_code)] // each test file uses its part

use std::path::PathBuf;
use std::time::{Duration, Instant};
use thenar_core::model::Side;
use thenar_core::random::Random;
#[cfg(unix)]
use thenar_link::twin::PtyTwin;
use thenar_link::twin::Twin;
use thenar_link::{Driver, ForceDisplay, HandOutput, LinkError, Opened, Tracker, now_ns};
use thenar_track::ANGLES;
use thenar_track::live::LivePose;

/// Longest that anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(30);

/// Longest that a program takes from its start to its own code, on a busy machine.
const COPIES_LIVE: Duration = Duration::from_secs(2);

/// Calls until it gives something.
pub fn wait<T>(what: &str, mut f: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = f() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "{what} never came");
        std::thread::sleep(Duration::from_micros(300));
    }
}

/// Device at this address.
pub fn open_device(address: &str) -> Opened {
    opened_at_a_free_port(|| thenar_link::open(address))
}

/// Opens a device, and tries again while its port is busy: a program that another test starts holds
/// copies of all sockets until its own code runs, even of one just closed. That takes milliseconds;
/// a device that keeps its port for longer has not let go of it.
pub fn opened_at_a_free_port(open: impl Fn() -> Result<Opened, LinkError>) -> Opened {
    let start = Instant::now();
    loop {
        match open() {
            Err(LinkError::Open { cause, .. })
                if cause.contains("in use") && start.elapsed() < COPIES_LIVE =>
            {
                std::thread::sleep(Duration::from_millis(1));
            }
            other => return other.unwrap_or_else(|error| panic!("{error}")),
        }
    }
}

/// A twin, its driver and what is expected of the two.
pub struct Bench<'d, T: Twin + 'static> {
    pub twin: PtyTwin<T>,
    driver: &'d dyn Driver,
    expected: fn([f64; 5]) -> [f64; ANGLES],
    tolerance: f64,
    options: String,
}

impl<'d, T: Twin + 'static> Bench<'d, T> {
    /// Plugs the twin in. `name` must differ between tests.
    pub fn new(
        name: &str,
        twin: T,
        driver: &'d dyn Driver,
        expected: fn([f64; 5]) -> [f64; ANGLES],
    ) -> Self {
        let file = format!("thenar-{}-{name}-{}", driver.name(), std::process::id());
        let path: PathBuf = std::env::temp_dir().join(file);
        let twin = PtyTwin::start(twin, &path).unwrap();
        Self { twin, driver, expected, tolerance: 1e-9, options: String::new() }
    }

    /// How far the angles may be off \[rad\].
    pub fn tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// What follows the port in the address.
    pub fn options(self, options: &str) -> Self {
        Self { options: options.into(), ..self }
    }

    pub fn open(&self) -> Device {
        let address = format!("{}{}", self.twin.path().display(), self.options);
        let opened = self.driver.open(&address).unwrap();
        Device { tracker: opened.tracker.unwrap(), display: opened.display, last_ns: 0 }
    }

    /// Waits for any sample.
    pub fn sample(&self, device: &mut Device) -> [f64; ANGLES] {
        wait("a sample", || device.angles(Side::Right))
    }

    /// Waits until the wearer's curls arrive, right to the twin's resolution.
    fn follows(&self, device: &mut Device, curls: [f64; 5]) {
        self.twin.twin().set_curls(curls);
        let expected = (self.expected)(curls);
        let mut last = [f64::NAN; ANGLES];
        let start = Instant::now();
        loop {
            if let Some(angles) = device.angles(Side::Right) {
                last = angles;
                let off = |k: usize| (angles[k] - expected[k]).abs();
                if (0..ANGLES).all(|k| off(k) <= self.tolerance) {
                    return;
                }
            }
            if start.elapsed() > PATIENCE {
                panic!("{last:?}\nexpected {expected:?}\n{:?}", device.tracker.messages());
            }
            std::thread::sleep(Duration::from_micros(300));
        }
    }

    fn feels(&self, what: &str, right: impl Fn([f64; 5]) -> bool, mut meanwhile: impl FnMut()) {
        wait(what, || {
            meanwhile();
            right(self.twin.twin().felt()).then_some(())
        });
    }
}

/// An open device; checks of every sample that its time goes on.
pub struct Device {
    pub tracker: Box<dyn Tracker>,
    pub display: Option<Box<dyn ForceDisplay>>,
    last_ns: u64,
}

impl Device {
    pub fn angles(&mut self, side: Side) -> Option<[f64; ANGLES]> {
        let sample = self.tracker.latest(side)?;
        assert!(sample.time_ns > self.last_ns && sample.time_ns <= now_ns(), "time goes on");
        self.last_ns = sample.time_ns;
        match sample.pose.as_ref()? {
            LivePose::Angles { angles, wrist } => {
                assert!(wrist.is_finite() && angles.iter().all(|a| a.is_finite()));
                Some(*angles)
            }
            LivePose::Joints { .. } => None,
        }
    }

    /// Shows a contact of each finger at this curl, with as much force as it is closed.
    pub fn show(&mut self, curls: [f64; 5]) {
        let Some(display) = &mut self.display else { return };
        let mut output = HandOutput::released(Side::Right, now_ns());
        for (digit, curl) in output.digits.iter_mut().zip(curls) {
            digit.curl_at_contact = Some(curl);
            digit.pad_force = 12.0 * (1.0 - curl);
        }
        display.show(&output);
    }

    /// Told in one message that begins with the device's name.
    fn told_by_name<T: Twin + 'static>(&mut self, bench: &Bench<T>, what: &str) {
        self.told_by_name_while(bench, what, || {});
    }

    fn told_by_name_while<T: Twin + 'static>(
        &mut self,
        bench: &Bench<T>,
        what: &str,
        mut meanwhile: impl FnMut(),
    ) {
        let name = format!("{}:{}: ", bench.driver.name(), bench.twin.path().display());
        let told = wait(what, || {
            meanwhile();
            self.tracker.messages().into_iter().find(|told| told.contains(what))
        });
        assert!(told.starts_with(&name), "{told}");
    }

    pub fn told(&mut self, what: &str) -> String {
        wait(what, || self.tracker.messages().into_iter().find(|told| told.contains(what)))
    }
}

/// The suite. `bench` makes a fresh twin, plugged in, under a name of its own.
pub fn run<'d, T: Twin + 'static>(bench: impl Fn(&str) -> Bench<'d, T> + Sync) {
    // These mostly wait for two seconds of silence: all at once.
    std::thread::scope(|scope| {
        scope.spawn(|| a_device_that_answers_nothing_is_told_of(&bench("mute")));
        scope.spawn(|| a_device_at_another_speed_is_told_of(&bench("speed")));
        scope.spawn(|| a_device_that_falls_silent_is_told_of(&bench("silent")));
    });
    samples_come_out_right(&bench("samples"));
    outputs_reach_the_hand_and_leave_it(&bench("outputs"));
    a_pulled_cable_is_plugged_in_again(&bench("cable"));
    noise_moves_nothing_and_is_told(&bench("noise"));
    a_device_may_come_later(&bench("later"));
}

const POSES: [[f64; 5]; 4] =
    [[0.0; 5], [1.0; 5], [0.1, 0.3, 0.5, 0.7, 0.9], [0.9, 0.6, 0.4, 0.2, 0.0]];

fn samples_come_out_right<T: Twin + 'static>(bench: &Bench<T>) {
    let mut device = bench.open();
    POSES.into_iter().for_each(|curls| bench.follows(&mut device, curls));
    assert!(device.tracker.latest(Side::Left).is_none(), "it is a right hand's");
    assert!(device.tracker.heard_ns().is_some_and(|ns| ns <= now_ns()));
    assert!(device.tracker.hand_length().is_some_and(|length| (0.1..0.3).contains(&length)));
    // Closed and opened again.
    drop(device);
    let mut device = bench.open();
    POSES.into_iter().for_each(|curls| bench.follows(&mut device, curls));
}

fn outputs_reach_the_hand_and_leave_it<T: Twin + 'static>(bench: &Bench<T>) {
    let mut device = bench.open();
    bench.sample(&mut device);
    if device.display.is_none() {
        return;
    }
    let contact = [0.5, 0.0, 0.25, 0.75, 1.0];
    let close = |felt: [f64; 5]| {
        felt.iter().zip(contact).all(|(felt, curl)| (felt - (1.0 - curl)).abs() < 2e-3)
    };
    bench.feels("what was shown", close, || device.show(contact));
    // Silence of the caller.
    bench.feels("release after silence", |felt| felt == [0.0; 5], || {});
    bench.feels("what was shown again", close, || device.show(contact));
    // The display is dropped, the tracker goes on.
    device.display = None;
    bench.feels("release by the display's drop", |felt| felt == [0.0; 5], || {});
    bench.sample(&mut device);
    drop(device);
    // Everything is dropped at once.
    let mut device = bench.open();
    bench.feels("what was shown a third time", close, || device.show(contact));
    drop(device);
    bench.feels("release by a drop", |felt| felt == [0.0; 5], || {});
}

/// In the midst of packets, the first ones of the stream included. (At every single byte without a
/// terminal, in `tests/all/noise.rs`.)
fn a_pulled_cable_is_plugged_in_again<T: Twin + 'static>(bench: &Bench<T>) {
    let mut device = bench.open();
    bench.sample(&mut device);
    for bytes in [0, 1, 2, 5, 9, 14, 20, 23, 27, 33, 38, 44, 51, 58, 60, 61] {
        let curls = POSES[bytes % POSES.len()];
        device.show([0.5; 5]);
        bench.twin.unplug_after(bytes as u64 + 1);
        wait("the end of the cable", || (!bench.twin.is_plugged()).then_some(()));
        bench.twin.plug(false);
        // Whatever the actuators hold without us is released when the line is back.
        bench.twin.plug(true);
        bench.follows(&mut device, curls);
        bench.feels("release after a loss", |felt| felt == [0.0; 5], || {});
    }
    let told = device.tracker.messages();
    assert!(
        told.iter().any(|m| m.contains("is lost")) && told.iter().any(|m| m.contains("is back"))
    );
    assert!(told.len() <= 65, "{} messages", told.len());
}

/// Random bytes, a device at another speed (runs of few values), half packets and repeated ones:
/// refused, told, bounded, and forgotten with the next good packet.
fn noise_moves_nothing_and_is_told<T: Twin + 'static>(bench: &Bench<T>) {
    let mut device = bench.open();
    bench.follows(&mut device, POSES[2]);
    device.tracker.messages();
    let mut seed = 0x1234_5678_9abc_def0_u64;
    let mut random = move || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        seed
    };
    for round in 0..24 {
        let noise: Vec<u8> = match round % 3 {
            0 => (0..2000).map(|_| random() as u8).collect(),
            1 => (0..2000).map(|_| [0x00, 0xe0, 0xfe, 0x80, 0xff][random() as usize % 5]).collect(),
            _ => (0..2000).map(|_| b"0123456789ABCDE()&\nS:"[random() as usize % 21]).collect(),
        };
        bench.twin.add_noise(&noise);
        bench.sample(&mut device);
    }
    bench.follows(&mut device, POSES[3]);
    let told = device.tracker.messages();
    assert!(!told.is_empty() && told.len() < 60, "{told:?}");
}

/// It is opened before it is there, and says nothing at first.
fn a_device_may_come_later<T: Twin + 'static>(bench: &Bench<T>) {
    bench.twin.plug(false);
    let mut device = bench.open();
    device.told("is not there");
    assert!(device.tracker.latest(Side::Right).is_none() && device.tracker.heard_ns().is_none());
    device.show([0.5; 5]);
    bench.twin.plug(true);
    bench.follows(&mut device, POSES[1]);
    bench.feels("no late output", |felt| felt == [0.0; 5], || {});
}

/// Name and cause, and nothing but these, until it answers.
fn a_device_that_answers_nothing_is_told_of<T: Twin + 'static>(bench: &Bench<T>) {
    bench.twin.hush(true);
    let mut device = bench.open();
    device.told("is connected");
    device.told_by_name(bench, "is connected but says nothing: is it switched on");
    assert!(device.tracker.latest(Side::Right).is_none() && device.tracker.heard_ns().is_none());
    device.show([0.5; 5]);
    bench.twin.hush(false);
    bench.follows(&mut device, POSES[3]);
    device.told("speaks now");
    // What was shown into the silence is over.
    bench.feels("no late output", |felt| felt == [0.0; 5], || {});
}

/// All that comes is what a wrong speed makes of bytes.
fn a_device_at_another_speed_is_told_of<T: Twin + 'static>(bench: &Bench<T>) {
    bench.twin.hush(true);
    let mut device = bench.open();
    let (mut random, mut bytes) = (Random::new(0x0bad_5eed), 0);
    device.told_by_name_while(bench, "is connected but says nothing that makes sense", || {
        // Long runs of bits become few values, the rest is anything.
        let few = random.below(2) == 0;
        let byte = if few { [0x00, 0xe0, 0xfe, 0x80, 0xff][bytes % 5] } else { 0xff };
        bench.twin.add_noise(&[byte, random.bits() as u8]);
        bytes += 2;
    });
    assert!(bytes > 20 && device.tracker.latest(Side::Right).is_none(), "no pose of {bytes} bytes");
    bench.twin.hush(false);
    bench.follows(&mut device, POSES[2]);
}

/// In the midst of a session.
fn a_device_that_falls_silent_is_told_of<T: Twin + 'static>(bench: &Bench<T>) {
    let mut device = bench.open();
    bench.follows(&mut device, POSES[2]);
    bench.twin.hush(true);
    device.told_by_name(bench, "has fallen silent");
    let heard = device.tracker.heard_ns();
    device.show([0.5; 5]);
    bench.twin.hush(false);
    bench.follows(&mut device, POSES[3]);
    device.told("speaks again");
    assert!(device.tracker.heard_ns() > heard);
}
