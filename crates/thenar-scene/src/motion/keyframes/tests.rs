//! Goal: keyed motions reach their keys, are smooth, stay within limits, and refuse bad input.

use super::*;
use crate::motion::fixture::hand;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;
use thenar_core::kinematics::velocity_between;
use thenar_testing::Mutator;

const MOTION: &str = r#"
[[key]]
time = 0.0
pose = "rest"
wrist = { position = [0.1, 0.2, 0.3], fingers = [0, 0, -1], back = [0, 1, 0] }
[[key]]
time = 0.5
pose = "relaxed"
wrist = { position = [0.1, 0.1, 0.3] }
[[key]]
time = 0.9
curl = { index = 1.0 }
joints = { thumb-metacarpal = { flexion_deg = 20, spread_deg = 10 } }
wrist = { fingers = [1, 0, 0], back = [0, 1, 0.2] }
[[key]]
time = 1.4
pose = "open"
wrist = { position = [-0.1, 0.15, 0.3], rotation = [0, 0, 0, 1] }
"#;

fn desc(text: &str) -> KeyframesDesc {
    KeyframesDesc::parse(text, Path::new("test.toml")).unwrap()
}

fn motion(text: &str, flip: bool) -> Keyframes {
    Keyframes::new(&desc(text), &hand(flip), &Pose::identity()).unwrap()
}

fn fails(text: &str, with: &str) {
    let error = KeyframesDesc::parse(text, Path::new("test.toml"))
        .and_then(|desc| Keyframes::new(&desc, &hand(false), &Pose::identity()))
        .unwrap_err()
        .to_string();
    assert!(error.contains(with), "{error}");
}

fn sample(motion: &mut Keyframes, time: f64) -> Vec<Target> {
    let mut out = vec![None; 16];
    motion.sample(time, &mut out);
    out.into_iter().flatten().collect()
}

#[test]
fn velocities_are_the_derivative_of_poses() {
    let mut motion = motion(MOTION, false);
    let h = 1e-5;
    for i in -50..1500 {
        let time = f64::from(i) * 1e-3 + 0.31e-3;
        let (before, at, after) = (
            sample(&mut motion, time - h),
            sample(&mut motion, time),
            sample(&mut motion, time + h),
        );
        assert_eq!(at.len(), 16);
        for b in 0..16 {
            let [linear, angular] =
                velocity_between(&before[b].pose_WB, &after[b].pose_WB, 2.0 * h);
            assert!((linear - at[b].velocity_W).norm() < 1e-5, "{time} {b}");
            assert!((angular - at[b].angular_velocity_W).norm() < 1e-4, "{time} {b}");
        }
    }
}

#[test]
fn the_start_placement_is_where_the_first_targets_hold_a_hand_at_rest() {
    let mut motion = motion(MOTION, false);
    let hand = hand(false);
    let pose_WM = motion.start_placement();
    for (bone, target) in hand.bones.iter().zip(sample(&mut motion, 0.0)) {
        let placed = pose_WM * bone.pose_MB;
        assert!((placed.position - target.pose_WB.position).norm() < 1e-12);
        assert!(placed.rotation.angle_to(&target.pose_WB.rotation) < 1e-7);
        assert_eq!(target.velocity_W, Vec3::zeros());
    }
}

#[test]
fn a_bent_index_points_down_whatever_the_axes_of_the_rig() {
    let text = r#"
        [[key]]
        time = 0.0
        wrist = { position = [0, 0, 0], fingers = [0, 0, -1], back = [0, 1, 0] }
        joints = { index-proximal = { flexion_deg = 90 } }
        [[key]]
        time = 1.0
        joints = { index-proximal = { flexion_deg = 0, spread_deg = 20 }, ring-proximal = { spread_deg = 20 } }
    "#;
    for flip in [false, true] {
        let mut motion = motion(text, flip);
        // Knuckle at (-25, 0, -90) mm, tip 87 mm further: straight down at 90°.
        let bent = sample(&mut motion, 0.0)[6].pose_WB.point(&Vec3::new(0.0, 0.0, -0.01));
        assert!((bent - Vec3::new(-0.025, -0.087, -0.09)).norm() < 1e-12, "{bent}");
        // Spread: the index goes to -x, the ring finger to +x.
        let spread = sample(&mut motion, 1.0);
        let (sin, cos) = 20f64.to_radians().sin_cos();
        let index = spread[6].pose_WB.point(&Vec3::new(0.0, 0.0, -0.01));
        assert!((index - Vec3::new(-0.025 - 0.087 * sin, 0.0, -0.09 - 0.087 * cos)).norm() < 1e-12);
        assert!(spread[12].pose_WB.position.x > 0.04);
    }
}

