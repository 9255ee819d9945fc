//! The guard of one actuator with N axes: 1 for a tendon or a motor, 3 for a force in space.

use crate::safety::wearer_side::WearerSide;
use crate::safety::{
    LimitError, Limits, Passivity, Pause, Quantity, Record, SignalLog, Status, Trip,
};
use crate::{GRIP, MARGIN, hold_then_fade, seconds_between};

/// Inputs of one tick. Times are of the same monotonic clock as the tick's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signal<const N: usize> {
    /// Force wanted on the wearer \[N\].
    pub force: [f64; N],
    /// Mean velocity since the last tick of the point that the force acts on, along the same
    /// axes \[m/s\]: force times velocity is power given to the wearer.
    pub velocity: [f64; N],
    /// Time at which the newest simulation state was made \[ns\].
    pub simulation_ns: u64,
    /// Time at which the newest pose was measured \[ns\].
    pub tracking_ns: u64,
    /// Time at which the device was last heard \[ns\].
    pub device_ns: u64,
    /// The dead-man switch is held, or there is none.
    pub enabled: bool,
}

/// Ticks for which a clock may stand still before it is broken.
const STUCK_TICKS: u32 = 100;

/// Part of the damping that is left where velocities are seen late: a late damper is stable against
/// a hand of more damping than its own, whatever the delay. What is felt leaves 15 % of the loosest
/// grip's 1 N s/m to it, of the usual 2 N s/m.
const DELAYED: f64 = (1.0 - MARGIN) * GRIP / 2.0;

/// After a pause forces come back once nothing has paused them for this many times the longest that
/// any news may be late before it does, 0.2 s: what comes too rarely, again and again, would be
/// felt as knocking.
const SURE: f64 = 4.0 / 3.0;

/// Progress of forces since they were armed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
enum ArmPhase {
    /// Little force has to be wanted first.
    Armed,
    /// Little force was wanted, and the ramp began.
    Ramping,
    /// Full force.
    Live,
}

/// Stands before one actuator.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Guard<const N: usize> {
    limits: Limits,
    status: Status,
    last_ns: Option<u64>,
    stuck_ticks: u32,
    /// Simulation, tracking, device.
    heard: [NewestInput; 3],
    /// Output of stage 7 in the last tick \[N\].
    #[serde(with = "crate::safety::arrays")]
    exact: [f64; N],
    /// Force sent in the last tick \[N\].
    #[serde(with = "crate::safety::arrays")]
    sent: [f64; N],
    passivity: Passivity,
    wearer: WearerSide<N>,
    /// Trust in the inputs of the last tick, 0 to 1.
    trust: f64,
    /// The hand is on its way to where its wearer's is.
    away: bool,
    got: ArmPhase,
    /// Time since something last paused the forces \[s\].
    calm: f64,
    #[serde(skip, default = "SignalLog::without_room")]
    log: SignalLog<N>,
}

impl<const N: usize> Guard<N> {
    /// Off, with room for `log_ticks` records.
    pub fn new(limits: Limits, log_ticks: usize) -> Result<Self, LimitError> {
        limits.check()?;
        Ok(Self {
            limits,
            status: Status::Off,
            last_ns: None,
            stuck_ticks: 0,
            heard: [NewestInput::default(); 3],
            exact: [0.0; N],
            sent: [0.0; N],
            passivity: Passivity::default(),
            wearer: WearerSide::new(),
            trust: 1.0,
            away: false,
            got: ArmPhase::Armed,
            calm: 0.0,
            log: SignalLog::new(log_ticks),
        })
    }

    /// Lets force through again, from zero, after the small-force wait and the ramp. Nothing of
    /// before a trip counts any more. One that is armed already begins anew as well, but its output
    /// goes down within stage 4, and its clock and energy account go on.
    pub fn arm(&mut self) {
        let armed = !matches!(self.status, Status::Off | Status::Tripped(_));
        self.status = Status::Waiting { small_ticks: 0, pause: None };
        self.got = ArmPhase::Armed;
        if armed {
            return;
        }
        self.last_ns = None;
        self.stuck_ticks = 0;
        self.heard = [NewestInput::default(); 3];
        (self.exact, self.sent) = ([0.0; N], [0.0; N]);
        self.passivity = Passivity::default();
        self.wearer.forget();
        self.log.resume();
    }

