//! LucidGloves and other gloves that speak OpenGloves' encodings: curl and splay in, stops out,
//! over USB or Bluetooth serial, or over Wi-Fi, where the glove calls us.

mod calibrate;
pub mod encoding;
pub mod profile;
mod protocol;
#[cfg(test)]
mod tests;
mod twin;

pub use profile::{Profile, SHIPPED};
pub use protocol::LucidGloves;
pub use twin::{FORCE_FEEDBACK_WAIT_NS, LucidGlovesTwin};

use crate::calibration::Calibrate;
use crate::profile::{Address, load};
use crate::transport::{SerialTransport, TcpServer, serial};
use crate::worker::{Connect, Device, DisplayTraits, TrackerTraits};
use crate::{Driver, FoundDevice, LinkError, Opened, Rendering};
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;

/// TCP port that a glove calls over Wi-Fi.
pub const WIFI_PORT: u16 = 65432;

/// `lucidgloves:PORT` and `lucidgloves:wifi`.
pub struct LucidGlovesDriver;

impl Driver for LucidGlovesDriver {
    fn name(&self) -> &'static str {
        "lucidgloves"
    }

    fn about(&self) -> &'static str {
        "LucidGloves and OpenGloves-compatible gloves: fingers in, movement stops out; \
         lucidgloves:/dev/ttyUSB0, lucidgloves:COM3 or lucidgloves:wifi?from=IP"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        // The boards have no name of their own: these are the USB chips they come with.
        serial::ports(|vendor, product, name| {
            let chip = match (vendor, product) {
                (0x10c4, 0xea60) => "CP210x",
                (0x1a86, _) => "CH340",
                (0x303a, _) => "ESP32",
                (0x2341 | 0x2a03, _) => "Arduino",
                _ if name == "Bluetooth" => "Bluetooth serial",
                _ => return None,
            };
            Some(format!("a microcontroller ({chip}) that may be a LucidGlove"))
        })
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        let parsed = Address::parse(self.name(), address)?;
        open_with(&parsed, load(self.name(), SHIPPED, &parsed)?)
    }

    fn calibrate(&self) -> Option<&dyn Calibrate> {
        Some(self)
    }
}

/// Opens a glove with this profile.
fn open_with(parsed: &Address, profile: Profile) -> Result<Opened, LinkError> {
    let name = format!("lucidgloves:{}", parsed.place);
    let connect = connect(&name, &parsed.place, parsed.from, profile.link.baud)?;
    let profile = Arc::new(profile);
    let display = DisplayTraits {
        rendering: Rendering::Stops,
        limits: profile.display.limits(true),
        torque_limits: None,
        loop_profile: profile.display.loop_profile(),
    };
    let device = Device {
        name,
        connect,
        protocol: Box::new(LucidGloves::new(profile.clone())),
        tracks: Some(TrackerTraits {
            hand_length: Some(profile.hand.length),
            timing: Some(profile.tracking.timing()),
        }),
        display: Some(display),
        speaks: true,
    };
    crate::paired::with_wrist(device.open()?, &profile.wrist, "lucidgloves", parsed)
}

fn connect(name: &str, place: &str, from: Option<IpAddr>, baud: u32) -> Result<Connect, LinkError> {
    let refuse = |cause: String| LinkError::Setting { what: format!("device `{name}`"), cause };
    if place.is_empty() {
        return Err(refuse("expected a serial port or `wifi`".into()));
    }
    let Some(port) = place.strip_prefix("wifi") else {
        let path = place.to_string();
        return Ok(Box::new(move || Ok(Box::new(SerialTransport::open(&path, baud)?))));
    };
    let port = match port.strip_prefix(':') {
        None if port.is_empty() => WIFI_PORT,
        Some(port) => port.parse().map_err(|_| refuse(format!("`{port}` is not a port number")))?,
        None => return Err(refuse("expected `wifi` or `wifi:PORT`".into())),
    };
    let at = (Ipv4Addr::UNSPECIFIED, port).into();
    let server = TcpServer::listen(at, from).map_err(|error| LinkError::Open {
        device: name.into(),
        cause: format!("cannot listen on port {port}: {error}"),
    })?;
    // A glove that returns calls from where it was; nobody else takes its hand over.
    let server = server.faithful();
    Ok(Box::new(move || Ok(Box::new(server.accept()?))))
}
