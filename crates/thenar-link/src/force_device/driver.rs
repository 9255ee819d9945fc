//! Driver that reaches bridges.

use super::ForceDevice;
use super::profile::{Profile, SHIPPED};
use crate::profile::{Address, Check, load};
use crate::transport::{UdpTransport, host_and_port};
use crate::worker::{Device, DisplayTraits, TrackerTraits};
use crate::{Driver, FoundDevice, LinkError, Opened, Rendering};
use std::net::ToSocketAddrs;

/// UDP port of a bridge unless another is given.
pub const PORT: u16 = 9020;

/// Driver of addresses `force-device:ARM@HOST:PORT`.
pub struct ForceDeviceDriver;

impl Driver for ForceDeviceDriver {
    fn name(&self) -> &'static str {
        "force-device"
    }

    fn about(&self) -> &'static str {
        "a desktop haptic arm behind a UDP bridge: force-device:touch@127.0.0.1:9020, or another \
         arm of the profile; ?side=left&profile=FILE"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        Vec::new()
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        let parsed = Address::parse(self.name(), address)?;
        let refuse = |cause: String| LinkError::Setting {
            what: format!("device `{}:{address}`", self.name()),
            cause,
        };
        let mut profile: Profile = load(self.name(), SHIPPED, &parsed)?;
        let (arm, place) = parsed.place.split_once('@').unwrap_or(("", &parsed.place));
        if !arm.is_empty() {
            profile.arm = arm.into();
            profile.check().map_err(|(_, cause)| refuse(cause))?;
        }
        let host = if place.is_empty() { "127.0.0.1" } else { place };
        let with_port = host_and_port(host, Some(PORT)).map_err(refuse)?;
        let (Some(arm), Some(setup)) = (profile.chosen(), profile.setup()) else {
            return Err(refuse(format!("`{}` is not an arm", profile.arm)));
        };
        let display = DisplayTraits {
            rendering: Rendering::Wrench,
            limits: arm.limits(),
            torque_limits: arm.torque_limits(),
            loop_profile: arm.loop_profile(),
        };
        let connect = move || -> std::io::Result<Box<dyn crate::Transport>> {
            let peer = with_port.to_socket_addrs()?.next().ok_or(std::io::ErrorKind::NotFound)?;
            Ok(Box::new(UdpTransport::connect(peer)?))
        };
        let device = Device {
            name: format!("force-device:{}", parsed.place),
            connect: Box::new(connect),
            protocol: Box::new(ForceDevice::new(setup)),
            tracks: Some(TrackerTraits {
                hand_length: Some(profile.hand.length),
                ..TrackerTraits::default()
            }),
            display: Some(display),
            speaks: true,
        };
        device.open()
    }
}
