//! Why force stopped, with the numbers.

/// Why all force stopped until the user arms again.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error, serde::Serialize, serde::Deserialize)]
pub enum Trip {
    /// A number that came in was not finite.
    #[error("{0} was not a finite number")]
    NotFinite(Quantity),
    /// The clock went backwards.
    #[error("the clock went back by {} s", short(*by_s))]
    ClockBackwards {
        /// By how much \[s\].
        by_s: f64,
    },
    /// The clock stood still.
    #[error("the clock stood still for {ticks} ticks")]
    ClockStuck {
        /// For how many ticks.
        ticks: u32,
    },
    /// Nobody called for too long.
    #[error("the haptic loop stood still for {} s", short(*gap_s))]
    LoopStalled {
        /// Length of the gap \[s\].
        gap_s: f64,
    },
    /// The point moved too fast.
    #[error("speed {} m/s is above {limit} m/s", short(*speed))]
    Overspeed {
        /// Speed of the point \[m/s\].
        speed: f64,
        /// The limit \[m/s\].
        limit: f64,
    },
    /// The hand turned too fast.
    #[error("turning at {rate} rad/s is above {limit} rad/s")]
    Overspin {
        /// Rate of the turn \[rad/s\].
        rate: f64,
        /// The limit \[rad/s\].
        limit: f64,
    },
    /// More energy was given out than the reserve holds.
    #[error("the display gave out {} J on balance; {reserve} J are allowed", short(*given_out))]
    Energy {
        /// Net energy given to the wearer \[J\].
        given_out: f64,
        /// The reserve \[J\].
        reserve: f64,
    },
    /// Somebody asked for it: emergency stop, a signal, shutdown.
    #[error("stop was asked for")]
    Requested,
    /// Whoever armed it and had to stay has gone.
    #[error("whoever armed it has gone: the page was closed, or its connection was lost")]
    Abandoned,
    /// Whoever armed it and had to stay says nothing any more.
    #[error("whoever armed it no longer answers: the page hangs, or its network is gone")]
    Unanswered,
    /// Another actuator of the device tripped.
    #[error("actuator {actuator} tripped")]
    Companion {
        /// Index of the other actuator.
        actuator: usize,
    },
}

/// Quantity that was not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Quantity {
    /// The wanted force.
    Force,
    /// The measured velocity.
    Velocity,
}

impl std::fmt::Display for Quantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Force => "the wanted force",
            Self::Velocity => "the measured velocity",
        })
    }
}

/// Why force fades for now; it comes back by itself, by a ramp.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error, serde::Serialize, serde::Deserialize)]
pub enum Pause {
    /// The newest simulation state is old.
    #[error("no simulation state for {} s", short(*age_s))]
    Simulation {
        /// Age of the frame \[s\].
        age_s: f64,
    },
    /// The newest tracked pose is old.
    #[error("no tracked pose for {} s", short(*age_s))]
    Tracking {
        /// Age of the pose \[s\].
        age_s: f64,
    },
    /// Nobody called for a while.
    #[error("the haptic loop stood still for {} s", short(*gap_s))]
    Loop {
        /// Length of the gap \[s\].
        gap_s: f64,
    },
    /// The device has said nothing.
    #[error("nothing from the device for {} s", short(*age_s))]
    Device {
        /// For how long \[s\].
        age_s: f64,
    },
    /// The dead-man switch is released.
    #[error("the dead-man switch is released")]
    DeadMan,
    /// The hand was found elsewhere.
    #[error("the hand is on its way to where it was found")]
    Away,
}

/// State of a guard.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Status {
    /// Not armed: zero.
    Off,
    /// Armed; zero until the wanted force has been small for some ticks.
    Waiting {
        /// For how many it has been.
        small_ticks: u32,
        /// Pause that keeps the guard waiting, if any.
        pause: Option<Pause>,
    },
    /// Growing towards full force.
    Ramping {
        /// Part of the wanted force that passes, 0 to 1.
        gain: f64,
    },
    /// At full force.
    Live,
    /// Stopped until armed again: zero.
    Tripped(Trip),
}

/// A number as a person reads it: three digits that count.
fn short(x: f64) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    let decimals = 2 - x.abs().log10().floor() as i32;
    match decimals {
        // Powers of ten up to here are exact.
        0..=22 => (x * 10_f64.powi(decimals)).round() / 10_f64.powi(decimals),
        _ => x,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_have_three_digits_that_count() {
        let told = |gap_s| Trip::LoopStalled { gap_s }.to_string();
        for (gap_s, text) in [(0.031758522000000004, "0.0318"), (1.0, "1"), (123.4, "123")] {
            assert_eq!(told(gap_s), format!("the haptic loop stood still for {text} s"));
        }
        let strange = [0.0, f64::NAN, f64::INFINITY, 1e-300, 5e-324, f64::MAX];
        for (x, text) in strange.into_iter().zip(["0", "NaN", "inf"]) {
            assert_eq!(short(x).to_string(), text);
        }
        assert!(strange[3..].iter().all(|x| short(*x) == *x));
    }
}