#[test]
fn angles_stay_within_limits() {
    let text = r#"
        limits = "clamp"
        [[key]]
        time = 0.0
        joints = { middle-proximal = { flexion_deg = 200 } }
        [[key]]
        time = 1.0
        pose = "fist"
        [[key]]
        time = 1.1
        pose = "open"
    "#;
    let mut motion = motion(text, true);
    assert_eq!(motion.warnings().len(), 1);
    assert!(motion.warnings()[0].contains("90.0°"), "{:?}", motion.warnings());
    let tree = motion.articulation.tree.clone();
    for i in 0..1200 {
        let poses: Vec<_> =
            sample(&mut motion, f64::from(i) * 1e-3).iter().map(|t| t.pose_WB).collect();
        let mut angles = vec![[0.0; 2]; 15];
        tree.angles(&poses, &mut angles);
        for (j, angles) in angles.iter().enumerate() {
            let clamped = tree.clamp(j, *angles);
            assert!((clamped[0] - angles[0]).abs() < 1e-9 && (clamped[1] - angles[1]).abs() < 1e-9);
        }
    }
    assert!(tree.limits(6)[1].is_some_and(|l| (l.max - FRAC_PI_2).abs() < 1e-12));
}

#[test]
fn times_that_are_no_numbers_leave_the_targets_finite() {
    let mut motion = motion(MOTION, false);
    for time in [f64::NAN, f64::INFINITY, -1e300, 1e300, f64::NEG_INFINITY] {
        for target in sample(&mut motion, time) {
            assert!(target.pose_WB.is_finite());
            assert!(target.velocity_W.iter().all(|x| x.is_finite()));
        }
    }
}

#[test]
fn what_is_wrong_is_named() {
    fails("", "at least one key");
    fails("[[key]]\ntime = 0\nwrits = 1", "line 3");
    fails("[[key]]\ntime = nan", "between 0 and 1e6");
    fails("[[key]]\ntime = 1\n[[key]]\ntime = 1", "key 2 (time 1 s): time must be later");
    fails("[[key]]\ntime = 0\nwrist = { position = [0, nan, 0] }", "wrist position");
    fails("[[key]]\ntime = 0\nwrist = { fingers = [0, 1, 0] }", "both `fingers` and `back`");
    fails("[[key]]\ntime = 0\nwrist = { fingers = [0, 1, 0], back = [0, 2, 0] }", "not parallel");
    fails("[[key]]\ntime = 0\nwrist = { rotation = [0, 0, 0, 0] }", "unit quaternion");
    fails("[[key]]\ntime = 0\npose = \"wave\"", "unknown variant `wave`");
    fails("[[key]]\ntime = 0\ncurl = { index = 2 }", "curl of index must be in 0..1");
    fails("[[key]]\ntime = 0\ncurl = { palm = 1 }", "no palm");
    fails("[[key]]\ntime = 0\njoints = { toe = {} }", "no joint `toe`");
    let beyond = "[[key]]\ntime = 0\njoints = { index-proximal = { flexion_deg = 91 } }";
    fails(beyond, "index-proximal`: flexion 91° is out of range, the nearest is 90.0°");
    let none = "[[key]]\ntime = 0\njoints = { index-distal = { spread_deg = 1 } }";
    fails(none, "`index-distal` has no spread");
}

#[test]
fn damaged_files_are_read_or_refused_but_never_harm() {
    let mut mutator = Mutator::new(7);
    let (mut made, mut refused) = (0, 0);
    for _ in 0..3000 {
        let text = String::from_utf8_lossy(&mutator.damage(MOTION.as_bytes())).into_owned();
        let motion = KeyframesDesc::parse(&text, Path::new("x"))
            .and_then(|desc| Keyframes::new(&desc, &hand(false), &Pose::identity()));
        let Ok(mut motion) = motion else {
            refused += 1;
            continue;
        };
        made += 1;
        for k in 0..10 {
            let targets = sample(&mut motion, f64::from(k) * 0.2);
            assert!(targets.len() == 16 && targets.iter().all(|t| t.pose_WB.is_finite()));
        }
    }
    assert!(made > 100 && refused > 500, "{made} {refused}");
}

