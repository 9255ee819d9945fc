//! Goal: a haptic tick allocates nothing. Method: a global allocator that counts, around ticks of a
//! hand of 16 bones with new frames, contacts, guards and a trip; around frames that a world
//! publishes.

#[path = "../../thenar-core/tests/common/mod.rs"]
mod common;

use common::{body, finger};
use thenar_core::model::Motion;
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Pose, Vec3, World};
use thenar_testing::allocations;
use thenar_touch::safety::{Bank, Limits, Signal, Trip};
use thenar_touch::shared::CondensedContact;
use thenar_touch::{
    BoneFrame, BoneJoint, CouplingDesign, HandSettings, HapticHand, ProxyMode, ProxyTargets,
    RigidState, SingleRate, SingleRateSettings, Touch, pad_force,
};

#[global_allocator]
static ALLOCATOR: allocations::Counting = allocations::Counting;

const BONES: usize = 16;

/// Each bone on its coupling alone, over its own contact.
fn fill(frame: &mut BoneFrame, contacts: usize) {
    let proxy = CouplingDesign::default().proxy(0.004, &Mat3::from_diagonal_element(1e-7));
    let response = &mut frame.response;
    response.clear();
    for i in 0..BONES {
        response.springs.push(proxy.bone);
        response.targets.push(frame.bones[i]);
    }
    let n = 6 * BONES;
    let on = |k: usize| if k % 6 < 3 { proxy.bone.stiffness } else { proxy.bone.angular_stiffness };
    response
        .compliance
        .extend((0..n * n).map(|i| if i / n == i % n { 1.0 / on(i / n) } else { 0.0 }));
    for i in 0..contacts {
        let normal = Mat3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
        let contact = CondensedContact {
            frame: normal,
            value: Vec3::zeros(),
            friction: 0.5,
            force: Vec3::zeros(),
        };
        response.contacts.push(contact);
        for (axis, sign) in [(1, 1.0), (0, 1.0), (2, -1.0)] {
            let at = 6 * (i % BONES) + axis;
            response.rows.extend((0..n).map(|c| if c == at { sign } else { 0.0 }));
        }
    }
    let m = 3 * contacts;
    response.local.extend((0..m * m).map(|i| if i / m == i % m { 1e-4 } else { 0.0 }));
    assert!(response.prepare());
}

#[test]
fn a_haptic_tick_allocates_nothing() {
    let start: Vec<RigidState> = (0..BONES)
        .map(|i| RigidState::at_rest(Pose::translation(0.02 * i as f64, 0.0, 0.0)))
        .collect();
    let proxy = CouplingDesign::default().proxy(0.004, &Mat3::from_diagonal_element(1e-7));
    let settings = HandSettings { mode: ProxyMode::SharedConstraints, ..HandSettings::default() };
    let mut hand = HapticHand::new(settings, vec![proxy; BONES], &start, 40).unwrap();
    let [at_parent, at_child] = [Vec3::x() * 0.01, Vec3::x() * -0.01];
    hand.set_joints((1..BONES).map(|child| BoneJoint {
        parent: child - 1,
        child,
        at_parent,
        at_child,
    }));
    let mut newest = BoneFrame::new(&start, 40);
    let frames = [5, 40, 0].map(|contacts| {
        let mut frame = BoneFrame::new(&start, 40);
        fill(&mut frame, contacts);
        frame
    });
    let mut back = ProxyTargets::new(&start);
    let limits = Limits { ramp: 0.1, ..Limits::cybergrasp() };
    let mut bank = Bank::<1>::new(&[limits; 5], 200).unwrap();
    bank.arm();
    let mut forces = [[0.0]; 5];

    let (mut active, mut felt) = (0, 0.0_f64);
    let before = allocations::so_far();
    for tick in 1..1000u64 {
        let now = tick * 1_000_000;
        if tick % 50 == 0 {
            newest.copy_from(&frames[(tick / 50) as usize % 3]);
            newest.step = tick / 50;
            newest.time_ns = now;
        }
        for (i, state) in start.iter().enumerate() {
            let place = state.pose_WB.position - Vec3::y() * 1e-5 * tick as f64;
            let pose_WB = Pose::new(place, state.pose_WB.rotation);
            hand.lead(i, RigidState::at_rest(pose_WB));
        }
        active = active.max(hand.tick(now, &newest).contact.active);
        hand.write_targets(now, &mut back);
        let signals: [Signal<1>; 5] = std::array::from_fn(|finger| {
            let [force, _] = hand.proxies().device_wrenches()[3 * finger + 3];
            let pad = pad_force(&force, &hand.tracked()[3 * finger + 3].pose_WB);
            Signal {
                force: [pad],
                velocity: [-0.01],
                simulation_ns: newest.time_ns.max(1),
                tracking_ns: now,
                device_ns: now,
                enabled: true,
            }
        });
        bank.tick(now, &signals, &mut forces);
        felt = felt.max(forces[0][0]);
        if tick == 900 {
            bank.trip(Trip::Requested);
        }
    }
    let after = allocations::so_far();
    assert_eq!(active, 40, "all contacts of the largest frame must bear");
    assert!(felt > 0.5 && forces == [[0.0]; 5], "{felt} N, then {forces:?}");
    assert_eq!(after - before, 0, "allocations in 1000 ticks");
}

/// A soft finger pressed on a floor: steps, frames, and the whole world within the tick.
#[test]
fn writing_targets_and_single_rate_allocate_nothing() {
    let mut desc = finger(1e8, 1.0 / 60.0);
    let mut floor = body("floor", 1.0, [1.0; 3], Vec3::y() * -0.001);
    floor.motion = Motion::Prescribed;
    floor.shape = Some(Shape::HalfSpace);
    desc.add_rigid(floor);
    let proxy = CouplingDesign::default().proxy(0.003, &Mat3::from_diagonal_element(1e-7));
    desc.drives[..2].fill(Some(proxy.bone));
    let inside = World::new(desc.clone()).unwrap();
    let mut world = World::new(desc).unwrap();
    let start = [0, 1].map(|b| RigidState::of(&world, b));
    let mut touch = SingleRate::new(SingleRateSettings::default(), inside, 0..2).unwrap();
    let mut frame = BoneFrame::new(&start, 40);
    let mut input = world.input();
    let mut run = |steps: u64| {
        let mut contacts = 0;
        for k in 0..steps {
            for (b, state) in start.iter().enumerate() {
                let low = state.pose_WB.position - Vec3::y() * 1e-4 * k as f64;
                let pose = Pose::new(low, state.pose_WB.rotation);
                input.targets[b] = Some(RigidState::at_rest(pose).target());
                touch.lead(b, RigidState::at_rest(pose));
            }
            world.step(&input, &mut ());
            assert!(world.condense(0..2, &input, &mut frame));
            contacts = contacts.max(frame.response.contacts.len());
            touch.tick((k + 1) * 1_000_000, &frame);
        }
        contacts
    };
    run(1);
    let (allocated, contacts) = allocations::count(|| run(60));
    assert!(contacts > 10, "{contacts} contacts");
    assert_eq!(allocated, 0, "allocations in 60 frames");
}
