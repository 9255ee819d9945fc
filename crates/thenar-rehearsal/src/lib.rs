//! Touch rehearsed: the product's own loop between a wearer, a tracker and a glove that do not
//! exist, on a clock that is counted and not read.
//!
//! ```text
//!  command ─[k, b]─ finger m ──► tracker: HZ, DELAY, NOISE ──► the loop (`ManualLoop`) ──► glove
//!                      ▲                                       proxies, guards, delays       │
//!                      └──────────────────── force on the pad ◄──────────────────────────────┘
//! ```
//!
//! The wearer does what the scene's script does, with five fingers that give way to what they feel;
//! then the fingers close a little more, the command stands still, each finger is pushed once, and
//! what is left of that is looked at. Or the command goes on to press and let go: then what a
//! finger was given is held against what its damper took up. The same request gives the same bits.

mod glove;
mod led;
mod onset;
mod stage;
mod study;
mod wearer;

pub use led::{Led, scripted};
pub use onset::{Onset, late_spring_onset};
pub use stage::Stage;
pub use study::{Comparison, Study, moved};
pub use wearer::{Finger, FingerImpedance, Flow};

use glove::{LateTracker, WearerEndpoint};
use std::ops::RangeInclusive;
use thenar_core::model::Side;
use thenar_link::{DIGITS, HandSample};
use thenar_scene::session::{Random, Session};
use thenar_touch::TrackerTiming;
use thenar_touch::haptic_loop::{LoopError, LoopMode, PortError, Settings};
use thenar_touch::safety::{Limits, Status};
use thenar_track::live::{LiveError, LivePose};
use wearer::RehearsedHand;

/// Length of a tick \[ns\].
const TICK_NS: u64 = 1_000_000;
/// Before the script begins: the hand sets out and forces ramp up \[ms\].
const BEFORE: u64 = 1800;
/// Forces ramp up within this, to be quick \[s\].
const RAMP: f64 = 0.5;
/// After the command stands still, before the push \[ms\].
const SETTLE: u64 = 1500;
/// Fingers close to press within this \[s\].
const PRESSING: f64 = 0.5;
/// The push: force \[N\] and time \[ms\].
const PUSH: (f64, u64) = (0.5, 50);
/// Window at the end that is evaluated \[ms\].
const WINDOW: u64 = 1000;
/// To measure how stiff fingers are felt they close by this much more \[m\] within a time, and then
/// are looked at after another, for as long as before \[ms\]: so slowly that delays and dampers
/// have no part in it.
const PROBE: f64 = 1e-3;
const PROBING: [u64; 2] = [250, 1000];

/// Description of a rehearsal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rehearsal {
    /// Each finger of the wearer.
    pub human: FingerImpedance,
    /// Timing of the tracker, known to the loop.
    pub tracker: TrackerTiming,
    /// Mode of touch between hand and simulation.
    pub mode: LoopMode,
    /// Damping of the loosest grip that the loop assumes \[N s/m\].
    pub grip: Option<f64>,
    /// Time of the scene at which the command stands still \[s\].
    pub until: f64,
    /// Then the fingers close by this much more, to press \[m\].
    pub press: f64,
    /// Fingers do so and open again at this rate, to the end \[Hz\]; `None` to stay closed.
    pub sway: Option<f64>,
    /// From the push to the end \[s\]; the last second is looked at.
    pub after: f64,
}

/// Why nothing can be rehearsed.
#[derive(Debug, thiserror::Error)]
pub enum RehearsalError {
    /// A number makes no sense.
    #[error("{what} is {value}, expected {expected}")]
    Number {
        /// Name of the number.
        what: &'static str,
        /// Value as given, with its unit.
        value: String,
        /// Values that make sense, in words.
        expected: &'static str,
    },
    /// The scene has no hand that could be worn.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The hand cannot be led by poses.
    #[error(transparent)]
    Live(#[from] LiveError),
    /// The loop cannot be made.
    #[error(transparent)]
    Loop(#[from] LoopError),
}

/// Figures of a finger at the end of a rehearsal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FingerOutcome {
    /// Mean force \[N\].
    pub mean: f64,
    /// Root mean square about it \[N\].
    pub rms: f64,
    /// Root mean square of its motion about its mean place \[m\].
    pub motion_rms: f64,
    /// Energy given to it in the window \[J\].
    pub given: f64,
    /// The most that was given to it on balance since its command stood still \[J\].
    pub given_max: f64,
    /// The most that was given on balance, to it and to what commands it, beyond what its own
    /// damper took up, since the script ended \[J\]. What is passive behind the delay stays near
    /// nothing.
    pub beyond: f64,
}

/// Outcome of a rehearsal.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Thumb first.
    pub fingers: [FingerOutcome; DIGITS],
    /// Largest force that was sent, and its largest change in a tick \[N\].
    pub largest: [f64; 2],
    /// Largest force that a finger felt once the command stood still or swayed \[N\].
    pub felt: f64,
    /// Stiffest that a blocked finger was felt in the end, by its couplings and the rule \[N/m\].
    pub stiffness: f64,
    /// Stiffness as the wearer measures it \[N/m\]: force on each pad by the way of its fingertip,
    /// flesh, joints and what is touched included; after [`Rehearsal::run_and_measure`].
    pub measured: Option<[f64; DIGITS]>,
    /// Delay from motion to force that the loop reckoned with \[s\].
    pub delay: f64,
    /// Reasons that stopped the forces.
    pub trips: Vec<String>,
    /// Forces were let through in the end.
    pub live: bool,
}

