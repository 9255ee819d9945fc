//! Driver that reaches the player.

use super::{Bhaptics, IntensityMap, PATH, PORT};
use crate::transport::{WebSocketTransport, websocket};
use crate::worker::{Device, DisplayTraits};
use crate::{Driver, FoundDevice, LinkError, Opened, Rendering};
use thenar_touch::safety::Limits;

/// `bhaptics:` and `bhaptics:HOST:PORT`.
pub struct BhapticsDriver;

impl Driver for BhapticsDriver {
    fn name(&self) -> &'static str {
        "bhaptics"
    }

    fn about(&self) -> &'static str {
        "bHaptics gloves that vibrate, through the maker's player: bhaptics:127.0.0.1:15881"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        Vec::new()
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        let place = if address.is_empty() { format!("127.0.0.1:{PORT}") } else { address.into() };
        let url = format!("ws://{place}{PATH}");
        websocket::authority(&url).map_err(|_| LinkError::Setting {
            what: format!("device `bhaptics:{address}`"),
            cause: "expected nothing or HOST:PORT".into(),
        })?;
        let feel = IntensityMap::default();
        // Intensities come from forces; the player answers when it likes, which is no silence.
        let limits = Limits {
            user_fraction: 1.0,
            unilateral: true,
            device_silence_max: 3600.0,
            ..Limits::rated(feel.force_full)
        };
        let device = Device {
            name: format!("bhaptics:{address}"),
            connect: Box::new(move || Ok(Box::new(WebSocketTransport::call(&url)?))),
            protocol: Box::new(Bhaptics::new(feel)),
            tracks: None,
            display: Some(DisplayTraits {
                rendering: Rendering::Vibration,
                limits,
                torque_limits: None,
                loop_profile: crate::null::loop_profile(),
            }),
            speaks: false,
        };
        device.open()
    }
}
