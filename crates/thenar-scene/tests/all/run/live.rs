//! Goal: a session can be driven live: poses move its hand and press things, scripts come back,
//! the scene starts over. Method: shipped scenes, poses made from known wrists, and a real capture.

use std::path::Path;
use thenar_core::model::Side;
use thenar_core::{Pose, Quat, Vec3};
use thenar_scene::live::{LiveError, LivePose, Mover};
use thenar_scene::motion::{ANGLES, Recording, size_ratio};
use thenar_scene::session::{HandLoad, Session, Summary, builtin};

/// A shipped scene, with the paper's hand if it has one.
fn shipped(name: &str) -> Session {
    let text = builtin(name).expect("a scene").text;
    let paper = text.contains("[[hand]]").then(|| "hand.0.preset=paper".to_owned());
    Session::from_text(text, Path::new("test.toml"), paper.as_slice())
        .unwrap_or_else(|e| panic!("{e}"))
}

fn angles(session: &Session) -> [f64; ANGLES] {
    session.hands()[0].angles().map(|angle| angle.map_or(0.0, |angle| angle.rest))
}

/// Where the targets and the simulated bones have the wrist.
fn wrists(session: &Session) -> [Pose; 2] {
    let hand = &session.hands()[0];
    let palm = hand.handle.bones.start;
    let target = session.input().targets[palm as usize].expect("a target").pose_WB;
    [target, session.world().rigid_pose(palm)].map(|pose| pose * hand.wrist_B())
}

/// Runs for `seconds` with poses at 100 Hz.
fn live(session: &mut Session, seconds: f64, pose: impl Fn(f64) -> LivePose) {
    let (start, mut next) = (session.world().time(), 0.0);
    while session.world().time() - start < seconds - 1e-9 {
        while next <= session.world().time() - start + 1e-9 {
            session.live_pose(0, 50.0 + next, &pose(next)).expect("a pose");
            next += 0.01;
        }
        assert!(!session.step(&mut ()).non_finite);
    }
}

#[test]
fn a_hand_follows_poses_presses_the_table_and_goes_back_to_its_script() {
    let mut session = shipped("table-press");
    let flat = angles(&session);
    assert_eq!(session.hands_of(Side::Right).collect::<Vec<_>>(), [0]);
    assert_eq!(session.hands_of(Side::Left).count(), 0);
    assert_eq!(session.mover(0), Mover::Script);
    // Fingers forwards, palm down, 12 cm up; then down until the palm would be below the table.
    let at = |height: f64| LivePose::Angles {
        wrist: Pose::new(Vec3::new(0.05, height, 0.05), Quat::identity()),
        angles: flat,
    };
    live(&mut session, 1.5, |_| at(0.12));
    assert_eq!(session.mover(0), Mover::Live);
    let [target, wrist] = wrists(&session);
    assert!((target.position - Vec3::new(0.05, 0.12, 0.05)).norm() < 1e-6);
    assert!((wrist.position - target.position).norm() < 0.02);
    assert_eq!(session.hand_loads(0), [HandLoad::default(); 6]);

    live(&mut session, 1.5, |t| at((0.12 - 0.2 * t).max(0.02)));
    let loads = session.hand_loads(0);
    let pressing: f64 = loads.iter().map(|load| load.normal).sum();
    let carried: f64 = session.world().contacts().iter().map(|c| c.force_W.y).sum();
    assert!(pressing > 3.0 && (pressing - carried.abs()).abs() < 1e-9, "{pressing} {carried}");
    assert!(loads.iter().all(|load| (load.normal > 0.0) == (load.area > 0.0)));
    let mut summary = Summary::new(&session);
    summary.take(&session);
    assert_eq!(summary.fingers, loads[1..]);

    session.live_lost(0);
    assert_eq!(session.mover(0), Mover::Lost);
    session.follow_script(0);
    assert_eq!(session.mover(0), Mover::Script);
    let mut scripted = shipped("table-press");
    while session.world().time() < 4.6 {
        assert!(!session.step(&mut ()).non_finite);
    }
    while scripted.world().time() < session.world().time() - 1e-9 {
        scripted.step(&mut ());
    }
    assert_eq!(session.input().targets, scripted.input().targets);
}

#[test]
fn who_only_watches_sees_the_same_bits_and_a_restart_repeats_them() {
    let run = |session: &mut Session, steps: u32| {
        for _ in 0..steps {
            session.step(&mut ());
        }
        session.world().state_hash()
    };
    for name in ["bread-grasp", "car-grasp", "soft-cube"] {
        let mut session = shipped(name);
        let first = run(&mut session, 70);
        let later = run(&mut session, 30);
        session.restart();
        assert_eq!((session.steps(), session.world().time()), (0, 0.0));
        assert_eq!(run(&mut session, 70), first, "{name}");
        assert_eq!(run(&mut session, 30), later, "{name}");
        assert_eq!(run(&mut shipped(name), 70), first, "{name}");
    }
}

#[test]
fn a_live_hand_stays_live_through_a_restart() {
    let mut session = shipped("free-motion");
    let rest = angles(&session);
    let wrist = Pose::new(Vec3::new(0.15, 0.3, -0.1), Quat::identity());
    let pose = LivePose::Angles { wrist, angles: rest };
    live(&mut session, 1.2, |_| pose.clone());
    session.restart();
    assert_eq!(session.mover(0), Mover::Live);
    let start = wrists(&shipped("free-motion"))[1];
    assert!((wrists(&session)[1].position - start.position).norm() < 1e-9);
    session.live_pose(0, 99.0, &pose).expect("a pose");
    session.step(&mut ());
    // It sets out from there softly.
    assert!((wrists(&session)[0].position - start.position).norm() < 1e-3);
    live(&mut session, 1.5, |_| pose.clone());
    assert!((wrists(&session)[0].position - wrist.position).norm() < 1e-6);
}

