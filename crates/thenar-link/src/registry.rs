//! All drivers, and addresses as a person writes them: `name:address`.

use crate::bhaptics::BhapticsDriver;
use crate::failover::FailoverDriver;
use crate::fault::FaultInjectionDriver;
use crate::force_device::ForceDeviceDriver;
use crate::hand_tracking_streamer::HandTrackingStreamerDriver;
use crate::pose_stream::PoseStreamDriver;
use crate::replay::ReplayDriver;
use crate::{Driver, LinkError, Opened, cyberglove, cybergrasp, lucidgloves, nesting, null};

/// All drivers.
pub fn drivers() -> Vec<Box<dyn Driver>> {
    vec![
        Box::new(null::NullDriver),
        Box::new(lucidgloves::LucidGlovesDriver),
        Box::new(cyberglove::CyberGloveDriver),
        Box::new(cyberglove::CyberGlove3Driver),
        Box::new(cybergrasp::CyberGraspDriver),
        Box::new(HandTrackingStreamerDriver),
        Box::new(PoseStreamDriver),
        Box::new(ReplayDriver),
        Box::new(ForceDeviceDriver),
        Box::new(BhapticsDriver),
        Box::new(FailoverDriver),
        Box::new(FaultInjectionDriver),
        #[cfg(feature = "openxr")]
        Box::new(crate::openxr::OpenXrDriver),
    ]
}

/// Opens `name:address`, such as `lucidgloves:/dev/ttyUSB0`.
///
/// # Errors
/// There is no such driver, it cannot open the address, or the address names too many devices one
/// inside another (`nesting`).
pub fn open(address: &str) -> Result<Opened, LinkError> {
    let _nested = nesting::enter(address)?;
    let (name, rest) = address.split_once(':').unwrap_or((address, ""));
    let drivers = drivers();
    match drivers.iter().find(|driver| driver.name() == name) {
        Some(driver) => driver.open(rest),
        None => {
            let known: Vec<_> = drivers.iter().map(|driver| driver.name()).collect();
            let cause = format!("no driver has that name; there are {}", known.join(", "));
            Err(LinkError::Setting { what: format!("device `{address}`"), cause })
        }
    }
}
