//! Goal: fingers are where the wrist is, no fresher than the staler of the two, and neither's clock
//! does harm. Method: two trackers that say what a test wants.

use super::*;
use std::cell::Cell;
use std::collections::VecDeque;
use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, Mutex};
use thenar_core::{Quat, Vec3};
use thenar_track::ANGLES;

const SIDE: Side = Side::Right;

thread_local! {
    static NOW: Cell<u64> = const { Cell::new(1000) };
}

/// Says each sample once, one per call.
#[derive(Clone, Default)]
struct Script(Arc<Mutex<VecDeque<HandSample>>>, Option<HandSample>);

impl Script {
    fn say(&self, time_ns: u64, pose: Option<LivePose>) {
        self.0.lock().unwrap().push_back(HandSample { side: SIDE, time_ns, pose });
    }
}

impl Tracker for Script {
    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        self.1 = self.0.lock().unwrap().pop_front();
        self.1.as_ref().filter(|sample| sample.side == side)
    }

    fn heard_ns(&mut self) -> Option<u64> {
        None
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}

fn fingers(angle: f64) -> Option<LivePose> {
    Some(LivePose::Angles { wrist: Pose::identity(), angles: [angle; ANGLES] })
}

fn wrist(pose: Pose) -> Option<LivePose> {
    let mut joints = [Pose::translation(9.0, 9.0, 9.0); 25];
    joints[0] = pose;
    Some(LivePose::Joints { joints, radii: [0.01; 25] })
}

fn pair(pose_TW: Pose) -> (Script, Script, Paired) {
    let (glove, base) = (Script::default(), Script::default());
    let paired =
        Paired::with_clock(Box::new(glove.clone()), Box::new(base.clone()), pose_TW, || NOW.get());
    (glove, base, paired)
}

fn told(paired: &mut Paired) -> (u64, Option<Pose>) {
    let sample = paired.latest(SIDE).expect("a sample");
    let wrist = sample.pose.as_ref().map(|pose| match pose {
        LivePose::Angles { wrist, .. } => *wrist,
        LivePose::Joints { .. } => panic!("the fingers' angles are lost"),
    });
    (sample.time_ns, wrist)
}

/// The tracker sits 0.1 m above the wrist, along its own y, which a quarter turn about z lays along
/// the world's -x: the wrist is at (2, 0, 0) + Rz(90°) (0, -0.1, 0) = (2.1, 0, 0).
#[test]
fn fingers_are_where_the_wrist_is() {
    let (glove, base, mut paired) = pair(Pose::translation(0.0, -0.1, 0.0));
    assert!(paired.latest(SIDE).is_none());
    glove.say(10, fingers(0.3));
    assert_eq!(told(&mut paired), (10, None), "a wrist that was never seen");
    let turned = Quat::from_scaled_axis(Vec3::z() * FRAC_PI_2);
    base.say(30, wrist(Pose::new(Vec3::new(2.0, 0.0, 0.0), turned)));
    let (time_ns, at) = told(&mut paired);
    let at = at.unwrap();
    assert!((at.position - Vec3::new(2.1, 0.0, 0.0)).norm() < 1e-12, "{at:?}");
    assert!(at.rotation.angle_to(&turned) < 1e-12);
    assert_eq!(time_ns, 11, "as old as the fingers, but news");
    glove.say(40, fingers(0.4));
    assert_eq!(told(&mut paired).0, 30, "as old as the wrist");
    assert!(paired.latest(SIDE).is_none(), "told once");
    base.say(50, None);
    assert_eq!(told(&mut paired), (40, None), "a wrist that is not seen");
    assert!(paired.latest(Side::Left).is_none());
    assert!(paired.messages().is_empty());
}

