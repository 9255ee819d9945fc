//! Limits of one actuator, and their checks.

/// Limits of one actuator. Where it turns, forces are torques \[N m\] and speeds rates \[rad/s\].
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Limits {
    /// Continuous rating of the device \[N\].
    pub rated: f64,
    /// An actuator that turns: torques and rates.
    pub turns: bool,
    /// Part of it that the user allows, 0 to 1.
    pub user_fraction: f64,
    /// Components are never negative: a tendon pulls.
    pub unilateral: bool,
    /// An actuator that holds and never pushes: a stop, or what is shown as vibration. It gives out
    /// no energy.
    pub passive: bool,
    /// Largest change per second \[N/s\].
    pub slew: f64,
    /// Largest change per tick \[N\], however long the tick: no kicks.
    pub step_max: f64,
    /// A faster point trips \[m/s\].
    pub speed_max: f64,
    /// A simulation state is fully trusted up to this age, then fades \[s\].
    pub simulation_hold: f64,
    /// A tracked pose likewise \[s\].
    pub tracking_hold: f64,
    /// Duration of either fade \[s\].
    pub fade: f64,
    /// Trust that has faded takes so long to come back from nothing \[s\]: force that fades before
    /// each frame of a slow simulation stays low, and does not buzz.
    pub regain: f64,
    /// A device that has been silent for longer fades, and then pauses the output \[s\].
    pub device_silence_max: f64,
    /// After a longer gap between two ticks forces begin anew \[s\]: whoever watched over the loop
    /// has let go by then.
    pub gap_hold: f64,
    /// One that is still longer trips \[s\].
    pub gap_max: f64,
    /// Engaging waits until the wanted force is below this \[N\] ...
    pub engage_force: f64,
    /// ... for this many ticks.
    pub engage_ticks: u32,
    /// Then force grows to its full size over this time \[s\].
    pub ramp: f64,
    /// Energy that may have been given out on balance before it trips \[J\].
    pub energy_reserve: f64,
    /// Energy taken in counts up to here \[J\]: what the stiffest use stores and may give back.
    pub energy_ceiling: f64,
    /// Largest damping that the passivity controller adds \[N s/m\].
    pub damping_max: f64,
    /// Smallest step of the device's command \[N\]; zero for none.
    pub quantum: f64,
}

/// Upper ends of what limits a force: in ratings a second, \[m/s\] or \[rad/s\], \[s\].
const RATINGS_A_SECOND_MAX: f64 = 1000.0;
const SPEED_MAX: f64 = 100.0;
const TIME_MAX: f64 = 60.0;

/// Why limits are refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("safety limit {name} = {value} must be {wanted}")]
pub struct LimitError {
    /// Field of `Limits`.
    pub name: &'static str,
    /// Value that was given.
    pub value: f64,
    /// Condition that the value must meet.
    pub wanted: &'static str,
}

impl Limits {
    /// Cautious limits for a device of this rating \[N\]: half of it, from nothing to the rating in
    /// 20 ms and a tenth of it per tick, 1.2 m/s, 2 s ramp.
    ///
    /// Energy: a reserve of a centimetre at full force, and room for a spring of 200 N/m at full
    /// force.
    pub fn rated(rated: f64) -> Self {
        let force_max = 0.5 * rated;
        Self {
            rated,
            turns: false,
            user_fraction: 0.5,
            unilateral: false,
            passive: false,
            slew: rated / 0.02,
            step_max: rated / 10.0,
            speed_max: 1.2,
            simulation_hold: 0.05,
            tracking_hold: 0.1,
            fade: 0.05,
            regain: 0.5,
            device_silence_max: 0.02,
            gap_hold: 0.02,
            gap_max: 0.5,
            engage_force: 0.2,
            engage_ticks: 4,
            ramp: 2.0,
            energy_reserve: 0.01 * force_max,
            energy_ceiling: force_max * force_max / (2.0 * 200.0),
            damping_max: 2.0,
            quantum: 0.0,
        }
    }

