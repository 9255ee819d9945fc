//! A handle that is moved to and fro against a wall felt through a proxy: who gives energy to whom?

use crate::virtual_user::wall::on_axis;
use crate::{Proxies, Proxy, ProxyError};

/// Energies over a whole number of cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleEnergy {
    /// Given to the hand on balance \[J\]; negative when the wall swallowed some.
    pub given: f64,
    /// The most that the hand had put in at any time \[J\].
    pub stored_max: f64,
    /// The largest force \[N\].
    pub force_max: f64,
}

/// Moves the handle as `amplitude sin(2π f t)` \[m, Hz\] for `cycles`, sampled every `period`
/// \[s\]. The simulated bone follows its proxy freely below zero and is blocked at zero. The force
/// is held between samples, and its work on the true motion is booked.
pub fn forced_wall(
    proxy: Proxy,
    amplitude: f64,
    frequency: f64,
    cycles: u32,
    period: f64,
) -> Result<CycleEnergy, ProxyError> {
    let omega = std::f64::consts::TAU * frequency;
    let place = |k: u64| amplitude * (omega * period * k as f64).sin();
    let mut proxies = Proxies::new(vec![proxy], &[on_axis(0.0, amplitude * omega)])?;
    let ticks = (f64::from(cycles) / (frequency * period)).round() as u64;
    let mut total = CycleEnergy { given: 0.0, stored_max: 0.0, force_max: 0.0 };
    let mut before = place(0);
    for k in 0..ticks {
        let x = place(k);
        let hand = on_axis(x, (x - before) / period);
        let follower = proxies.states()[0];
        let bone = if follower.pose_WB.position.x < 0.0 { follower } else { on_axis(0.0, 0.0) };
        proxies.step(period, &[hand], &[bone]);
        let force = proxies.device_wrenches()[0][0].x;
        total.given += force * (place(k + 1) - x);
        total.stored_max = total.stored_max.max(-total.given);
        total.force_max = total.force_max.max(force.abs());
        before = x;
    }
    Ok(total)
}