/// The glove's clock, the tracker's or both jump by a day, for two seconds or for good, forward
/// (which is seen at once) or back (which is believed after half a second): until then the hand is
/// as old as that time says, and from then on as fresh as it is. Every fourth sample comes twice.
/// Each jump of each clock is reported.
#[test]
fn clocks_that_jump_are_followed_and_times_never_step_back() {
    const DAY_NS: i64 = 86_400_000_000_000;
    for who in [[true, false], [false, true], [true, true]] {
        for (by, held) in [(DAY_NS, 0), (-DAY_NS, 50)] {
            for home in [300, u64::MAX] {
                let (glove, base, mut paired) = pair(Pose::identity());
                let mut message_source = paired.message_source();
                let mut last = 0;
                for k in 1..=500u64 {
                    let now = 3 * DAY_NS as u64 + 10_000_000 * k;
                    NOW.set(now);
                    let away = (100..home).contains(&k);
                    let [of_glove, of_base] = who
                        .map(|jumps| now.saturating_add_signed(if jumps && away { by } else { 0 }));
                    for _ in 0..if k % 4 == 0 { 2 } else { 1 } {
                        glove.say(of_glove, fingers(0.1));
                        base.say(of_base, wrist(Pose::translation(k as f64, 0.0, 0.0)));
                        let (time_ns, at) = told(&mut paired);
                        assert!(time_ns > last || last == now);
                        assert_eq!(at.unwrap().position.x, k as f64, "the newest, however old");
                        match away && k < 100 + held {
                            true => assert!(time_ns - last <= 1, "it stands still"),
                            false => assert!(time_ns - now <= 1, "{who:?} {by} {k}"),
                        }
                        last = time_ns;
                    }
                    let jumps = k == 100 + held || k == home;
                    let told = message_source();
                    let named = NAMES.map(|name| told.iter().any(|text| text.contains(name)));
                    assert_eq!(named, who.map(|who| who && jumps), "{k} {told:?}");
                }
                assert!(paired.messages().is_empty(), "told once, be it there or here");
            }
        }
    }
    // The end of all times is no panic.
    let (glove, base, mut paired) = pair(Pose::identity());
    NOW.set(u64::MAX);
    for _ in 0..2 {
        glove.say(u64::MAX, fingers(0.1));
        base.say(u64::MAX, wrist(Pose::identity()));
        assert_eq!(told(&mut paired).0, u64::MAX);
    }
}

/// A tracker that tells its last sample again and again, on a clock that has jumped before, leaves
/// the hand as old as that.
#[test]
fn duplicates_of_a_jumped_clock_are_no_news() {
    let (glove, base, mut paired) = pair(Pose::identity());
    const MS: u64 = 1_000_000;
    let mut before = 0;
    for k in 1..=300u64 {
        let now = 86_400_000 * MS + 10 * MS * k;
        NOW.set(now);
        glove.say(now, fingers(0.1));
        base.say(10 * MS * k.min(100), wrist(Pose::identity()));
        let (time_ns, _) = told(&mut paired);
        match k {
            0..51 => {}
            51..=100 => assert_eq!(time_ns, now),
            _ => assert_eq!(time_ns - before, 1),
        }
        before = time_ns;
    }
}

/// Pose of the wrist, for a glove on a wrist that is held still at the origin.
fn wrist_of(tracker: &str, address: Option<&str>) -> Pose {
    let profile = Wrist {
        position: [0.0, 0.1, 0.07],
        rotation: [0.0, 0.0, 0.0, 1.0],
        tracker: tracker.into(),
    };
    let parsed = Address { wrist: address.map(str::to_owned), ..Address::default() };
    let glove = crate::open("null:right").unwrap();
    let mut tracker = with_wrist(glove, &profile, "null", &parsed).unwrap().tracker.unwrap();
    let begun = std::time::Instant::now();
    loop {
        let sample = tracker.latest(Side::Right).and_then(|sample| sample.pose.clone());
        if let Some(LivePose::Angles { wrist, .. }) = sample {
            return wrist;
        }
        assert!(begun.elapsed() < std::time::Duration::from_secs(30), "no hand");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

#[test]
fn the_profile_places_a_wrist_on_its_own_tracker_only() {
    let off = |wrist: Pose| wrist.position - wrist_of("", Some("null:right")).position;
    assert_eq!(off(wrist_of("null:right", None)), Vec3::new(0.0, 0.1, 0.07));
    assert_eq!(off(wrist_of("", Some("null:right"))), Vec3::zeros());
    // The address takes the place of the tracker that the profile names.
    assert_eq!(off(wrist_of("null:left", Some("null:right"))), Vec3::new(0.0, 0.1, 0.07));
}

/// Straight, or by way of another profile.
#[test]
fn a_glove_is_not_its_own_wrist() {
    let folder = std::env::temp_dir().join(format!("thenar-own-wrist-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = |name: &str| folder.join(name).display().to_string();
    let write = |name: &str, tracker: &str| {
        std::fs::write(file(name), format!("[wrist]\ntracker = '{tracker}'\n")).unwrap();
    };
    let why = "this is the device whose wrist it is to track";
    for driver in ["lucidgloves", "cyberglove", "cyberglove3"] {
        let own = format!("{driver}:no-such-port?profile={}", file("own.toml"));
        write("own.toml", &own);
        let there = format!("lucidgloves:none?profile={}", file("there.toml"));
        let back = format!("either:null:left||{driver}:none?profile={}", file("back.toml"));
        write("back.toml", &there);
        write("there.toml", &back);
        for (address, profile) in [(&own, "own.toml"), (&there, "back.toml"), (&back, "there.toml")]
        {
            let told = crate::open(address).map(|_| ()).unwrap_err().to_string();
            let named = format!("profile {}, wrist.tracker = \"", file(profile));
            assert!(told.starts_with(&named) && told.ends_with(why), "{told}");
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