    /// Zero from the next tick on, until armed. The first reason stays.
    pub fn trip(&mut self, reason: Trip) {
        if !matches!(self.status, Status::Off | Status::Tripped(_)) {
            self.status = Status::Tripped(reason);
        }
    }

    /// Returns the guard's status.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Limits of this guard.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// The velocities of the next ticks are of the wearer's motion so long ago \[s\].
    pub fn see_late(&mut self, delay: f64) {
        self.wearer.see_late(delay);
    }

    /// The hand that is felt is on its way to where its wearer's is, as after a teleport, or has
    /// arrived: on the way it meets things that its wearer does not.
    pub fn see_away(&mut self, away: bool) {
        self.away = away;
    }

    /// Bound of the energy given out that [`Guard::energy`] cannot know of yet, for the delay
    /// \[J\].
    pub fn hidden(&self) -> f64 {
        self.wearer.hidden()
    }

    /// Energy taken from the wearer minus energy given, since it was armed \[J\].
    pub fn energy(&self) -> f64 {
        self.passivity.balance()
    }

    /// The last ticks; after a trip, those that led to it.
    pub fn log(&self) -> &SignalLog<N> {
        &self.log
    }

    /// The force to send \[N\] for the force wanted: the eight stages.
    pub fn tick(&mut self, now_ns: u64, signal: &Signal<N>) -> [f64; N] {
        if self.status == Status::Off {
            return [0.0; N];
        }
        let exact = match self.stages(now_ns, signal) {
            Ok(force) => force,
            Err(reason) => {
                self.trip(reason);
                [0.0; N]
            }
        };
        self.exact = exact;
        self.sent = exact.map(|f| toward_zero(f, self.limits.quantum)); // 8
        self.log.push(Record {
            time_ns: now_ns,
            wanted: signal.force,
            velocity: signal.velocity,
            output: self.sent,
            energy: self.passivity.balance(),
            status: self.status,
        });
        self.sent
    }

    fn stages(&mut self, now_ns: u64, signal: &Signal<N>) -> Result<[f64; N], Trip> {
        if let Status::Tripped(reason) = self.status {
            return Err(reason);
        }
        check_finite(signal)?; // 1
        let dt = self.advance_clock(now_ns)?;
        let (trust, mut pause) = self.freshness(now_ns, signal); // 2
        if dt > self.limits.gap_hold {
            pause = Some(Pause::Loop { gap_s: dt });
        }
        let wanted = self.clamp(&signal.force); // 3
        let change = self.limits.change_max(dt); // 4
        let gain = self.regain(trust, dt) * self.engage(dt, pause, length(&wanted)); // 5
        // Where nothing is sent nothing is given out, and a hand may be on its way by itself.
        let idle = matches!(self.status, Status::Waiting { .. }) && self.sent == [0.0; N];
        let speed = if idle { 0.0 } else { length(&signal.velocity) };
        let limit = self.limits.speed_max;
        if speed > limit {
            return Err(match self.limits.turns {
                true => Trip::Overspin { rate: speed, limit },
                false => Trip::Overspeed { speed, limit },
            }); // 6
        }
        let damping = self.balance_energy(&signal.velocity, speed, dt)?; // 7
        if dt > self.limits.gap_hold {
            // The device was let go meanwhile.
            return Ok([0.0; N]);
        }
        let even: [f64; N] =
            std::array::from_fn(|i| gain * wanted[i] - damping * signal.velocity[i]);
        // Damping takes force away and never adds to what is wanted: noise in the velocity would be
        // felt as kicks.
        let even = at_most(&even, gain * length(&wanted));
        // Neither fade nor ramp nor damping may undo stages 3 and 4.
        Ok(approach(&self.exact, &self.clamp(&even), change))
    }