impl Outcome {
    /// True if the hand's disturbance has died out: 20 mN and 0.1 mm rms, 0.1 mJ a second, and
    /// nothing stopped the forces.
    pub fn is_still(&self) -> bool {
        let worst = self.worst();
        self.trips.is_empty() && worst.rms < 0.02 && worst.motion_rms < 1e-4 && worst.given < 1e-4
    }

    /// True when a finger that rests or sways felt more than the flesh of a hand in free air may
    /// show by itself, 20 mN.
    pub fn is_felt(&self) -> bool {
        self.felt > 0.02
    }

    /// The worst of all fingers.
    pub fn worst(&self) -> FingerOutcome {
        self.fingers.iter().fold(FingerOutcome::default(), |worst, felt| FingerOutcome {
            mean: worst.mean.max(felt.mean),
            rms: worst.rms.max(felt.rms),
            motion_rms: worst.motion_rms.max(felt.motion_rms),
            given: worst.given.max(felt.given),
            given_max: worst.given_max.max(felt.given_max),
            beyond: worst.beyond.max(felt.beyond),
        })
    }
}

impl Rehearsal {
    /// Refuses what no wearer, tracker or scene does.
    ///
    /// # Errors
    /// Names the number and what it may be.
    pub fn check(&self) -> Result<(), RehearsalError> {
        let FingerImpedance { mass, damping, stiffness } = self.human;
        let numbers = [
            ("the mass M", mass, 1e-3..=100.0, "kg", "0.001 to 100 kg"),
            ("the damping B", damping, 0.0..=1000.0, "N s/m", "0 to 1000 N s/m"),
            ("the stiffness K", stiffness, 0.0..=1e5, "N/m", "0 to 100000 N/m"),
            ("the time of the scene", self.until, 0.0..=60.0, "s", "0 to 60 s"),
            ("the way to press", self.press, 0.0..=0.05, "m", "0 to 50 mm"),
            ("the rate to sway", self.sway.unwrap_or(1.0), 0.05..=10.0, "Hz", "0.05 to 10 Hz"),
            ("the time after the push", self.after, 1.0..=60.0, "s", "1 to 60 s"),
            ("the grip", self.grip.unwrap_or(1.0), 1e-3..=1000.0, "N s/m", "0.001 to 1000 N s/m"),
        ];
        check_all(&numbers)?;
        check_tracker(&self.tracker)
    }

    /// Runs it with the first hand of a scene.
    ///
    /// # Errors
    /// A number makes no sense, or the scene has no hand that could be worn.
    pub fn run(&self, session: Session) -> Result<Outcome, RehearsalError> {
        self.check()?;
        let mut run = Run::new(self, session)?;
        run.run()?;
        Ok(run.finish())
    }

    /// Runs it, and then has each finger close by a millimetre more, slowly, to measure how stiff
    /// it is felt. The rest is as without that. Fingers that sway measure nothing.
    ///
    /// # Errors
    /// As [`Rehearsal::run`].
    pub fn run_and_measure(&self, session: Session) -> Result<Outcome, RehearsalError> {
        self.check()?;
        let mut run = Run::new(self, session)?;
        run.run()?;
        let before = run.means();
        let mut out = run.finish();
        if self.sway.is_none() {
            let after = run.probe()?;
            out.measured = Some(std::array::from_fn(|k| {
                let [(force, place), (force_before, place_before)] = [after[k], before[k]];
                (force - force_before) / (place - place_before)
            }));
        }
        Ok(out)
    }
}

