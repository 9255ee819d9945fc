//! Passivity observer and controller (Hannaford and Ryu 2002) of one actuator.

/// Account of the energy exchanged with the wearer. A display that is passive never gives out more
/// than it took in; a sampled spring can, and then adds damping until it is even.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Passivity {
    balance: f64,
}

impl Passivity {
    /// Energy taken in minus energy given out \[J\], not above the ceiling.
    pub fn balance(&self) -> f64 {
        self.balance
    }

    /// Books the interval just past: `force` \[N\] was held for `dt` \[s\] while its point moved at
    /// the mean velocity `velocity` \[m/s\]. Exact for a zero-order hold.
    pub fn observe<const N: usize>(
        &mut self,
        force: &[f64; N],
        velocity: &[f64; N],
        dt: f64,
        ceiling: f64,
    ) {
        let power: f64 = force.iter().zip(velocity).map(|(f, v)| f * v).sum();
        self.balance = (self.balance - power * dt).min(ceiling);
    }

    /// Damping \[N s/m\] that would take a deficit back within `dt` \[s\] at this speed:
    /// `α = -E / (v² dt)`, at most `damping_max`; zero without a deficit.
    pub fn damping<const N: usize>(&self, velocity: &[f64; N], dt: f64, damping_max: f64) -> f64 {
        if self.balance >= 0.0 {
            return 0.0;
        }
        let square: f64 = velocity.iter().map(|v| v * v).sum();
        // At rest this is infinite, which the bound takes in.
        (-self.balance / (square * dt)).min(damping_max)
    }
}
