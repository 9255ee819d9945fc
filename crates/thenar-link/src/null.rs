//! A device that is always there: a hand held still, and a display that shows nothing.

use crate::worker::{Device, DisplayTraits, TrackerTraits};
use crate::{
    Driver, Event, FoundDevice, HandOutput, HandSample, LinkError, Opened, Protocol, Rendering,
    Transport,
};
use std::io;
use std::time::Duration;
use thenar_core::Pose;
use thenar_core::model::Side;
use thenar_touch::LoopProfile;
use thenar_touch::safety::Limits;
use thenar_track::ANGLES;
use thenar_track::live::LivePose;

/// Between samples \[ns\].
const PERIOD_NS: u64 = 10_000_000;

/// `null:left` and `null:right`.
pub struct NullDriver;

impl Driver for NullDriver {
    fn name(&self) -> &'static str {
        "null"
    }

    fn about(&self) -> &'static str {
        "no device: a hand held still at 100 Hz, forces that nobody feels; null:left or null:right"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        Vec::new()
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        let side = match address {
            "left" => Side::Left,
            "right" | "" => Side::Right,
            _ => {
                let what = format!("device `null:{address}`");
                return Err(LinkError::Setting {
                    what,
                    cause: "expected `left` or `right`".into(),
                });
            }
        };
        let limits = Limits { unilateral: true, ..Limits::rated(10.0) };
        let device = Device {
            name: format!("null:{address}"),
            connect: Box::new(|| Ok(Box::new(NullTransport))),
            protocol: Box::new(NullProtocol { side, next_ns: 0 }),
            tracks: Some(TrackerTraits::default()),
            display: Some(DisplayTraits {
                rendering: Rendering::Tendons,
                limits,
                torque_limits: None,
                loop_profile: loop_profile(),
            }),
            speaks: true,
        };
        device.open()
    }
}

/// A mechanism that nothing moves: no rule bounds a coupling to it.
pub(crate) fn loop_profile() -> LoopProfile {
    LoopProfile {
        period: 1e-3,
        delay: 0.0,
        damping: f64::INFINITY,
        friction: 0.0,
        resolution: 0.0,
        rated_stiffness: f64::INFINITY,
    }
}

/// Carries nothing.
struct NullTransport;

impl Transport for NullTransport {
    fn receive(&mut self, _: &mut [u8], timeout: Duration) -> io::Result<usize> {
        std::thread::sleep(timeout);
        Ok(0)
    }

    fn send(&mut self, _: &[u8]) -> io::Result<()> {
        Ok(())
    }
}

/// Says nothing.
struct NullProtocol {
    side: Side,
    next_ns: u64,
}

impl Protocol for NullProtocol {
    fn start(&mut self, _: u64, _: &mut dyn FnMut(&[u8])) {}

    fn receive(&mut self, _: u64, _: &[u8], _: &mut dyn FnMut(Event), _: &mut dyn FnMut(&[u8])) {}

    fn tick(
        &mut self,
        now_ns: u64,
        _: Option<&HandOutput>,
        event: &mut dyn FnMut(Event),
        _: &mut dyn FnMut(&[u8]),
    ) {
        if now_ns >= self.next_ns {
            self.next_ns = now_ns + PERIOD_NS;
            let pose = LivePose::Angles { wrist: Pose::identity(), angles: [0.0; ANGLES] };
            event(Event::Sample(HandSample { side: self.side, time_ns: now_ns, pose: Some(pose) }));
        }
    }

    fn stop(&mut self, _: &mut dyn FnMut(&[u8])) {}
}

#[cfg(test)]
mod tests {
    use crate::now_ns;
    use std::time::{Duration, Instant};
    use thenar_core::model::Side;

    #[test]
    fn the_null_hand_holds_still_and_feels_nothing() {
        let mut opened = crate::open("null:left").unwrap();
        let tracker = opened.tracker.as_mut().unwrap();
        let (start, mut last) = (Instant::now(), 0);
        for _ in 0..3 {
            let time = loop {
                assert!(start.elapsed() < Duration::from_secs(20));
                if let Some(sample) = tracker.latest(Side::Left) {
                    break sample.time_ns;
                }
                std::thread::sleep(Duration::from_micros(200));
            };
            assert!(last < time && time <= now_ns());
            last = time;
        }
        assert!(tracker.latest(Side::Right).is_none());
        assert_eq!(opened.display.unwrap().rendering(), crate::Rendering::Tendons);
    }

    #[test]
    fn addresses_are_read_strictly() {
        let told = |address| crate::open(address).map(|_| ()).unwrap_err().to_string();
        assert_eq!(told("null:up"), "device `null:up`: expected `left` or `right`");
        assert!(told("nul").starts_with("device `nul`: no driver has that name; there are null"));
        assert!(told("").contains("no driver"));
    }
}
