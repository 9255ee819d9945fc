//! From the text of a device's profile to what its device would say and do.
//!
//! The fuzz target `profile` and `crates/thenar-link/tests/all/fuzz_profiles.rs` run this code.

use std::path::Path;
use std::sync::Arc;
use thenar_core::Vec3;
use thenar_core::model::Side;
use thenar_link::cyberglove::{self, Classic, ClassicTwin, Third, ThirdTwin};
use thenar_link::cybergrasp::{self, CyberGrasp};
use thenar_link::force_device::wire::State;
use thenar_link::force_device::{self, ForceDevice};
use thenar_link::lucidgloves::{self, LucidGloves, LucidGlovesTwin};
use thenar_link::profile::{Address, Check, Display, load};
use thenar_link::twin::Twin;
use thenar_link::{Event, HandOutput, LinkError, Protocol};
use thenar_track::live::{LivePose, checked};

/// Drivers with profiles, and what is shipped for them.
pub const DRIVERS: [(&str, &str); 5] = [
    ("lucidgloves", lucidgloves::SHIPPED),
    ("cyberglove", cyberglove::SHIPPED),
    ("cyberglove3", cyberglove::SHIPPED_3),
    ("cybergrasp", cybergrasp::SHIPPED),
    ("force-device", force_device::profile::SHIPPED),
];

/// A user's profile for one of the drivers, put into `file`: read, and its device plays with it.
pub fn plays(driver: usize, text: &[u8], file: &Path) -> Result<(), LinkError> {
    std::fs::write(file, text).unwrap();
    let (name, shipped) = DRIVERS[driver % DRIVERS.len()];
    match name {
        "lucidgloves" => {
            let profile: Arc<lucidgloves::Profile> = Arc::new(loaded(name, shipped, file)?);
            bounded(&profile.display);
            let stops = profile.stops([None, Some(0.0), Some(0.4), Some(1.0), Some(f64::NAN)]);
            assert!(stops.iter().all(|stop| *stop <= 1000), "{stops:?}");
            let mut twin = LucidGlovesTwin::new(false, true);
            twin.set_curls([0.2, 0.4, 0.6, 0.8, 0.3]);
            let line = twin.line();
            speaks(&mut LucidGloves::new(profile), line.as_bytes());
        }
        "cyberglove" => {
            let profile: Arc<cyberglove::Profile> = Arc::new(loaded(name, shipped, file)?);
            let mut twin = ClassicTwin::new(profile.glove.sensors);
            twin.set_curls([0.2, 0.4, 0.6, 0.8, 0.3]);
            let record = twin.record();
            speaks(&mut Classic::new(profile), &record);
        }
        "cyberglove3" => {
            let mut twin = ThirdTwin::default();
            twin.set_curls([0.2, 0.4, 0.6, 0.8, 0.3]);
            speaks(&mut Third::new(Arc::new(loaded(name, shipped, file)?)), &twin.packet(0));
        }
        "cybergrasp" => {
            let profile: cybergrasp::Profile = loaded(name, shipped, file)?;
            bounded(&profile.display);
            speaks(&mut CyberGrasp::new(None), b"TGRA\x01\0\0\0");
        }
        _ => {
            let profile: force_device::profile::Profile = loaded(name, shipped, file)?;
            let arm = profile.chosen().expect("a profile that was read names an arm");
            arm.limits().check().unwrap();
            arm.torque_limits().iter().for_each(|limits| limits.check().unwrap());
            let setup = profile.setup().expect("a profile that was read stands somewhere");
            let pose = thenar_core::Pose::translation(0.1, -0.1, 0.05);
            let state = State { seq: 1, time_ns: 1, pose, velocity: Vec3::zeros(), buttons: 1 };
            speaks(&mut ForceDevice::new(setup), &state.write());
        }
    }
    Ok(())
}

/// The profile for both hands; they differ in nothing else.
fn loaded<P: Check>(name: &str, shipped: &str, file: &Path) -> Result<P, LinkError> {
    let address = |side| Address { side, profile: Some(file.into()), ..Address::default() };
    load::<P>(name, shipped, &address(Some(Side::Left)))?;
    load(name, shipped, &address(None))
}

/// Every actuator that is read passes its guards.
fn bounded(display: &Display) {
    for unilateral in [false, true] {
        display.limits(unilateral).check().unwrap();
    }
    let rules = display.loop_profile();
    assert!(rules.period > 0.0 && rules.rated_stiffness > 0.0, "{rules:?}");
}

/// A device says this, twice, and is told what its wearer shall feel; what comes of it is a hand
/// nearby.
fn speaks(protocol: &mut dyn Protocol, bytes: &[u8]) {
    let mut event = |event| match event {
        Event::Sample(sample) => {
            if let Some(pose @ LivePose::Angles { wrist, angles }) = &sample.pose {
                assert!(wrist.is_finite() && angles.iter().all(|a| a.is_finite()), "{pose:?}");
                assert!(checked(0.0, pose).is_ok(), "{pose:?}");
            }
        }
        Event::Note(text) | Event::Refused(text) => assert!(text.len() < 400, "{text}"),
        Event::Alive => {}
    };
    let mut output = HandOutput::released(Side::Right, 1);
    output.force_W = Vec3::new(3.0, f64::NAN, -1.0);
    for digit in &mut output.digits {
        (digit.pad_force, digit.curl_at_contact) = (5.0, Some(0.5));
    }
    protocol.start(1, &mut |_| {});
    for now_ns in [2_000_000, 14_000_000] {
        protocol.receive(now_ns, bytes, &mut event, &mut |_| {});
        protocol.tick(now_ns, Some(&output), &mut event, &mut |_| {});
    }
    protocol.stop(&mut |_| {});
}