/// One number of noise with this standard deviation: even ones have it that reach √3 as far.
fn white(noise: f64, random: &mut Random) -> f64 {
    if noise > 0.0 { 3.0_f64.sqrt() * noise * random.symmetric() } else { 0.0 }
}

/// Name, value, values that make sense, unit, and these values in words.
type Number = (&'static str, f64, RangeInclusive<f64>, &'static str, &'static str);

fn check_all(numbers: &[Number]) -> Result<(), RehearsalError> {
    for (what, value, range, unit, expected) in numbers {
        if !range.contains(value) {
            let value = format!("{value} {unit}");
            return Err(RehearsalError::Number { what, value, expected });
        }
    }
    Ok(())
}

fn check_tracker(timing: &TrackerTiming) -> Result<(), RehearsalError> {
    let TrackerTiming { rate, latency, noise } = *timing;
    check_all(&[
        ("the tracker's rate HZ", rate, 5.0..=1000.0, "Hz", "5 to 1000 Hz"),
        ("the tracker's DELAY", latency, 0.0..=0.2, "s", "0 to 200 ms"),
        ("the tracker's NOISE", noise, 0.0..=0.02, "m", "0 to 20 mm"),
    ])
}

/// A rehearsal under way.
struct Run<'a> {
    what: &'a Rehearsal,
    stage: Stage,
    ends: WearerEndpoint,
    hand: RehearsedHand,
    random: Random,
    side: Side,
    tracker: LateTracker,
    out: Outcome,
    sums: [[f64; 4]; DIGITS],
}

impl<'a> Run<'a> {
    fn new(what: &'a Rehearsal, session: Session) -> Result<Self, RehearsalError> {
        let limits = Limits { ramp: RAMP, ..Limits::cybergrasp() };
        let (ends, tracker, display) = glove::pair(what.tracker, limits);
        let settings = Settings { mode: what.mode, grip: what.grip, ..Settings::default() };
        let stage = Stage::new(session, &settings, vec![tracker], vec![display])?;
        let side = stage.session().hands()[0].model.side.unwrap_or(Side::Right);
        let hand = RehearsedHand::new(stage.session(), &what.human, 1e-9 * TICK_NS as f64)?;
        let out = Outcome {
            fingers: [FingerOutcome::default(); DIGITS],
            largest: [0.0; 2],
            felt: 0.0,
            stiffness: 0.0,
            measured: None,
            delay: 0.0,
            trips: Vec::new(),
            live: false,
        };
        let (random, sums) = (Random::new(1), [[0.0; 4]; DIGITS]);
        let tracker = LateTracker::new(what.tracker);
        Ok(Self { what, stage, ends, hand, random, side, tracker, out, sums })
    }

    /// The last millisecond of the rehearsal.
    fn end(&self) -> u64 {
        BEFORE + (1e3 * self.what.until) as u64 + SETTLE + (1e3 * self.what.after) as u64
    }

    fn run(&mut self) -> Result<(), RehearsalError> {
        self.stage.clock().remote().arm();
        let script = (1e3 * self.what.until) as u64;
        let still = BEFORE + script;
        let push = still + SETTLE;
        let end = self.end();
        for ms in 1..=end {
            let scene = 1e-3 * ms.saturating_sub(BEFORE).min(script) as f64;
            if ms == still + 1 {
                self.hand.beyond = [0.0; DIGITS];
            }
            self.hand.command(scene, self.pressed(1e-3 * ms.saturating_sub(still) as f64));
            let pushes = self.what.sway.is_none() && (push..push + PUSH.1).contains(&ms);
            let [forces, moved] = self.go_on(ms, if pushes { PUSH.0 } else { 0.0 })?;
            if ms > still {
                self.balance();
            }
            if ms > still + SETTLE / 2 {
                self.account(&forces, &moved, ms + WINDOW > end);
            }
        }
        Ok(())
    }

    /// A millisecond in which the hand gives way to what it feels and to a push \[N\], is seen, and
    /// the loop ticks: the forces that it felt \[N\], and how far its fingers went \[m\].
    fn go_on(&mut self, ms: u64, push: f64) -> Result<[[f64; DIGITS]; 2], RehearsalError> {
        let now_ns = ms * TICK_NS;
        let forces = self.ends.shown().digits.map(|digit| digit.pad_force);
        let moved = self.hand.advance(&forces, push);
        if self.tracker.is_due(ms) {
            let pose = self.seen();
            self.tracker.see(HandSample { side: self.side, time_ns: now_ns, pose: Some(pose) });
        }
        if let Some(sample) = self.tracker.arrived(now_ns) {
            self.ends.tell(sample, now_ns);
        }
        self.tick(now_ns, &forces)?;
        Ok([forces, moved])
    }

