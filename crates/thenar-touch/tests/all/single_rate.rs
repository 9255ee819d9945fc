//! Goal: with the whole simulation inside the haptic tick, the wearer feels the drive's other end.
//! Method: a ball led onto a floor at 1 kHz, an uneven clock, a hand that is somewhere else.

use crate::common::body;
use thenar_core::model::{Digit, Motion, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Pose, Vec3, World};
use thenar_touch::{
    BoneFrame, CouplingDesign, HapticHand, Pad, ProxyTargets, RigidState, SingleRate,
    SingleRateSettings, Touch, series_drive,
};

const MS: u64 = 1_000_000;
/// Radius of the bone, a ball: it rests on the floor when its centre is this high.
const RADIUS: f64 = 0.008;
const MASS: f64 = 0.004;

/// A floor (body 0) and a bone (body 1) on a drive of 400 N/m, without weight.
fn single_rate(height: f64) -> SingleRate {
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
    SingleRate::new(settings, world, bone..bone + 1).expect("a hand of one bone")
}

fn no_frame() -> BoneFrame {
    BoneFrame::new(&[RigidState::at_rest(Pose::identity())], 0)
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
            touch.lead(0, RigidState::at_rest(Pose::translation(0.0, low, 0.0)));
            let report = touch.tick(now, &frame);
            assert!(report.world.is_none_or(|world| !world.non_finite));
            pressed = pad.read(&touch, report.step).pad_force;
        }
        assert!((pressed - 1.6).abs() < 1e-3, "{lengths:?}: {pressed} N");
        let bone = touch.world().unwrap().rigid_pose(1).position.y;
        assert!((bone - RADIUS).abs() < 1e-5, "the bone rests on the floor: {bone} m");
        let mut back = ProxyTargets::new(touch.bones());
        touch.write_targets(now, &mut back);
        assert!((back.proxies[0].pose_WB.position.y - (RADIUS - 0.004)).abs() < 1e-6);
    }
}

/// A hand that nobody leads pulls at nobody; one led 4 mm into the floor pulls with 1.6 N; one that
/// is somewhere else, in empty air, says so for one tick and soon pulls no more.
#[test]
fn a_hand_is_felt_once_it_is_led() {
    let mut touch = single_rate(RADIUS + 0.002);
    let frame = no_frame();
    let mut now = 0;
    let mut tick = |touch: &mut SingleRate, place: Option<[f64; 2]>| {
        now += MS;
        if let Some([x, y]) = place {
            touch.lead(0, RigidState::at_rest(Pose::translation(x, y, 0.0)));
        }
        touch.tick(now, &frame);
        (touch.device_wrenches()[0][0].norm(), touch.jumped(0))
    };
    for _ in 0..100 {
        assert_eq!(tick(&mut touch, None), (0.0, false));
    }
    let mut pressed = 0.0;
    for _ in 0..1000 {
        let (force, jumped) = tick(&mut touch, Some([0.0, RADIUS - 0.004]));
        assert!(!jumped);
        pressed = force;
    }
    assert!((pressed - 1.6).abs() < 1e-3, "{pressed} N");
    touch.set_out(0);
    for k in 0..1000 {
        let (force, jumped) = tick(&mut touch, Some([0.5, 0.1]));
        assert_eq!(jumped, k == 0);
        pressed = force;
    }
    assert!(pressed < 1e-6, "{pressed} N");
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
