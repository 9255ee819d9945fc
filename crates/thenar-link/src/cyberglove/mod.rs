//! CyberGlove I, II and III over serial: 18 or 22 bend sensors, no place in space.

mod calibrate;
mod classic;
mod handshake;
mod profile;
mod sensors;
mod third;
mod twin;

pub use classic::Classic;
use handshake::Handshake;
pub use profile::{Glove, Profile, SHIPPED, SHIPPED_3, Sensor};
pub use sensors::{NAMES, SENSORS};
pub use third::{PACKET, Third};
pub use twin::{ClassicTwin, ThirdTwin};

use crate::calibration::Calibrate;
use crate::profile::{Address, load};
use crate::transport::{SerialTransport, serial};
use crate::worker::{Device, TrackerTraits};
use crate::{Driver, Event, FoundDevice, HandSample, LinkError, Opened, Protocol};
use std::sync::Arc;
use thenar_track::live::LivePose;

/// The hand that a glove's values make.
fn sample(profile: &Profile, now_ns: u64, values: &[f64]) -> Event {
    let (wrist, angles) = profile.pose(values);
    let pose = Some(LivePose::Angles { wrist, angles });
    Event::Sample(HandSample { side: profile.hand.side, time_ns: now_ns, pose })
}

/// `cyberglove:PORT`, CyberGlove I and II.
pub struct CyberGloveDriver;

impl Driver for CyberGloveDriver {
    fn name(&self) -> &'static str {
        "cyberglove"
    }

    fn about(&self) -> &'static str {
        "CyberGlove I and II, 18 or 22 sensors; cyberglove:/dev/ttyS0 or cyberglove:COM1"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        // RS-232 ports and adapters of any kind: nothing tells what hangs on them.
        serial::ports(|_, _, name| {
            (name == "PCI").then(|| "a serial port that may lead to a CyberGlove".into())
        })
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        open(self.name(), SHIPPED, address, |profile| Box::new(Classic::new(profile)))
    }

    fn calibrate(&self) -> Option<&dyn Calibrate> {
        Some(self)
    }
}

/// Driver of addresses `cyberglove3:PORT`.
pub struct CyberGlove3Driver;

impl Driver for CyberGlove3Driver {
    fn name(&self) -> &'static str {
        "cyberglove3"
    }

    fn about(&self) -> &'static str {
        "CyberGlove III over USB; cyberglove3:/dev/ttyUSB0 or cyberglove3:COM3"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        serial::ports(|vendor, product, _| {
            let text = "an FTDI serial adapter that may be a CyberGlove III";
            ((vendor, product) == (0x0403, 0x6001)).then(|| text.into())
        })
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        open(self.name(), SHIPPED_3, address, |profile| Box::new(Third::new(profile)))
    }

    fn calibrate(&self) -> Option<&dyn Calibrate> {
        Some(self)
    }
}

fn open(
    driver: &str,
    shipped: &str,
    address: &str,
    protocol: fn(Arc<Profile>) -> Box<dyn Protocol>,
) -> Result<Opened, LinkError> {
    let parsed = Address::parse(driver, address)?;
    open_with(driver, &parsed, load(driver, shipped, &parsed)?, protocol)
}

/// Opens a glove with this profile.
fn open_with(
    driver: &str,
    parsed: &Address,
    profile: Profile,
    protocol: fn(Arc<Profile>) -> Box<dyn Protocol>,
) -> Result<Opened, LinkError> {
    let profile = Arc::new(profile);
    let name = format!("{driver}:{}", parsed.place);
    if parsed.place.is_empty() {
        let cause = "expected a serial port".into();
        return Err(LinkError::Setting { what: format!("device `{name}`"), cause });
    }
    let (path, baud) = (parsed.place.clone(), profile.link.baud);
    let device = Device {
        name,
        connect: Box::new(move || Ok(Box::new(SerialTransport::open(&path, baud)?))),
        protocol: protocol(profile.clone()),
        tracks: Some(TrackerTraits {
            hand_length: Some(profile.hand.length),
            timing: Some(profile.tracking.timing()),
        }),
        display: None,
        speaks: true,
    };
    crate::paired::with_wrist(device.open()?, &profile.wrist, driver, parsed)
}
