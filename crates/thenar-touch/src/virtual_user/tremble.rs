//! Passivity: the hand that takes most energy out of a sampled wall trembles, one sample to, one
//! sample fro.

use crate::virtual_user::wall::on_axis;
use crate::virtual_user::{Wall, quantised};
use crate::{Proxies, ProxyError};

/// Cycles of a tremble, the first tenth of which settles.
const CYCLES: u32 = 50;

impl Wall {
    /// Energy that a hand wins in one cycle \[J\] when it trembles by `amplitude` \[m\] about an
    /// edge of the sensor's step, at even speed between samples: what the wall gives less what
    /// friction and damping of the device take. Positive means that the display is active.
    ///
    /// # Errors
    /// The proxy is refused.
    pub fn given_to_a_tremble(&self, amplitude: f64) -> Result<f64, ProxyError> {
        let (device, rest) = (&self.device, [on_axis(0.0, 0.0)]);
        let mut proxies = Proxies::new(vec![self.proxy], &rest)?;
        let middle = 2.5 * device.resolution;
        let mut ends = [-0.5, 0.5].map(|part| middle + part * amplitude);
        let mut given = 0.0;
        for half in 0..2 * CYCLES {
            let [from, to] = ends;
            let [seen, before] = [from, to].map(|x| quantised(x, device.resolution));
            let hand = on_axis(seen, (seen - before) / device.period);
            proxies.step(device.period, &[hand], &rest);
            if half >= CYCLES / 5 {
                let way = to - from;
                given += proxies.device_wrenches()[0][0].x * way;
                given -= device.friction * way.abs() + device.damping * way * way / device.period;
            }
            ends.swap(0, 1);
        }
        Ok(given / f64::from(CYCLES - CYCLES / 10))
    }

    /// True if no tremble, from 1e-5 of a sensor's step (or of a millimetre) to ten thousand of
    /// them, wins energy.
    pub fn is_passive(&self) -> bool {
        let step = if self.device.resolution > 0.0 { self.device.resolution } else { 1e-3 };
        (-5..=4).all(|power| {
            let given = self.given_to_a_tremble(step * 10.0_f64.powi(power));
            given.is_ok_and(|given| given <= 0.0)
        })
    }
}

/// The value of a parameter at which walls stop being passive, between `low` (passive) and `high`
/// (not), to one part in a thousand. None when the ends are not so.
pub fn passive_onset(low: f64, high: f64, wall: impl Fn(f64) -> Wall) -> Option<f64> {
    super::wall::onset(low, high, |value| wall(value).is_passive())
}
