//! Actuators of one display for one hand: every force goes through a safety guard here, and other
//! outputs are shown only while the guards let forces through.

use super::hand::LoopHand;
use crate::safety::{Bank, LimitError, Limits, Signal, Status, Trip};
use crate::{DIGITS, HandOutput, Rendering, StopLatch};
use serde::{Deserialize, Serialize};

/// A finger stop engages above the first force and lets go below the second \[N\].
const STOP_FORCES: [f64; 2] = [0.3, 0.1];

/// Abilities of a display, and their limits.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Capability {
    /// Kind of rendering.
    pub rendering: Rendering,
    /// Limits of its forces.
    pub limits: Limits,
    /// Limits of torques, for a display that renders any.
    pub torque_limits: Option<Limits>,
}

/// Input and output of one axis in a tick: a finger, or x, y or z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Force asked for \[N\].
    pub wanted: f64,
    /// Measured velocity along it \[m/s\].
    pub velocity: f64,
    /// Force sent \[N\].
    pub output: f64,
    /// Energy taken in minus given out \[J\]; of the whole vector, for x, y, z.
    pub energy: f64,
}

/// The guards of one display for one hand.
#[derive(Serialize, Deserialize)]
pub struct Actuators {
    bank: Guards,
    latches: [StopLatch; DIGITS],
    axes: [Axis; DIGITS],
}

#[derive(Serialize, Deserialize)]
enum Guards {
    Fingers(Bank<1>),
    /// A force, and perhaps a torque.
    Point(Bank<3>),
}

/// Signs of life of a device, for the guards' stale checks.
#[derive(Clone, Copy, Debug)]
pub struct Liveness {
    /// The device \[ns\].
    pub device_ns: u64,
    /// A dead-man switch is held, or there is none.
    pub enabled: bool,
}

impl Actuators {
    /// Guards that are off.
    ///
    /// # Errors
    /// The limits make no sense.
    pub fn new(capability: &Capability) -> Result<Self, LimitError> {
        let Capability { rendering, limits, torque_limits } = *capability;
        let bank = match rendering {
            // In one bank: what trips the torque trips the force.
            Rendering::Wrench => Guards::Point(match torque_limits {
                Some(torque) => Bank::new(&[limits, torque], 0)?,
                None => Bank::new(&[limits], 0)?,
            }),
            Rendering::Tendons | Rendering::Stops | Rendering::Vibration => {
                Guards::Fingers(Bank::new(&[rendering.limits(limits); DIGITS], 0)?)
            }
        };
        let latch = StopLatch::new(STOP_FORCES[0], STOP_FORCES[1]);
        Ok(Self { bank, latches: [latch; DIGITS], axes: [Axis::default(); DIGITS] })
    }

    /// Lets forces through again, after the small-force wait and the ramp.
    pub fn arm(&mut self) {
        match &mut self.bank {
            Guards::Fingers(bank) => bank.arm(),
            Guards::Point(bank) => bank.arm(),
        }
    }

    /// Zero until armed.
    pub fn trip(&mut self, reason: Trip) {
        match &mut self.bank {
            Guards::Fingers(bank) => bank.trip(reason),
            Guards::Point(bank) => bank.trip(reason),
        }
    }

    /// The status of the guard that passes least.
    pub fn status(&self) -> Status {
        let tripped = match &self.bank {
            Guards::Fingers(bank) => bank.tripped(),
            Guards::Point(bank) => bank.tripped(),
        };
        if let Some((_, reason)) = tripped {
            return Status::Tripped(reason);
        }
        match &self.bank {
            Guards::Fingers(bank) => least(bank),
            Guards::Point(bank) => least(bank),
        }
    }

    /// Returns the inputs and outputs of the last tick.
    pub fn axes(&self) -> &[Axis; DIGITS] {
        &self.axes
    }

    /// Returns the output to show after a tick of the hand.
    pub fn tick(&mut self, now_ns: u64, hand: &mut LoopHand, heard: Liveness) -> HandOutput {
        let mut output = HandOutput::released(hand.side(), now_ns);
        let (simulation_ns, tracking_ns) = (hand.simulated_ns(), hand.tracked_ns());
        let Liveness { device_ns, enabled } = heard;
        match &mut self.bank {
            Guards::Fingers(bank) => {
                bank.see_late(hand.seen_late());
                bank.see_away(hand.is_away());
            }
            Guards::Point(bank) => {
                bank.see_late(hand.seen_late());
                bank.see_away(hand.is_away());
            }
        }
        match &mut self.bank {
            Guards::Point(bank) => {
                let signals = hand.palm().map(|(force, velocity)| Signal {
                    force,
                    velocity,
                    simulation_ns,
                    tracking_ns,
                    device_ns,
                    enabled,
                });
                // Without a guard for torques there is none.
                let mut sent = [[0.0; 3]; 2];
                bank.tick(now_ns, &signals, &mut sent);
                let (energy, Signal { force, velocity, .. }) =
                    (bank.guards()[0].energy(), &signals[0]);
                for k in 0..3 {
                    self.axes[k] = Axis {
                        wanted: force[k],
                        velocity: velocity[k],
                        output: sent[0][k],
                        energy,
                    };
                }
                [output.force_W, output.torque_W] = sent.map(thenar_core::Vec3::from);
            }
            Guards::Fingers(bank) => {
                let readings = *hand.readings();
                let signals = readings.map(|reading| Signal {
                    force: [reading.map_or(0.0, |r| r.pad_force)],
                    velocity: [reading.map_or(0.0, |r| r.opening_velocity)],
                    simulation_ns,
                    tracking_ns,
                    device_ns,
                    enabled,
                });
                let mut sent = [[0.0]; DIGITS];
                bank.tick(now_ns, &signals, &mut sent);
                let contacts = hand.frame().contacts;
                for k in 0..DIGITS {
                    let (force, status) = (sent[k][0], bank.guards()[k].status());
                    let (wanted, velocity) = (signals[k].force[0], signals[k].velocity[0]);
                    let energy = bank.guards()[k].energy();
                    self.axes[k] = Axis { wanted, velocity, output: force, energy };
                    let digit = &mut output.digits[k];
                    digit.pad_force = force;
                    // Of the whole force the guarded part only: nothing else has passed the stages.
                    digit.force_W = hand.inward(k) * force;
                    digit.curl_at_contact = self.latches[k].update(force, hand.curl(k));
                    let gain = match status {
                        Status::Live => 1.0,
                        Status::Ramping { gain } => gain,
                        _ => 0.0,
                    };
                    if force > 0.0 && gain > 0.0 {
                        digit.area = contacts[k].area;
                        digit.pressure_mean = contacts[k].pressure_mean * gain;
                        digit.pressure_max = contacts[k].pressure_max * gain;
                        digit.slip_speed = contacts[k].slip_speed * gain;
                    }
                }
            }
        }
        output
    }
}

/// Off, waiting, ramping, live: the first of these that some guard is.
fn least<const N: usize>(bank: &Bank<N>) -> Status {
    let rank = |status: &Status| match status {
        Status::Off => 0,
        Status::Tripped(_) => 1,
        Status::Waiting { .. } => 2,
        Status::Ramping { .. } => 3,
        Status::Live => 4,
    };
    bank.guards().iter().map(|guard| guard.status()).min_by_key(rank).unwrap_or(Status::Off)
}
