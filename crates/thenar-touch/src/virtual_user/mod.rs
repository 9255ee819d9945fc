//! A finger and a device that do not exist, to close the loop without hardware: tests and
//! `thenar validate` put the real coupling code between them.
//!
//! ```text
//!   finger push ──► mass, damping, Coulomb friction ──► position, measured in steps of Δ
//!                        ▲                                      │ sampled every T
//!                   held for T ◄── delay of d ticks ◄── force ◄─┘ (the code under test)
//! ```
//!
//! Motion between two samples is exact for the held force, friction included, so whatever is
//! unstable or active is so because of sampling, delay and quantisation, and not by integration.

mod eigenvalues;
mod forced;
#[cfg(test)]
mod tests;
mod tremble;
mod wall;

pub use eigenvalues::predicted_onset;
pub use forced::{CycleEnergy, forced_wall};
pub use tremble::passive_onset;
pub use wall::{Wall, stability_onset};

/// One axis of a device with the finger in it: constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Device {
    /// Moving mass, finger included \[kg\].
    pub mass: f64,
    /// Viscous damping, finger included \[N s/m\].
    pub damping: f64,
    /// Coulomb friction \[N\].
    pub friction: f64,
    /// Position resolution \[m\]; zero measures exactly.
    pub resolution: f64,
    /// Ticks from a command to its force, beyond the hold.
    pub delay_ticks: usize,
    /// Sampling period \[s\].
    pub period: f64,
}

/// A device in motion.
#[derive(Clone, Debug)]
pub struct VirtualUser {
    device: Device,
    position: f64,
    velocity: f64,
    measured: [f64; 2],
    commands: Vec<f64>,
    tick: usize,
    given: f64,
}

impl VirtualUser {
    /// At rest at `position` \[m\].
    pub fn new(device: Device, position: f64) -> Self {
        let measured = quantised(position, device.resolution);
        Self {
            device,
            position,
            velocity: 0.0,
            measured: [measured; 2],
            commands: vec![0.0; device.delay_ticks],
            tick: 0,
            given: 0.0,
        }
    }

    /// True position \[m\].
    pub fn position(&self) -> f64 {
        self.position
    }

    /// True velocity \[m/s\].
    pub fn velocity(&self) -> f64 {
        self.velocity
    }

    /// Position as its sensor says \[m\].
    pub fn measured_position(&self) -> f64 {
        self.measured[0]
    }

    /// Difference of the last two measured positions over the period \[m/s\].
    pub fn measured_velocity(&self) -> f64 {
        (self.measured[0] - self.measured[1]) / self.device.period
    }

    /// Energy given by the commanded force so far \[J\].
    pub fn energy_given(&self) -> f64 {
        self.given
    }

    /// One period: `command` \[N\] enters the delay line, what leaves it is held; `push` \[N\]
    /// is the finger's own.
    pub fn advance(&mut self, command: f64, push: f64) {
        let force = match self.device.delay_ticks {
            0 => command,
            delay => std::mem::replace(&mut self.commands[self.tick % delay], command),
        };
        self.tick += 1;
        let before = self.position;
        self.fly(force + push);
        self.given += force * (self.position - before);
        self.measured = [quantised(self.position, self.device.resolution), self.measured[0]];
    }

    /// Moves for one period under a constant force, from one stop or reversal to the next.
    fn fly(&mut self, force: f64) {
        let Device { friction, period, .. } = self.device;
        let mut left = period;
        // Under a constant force a body reverses once at most.
        for _ in 0..3 {
            let way = if self.velocity != 0.0 { self.velocity } else { force };
            if self.velocity == 0.0 && force.abs() <= friction {
                return; // sticks
            }
            let net = force - friction.copysign(way);
            let time = self.time_to_stop(net).min(left);
            self.glide(net, time);
            left -= time;
            if left <= 0.0 {
                return;
            }
            self.velocity = 0.0;
        }
    }

    /// Returns the time until this net force stops the motion \[s\]; infinite when never.
    fn time_to_stop(&self, net: f64) -> f64 {
        let Device { mass, damping, .. } = self.device;
        if self.velocity * net >= 0.0 {
            return f64::INFINITY; // starting, speeding up, or only damped
        }
        if damping == 0.0 {
            return -self.velocity * mass / net;
        }
        mass / damping * (1.0 - self.velocity * damping / net).ln()
    }

    /// `m v' + b v = net` for `time`.
    fn glide(&mut self, net: f64, time: f64) {
        let Device { mass, damping, .. } = self.device;
        if damping == 0.0 {
            self.position += time * (self.velocity + 0.5 * time * net / mass);
            self.velocity += time * net / mass;
            return;
        }
        let (end, lag) = (net / damping, mass / damping);
        let decay = (-time / lag).exp();
        self.position += end * time + (self.velocity - end) * lag * (1.0 - decay);
        self.velocity = end + (self.velocity - end) * decay;
    }
}

/// The nearest step of a sensor.
pub(crate) fn quantised(position: f64, resolution: f64) -> f64 {
    if resolution > 0.0 { (position / resolution).round() * resolution } else { position }
}