    /// Mean force on each pad \[N\] and place of its fingertip on the way to close \[m\], in what
    /// was looked at.
    fn means(&self) -> [(f64, f64); DIGITS] {
        let mean = |sum: f64| sum / WINDOW as f64;
        self.sums.map(|[force, _, place, _]| (mean(force), self.hand.press() + mean(place)))
    }

    /// Closes the fingers a little more, and waits: these means again.
    fn probe(&mut self) -> Result<[(f64, f64); DIGITS], RehearsalError> {
        let (end, script) = (self.end(), self.what.until);
        let [closing, wait] = PROBING;
        self.sums = [[0.0; 4]; DIGITS];
        for ms in 1..=closing + wait + WINDOW {
            let part = (ms as f64 / closing as f64).min(1.0);
            self.hand.command(script, self.what.press + PROBE * part);
            let [forces, _] = self.go_on(end + ms, 0.0)?;
            if ms > closing + wait {
                self.sum(&forces);
            }
        }
        Ok(self.means())
    }

    /// Returns how much farther the fingers are closed this long after the script's end \[m\].
    fn pressed(&self, after: f64) -> f64 {
        let part = match self.what.sway {
            None => (after / PRESSING).min(1.0),
            Some(rate) => 0.5 - 0.5 * (std::f64::consts::TAU * rate * after).cos(),
        };
        self.what.press * part
    }

    /// Books what each finger was given beyond what its damper took up.
    fn balance(&mut self) {
        for (felt, beyond) in self.out.fingers.iter_mut().zip(&self.hand.beyond) {
            felt.beyond = felt.beyond.max(*beyond);
        }
    }

    /// The hand as the tracker sees it.
    fn seen(&mut self) -> LivePose {
        let (noise, random) = (self.what.tracker.noise, &mut self.random);
        self.hand.pose(&mut || white(noise, random))
    }

    fn tick(&mut self, now_ns: u64, before: &[f64; DIGITS]) -> Result<(), RehearsalError> {
        self.ends.hear(now_ns);
        self.stage.tick(false)?;
        let clock = self.stage.clock();
        if let Some(reason) = clock.core(|core| core.tripped()) {
            self.out.trips.push(format!("{:.3} s: {reason}", now_ns as f64 * 1e-9));
            clock.remote().arm();
        }
        let after = self.ends.shown().digits.map(|digit| digit.pad_force);
        for (before, after) in before.iter().zip(after) {
            let [largest, step] = &mut self.out.largest;
            *largest = largest.max(after);
            *step = step.max((after - before).abs());
        }
        Ok(())
    }

    /// Books what the forces of the last tick did.
    fn account(&mut self, forces: &[f64; DIGITS], moved: &[f64; DIGITS], looked_at: bool) {
        self.out.felt = forces.iter().copied().fold(self.out.felt, f64::max);
        for (k, felt) in self.out.fingers.iter_mut().enumerate() {
            // Closing is against the force.
            let given = -forces[k] * moved[k];
            self.hand.given[k] += given;
            felt.given_max = felt.given_max.max(self.hand.given[k]);
            if looked_at {
                felt.given += given;
            }
        }
        if looked_at {
            self.sum(forces);
        }
    }

    fn sum(&mut self, forces: &[f64; DIGITS]) {
        for (k, sums) in self.sums.iter_mut().enumerate() {
            let (force, place) = (forces[k], self.hand.fingers[k].place);
            sums[0] += force;
            sums[1] += force * force;
            sums[2] += place;
            sums[3] += place * place;
        }
    }

    /// Computes the outcome up to now.
    fn finish(&mut self) -> Outcome {
        let n = WINDOW as f64;
        for (felt, sums) in self.out.fingers.iter_mut().zip(&self.sums) {
            let [force, square, place, place_square] = sums.map(|sum| sum / n);
            felt.mean = force;
            felt.rms = (square - force * force).max(0.0).sqrt();
            felt.motion_rms = (place_square - place * place).max(0.0).sqrt();
        }
        let out = &mut self.out;
        self.stage.clock().core(|core| {
            let hand = &core.hands()[0];
            (out.stiffness, out.delay) = (hand.felt_stiffness(), hand.delay());
            // The glove is worn on the first hand; nobody leads another one.
            out.live = core.actuators().first().is_some_and(|a| a.status() == Status::Live);
        });
        self.out.clone()
    }
}
