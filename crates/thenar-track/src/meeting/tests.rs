use super::{LED, Meeting, PRESS, Pair};
use crate::fixture;
use crate::reach::{Angles, Chain, Goal, PadKinematics, PadPlace, solve};
use crate::recording::mirrored;
use crate::tracker::Tracker;
use crate::{Articulation, Retarget};
use thenar_core::model::{Digit, HandModel};
use thenar_core::{Pose, Quat, Vec3};

const OPPOSED: [Digit; 2] = [Digit::Thumb, Digit::Index];

fn chains(hand: &HandModel) -> [Chain; 2] {
    OPPOSED.map(|digit| Chain::new(hand, digit, PadPlace::Tip).unwrap())
}

/// Angles of all joints at which thumb and index finger of a hand face each other, their skins
/// `gap` \[m\] apart.
fn pinched(hand: &HandModel, gap: f64) -> Vec<[f64; 2]> {
    let chains = chains(hand);
    let mut at: [Angles; 2] = [chains[0].ease(), chains[1].ease()];
    let mut miss = [f64::INFINITY; 2];
    for _ in 0..200 {
        let [thumb, index] = [0, 1].map(|k| chains[k].reach(&at[k]));
        let (middle, axis) = ((thumb.centre + index.centre) / 2.0, thumb.normal - index.normal);
        for (k, sign) in [(0, -1.0), (1, 1.0)] {
            let away = axis.normalize() * sign;
            let centre = middle + away * (chains[k].pad.radius + gap / 2.0);
            let ease = chains[k].ease();
            miss[k] = solve(&chains[k], &ease, &mut at[k], &Goal { centre, normal: -away }, 3);
        }
    }
    assert!(miss.iter().all(|miss| *miss < 2e-3), "{miss:?} m at a gap of {gap} m");
    let mut angles = Articulation::new(hand).unwrap().rest_angles;
    chains.iter().zip(&at).for_each(|(chain, at)| chain.write(at, &mut angles));
    angles
}

/// Returns the joints that a tracker sees of a hand at these angles, somewhere in the world,
/// turned.
fn watched(theirs: &HandModel, angles: &[[f64; 2]]) -> [Pose; 25] {
    let turned = Quat::from_scaled_axis(Vec3::new(0.4, -1.1, 0.7));
    let root = Pose::new(Vec3::new(0.3, 0.2, -0.1), turned);
    let motion = |_: f64| (root, angles.to_vec());
    Tracker::new(theirs, &motion).joints(0.0)
}

/// Our angles for what a tracker sees, which lets pads meet or not.
fn angles_for(ours: &HandModel, joints: &[Pose; 25], mirror: bool, meets: bool) -> Vec<[f64; 2]> {
    let articulation = Articulation::new(ours).unwrap();
    let mut found = vec![[0.0; 2]; ours.joints.len()];
    let bones = vec![Pose::identity(); ours.bones.len()];
    let mut retarget = Retarget::uncalibrated(ours, mirror).unwrap();
    if !meets {
        retarget.meeting = None;
    }
    retarget.apply(&articulation, joints, &mut found, &mut bones.clone(), &mut bones.clone());
    found
}

fn carried(ours: &HandModel, theirs: &HandModel, angles: &[[f64; 2]]) -> Vec<[f64; 2]> {
    angles_for(ours, &watched(theirs, angles), false, true)
}

/// From the thumb's skin to the index finger's at their pads \[m\], and the cosine of the larger
/// angle at which they face each other.
fn between(hand: &HandModel, angles: &[[f64; 2]]) -> (f64, f64) {
    let chains = chains(hand);
    let [thumb, index] = [0, 1].map(|k| chains[k].reach(&chains[k].read(angles)));
    let way = index.centre - thumb.centre;
    let radii = chains[0].pad.radius + chains[1].pad.radius;
    let facing = thumb.normal.dot(&way).min(-index.normal.dot(&way)) / way.norm();
    (way.norm() - radii, facing)
}

/// Lengths of thumb and fingers over ours, and the size of the whole hand.
const HANDS: [[f64; 3]; 7] = [
    [1.0, 1.0, 1.0],
    [0.9, 1.06, 1.0],
    [1.1, 0.95, 1.0],
    [0.85, 1.1, 0.9],
    [1.15, 0.9, 1.2],
    [1.0, 1.0, 0.7],
    [1.0, 1.2, 1.0],
];

fn proportioned([thumb, fingers, whole]: [f64; 3]) -> HandModel {
    let mut hand = fixture::scaled(fixture::hand(false), whole);
    hand.bones.iter_mut().for_each(|bone| bone.radius *= whole);
    for digit in Digit::FINGERS {
        fixture::lengthen(&mut hand, digit, if digit == Digit::Thumb { thumb } else { fingers });
    }
    hand
}

/// Pads that touch on the tracked hand press into each other on ours by `PRESS`, whatever the two
/// hands' proportions, the sense of our joints and the side that is tracked: within 2 mm, by which
/// pads are nearer that do not face each other quite.
#[test]
fn pads_that_touch_meet_whatever_the_proportions() {
    for flip in [false, true] {
        let ours = fixture::hand(flip);
        for proportions in HANDS {
            let theirs = proportioned(proportions);
            let joints = watched(&theirs, &pinched(&theirs, 0.0));
            for mirror in [false, true] {
                let seen = if mirror { joints.each_ref().map(mirrored) } else { joints };
                let (gap, facing) = between(&ours, &angles_for(&ours, &seen, mirror, true));
                let what = format!("{proportions:?}, {flip}, {mirror}: {gap} m, {facing}");
                assert!((gap + PRESS).abs() < 2e-3 && facing > 0.8, "{what}");
            }
        }
    }
}

