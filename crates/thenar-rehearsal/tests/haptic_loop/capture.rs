//! Real hands (an excerpt of a capture, `data/SOURCE.md`) through the loop, clean and mangled:
//! noise, drop-outs, frozen frames, the two hands taken for each other. The left hand pinches.

use crate::rig::{MS, devices, limits, session};
use std::path::Path;
use std::sync::{Arc, Mutex};
use thenar_core::model::Side;
use thenar_core::{Pose, Quat};
use thenar_link::haptic_loop::{LoopMode, ManualLoop, Settings};
use thenar_link::{HandOutput, HandSample, Rendering, Tracker};
use thenar_scene::session::Random;
use thenar_touch::safety::Status;
use thenar_track::live::LivePose;
use thenar_track::{Recording, TrackedSample};

/// The left hand can touch itself; the right one is bones alone, which is quicker.
const SCENE: &str = "version = 1
time_step = 0.016
gravity = [0, 0, 0]
[[hand]]
preset = \"paper\"
name = \"left\"
tets = 600
model = \"left\"
[[hand]]
preset = \"paper\"
name = \"right\"
model = \"right\"
flesh = false
";
const SIDES: [Side; 2] = [Side::Left, Side::Right];

/// Tells of both hands.
#[derive(Clone, Default)]
struct Headset {
    next: Arc<Mutex<[Option<HandSample>; 2]>>,
    told: [Option<HandSample>; 2],
}

impl Tracker for Headset {
    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        let slot = side as usize;
        self.told[slot] = Some(self.next.lock().unwrap()[slot].take()?);
        self.told[slot].as_ref()
    }

    fn heard_ns(&mut self) -> Option<u64> {
        None
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}

/// What becomes of a sample on its way.
type Mangle = fn(&mut Headset, side: Side, at_ns: u64, [Pose; 25], &mut Random);

fn say(headset: &mut Headset, side: Side, time_ns: u64, joints: [Pose; 25]) {
    let pose = Some(LivePose::Joints { joints, radii: [0.009; 25] });
    headset.next.lock().unwrap()[side as usize] = Some(HandSample { side, time_ns, pose });
}

fn clean(headset: &mut Headset, side: Side, at: u64, joints: [Pose; 25], _: &mut Random) {
    say(headset, side, at, joints);
}

/// Two millimetres and three degrees per joint; one sample in five is lost; a fifth of a second is
/// frozen, stamped as new; for a while the hands are taken for each other, and flicker.
fn bad(headset: &mut Headset, side: Side, at: u64, mut joints: [Pose; 25], random: &mut Random) {
    let ms = at / MS;
    let lost = random.symmetric() > 0.6;
    for pose in &mut joints {
        pose.position += random.vector(2e-3);
        pose.rotation = Quat::from_scaled_axis(random.vector(0.05)) * pose.rotation;
    }
    let frozen = (1500..1700).contains(&ms);
    let swapped = (1900..2100).contains(&ms) && (ms / 22).is_multiple_of(2);
    let other = SIDES[1 - side as usize];
    match () {
        () if lost => (),
        () if frozen => {
            let last = headset.told[side as usize].clone();
            if let Some(HandSample { pose: Some(LivePose::Joints { joints, .. }), .. }) = last {
                say(headset, side, at, joints);
            }
        }
        () if swapped => say(headset, other, at, joints),
        () => say(headset, side, at, joints),
    }
}

/// What came of it.
struct Outcome {
    /// Largest force on the left thumb and index finger \[N\].
    pinch: f64,
    /// Ticks in which the left hand's guards let force through.
    live: u32,
    trips: Vec<String>,
}

