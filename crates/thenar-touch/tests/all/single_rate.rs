//! Goal: with the whole simulation inside the haptic tick, the wearer feels the drive's other end.
//! Method: a ball led onto a floor at 1 kHz, an uneven clock, a tracker that jumps.

use crate::common::body;
use thenar::model::{Digit, Motion, WorldDesc};
use thenar::shape::Shape;
use thenar::{Mat3, Pose, Vec3, World};
use thenar_touch::sampled::Sampled;
use thenar_touch::{
    CouplingDesign, FastToSlow, HapticHand, Pad, RigidState, SingleRate, SingleRateSettings,
    SlowToFast, Touch, series_drive,
};

const MS: u64 = 1_000_000;
/// Radius of the bone, a ball: it rests on the floor when its centre is this high.
const RADIUS: f64 = 0.008;
const MASS: f64 = 0.004;

/// A floor (body 0) and a bone (body 1) on a drive of 400 N/m, without weight.
fn single_rate(height: f64) -> Sampled<SingleRate> {
    let mut desc = WorldDesc { gravity: Vec3::zeros(), ..WorldDesc::default() };
    let mut floor = body("floor", 1.0, [1.0; 3], Vec3::zeros());
    floor.motion = Motion::Prescribed;
    floor.shape = Some(Shape::HalfSpace);
    desc.add_rigid(floor);
    let mut bone = body("bone", MASS, [2e-7; 3], Vec3::y() * height);
    bone.shape = Some(Shape::Sphere { radius: RADIUS });
    let bone = desc.add_rigid(bone);
    let proxy = CouplingDesign::default().proxy(MASS, &Mat3::from_diagonal_element(2e-7));
    desc.drives[bone as usize] = Some(series_drive(&proxy.device, &proxy.bone));
    let (settings, world) = (SingleRateSettings::default(), World::new(desc).unwrap());
    let touch = SingleRate::new(settings, world, bone..bone + 1).expect("a hand of one bone");
    Sampled::new(Box::new(touch))
}

fn no_frame() -> SlowToFast {
    SlowToFast::new(&[RigidState::at_rest(Pose::identity())], 0)
}

/// Led 4 mm into the floor: 400 N/m times 4 mm at rest, whatever the length of the ticks.
#[test]
fn a_floor_is_as_stiff_as_the_drive() {
    for lengths in [[1.0, 1.0], [0.5, 1.5], [0.02, 1.98]] {
        let mut touch = single_rate(RADIUS + 0.002);
        let mut pad = Pad::new(Digit::Index, 0, Vec3::zeros());
        let frame = no_frame();
        let (mut now, mut pressed) = (0, 0.0);
        for tick in 0..1000usize {
            now += (lengths[tick % 2] * MS as f64) as u64;
            let low = RADIUS + 0.002 - 0.006 * (now as f64 / 5e8).min(1.0);
            touch.track(0, now, Pose::translation(0.0, low, 0.0), None);
            let report = touch.tick(now, &frame);
            assert!(report.world.is_none_or(|world| !world.non_finite));
            pressed = pad.read(&touch, report.step).pad_force;
        }
        assert!((pressed - 1.6).abs() < 1e-3, "{lengths:?}: {pressed} N");
        let bone = touch.world().unwrap().rigid_pose(1).position.y;
        assert!((bone - RADIUS).abs() < 1e-5, "the bone rests on the floor: {bone} m");
        let mut back = FastToSlow::new(touch.bones());
        touch.publish(now, &mut back);
        assert!((back.proxies[0].pose_WB.position.y - (RADIUS - 0.004)).abs() < 1e-6);
    }
}

/// Before the first sample nothing pulls; a hand found half a metre away, and a jump as far, are
/// followed without a kick: nothing is felt on the way, and at its end no more than inertia asks.
#[test]
fn jumps_are_followed_without_a_kick() {
    let mut touch = single_rate(0.1);
    let frame = no_frame();
    let mut largest = 0.0_f64;
    for tick in 1..=3000u64 {
        let now = tick * MS;
        if tick > 100 {
            let x = if tick < 1500 { 0.5 } else { 0.0 };
            touch.track(0, now, Pose::translation(x, 0.1, 0.0), None);
        }
        let report = touch.tick(now, &frame);
        let force = touch.device_wrenches()[0][0].norm();
        if tick <= 100 {
            assert_eq!((force, report.tracking_age), (0.0, f64::INFINITY));
        }
        assert_eq!(touch.jumped(0), tick == 1500);
        largest = largest.max(force);
        let [there, want] = [&touch.bones()[0], &touch.tracked()[0]].map(|s| s.pose_WB.position);
        assert!(force == 0.0 || (there - want).norm() < 0.05, "{tick}: {force} N on the way");
        if [1499, 3000].contains(&tick) {
            assert!((there - want).norm() < 1e-4, "{tick}: {there} {want}");
            assert!(force < 0.01);
        }
    }
    // A mass of 4 g brought to 0.5 m / 0.15 s by two dampers in series, from rest.
    let proxy = CouplingDesign::default().proxy(MASS, &Mat3::from_diagonal_element(2e-7));
    let drive = series_drive(&proxy.device, &proxy.bone);
    let speed = 0.5 / 0.15;
    let bound = speed * (drive.damping + (MASS * drive.stiffness).sqrt());
    assert!(largest < bound, "{largest} N of {bound} N; the spring alone would pull 200 N");
}

/// The loop around holds either kind by the same handle.
#[test]
fn both_kinds_of_hand_are_ticked_alike() {
    let start = [RigidState::at_rest(Pose::identity())];
    let proxy = CouplingDesign::default().proxy(MASS, &Mat3::from_diagonal_element(2e-7));
    let coupled = HapticHand::new(Default::default(), vec![proxy], &start, 0).unwrap();
    let hands: [Box<dyn Touch>; 2] = [Box::new(coupled), Box::new(single_rate(0.1))];
    for mut hand in hands {
        let mut pad = Pad::new(Digit::Index, 0, Vec3::zeros());
        hand.lead(0, RigidState::at_rest(Pose::translation(0.0, 0.1, 0.0)));
        let report = hand.tick(2 * MS, &no_frame());
        assert!(pad.read(&*hand, report.step).pad_force.is_finite());
    }
}