/// Fingers bend before the thumb lies over them, and it is off them before they straighten; from a
/// fist to a pointing hand, too. A thumb that a key names itself goes straight there.
#[test]
fn a_thumb_goes_aside_where_fingers_pass() {
    let text = |own: &str| {
        format!(
            r#"
            [[key]]
            time = 0
            pose = "open"
            [[key]]
            time = 1
            pose = "fist"
            {own}
            [[key]]
            time = 2
            pose = "fist"
            {own}
            [[key]]
            time = 3
            pose = "point"
            {own}
            [[key]]
            time = 4
            pose = "open"
            "#
        )
    };
    let thumb = |motion: &mut Keyframes, time: f64| {
        let poses: Vec<_> = sample(motion, time).iter().map(|t| t.pose_WB).collect();
        let mut angles = vec![[0.0; 2]; 15];
        motion.articulation.tree.angles(&poses, &mut angles);
        angles[1][0].abs().to_degrees()
    };
    let mut fist = motion(&text(""), false);
    let aside = [0.75, 2.25, 2.75, 3.25].map(|t| thumb(&mut fist, t));
    assert!(aside.iter().all(|angle| *angle < 1e-6), "{aside:?}");
    let over = [1.0, 1.5, 2.0, 3.0].map(|t| thumb(&mut fist, t));
    assert!(over.iter().all(|angle| (angle - 30.0).abs() < 1e-6), "{over:?}");
    // Keys that bend other digits meanwhile put the way off until they are there.
    let late = r#"
        [[key]]
        time = 0
        pose = "open"
        [[key]]
        time = 9
        joints = { index-proximal = { flexion_deg = 10 } }
        [[key]]
        time = 10
        pose = "fist"
    "#;
    let mut late = motion(late, false);
    let before = [9.0, 9.75].map(|t| thumb(&mut late, t));
    assert!(before.iter().all(|angle| *angle < 1e-6), "{before:?}");
    let mut own = motion(&text("joints = { thumb-proximal = { flexion_deg = 30 } }"), false);
    assert!(thumb(&mut own, 0.75) > 15.0 && (thumb(&mut own, 2.5) - 30.0).abs() < 1e-6);
}

/// Pads are where a key wants them at its time, wherever the wrist has gone; what is out of reach
/// is refused, or told.
#[test]
fn fingertips_come_to_their_places() {
    let text = |place: &str| {
        format!(
            "[[key]]\ntime = 0.0\npose = \"rest\"\n\
             wrist = {{ position = [0.1, 0.2, 0.3], fingers = [0, 0, -1], back = [0, 1, 0] }}\n\
             [[key]]\ntime = 0.5\nwrist = {{ position = [0.1, 0.1, 0.3] }}\n\
             tips = {{ index = {place} }}\n"
        )
    };
    // Below the knuckle, which is 25 mm aside of the wrist's middle and 90 mm before it.
    let place = Vec3::new(0.07, 0.05, 0.18);
    for flip in [false, true] {
        let hand = hand(flip);
        let desc = desc(&text("[0.07, 0.05, 0.18]"));
        let mut motion = Keyframes::new(&desc, &hand, &Pose::identity()).unwrap();
        assert!(motion.warnings().is_empty(), "{:?}", motion.warnings());
        let chain = thenar_track::reach::Chain::new(
            &hand,
            thenar_core::model::Digit::Index,
            thenar_track::reach::PadPlace::Tip,
        )
        .unwrap();
        let tip = sample(&mut motion, 0.5)[chain.pad.bone].pose_WB;
        let pad = tip.point(&(chain.pad.centre_B + chain.pad.normal_B * chain.pad.radius));
        assert!((pad - place).norm() < 1e-3, "{pad} m");
        // Others stay at rest.
        let (start, end) = (sample(&mut motion, 0.0), sample(&mut motion, 0.5));
        let relative =
            |bones: &[Target], bone: usize| bones[0].pose_WB.inverse() * bones[bone].pose_WB;
        let other =
            hand.bones.iter().rposition(|b| b.digit == thenar_core::model::Digit::Ring).unwrap();
        let moved = relative(&start, other).position - relative(&end, other).position;
        assert!(moved.norm() < 1e-12, "{moved} m");
    }
    fails(&text("[0.07, 0.05, -0.4]"), "the index's pad ends");
    fails(&text("[0.07, 1e9, -0.4]"), "is not within 1 km");
    fails(&text("[0.07, 0.05]"), "3");
    let clamped = format!("limits = \"clamp\"\n{}", text("[0.07, 0.05, -0.4]"));
    let motion = motion(&clamped, false);
    assert!(motion.warnings().iter().any(|w| w.contains("the index's pad ends")));
}
