//! Goal: what the thread promises, with a transport and a protocol that do just what a test says.

use super::*;
use crate::{Event, ForceDisplay, HandOutput, HandSample, Tracker, now_ns};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use thenar_core::Pose;
use thenar_core::Vec3;
use thenar_track::ANGLES;
use thenar_track::live::LivePose;

/// Longest that anything may take on a busy machine before a test gives up.
const PATIENCE: Duration = Duration::from_secs(20);

/// Bytes that the device says; dropping the sender unplugs it.
type Plug = Sender<Vec<u8>>;

/// Ends of a cable: what the device will say, and who hears what is sent to it.
type Socket = (Receiver<Vec<u8>>, Sender<Vec<u8>>);

/// A device whose cable a test holds.
struct Bench {
    plugs: Sender<Option<Socket>>,
}

impl Bench {
    fn open() -> (Self, Opened) {
        let (plugs, sockets) = channel();
        let device = Device {
            name: "bench:1".into(),
            connect: Box::new(move || match sockets.try_recv() {
                Ok(Some((from, to))) => Ok(Box::new(Cable { from, to })),
                Ok(None) => Err(io::Error::from(io::ErrorKind::PermissionDenied)),
                Err(_) => Err(io::Error::from(io::ErrorKind::NotFound)),
            }),
            protocol: Box::new(Bytewise),
            tracks: Some(TrackerTraits::default()),
            display: Some(DisplayTraits {
                rendering: Rendering::Tendons,
                // At once: the door has tests of its own.
                limits: Limits { slew: 1e6, step_max: 12.0, ..Limits::rated(24.0) },
                torque_limits: None,
                loop_profile: crate::null::loop_profile(),
            }),
            speaks: true,
        };
        (Self { plugs }, device.open().unwrap())
    }

    fn plug_in(&self) -> (Plug, Receiver<Vec<u8>>) {
        let (plug, from) = channel();
        let (to, heard) = channel();
        self.plugs.send(Some((from, to))).unwrap();
        (plug, heard)
    }
}

struct Cable {
    from: Receiver<Vec<u8>>,
    to: Sender<Vec<u8>>,
}

impl Transport for Cable {
    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        match self.from.recv_timeout(timeout) {
            Ok(bytes) => {
                buffer[..bytes.len()].copy_from_slice(&bytes);
                Ok(bytes.len())
            }
            Err(RecvTimeoutError::Timeout) => Ok(0),
            Err(RecvTimeoutError::Disconnected) => Err(io::ErrorKind::UnexpectedEof.into()),
        }
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.to.send(bytes.to_vec()).map_err(|_| io::ErrorKind::BrokenPipe.into())
    }
}

/// Each byte is a sample of the right hand, whose wrist is that number of centimetres to the right,
/// at once; 255 is not a number, 254 a panic, 253 a sample from the past.
struct Bytewise;

impl Protocol for Bytewise {
    fn start(&mut self, _: u64, send: &mut dyn FnMut(&[u8])) {
        send(b"start");
    }

    fn receive(
        &mut self,
        now: u64,
        bytes: &[u8],
        event: &mut dyn FnMut(Event),
        _: &mut dyn FnMut(&[u8]),
    ) {
        for byte in bytes {
            let x = match byte {
                254 => panic!("as the test wants it"),
                255 => f64::NAN,
                _ => f64::from(*byte) / 100.0,
            };
            let time_ns = if *byte == 253 { 5 } else { now };
            let wrist = Pose::translation(x, 0.0, 0.0);
            let pose = Some(LivePose::Angles { wrist, angles: [0.0; ANGLES] });
            event(Event::Sample(HandSample { side: Side::Right, time_ns, pose }));
        }
    }

    fn tick(
        &mut self,
        _: u64,
        output: Option<&HandOutput>,
        _: &mut dyn FnMut(Event),
        send: &mut dyn FnMut(&[u8]),
    ) {
        if let Some(output) = output {
            send(format!("{:?} {}", output.side, output.force_W.x).as_bytes());
        }
    }

    fn stop(&mut self, send: &mut dyn FnMut(&[u8])) {
        send(b"stop");
    }
}

fn heard(from: &Receiver<Vec<u8>>) -> String {
    String::from_utf8(from.recv_timeout(PATIENCE).expect("the device hears nothing")).unwrap()
}

/// Calls until it gives something.
fn wait<T>(mut f: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = f() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "nothing came");
        std::thread::sleep(Duration::from_micros(100));
    }
}

fn next_x(tracker: &mut Box<dyn Tracker>) -> f64 {
    wait(|| match tracker.latest(Side::Right)?.pose.as_ref()? {
        LivePose::Angles { wrist, .. } => Some(wrist.position.x),
        LivePose::Joints { .. } => None,
    })
}

fn message(tracker: &mut Box<dyn Tracker>) -> String {
    wait(|| tracker.messages().into_iter().next())
}

fn force(side: Side, x: f64) -> HandOutput {
    HandOutput { force_W: Vec3::x() * x, ..HandOutput::released(side, now_ns()) }
}

