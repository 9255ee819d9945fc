//! Touch in simulated time: a scene's hand felt through the whole haptic chain, by a clock that is
//! counted and not read. The same samples give the same bits on any machine, however slow, and the
//! three modes can be compared on one motion.
//!
//! ```text
//!   samples ─► haptic tick, 1 kHz ─► proxies ─► [every period] simulation step
//!                  ▲ newest frame ◄── [some ticks later] bones, response ◄┘
//! ```

mod study;

pub use study::{Comparison, Study, compare, lead};

use crate::session::Session;
use thenar::model::SolverKind;
use thenar::world::{Input, ModelError};
use thenar::{Pose, Vec3, World};
use thenar_touch::sampled::Sampled;
use thenar_touch::{
    CouplingDesign, FastToSlow, Felt, FeltBounds, FreeHand, HandReport, HandSettings, HapticHand,
    LoopProfile, Mode, Observation, Pad, PadReading, Prediction, ProxyError, RigidState,
    SingleRate, SingleRateSettings, SlowToFast, Touch, series_drive, series_stiffness,
};

/// Length of a haptic tick \[ns\].
pub const TICK_NS: u64 = 1_000_000;
/// Contacts of a frame.
const CONTACTS_MAX: usize = 64;

/// What stands between two frames of the simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TouchMode {
    /// The bones of the last frame, carried on (the paper).
    Multirate,
    /// The last frame's response, contact resolved every tick.
    SharedConstraints,
    /// Nothing: the simulation steps within the tick.
    SingleRate,
}

impl TouchMode {
    /// As it reads in a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Multirate => "multirate",
            Self::SharedConstraints => "shared constraints",
            Self::SingleRate => "single-rate",
        }
    }
}

/// How a scene is felt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchSettings {
    /// Mode of touch.
    pub mode: TouchMode,
    /// Couplings of all bones; they replace the scene's drives.
    pub design: CouplingDesign,
    /// Ticks from one simulation step to the next, which is also its time step \[ms\].
    pub period: u64,
    /// Ticks from a step's inputs to its frame \[ms\]: what computing takes.
    pub latency: u64,
    /// How bones are carried on between frames, in `Multirate`.
    pub prediction: Prediction,
    /// Damping of the loosest grip that is allowed for \[N s/m\], which bounds how stiff bones are felt by the delay of
    /// the frames; `None` bounds nothing.
    pub grip: Option<f64>,
}

