//! A wall felt through a proxy: does the device come to rest, or does it oscillate?

use crate::virtual_user::{Device, VirtualUser};
use crate::{Proxies, Proxy, RigidState};
use thenar_core::math::{Mat3, Pose, Vec3};
use thenar_core::model::Drive;

/// A virtual user pushed into a bone that cannot move: a wall that pulls as well as it pushes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// The device.
    pub device: Device,
    /// The proxy with its two couplings. A very heavy one stands still, which makes the device
    /// coupling a plain sampled spring and damper.
    pub proxy: Proxy,
}

/// On the axis of the experiment.
pub(super) fn on_axis(position: f64, velocity: f64) -> RigidState {
    RigidState {
        velocity_W: Vec3::x() * velocity,
        ..RigidState::at_rest(Pose::translation(position, 0.0, 0.0))
    }
}

impl Wall {
    /// A proxy that stands still: the device coupling alone, a plain sampled spring \[N/m\] and
    /// damper \[N s/m\].
    pub fn plain_proxy(stiffness: f64, damping: f64) -> Proxy {
        let drive = |stiffness: f64, damping: f64| Drive {
            stiffness,
            damping,
            angular_stiffness: 0.0,
            angular_damping: 0.0,
        };
        Proxy {
            mass: 1e12,
            inertia_B: Mat3::identity(),
            device: drive(stiffness, damping),
            bone: drive(0.0, 0.0),
        }
    }

    /// Lets go one millimetre from equilibrium and looks whether the swing dies: whether its
    /// largest excursion in the last tenth of `seconds` is smaller than in the fifth tenth. A proxy
    /// that is refused, or motion that is not finite, counts as unstable.
    ///
    /// Near the onset the swing changes at about (excess of damping) / (2 m) per second: a longer
    /// time resolves it more finely.
    pub fn is_stable(&self, seconds: f64) -> bool {
        let Ok(mut proxies) = Proxies::new(vec![self.proxy], &[on_axis(0.0, 0.0)]) else {
            return false;
        };
        let mut user = VirtualUser::new(self.device, 1e-3);
        let wall = [on_axis(0.0, 0.0)];
        let tenth = (0.1 * seconds / self.device.period) as u64;
        let mut largest = [0.0_f64; 10];
        for swing in &mut largest {
            for _ in 0..tenth {
                let hand = on_axis(user.measured_position(), user.measured_velocity());
                proxies.step(self.device.period, &[hand], &wall);
                user.advance(proxies.device_wrenches()[0][0].x, 0.0);
                *swing = swing.max(user.position().abs());
            }
            // A metre: it has left. Written so that NaN has, too.
            if swing.is_nan() || *swing > 1.0 {
                return false;
            }
        }
        largest[9] < largest[4] || largest[9] < 1e-12
    }
}

/// The value of a parameter at which walls stop being stable, between `low` (stable) and `high`
/// (not), to one part in a thousand. None when the ends are not so.
pub fn stability_onset(
    low: f64,
    high: f64,
    seconds: f64,
    wall: impl Fn(f64) -> Wall,
) -> Option<f64> {
    onset(low, high, |value| wall(value).is_stable(seconds))
}

/// Finds where a property is lost between `low` and `high`, to one part in a thousand.
pub(super) fn onset(low: f64, high: f64, holds: impl Fn(f64) -> bool) -> Option<f64> {
    if !holds(low) || holds(high) {
        return None;
    }
    let (mut low, mut high) = (low, high);
    while high - low > 1e-3 * high.abs() {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}
