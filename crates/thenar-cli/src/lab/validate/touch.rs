//! Touch: the real coupling and safety code in the loop with a device and a finger that do not
//! exist. No scene and no solver takes part.

mod device;
mod two_stage;
mod wall;

use super::case::{Case, CaseError, case};
use thenar_touch::ProxyError;
use thenar_touch::virtual_user::Device;

/// The cases.
pub const CASES: &[Case] = &[
    case("E1", "a sampled wall: passive and stable limits", wall::limits),
    case("E2", "two couplings, one after the other", two_stage::stiffness),
    case("E3", "a wall felt through a proxy gives no energy", wall::forced),
    case("E4", "CyberGrasp: what leaves the guard", device::cybergrasp),
    case("E8", "a coarse sensor against friction", wall::quantised),
];

/// Finger and device of 0.1 kg and 1 N s/m at 1 kHz.
const DEVICE: Device = Device {
    mass: 0.1,
    damping: 1.0,
    friction: 0.0,
    resolution: 0.0,
    delay_ticks: 0,
    period: 1e-3,
};

fn setup(device: &Device) -> String {
    let delay = if device.delay_ticks > 0 { ", 1 tick late" } else { "" };
    format!("T = {} ms{delay}", device.period * 1e3)
}

fn refused(error: ProxyError) -> CaseError {
    CaseError::Missing(error.to_string())
}