/// By rotations alone pads of hands of other proportions end up to centimetres apart.
#[test]
fn rotations_alone_leave_pads_apart() {
    let ours = fixture::hand(false);
    let gap = |proportions| {
        let theirs = proportioned(proportions);
        let joints = watched(&theirs, &pinched(&theirs, 0.0));
        between(&ours, &angles_for(&ours, &joints, false, false)).0
    };
    assert!(HANDS.into_iter().map(gap).fold(0.0, f64::max) > 0.01);
}

/// Wearers who feel the forces press with fingers of their own: pads that touch then touch, and do
/// not press.
#[test]
fn pads_touch_without_press_where_forces_are_felt() {
    let ours = fixture::hand(false);
    for proportions in HANDS {
        let theirs = proportioned(proportions);
        let joints = watched(&theirs, &pinched(&theirs, 0.0));
        let mut retarget = Retarget::uncalibrated(&ours, false).unwrap();
        retarget.without_press();
        let mut found = vec![[0.0; 2]; ours.joints.len()];
        let bones = vec![Pose::identity(); ours.bones.len()];
        let articulation = Articulation::new(&ours).unwrap();
        retarget.apply(&articulation, &joints, &mut found, &mut bones.clone(), &mut bones.clone());
        let (gap, _) = between(&ours, &found);
        assert!(gap.abs() < 3e-3, "{proportions:?}: {gap} m");
    }
}

/// No angle jumps as tracked pads close by 50 µm at a time: none changes by more than twelve times
/// as much as the tracked ones do at most. The gap's own slope is 1 + 1.5 · 11 mm / 6.4 mm = 3.6
/// where pads begin to press, and pads turn to face each other on the way.
#[test]
fn pads_close_without_a_jump() {
    let ours = fixture::hand(false);
    let largest = |a: &[[f64; 2]], b: &[[f64; 2]]| {
        let ways = a.as_flattened().iter().zip(b.as_flattened());
        ways.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    for proportions in HANDS {
        let theirs = proportioned(proportions);
        let [far, near] = [0.026, 0.0].map(|gap| pinched(&theirs, gap));
        let steps = 600;
        let at = |k: usize| -> Vec<[f64; 2]> {
            let part = k as f64 / steps as f64;
            let between =
                |(a, b): (&[f64; 2], &[f64; 2])| [0, 1].map(|i| a[i] + (b[i] - a[i]) * part);
            far.iter().zip(&near).map(between).collect()
        };
        let mut before: Option<Vec<[f64; 2]>> = None;
        let moved = largest(&at(1), &at(0));
        for k in 0..=steps {
            let angles = carried(&ours, &theirs, &at(k));
            if let Some(before) = before {
                let answer = largest(&angles, &before);
                assert!(answer < 12.0 * moved, "{proportions:?}, {k}: {answer} rad of {moved}");
            }
            before = Some(angles);
        }
    }
}

/// Pads that are farther apart than they are led by each other do as rotations say, to the bit.
#[test]
fn pads_far_apart_are_led_by_rotations_alone() {
    let ours = fixture::hand(false);
    let theirs = proportioned(HANDS[1]);
    let joints = watched(&theirs, &Articulation::new(&theirs).unwrap().rest_angles);
    let [with, without] = [true, false].map(|meets| angles_for(&ours, &joints, false, meets));
    assert_eq!(with, without);
}

/// A thumb on the back of a finger, or beside it, pinches nothing however near it is.
#[test]
fn pads_that_do_not_face_each_other_are_left_alone() {
    let reached = |normal: Vec3| PadKinematics {
        centre: Vec3::zeros(),
        normal,
        moves: [Vec3::zeros(); crate::reach::FREEDOMS_MAX],
        turns: [Vec3::zeros(); crate::reach::FREEDOMS_MAX],
    };
    let weight = |thumb: Vec3, finger: Vec3, apart: f64| {
        let pads = Vec3::x() * apart;
        Pair::new([0.008; 2], PRESS, [&reached(thumb), &reached(finger)], &pads).weight
    };
    let x = Vec3::x();
    assert_eq!(weight(x, -x, 0.016), 1.0);
    assert_eq!(weight(x, x, 0.016), 0.0);
    assert_eq!(weight(-x, -x, 0.016), 0.0);
    // A thumb touches with its tip or its side as well, a finger does not.
    assert_eq!(weight(Vec3::y(), -x, 0.016), 1.0);
    assert_eq!(weight(x, Vec3::y(), 0.016), 0.0);
    assert_eq!(weight(x, -x, 0.016 * (1.0 + LED[0])), 0.0);
}

/// A hand without tracked joints has no pads to meet, nor has one whose last bones are no digit's
/// last; joints that lie in one place, or are no places, move nothing.
#[test]
fn pads_that_are_not_tracked_do_not_meet() {
    let mut hand = fixture::hand(false);
    hand.bones.iter_mut().for_each(|bone| bone.tracked_joint = None);
    assert!(Meeting::of(&hand).is_none());
    let mut hand = fixture::hand(false);
    hand.bones.last_mut().unwrap().tracked_joint = Some("pinky-finger-tip".into());
    assert_eq!(Meeting::of(&hand).unwrap().tips.len(), 4);
    hand.bones[3].tracked_joint = Some("thumb-tip".into());
    assert!(Meeting::of(&hand).is_none());

    let ours = fixture::hand(false);
    let meeting = Meeting::of(&ours).unwrap();
    let mut joints = watched(&ours, &pinched(&ours, 0.0));
    joints[4].position.x = f64::NAN;
    for joints in [[Pose::identity(); 25], joints] {
        let mut angles = vec![[0.1; 2]; 15];
        meeting.apply(&joints, &Quat::identity(), &mut angles);
        assert_eq!(angles, vec![[0.1; 2]; 15]);
    }
}
