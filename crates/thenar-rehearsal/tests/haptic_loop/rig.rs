//! A hand in the loop with a tracker and a display that only exist in memory.

use std::path::Path;
use std::sync::{Arc, Mutex};
use thenar_core::Pose;
use thenar_core::model::Side;
use thenar_link::haptic_loop::{LoopMode, ManualLoop, Settings, SimulationPort};
use thenar_link::{ForceDisplay, HandOutput, HandSample, Rendering, Tracker};
use thenar_scene::session::Session;
use thenar_touch::LoopProfile;
use thenar_touch::safety::Limits;
use thenar_track::ANGLES;
use thenar_track::live::LivePose;

pub const MS: u64 = 1_000_000;

/// Bones without flesh: quick to make, and all that the loop sees of a hand.
pub const SCENE: &str =
    "version = 1\n[[hand]]\npreset = \"paper\"\nname = \"hand\"\nflesh = false\n";

/// The same scene with the paper's hand of 200 tetrahedra: it steps in a fraction of the time, and
/// is as good where the chain matters and not the flesh.
pub fn small(scene: &str) -> String {
    let model = "model = \"right\"\n";
    assert!(scene.contains(model), "{scene}");
    scene.replace(model, &format!("{model}preset = \"paper\"\ntets = 200\n"))
}

pub fn session(text: &str) -> Session {
    Session::from_text(text, Path::new("test.toml"), &[]).expect("a scene")
}

/// What a tracker tells next, and when.
#[derive(Default)]
pub struct Said {
    pub next: Option<HandSample>,
    pub heard_ns: Option<u64>,
    /// What happens at the next look: a stall, a panic.
    pub mischief: Option<Box<dyn FnOnce() + Send>>,
}

pub struct FakeTracker {
    said: Arc<Mutex<Said>>,
    told: Option<HandSample>,
}

impl Tracker for FakeTracker {
    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        let mut said = self.said.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let mischief = said.mischief.take();
        let next = said.next.take();
        drop(said);
        if let Some(mischief) = mischief {
            mischief();
        }
        self.told = Some(next?);
        self.told.as_ref().filter(|sample| sample.side == side)
    }

    fn heard_ns(&mut self) -> Option<u64> {
        self.said.lock().unwrap().heard_ns
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}

/// What a display was told.
pub struct Shown {
    pub outputs: Vec<HandOutput>,
    pub heard_ns: Option<u64>,
    pub dropped: bool,
}

/// The paper's device with a short ramp, so that tests are short.
pub fn limits() -> Limits {
    Limits { ramp: 0.3, ..Limits::cybergrasp() }
}

/// Of a small arm that turns its handle.
pub fn torque_limits() -> Limits {
    Limits { ramp: 0.3, ..Limits::torque(0.2) }
}

/// For hands that are held by hand, as no simulation would: between frames they stay as they are.
pub fn blocked() -> Settings {
    Settings { mode: LoopMode::Multirate, grip: None, ..Settings::default() }
}

pub struct FakeDisplay {
    shown: Arc<Mutex<Shown>>,
    rendering: Rendering,
    limits: Limits,
}

impl ForceDisplay for FakeDisplay {
    fn rendering(&self) -> Rendering {
        self.rendering
    }

    fn limits(&self) -> Limits {
        self.limits
    }

    fn torque_limits(&self) -> Option<Limits> {
        (self.rendering == Rendering::Wrench).then(torque_limits)
    }

    fn loop_profile(&self) -> LoopProfile {
        let rated_stiffness = f64::INFINITY;
        let [period, delay, damping, friction, resolution] = [1e-3, 0.0, 2.0, 0.1, 1e-5];
        LoopProfile { period, delay, damping, friction, resolution, rated_stiffness }
    }

    fn show(&mut self, output: &HandOutput) {
        self.shown.lock().unwrap().outputs.push(*output);
    }

    fn heard_ns(&mut self) -> Option<u64> {
        self.shown.lock().unwrap().heard_ns
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}

impl Drop for FakeDisplay {
    fn drop(&mut self) {
        self.shown.lock().unwrap().dropped = true;
    }
}

/// The other ends of both.
#[derive(Clone)]
pub struct Wearer {
    pub said: Arc<Mutex<Said>>,
    pub shown: Arc<Mutex<Shown>>,
}

pub fn devices(rendering: Rendering) -> (Wearer, Box<dyn Tracker>, Box<dyn ForceDisplay>) {
    devices_within(limits(), rendering)
}

pub fn devices_within(
    limits: Limits,
    rendering: Rendering,
) -> (Wearer, Box<dyn Tracker>, Box<dyn ForceDisplay>) {
    let said = Arc::new(Mutex::new(Said::default()));
    let shown = Shown { outputs: Vec::with_capacity(100_000), heard_ns: None, dropped: false };
    let shown = Arc::new(Mutex::new(shown));
    let tracker = FakeTracker { said: said.clone(), told: None };
    let display = FakeDisplay { shown: shown.clone(), rendering, limits };
    (Wearer { said, shown }, Box::new(tracker), Box::new(display))
}

impl Wearer {
    /// The device is heard now.
    pub fn alive(&self, now_ns: u64) {
        self.shown.lock().unwrap().heard_ns = Some(now_ns);
    }