#[test]
fn hands_that_cannot_follow_say_why() {
    let text =
        "version = 1\n[[hand]]\npreset = \"paper\"\nname = \"loose\"\ntets = 300\ndriven = false\n";
    let mut session = Session::from_text(text, Path::new("t.toml"), &[]).expect("a scene");
    let pose = LivePose::Angles { wrist: Pose::identity(), angles: [0.0; ANGLES] };
    let error = session.live_pose(0, 0.0, &pose).unwrap_err();
    assert_eq!(error, LiveError::NotDriven { hand: "loose".into() });
    let error = session.live_pose(1, 0.0, &pose).unwrap_err();
    assert_eq!(error.to_string(), "there is no hand 1: the scene has 1");
    // Nobody there: nothing happens.
    session.live_lost(3);
    session.follow_script(3);
    assert_eq!((session.mover(3), session.wearer_length(3)), (Mover::Script, None));
}

/// Where `THENAR_MOTION_DIR` names the folder that holds a capture: it is played live at its own
/// times, and targets are compared with it.
#[test]
fn a_real_capture_is_followed_live() {
    let Some(folder) = std::env::var_os("THENAR_MOTION_DIR") else {
        eprintln!("skipped: THENAR_MOTION_DIR is not set");
        return;
    };
    let file = Path::new(&folder).join("quest3-two-hands-8s.jsonl");
    let recording = Recording::open(&file).expect("a capture");
    let samples = recording.hand(Side::Right);
    for h in ["0.005", "0.016666666666666666"] {
        let text = builtin("free-motion").expect("a scene").text;
        let overrides = [format!("time_step={h}"), "hand.0.preset=paper".into()];
        let mut session =
            Session::from_text(text, Path::new("t.toml"), &overrides).expect("a scene");
        let h = session.world().time_step();
        let (begin, mut next) = (samples[0].time, 0);
        // Interpolated truth, `None` where the tracker had lost the hand.
        let truth = |t: f64| {
            let k = samples.partition_point(|s| s.time <= t + begin);
            let (a, b) = (samples.get(k.checked_sub(1)?)?, samples.get(k)?);
            let u = (t + begin - a.time) / (b.time - a.time);
            let turn = a.joints[0].rotation.slerp(&b.joints[0].rotation, u);
            let place = a.joints[0].position.lerp(&b.joints[0].position, u);
            (b.time - a.time < 0.05).then(|| Pose::new(place, turn))
        };
        let lags: Vec<f64> = (-4..=12).map(|k| f64::from(k) * 2.5e-3).collect();
        let mut sums = vec![[0.0; 2]; lags.len()];
        let (mut n, mut worst, mut speed, mut settled) = (0.0, 0.0_f64, 0.0_f64, 0.0);
        let mut held = 0.0;
        let mut before = wrists(&session)[0];
        while session.world().time() < samples[samples.len() - 1].time - begin {
            let now = session.world().time();
            while samples.get(next).is_some_and(|s| s.time - begin <= now) {
                let sample = &samples[next];
                let pose = LivePose::Joints { joints: sample.joints, radii: [0.01; 25] };
                session.live_pose(0, sample.time, &pose).expect("a pose");
                next += 1;
            }
            assert!(!session.step(&mut ()).non_finite);
            let t = session.world().time();
            let target = wrists(&session)[0];
            speed = speed.max((target.position - before.position).norm() / h);
            before = target;
            // Losses and what follows them are not lag.
            let known = lags.iter().map(|lag| truth(t - lag)).collect::<Option<Vec<_>>>();
            let Some(known) = known.filter(|_| session.mover(0) == Mover::Live) else {
                settled = t + 1.2;
                continue;
            };
            if t < settled.max(1.2) {
                continue;
            }
            for (sum, truth) in sums.iter_mut().zip(&known) {
                sum[0] += (target.position - truth.position).norm_squared();
                sum[1] += target.rotation.angle_to(&truth.rotation).powi(2);
            }
            held += (samples[next - 1].joints[0].position - known[4].position).norm_squared();
            worst = worst.max((target.position - known[4].position).norm());
            n += 1.0;
        }
        let rms = |k: usize| sums[k].map(|sum| (sum / n).sqrt());
        let best = (0..lags.len()).min_by(|a, b| rms(*a)[0].total_cmp(&rms(*b)[0])).expect("lags");
        let [place, turn] = rms(4);
        println!(
            "step {:.1} ms, {n} steps: wrist {:.2} mm and {:.2}° rms, {:.1} mm at most; best lag {:.1} ms ({:.2} mm); newest sample {:.2} mm",
            h * 1e3,
            place * 1e3,
            turn.to_degrees(),
            worst * 1e3,
            lags[best] * 1e3,
            rms(best)[0] * 1e3,
            (held / n).sqrt() * 1e3,
        );
        assert!(n * h > 2.0 && speed <= 4.0 * (1.0 + 1e-9), "{n} {speed}");
        // Closer than to stay at the newest sample, which is what a tracker gives.
        assert!(place < 0.8 * (held / n).sqrt() && place < 5e-3, "{place}");
        assert!(turn.to_degrees() < 3.0, "{turn}");
        assert!(lags[best].abs() < 0.011, "{}", lags[best]);
        let length = session.wearer_length(0).expect("a length");
        let ratio = size_ratio(&session.hands()[0].model, samples).expect("a size");
        assert!((length / session.hands()[0].model.length / ratio - 1.0).abs() < 0.01);
    }
}