    /// CyberGrasp: 12 N per tendon, pull only. Fingertips move against the palm at more than the
    /// 1.2 m/s of a desktop arm: a captured hand that flicks its fingers reaches 3.6 m/s, so 5 m/s.
    pub fn cybergrasp() -> Self {
        let rated = Self::rated(crate::CYBERGRASP_FORCE_MAX);
        Self { unilateral: true, speed_max: 5.0, ..rated }
    }

    /// Cautious limits of a torque of this rating \[N m\]: those of a force at a lever of 2 cm, but
    /// that 20 rad/s, as fast as a wrist turns, is too fast.
    pub fn torque(rated: f64) -> Self {
        const LEVER: f64 = 0.02;
        let force = Self::rated(rated / LEVER);
        Self {
            turns: true,
            rated,
            slew: force.slew * LEVER,
            step_max: force.step_max * LEVER,
            speed_max: 20.0,
            engage_force: force.engage_force * LEVER,
            damping_max: force.damping_max * LEVER * LEVER,
            ..force
        }
    }

    /// Largest force that leaves \[N\].
    pub fn force_max(&self) -> f64 {
        self.rated * self.user_fraction
    }

    /// Largest change within `dt` \[s\] \[N\].
    pub fn change_max(&self, dt: f64) -> f64 {
        (self.slew * dt).min(self.step_max)
    }

    /// Refuses limits that make no sense, and such as limit nothing.
    pub fn check(&self) -> Result<(), LimitError> {
        if !(0.0..=1.0).contains(&self.user_fraction) {
            let (name, value) = ("user_fraction", self.user_fraction);
            return Err(LimitError { name, value, wanted: "between 0 and 1" });
        }
        let positive = [
            ("rated", self.rated),
            ("slew", self.slew),
            ("step_max", self.step_max),
            ("speed_max", self.speed_max),
            ("gap_hold", self.gap_hold),
            ("gap_max", self.gap_max),
            ("engage_force", self.engage_force),
        ];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(LimitError { name, value, wanted: "positive and finite" });
            }
        }
        // The whole rating in a millisecond or one tick is a blow; no limb is as fast as 100 m/s or
        // rad/s; who waits for a minute believes that nothing comes.
        let upper_ends = [
            (
                "slew",
                self.slew,
                RATINGS_A_SECOND_MAX * self.rated,
                "at most a rating a millisecond",
            ),
            ("step_max", self.step_max, self.rated, "at most the rating"),
            ("speed_max", self.speed_max, SPEED_MAX, "at most 100 m/s or rad/s"),
            ("simulation_hold", self.simulation_hold, TIME_MAX, "at most 60 s"),
            ("tracking_hold", self.tracking_hold, TIME_MAX, "at most 60 s"),
            ("fade", self.fade, TIME_MAX, "at most 60 s"),
            ("regain", self.regain, TIME_MAX, "at most 60 s"),
            ("device_silence_max", self.device_silence_max, TIME_MAX, "at most 60 s"),
            ("gap_hold", self.gap_hold, TIME_MAX, "at most 60 s"),
            ("gap_max", self.gap_max, TIME_MAX, "at most 60 s"),
            ("ramp", self.ramp, TIME_MAX, "at most 60 s"),
        ];
        for (name, value, most, wanted) in upper_ends {
            // Products of a profile's decimals are off by round-off.
            if value > most * (1.0 + 1e-9) {
                return Err(LimitError { name, value, wanted });
            }
        }
        let not_negative = [
            ("simulation_hold", self.simulation_hold),
            ("tracking_hold", self.tracking_hold),
            ("fade", self.fade),
            ("regain", self.regain),
            ("device_silence_max", self.device_silence_max),
            ("ramp", self.ramp),
            ("energy_reserve", self.energy_reserve),
            ("energy_ceiling", self.energy_ceiling),
            ("damping_max", self.damping_max),
            ("quantum", self.quantum),
        ];
        for (name, value) in not_negative {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(LimitError { name, value, wanted: "finite and not negative" });
            }
        }
        Ok(())
    }
}