fn play(mode: LoopMode, mangle: Mangle) -> Outcome {
    let file =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../thenar-link/tests/data/quest3-two-hands.jsonl");
    let capture = Recording::open(Path::new(file)).expect("a capture");
    let mut session = session(SCENE);
    let (wearer, _, display) = devices(Rendering::Tendons);
    let mut headset = Headset::default();
    let settings = Settings { mode, ..Settings::default() };
    let trackers: Vec<Box<dyn Tracker>> = vec![Box::new(headset.clone())];
    let mut clock = ManualLoop::new(&settings, trackers, vec![display]).expect("a loop");
    let mut port = clock.port();
    port.attach(&session).expect("two hands");
    clock.remote().arm();
    let mut random = Random::new(7);
    let mut out = Outcome { pinch: 0.0, live: 0, trips: Vec::new() };
    let begin = 400;
    let mut at = [0; 2];
    for ms in 1..=2800u64 {
        let now = ms * MS;
        for side in SIDES {
            let samples: &[TrackedSample] = capture.hand(side);
            // The first pose is held while the hand sets out and the guards wait.
            let t = 1e-3 * ms.saturating_sub(begin) as f64;
            let k = &mut at[side as usize];
            let new =
                ms < begin && ms % 11 == 0 || *k + 1 < samples.len() && samples[*k + 1].time <= t;
            while *k + 1 < samples.len() && samples[*k + 1].time <= t {
                *k += 1;
            }
            if new {
                mangle(&mut headset, side, now, samples[*k].joints, &mut random);
                // What is being said is what the headset will have told.
                let said = headset.next.lock().unwrap()[side as usize].clone();
                headset.told[side as usize] = said.or(headset.told[side as usize].take());
            }
        }
        if ms % 16 == 0 {
            port.before_step(&mut session, now).expect("the same hands");
            let report = session.step(&mut ());
            assert!(!report.non_finite && session.world().state().is_sound(), "{ms} ms");
            port.after_step(&mut session, now);
            check_joints(&session, ms);
        }
        wearer.alive(now);
        assert!(clock.tick(now));
        while let Ok(record) = clock.records.pop() {
            let open = matches!(record.status, Status::Live | Status::Ramping { .. });
            out.live += u32::from(record.side == Side::Left && open);
        }
        if let Some(reason) = clock.core(|core| core.tripped()) {
            out.trips.push(format!("{ms} ms: {reason}"));
            clock.remote().arm();
        }
    }
    let outputs = wearer.shown.lock().unwrap().outputs.clone();
    for side in SIDES {
        let of_side: Vec<_> = outputs.iter().filter(|o| o.side == side).copied().collect();
        assert!(of_side.len() == 2800);
        check(&of_side);
        if side == Side::Left {
            let pinch = |o: &HandOutput| o.digits[0].pad_force.min(o.digits[1].pad_force);
            out.pinch = of_side.iter().map(pinch).fold(0.0, f64::max);
        }
    }
    out
}

/// Within limits, and within the slew unless all was stopped at once.
fn check(outputs: &[HandOutput]) {
    let limits = limits();
    for pair in outputs.windows(2) {
        let dt = (pair[1].time_ns - pair[0].time_ns) as f64 * 1e-9;
        let stopped = pair[1].digits.iter().all(|d| d.pad_force == 0.0);
        for (before, after) in pair[0].digits.iter().zip(&pair[1].digits) {
            let (force, change) = (after.pad_force, (after.pad_force - before.pad_force).abs());
            assert!(force.is_finite() && (0.0..=limits.force_max()).contains(&force), "{force} N");
            assert!(stopped || change <= limits.change_max(dt) + 1e-12, "{change} N in {dt} s");
        }
    }
}

/// No joint far beyond its range: couplings that are thrown about overdrive the bones alone by 0.1
/// rad.
fn check_joints(session: &thenar_scene::session::Session, ms: u64) {
    let world = session.world();
    for (j, joint) in world.desc().joints.iter().enumerate() {
        let angles = world.joint_angles(j as u32);
        for (axis, angle) in joint.axes.iter().zip(angles) {
            let Some(limit) = axis.limit else { continue };
            let beyond = (limit.min - angle).max(angle - limit.max);
            assert!(beyond < 0.2, "{ms} ms, {}: {angle} rad is {beyond} beyond", joint.name);
        }
    }
}

/// Bones without flesh meet nothing, however they are moved: nothing is felt, and forces engage and
/// stay so.
#[test]
fn a_captured_pinch_that_touches_nothing_is_felt_as_nothing() {
    for mode in [LoopMode::Multirate, LoopMode::Shared] {
        let out = play(mode, clean);
        println!("{mode:?}: {} N, live for {} ms", out.pinch, out.live);
        assert_eq!(out.trips, [""; 0]);
        assert!(out.live > 1500, "{mode:?}: live for {} ms", out.live);
        assert!(out.pinch < 0.02, "{mode:?}: {} N", out.pinch);
    }
}

#[test]
fn mangled_hands_stay_within_all_limits() {
    for mode in [LoopMode::Multirate, LoopMode::Shared] {
        let out = play(mode, bad);
        println!("{mode:?}: {} N, live for {} ms, trips {:?}", out.pinch, out.live, out.trips);
        assert!(out.live > 300, "{mode:?}: the guards must have had something to do: {}", out.live);
    }
}