/// Why a scene cannot be felt.
#[derive(Clone, Debug, thiserror::Error)]
pub enum TouchError {
    /// There is no such hand.
    #[error("there is no hand {0} in the scene")]
    NoHand(usize),
    /// The couplings are refused.
    #[error(transparent)]
    Proxy(#[from] ProxyError),
    /// The world is refused.
    #[error(transparent)]
    World(#[from] ModelError),
}

/// A hand of a scene, felt in simulated time.
pub struct Rehearsal {
    touch: Sampled<dyn Touch>,
    felt: Felt,
    /// None in single-rate, where it is within `touch`.
    slow: Option<Slow>,
    frame: SlowToFast,
    back: FastToSlow,
    pads: Vec<Pad>,
    readings: Vec<PadReading>,
    tick: u64,
}

/// The simulation at its own rate.
struct Slow {
    world: World,
    input: Input,
    bones: std::ops::Range<u32>,
    mode: TouchMode,
    /// The hand in empty air, where frames have no response that tells of it.
    free: Option<FreeHand>,
    period: u64,
    latency: u64,
    /// A frame on its way, and when it arrives.
    coming: Option<u64>,
    next: SlowToFast,
}

impl Rehearsal {
    /// Takes the scene as it is now. Nothing but this hand is moved: the scene's own motions and
    /// loads do not act.
    ///
    /// # Errors
    /// There is no such hand, or the couplings make no sense.
    pub fn new(
        session: &Session,
        hand: usize,
        settings: &TouchSettings,
    ) -> Result<Self, TouchError> {
        let built = session.hands().get(hand).ok_or(TouchError::NoHand(hand))?;
        let bones = built.handle.bones.clone();
        let mut desc = session.world().desc().clone();
        let proxies = settings.design.hand(&built.model);
        let couplings = (proxies.iter())
            .map(|proxy| series_stiffness(proxy.device.stiffness, proxy.bone.stiffness));
        let felt = Felt::new(bounds(settings.grip), couplings.collect());
        for (b, proxy) in bones.clone().zip(&proxies) {
            desc.drives[b as usize] = Some(match settings.mode {
                TouchMode::SingleRate => series_drive(&proxy.device, &proxy.bone),
                _ => proxy.bone,
            });
        }
        desc.time_step = 1e-9 * (TICK_NS * settings.period.max(1)) as f64;
        let mut world = World::new(desc)?;
        world.restore(session.world().state());
        let start: Vec<RigidState> = bones.clone().map(|b| RigidState::of(&world, b)).collect();
        let frame = SlowToFast::new(&start, CONTACTS_MAX);
        let input = world.input();
        let mut slow = None;
        let touch: Box<dyn Touch> = if settings.mode == TouchMode::SingleRate {
            Box::new(SingleRate::new(SingleRateSettings::default(), world, bones)?)
        } else {
            let responds = settings.mode == TouchMode::SharedConstraints
                && world.desc().solver.kind == SolverKind::Exact;
            let free =
                (!responds).then(|| FreeHand::of(&world, bones.clone(), false)).transpose()?;
            slow = Some(Slow {
                free,
                world,
                input,
                bones,
                mode: settings.mode,
                period: settings.period.max(1),
                latency: settings.latency,
                coming: None,
                next: frame.clone(),
            });
            let mode = match settings.mode {
                TouchMode::SharedConstraints => Mode::SharedConstraints,
                _ => Mode::Multirate,
            };
            let simulation = settings.prediction;
            let settings = HandSettings { mode, simulation, ..HandSettings::default() };
            Box::new(HapticHand::new(settings, proxies, &start, CONTACTS_MAX)?)
        };
        let pads = Pad::of_hand(&built.model);
        let none = PadReading { force_W: Vec3::zeros(), pad_force: 0.0, opening_velocity: 0.0 };
        Ok(Self {
            back: FastToSlow::new(&start),
            readings: vec![none; pads.len()],
            touch: Sampled::new(touch),
            felt,
            slow,
            frame,
            pads,
            tick: 0,
        })
    }

    /// Present time \[ns\].
    pub fn now_ns(&self) -> u64 {
        self.tick * TICK_NS
    }

    /// Where a bone of the hand is in the tick that comes, as the loop leads it: observed before.
    pub fn lead(&mut self, bone: usize, state: RigidState) {
        let time_ns = (self.tick + 1) * TICK_NS;
        self.touch.lead(bone, state);
        if bone == 0 {
            self.felt.hear(time_ns, time_ns, None);
        }
    }

    /// A sample of a tracker, taken now, which nobody has observed before.
    pub fn track(&mut self, bone: usize, pose_WB: Pose, velocity: Option<[Vec3; 2]>) {
        // It is known in the tick that comes.
        let time_ns = (self.tick + 1) * TICK_NS;
        self.touch.track(bone, time_ns, pose_WB, velocity);
        if bone == 0 {
            self.felt.hear(time_ns, time_ns, None);
        }
    }

    /// One millisecond. `stalled` keeps the simulation from beginning a step.
    pub fn tick(&mut self, stalled: bool) -> HandReport {
        self.tick += 1;
        let now = self.now_ns();
        if let Some(slow) = &mut self.slow {
            slow.deliver(self.tick, &mut self.frame);
            slow.begin(self.tick, stalled, now, &self.back);
        }
        let report = self.touch.tick(now, &self.frame);
        self.touch.publish(now, &mut self.back);
        self.felt.step(report.step, 0.0, |bone, observed| self.touch.added_delay(bone, observed));
        for (pad, reading) in self.pads.iter_mut().zip(&mut self.readings) {
            *reading = pad.read(&self.touch, report.step);
            let part = self.felt.part(pad.bone);
            reading.force_W *= part;
            reading.pad_force *= part;
        }
        report
    }

    /// The pads, thumb first.
    pub fn pads(&self) -> &[Pad] {
        &self.pads
    }

    /// What each pad felt in the last tick.
    pub fn readings(&self) -> &[PadReading] {
        &self.readings
    }

    /// How stiff the bones are felt.
    pub fn felt(&self) -> &Felt {
        &self.felt
    }

    /// The hand at the haptic rate: what it would have the wearer feel before that is bounded.
    pub fn touch(&self) -> &dyn Touch {
        &self.touch
    }

    /// The simulation.
    pub fn world(&self) -> Option<&World> {
        self.slow.as_ref().map(|slow| &slow.world).or(self.touch.world())
    }

    /// Power given to the wearer by what is felt of all couplings \[W\], with the tracked bones' velocities.
    pub fn power(&self) -> f64 {
        let each = self.touch.tracked().iter().zip(self.touch.device_wrenches()).enumerate();
        each.map(|(bone, (hand, [force, torque]))| {
            let power = force.dot(&hand.velocity_W) + torque.dot(&hand.angular_velocity_W);
            self.felt.part(bone) * power
        })
        .sum()
    }
}

/// The bounds of a loop of one tick, whose display acts at once.
fn bounds(grip: Option<f64>) -> FeltBounds {
    let [delay, damping, friction, resolution] = [0.0; 4];
    let (period, rated_stiffness) = (1e-9 * TICK_NS as f64, f64::INFINITY);
    let profile = LoopProfile { period, delay, damping, friction, resolution, rated_stiffness };
    FeltBounds { grip, profile, observation: Observation::default() }
}

impl Slow {
    fn deliver(&mut self, tick: u64, to: &mut SlowToFast) {
        if self.coming.is_some_and(|due| tick >= due) {
            to.copy_from(&self.next);
            self.coming = None;
        }
    }

    fn begin(&mut self, tick: u64, stalled: bool, now: u64, back: &FastToSlow) {
        if stalled || self.coming.is_some() || !tick.is_multiple_of(self.period) {
            return;
        }
        let first = self.bones.start as usize;
        for (target, proxy) in self.input.targets[first..].iter_mut().zip(&back.proxies) {
            *target = Some(proxy.target());
        }
        self.world.step(&self.input, &mut ());
        if let Some(free) = &mut self.free {
            let targets = back.free.iter().map(|proxy| Some(proxy.target()));
            free.step(self.world.time_step(), targets, &self.input);
            free.publish(&mut self.next.free);
        }
        self.world.condense(self.bones.clone(), &self.input, &mut self.next);
        if self.mode == TouchMode::Multirate {
            self.next.response.clear();
        }
        (self.next.time_ns, self.next.step) = (now, self.next.step + 1);
        self.coming = Some(tick + self.latency);
    }
}