    pub fn say(&self, now_ns: u64, pose: Option<LivePose>) {
        let mut said = self.said.lock().unwrap();
        said.next = Some(HandSample { side: Side::Right, time_ns: now_ns, pose });
        said.heard_ns = Some(now_ns);
    }

    pub fn last(&self) -> HandOutput {
        *self.shown.lock().unwrap().outputs.last().expect("an output")
    }
}

/// The loop on a clock that a test turns, beside a simulation that a test steps.
pub struct Rig {
    pub clock: ManualLoop,
    pub port: SimulationPort,
    pub session: Session,
    pub wearer: Wearer,
    pub now_ns: u64,
    pub wrist: Pose,
    rest: [f64; ANGLES],
    index: usize,
}

impl Rig {
    pub fn new(settings: &Settings, rendering: Rendering) -> Self {
        Self::of(SCENE, settings, rendering)
    }

    /// With another scene, whose first hand is a right one.
    pub fn of(scene: &str, settings: &Settings, rendering: Rendering) -> Self {
        Self::within(limits(), scene, settings, rendering)
    }

    /// With another device as well.
    pub fn within(limits: Limits, scene: &str, settings: &Settings, rendering: Rendering) -> Self {
        let session = session(scene);
        let (wearer, tracker, display) = devices_within(limits, rendering);
        let clock = ManualLoop::new(settings, vec![tracker], vec![display]).expect("a loop");
        let mut port = clock.port();
        port.attach(&session).expect("a hand");
        let hand = &session.hands()[0];
        let wrist = session.world().rigid_pose(hand.handle.bones.start) * hand.wrist_B();
        let rest = hand.angles().map(|range| range.map_or(0.0, |range| range.rest));
        Self { clock, port, session, wearer, now_ns: MS, wrist, rest, index: 4 }
    }

    /// The hand at rest with the index finger's knuckle flexed by so much \[rad\].
    pub fn pose(&self, flexion: f64) -> LivePose {
        let mut angles = self.rest;
        angles[self.index] += flexion;
        LivePose::Angles { wrist: self.wrist, angles }
    }

    /// One millisecond; the device lives.
    pub fn tick(&mut self) {
        self.now_ns += MS;
        self.wearer.alive(self.now_ns);
        assert!(self.clock.tick(self.now_ns));
        while self.clock.records.pop().is_ok() {}
    }

    /// A frame of a hand that is held where it is: bones do not follow.
    pub fn blocked_frame(&mut self) {
        self.port.before_step(&mut self.session, self.now_ns).expect("hands as before");
        self.port.after_step(&mut self.session, self.now_ns);
    }

    /// A step of the scene, led by the loop, and its frame.
    pub fn simulated_frame(&mut self) {
        self.port.before_step(&mut self.session, self.now_ns).expect("hands as before");
        self.session.step(&mut ());
        self.port.after_step(&mut self.session, self.now_ns);
    }

    /// Runs for so many milliseconds, a frame and a sample in each; the finger is at `flexion(ms)`.
    pub fn run(&mut self, ms: u64, flexion: impl Fn(u64) -> f64) {
        for k in 0..ms {
            self.blocked_frame();
            let pose = self.pose(flexion(k));
            self.wearer.say(self.now_ns, Some(pose));
            self.tick();
        }
    }

    /// Armed, and at full force where there is any.
    pub fn engaged(&mut self) {
        self.run(1000, |_| 0.0);
        self.clock.remote().arm();
        self.run(500, |_| 0.0);
    }

    /// Engaged and pressing with the index finger: tracked pads are inside the blocked
    /// hand's by some millimetres.
    pub fn pressing(&mut self) {
        self.engaged();
        self.run(600, |ms| PRESS * (ms as f64 / 500.0).min(1.0));
        assert!(self.index_force() > 0.2, "{}", self.index_force());
    }

    pub fn index_force(&self) -> f64 {
        self.wearer.last().digits[1].pad_force
    }
}

/// How far the index finger flexes to press \[rad\].
pub const PRESS: f64 = 0.2;

/// Every change between successive outputs of one device is allowed by its slew limit, and every
/// number is finite and within the limits.
pub fn check_outputs(outputs: &[HandOutput]) {
    let limits = limits();
    let sound = |f: f64| f.is_finite() && (0.0..=limits.force_max()).contains(&f);
    for pair in outputs.windows(2) {
        let dt = (pair[1].time_ns - pair[0].time_ns) as f64 * 1e-9;
        for (before, after) in pair[0].digits.iter().zip(&pair[1].digits) {
            assert!(sound(after.pad_force), "{after:?}");
            let change = (after.pad_force - before.pad_force).abs();
            assert!(change <= limits.change_max(dt) + 1e-12, "{change} N in {dt} s");
            let along = after.force_W.norm();
            assert!((along - after.pad_force).abs() < 1e-9, "{along} {}", after.pad_force);
            let rest = [after.area, after.pressure_mean, after.pressure_max, after.slip_speed];
            assert!(rest.iter().all(|x| x.is_finite()));
        }
    }
}