    /// Seconds since the last tick.
    fn advance_clock(&mut self, now_ns: u64) -> Result<f64, Trip> {
        let dt = seconds_between(self.last_ns.unwrap_or(now_ns), now_ns);
        self.last_ns = Some(now_ns);
        if dt < 0.0 {
            return Err(Trip::ClockBackwards { by_s: -dt });
        }
        if dt > self.limits.gap_max {
            return Err(Trip::LoopStalled { gap_s: dt });
        }
        self.stuck_ticks = if dt > 0.0 { 0 } else { self.stuck_ticks + 1 };
        if self.stuck_ticks > STUCK_TICKS {
            return Err(Trip::ClockStuck { ticks: self.stuck_ticks });
        }
        Ok(dt)
    }

    /// Returns the trust in the inputs, 0 to 1, and the cause of a pause, if there is one.
    fn freshness(&mut self, now_ns: u64, signal: &Signal<N>) -> (f64, Option<Pause>) {
        let stamps = [signal.simulation_ns, signal.tracking_ns, signal.device_ns];
        let mut ages = [0.0; 3];
        for (i, stamp) in stamps.into_iter().enumerate() {
            ages[i] = self.heard[i].age(stamp, now_ns);
        }
        let limits = &self.limits;
        let simulation = hold_then_fade(ages[0], limits.simulation_hold, limits.fade);
        let tracking = hold_then_fade(ages[1], limits.tracking_hold, limits.fade);
        let device = hold_then_fade(ages[2], limits.device_silence_max, limits.fade);
        let pause = if !signal.enabled {
            Some(Pause::DeadMan)
        } else if device == 0.0 {
            Some(Pause::Device { age_s: ages[2] })
        } else if self.away {
            Some(Pause::Away)
        } else if tracking == 0.0 {
            Some(Pause::Tracking { age_s: ages[1] })
        } else if simulation == 0.0 {
            Some(Pause::Simulation { age_s: ages[0] })
        } else {
            None
        };
        (simulation.min(tracking).min(device), pause)
    }

    /// Trust falls at once and comes back slowly.
    fn regain(&mut self, trust: f64, dt: f64) -> f64 {
        let ramps = matches!(self.status, Status::Ramping { .. } | Status::Live);
        let most = if ramps && self.limits.regain > 0.0 {
            self.trust + dt / self.limits.regain
        } else {
            1.0
        };
        self.trust = trust.min(most);
        self.trust
    }

    /// Waiting, ramp, full force: the part of the wanted force that passes. Who arms, or takes hold
    /// of a dead-man switch, has to want little force first. Any other pause is over once its cause
    /// is, however much is wanted: what was held is held still, and is felt again by a ramp.
    fn engage(&mut self, dt: f64, pause: Option<Pause>, wanted: f64) -> f64 {
        if pause.is_some() {
            if pause == Some(Pause::DeadMan) {
                self.got = ArmPhase::Armed;
            }
            self.calm = 0.0;
            self.status = Status::Waiting { small_ticks: 0, pause };
            return 0.0;
        }
        self.calm += dt;
        match self.status {
            Status::Waiting { small_ticks, .. } => {
                let small = self.got == ArmPhase::Armed && wanted < self.limits.engage_force;
                let small_ticks = if small { small_ticks + 1 } else { 0 };
                let begins = match self.got {
                    ArmPhase::Armed => small_ticks >= self.limits.engage_ticks,
                    ArmPhase::Ramping | ArmPhase::Live => self.calm >= self.calm_enough(),
                };
                self.status = if begins {
                    Status::Ramping { gain: 0.0 }
                } else {
                    Status::Waiting { small_ticks, pause: None }
                };
                if begins && self.got == ArmPhase::Armed {
                    self.got = ArmPhase::Ramping;
                }
                0.0
            }
            Status::Ramping { gain } => {
                let Limits { ramp, regain, .. } = self.limits;
                let ramp = if self.got == ArmPhase::Live { ramp.min(regain) } else { ramp };
                let gain = if ramp > 0.0 { gain + dt / ramp } else { 1.0 };
                self.status = if gain < 1.0 { Status::Ramping { gain } } else { Status::Live };
                if gain >= 1.0 {
                    self.got = ArmPhase::Live;
                }
                gain.min(1.0)
            }
            Status::Live => 1.0,
            Status::Off | Status::Tripped(_) => 0.0,
        }
    }