fn both(opened: Opened) -> (Box<dyn Tracker>, Box<dyn ForceDisplay>) {
    (opened.tracker.unwrap(), opened.display.unwrap())
}

#[test]
fn the_newest_sample_is_seen_once() {
    let (bench, opened) = Bench::open();
    let (mut tracker, _display) = both(opened);
    let (plug, _heard) = bench.plug_in();
    assert!(tracker.latest(Side::Right).is_none());
    for k in [10, 20, 30] {
        plug.send(vec![k]).unwrap();
        assert_eq!(next_x(&mut tracker), f64::from(k) / 100.0);
        assert!(tracker.latest(Side::Right).is_none() && tracker.latest(Side::Left).is_none());
        assert!(tracker.heard_ns().is_some_and(|ns| ns <= now_ns()));
    }
}

/// Neither a sample from the past nor one that is not a number reaches a caller; the latter is
/// reported.
#[test]
fn what_makes_no_sense_is_kept_back() {
    let (bench, opened) = Bench::open();
    let (mut tracker, _display) = both(opened);
    let (plug, _heard) = bench.plug_in();
    plug.send(vec![1]).unwrap();
    assert_eq!(next_x(&mut tracker), 0.01);
    tracker.messages();
    for bad in [253, 255] {
        plug.send(vec![bad]).unwrap();
    }
    assert_eq!(message(&mut tracker), "bench:1: a pose is refused: wrist is not a finite number");
    assert!(tracker.latest(Side::Right).is_none());
}

#[test]
fn silence_releases_each_hand() {
    let (bench, opened) = Bench::open();
    let (_tracker, mut display) = both(opened);
    let (_plug, heard_by_device) = bench.plug_in();
    assert_eq!(heard(&heard_by_device), "start");
    // An output before the device was there is not shown late: nothing else was said until now.
    let shown = Instant::now();
    display.show(&force(Side::Left, 2.0));
    assert_eq!(heard(&heard_by_device), "Left 2");
    assert_eq!(heard(&heard_by_device), "Left 0");
    assert!(shown.elapsed() > Duration::from_millis(19), "{:?}", shown.elapsed());
    display.show(&force(Side::Right, 3.0));
    assert_eq!(heard(&heard_by_device), "Right 3");
    assert_eq!(heard(&heard_by_device), "Right 0");
    assert!(heard_by_device.recv_timeout(Duration::from_millis(50)).is_err(), "told once");
}

#[test]
fn dropping_the_display_releases_and_dropping_both_closes() {
    let (bench, opened) = Bench::open();
    let (mut tracker, mut display) = both(opened);
    let (plug, heard_by_device) = bench.plug_in();
    assert_eq!(heard(&heard_by_device), "start");
    display.show(&force(Side::Right, 3.0));
    assert_eq!(heard(&heard_by_device), "Right 3");
    drop(display);
    assert_eq!(heard(&heard_by_device), "Right 0");
    plug.send(vec![7]).unwrap();
    assert_eq!(next_x(&mut tracker), 0.07);
    drop(tracker);
    assert_eq!(heard(&heard_by_device), "stop");
    assert!(heard_by_device.recv().is_err(), "the cable is let go");
}

#[test]
fn a_device_that_returns_is_taken_up_and_each_change_is_told_once() {
    let (bench, opened) = Bench::open();
    let (mut tracker, mut display) = both(opened);
    assert!(message(&mut tracker).starts_with("bench:1: is not there (entity not found)"));
    for round in 0..3 {
        display.show(&force(Side::Right, 9.0));
        let (plug, heard_by_device) = bench.plug_in();
        let expected = if round == 0 { "bench:1: is connected" } else { "bench:1: is back" };
        assert_eq!(message(&mut tracker), expected);
        assert_eq!(heard(&heard_by_device), "start");
        plug.send(vec![round]).unwrap();
        assert_eq!(next_x(&mut tracker), f64::from(round) / 100.0);
        drop(plug);
        // The last words are tried, and the output from before the loss never came.
        assert_eq!(heard(&heard_by_device), "stop");
        assert!(message(&mut tracker).starts_with("bench:1: is lost (unexpected end of file)"));
        std::thread::sleep(Duration::from_millis(120));
        assert!(tracker.messages().is_empty(), "told once");
    }
    bench.plugs.send(None).unwrap();
    assert!(message(&mut tracker).starts_with("bench:1: is not there (permission denied)"));
}

#[test]
fn a_panic_in_a_protocol_releases_the_hand() {
    let (bench, opened) = Bench::open();
    let (mut tracker, mut display) = both(opened);
    let (plug, heard_by_device) = bench.plug_in();
    assert_eq!(heard(&heard_by_device), "start");
    display.show(&force(Side::Right, 3.0));
    assert_eq!(heard(&heard_by_device), "Right 3");
    plug.send(vec![254]).unwrap();
    // Whether or not the silence was noticed before.
    while heard(&heard_by_device) != "stop" {}
    wait(|| tracker.messages().into_iter().find(|told| told.contains("internal error")));
}