    /// Time without a pause after which one is over \[s\].
    fn calm_enough(&self) -> f64 {
        let Limits { simulation_hold, tracking_hold, device_silence_max, fade, .. } = self.limits;
        SURE * (simulation_hold.max(tracking_hold).max(device_silence_max) + fade)
    }

    /// Books the last interval; the damping that evens out a deficit \[N s/m\].
    fn balance_energy(&mut self, velocity: &[f64; N], speed: f64, dt: f64) -> Result<f64, Trip> {
        let limits = &self.limits;
        let held = dt.min(limits.gap_hold);
        let acted = self.wearer.take(self.sent, held, speed);
        let power: f64 = acted.iter().zip(velocity).map(|(f, v)| f * v).sum();
        if !(limits.passive && power > 0.0) {
            self.passivity.observe(&acted, velocity, held, limits.energy_ceiling);
        }
        let given_out = -self.passivity.balance();
        if given_out > limits.energy_reserve {
            return Err(Trip::Energy { given_out, reserve: limits.energy_reserve });
        }
        let engaged = matches!(self.status, Status::Ramping { .. } | Status::Live);
        let allowed = if self.wearer.is_late() { DELAYED } else { 1.0 };
        let damping = self.passivity.damping(velocity, dt, allowed * limits.damping_max);
        Ok(if engaged && dt > 0.0 { damping } else { 0.0 })
    }

    fn clamp(&self, force: &[f64; N]) -> [f64; N] {
        let pulled = if self.limits.unilateral { force.map(|f| f.max(0.0)) } else { *force };
        let (size, max) = (length(&pulled), self.limits.force_max());
        // A finite vector may have an infinite length; it is then cut by its largest component
        // first.
        if size.is_infinite() {
            let largest = pulled.iter().fold(0.0_f64, |a, f| a.max(f.abs()));
            return self.clamp(&pulled.map(|f| f / largest * max));
        }
        at_most(&pulled, max)
    }
}

/// Time of the last news \[ns\].
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
struct NewestInput {
    newest: Option<u64>,
}

impl NewestInput {
    /// Age \[s\] of what carries this stamp. A stamp from the future or older than its
    /// predecessor is no news: a wrong clock looks stale, never fresh. 0 stands for never, however
    /// young the clock is.
    fn age(&mut self, stamp: u64, now_ns: u64) -> f64 {
        if stamp > 0 && stamp <= now_ns && self.newest.is_none_or(|newest| stamp > newest) {
            self.newest = Some(stamp);
        }
        self.newest.map_or(f64::INFINITY, |newest| seconds_between(newest, now_ns))
    }
}

fn check_finite<const N: usize>(signal: &Signal<N>) -> Result<(), Trip> {
    let finite = |v: &[f64; N]| v.iter().all(|x| x.is_finite());
    if !finite(&signal.force) {
        Err(Trip::NotFinite(Quantity::Force))
    } else if !finite(&signal.velocity) {
        Err(Trip::NotFinite(Quantity::Velocity))
    } else {
        Ok(())
    }
}

fn length<const N: usize>(v: &[f64; N]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn scaled<const N: usize>(v: &[f64; N], factor: f64) -> [f64; N] {
    v.map(|x| x * factor)
}

/// A vector of the same direction, no longer than `most`.
fn at_most<const N: usize>(v: &[f64; N], most: f64) -> [f64; N] {
    let size = length(v);
    if size > most { scaled(v, most / size) } else { *v }
}

/// From `start` towards `end`, by at most `change`.
fn approach<const N: usize>(start: &[f64; N], end: &[f64; N], change: f64) -> [f64; N] {
    let way: [f64; N] = std::array::from_fn(|i| end[i] - start[i]);
    let distance = length(&way);
    if distance <= change {
        return *end;
    }
    std::array::from_fn(|i| start[i] + way[i] * (change / distance))
}

/// The multiple of `quantum` next to `force` on the side of zero.
fn toward_zero(force: f64, quantum: f64) -> f64 {
    if quantum > 0.0 { (force / quantum).trunc() * quantum } else { force }
}
