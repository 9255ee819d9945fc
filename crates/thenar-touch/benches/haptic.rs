//! One step of the haptic loop's parts, for a hand of 16 bones. Run with
//! `cargo bench -p thenar-touch --bench haptic`.

use divan::{Bencher, black_box};
use thenar_core::{Mat3, Pose, Quat, Vec3};
use thenar_touch::safety::{Bank, Limits, Signal};
use thenar_touch::shared::{Condensed, CondensedContact, SharedConstraints};
use thenar_touch::{
    BoneFrame, BoneJoint, CouplingDesign, HandSettings, HapticHand, Proxies, Proxy, ProxyMode,
    RigidState, Touch,
};

fn main() {
    divan::main();
}

const BONES: usize = 16;

fn proxy() -> Proxy {
    let inertia = Mat3::from_diagonal(&Vec3::new(3e-7, 3e-8, 3.1e-7));
    CouplingDesign::default().proxy(0.004, &inertia)
}

/// Tracked poses and simulated bones that a press has driven apart by a centimetre and 20 degrees.
fn hand() -> (Proxies, Vec<RigidState>, Vec<RigidState>) {
    let bones: Vec<RigidState> = (0..BONES)
        .map(|i| RigidState {
            velocity_W: Vec3::new(0.1, -0.02, 0.05),
            angular_velocity_W: Vec3::new(1.0, 0.5, -2.0),
            ..RigidState::at_rest(Pose::translation(0.02 * i as f64, 0.01, -0.03))
        })
        .collect();
    let turn = Quat::from_scaled_axis(Vec3::new(0.3, 0.1, -0.1));
    let tracked = bones
        .iter()
        .map(|bone| {
            let place = bone.pose_WB.position - Vec3::y() * 0.01;
            RigidState { pose_WB: Pose::new(place, turn), ..*bone }
        })
        .collect();
    let proxies = Proxies::new(vec![proxy(); BONES], &bones).expect("the bench's own proxies");
    (proxies, tracked, bones)
}

/// The paper: 95 µs on a 2.4 GHz quad-core of 2009.
#[divan::bench]
fn proxies_16_bones(bencher: Bencher) {
    let (mut proxies, tracked, bones) = hand();
    bencher.bench_local(|| proxies.step(1e-3, black_box(&tracked), black_box(&bones)));
}

/// Prediction of hand and bones, then the proxies.
#[divan::bench]
fn whole_tick_multirate(bencher: Bencher) {
    let (_, tracked, bones) = hand();
    let mut hand = HapticHand::new(HandSettings::default(), vec![proxy(); BONES], &bones, 0)
        .expect("the bench's own hand");
    let mut frame = BoneFrame::new(&bones, 0);
    let mut now = 0;
    bencher.bench_local(|| {
        now += 1_000_000;
        frame.time_ns = now - now % 16_000_000;
        for (i, state) in tracked.iter().enumerate() {
            hand.lead(i, *state);
        }
        hand.tick(now, black_box(&frame))
    });
}

/// Contacts that all feel each other through the bones, pressed and dragged.
fn pressed(contacts: usize, bones: &[RigidState]) -> Condensed {
    let n = 6 * BONES;
    let mut frame = Condensed::new(BONES, contacts);
    frame.springs = vec![proxy().bone; BONES];
    frame.targets = bones.to_vec();
    let share = |r: usize, c: usize| (-(r.abs_diff(c) as f64) / 12.0).exp() / 2000.0;
    frame.compliance = (0..n * n).map(|i| share(i / n, i % n)).collect();
    for i in 0..contacts {
        let turn = Quat::from_scaled_axis(Vec3::new(0.4, 0.1, 0.3) * i as f64);
        let axes = turn.to_rotation_matrix().into_inner();
        let force = Vec3::zeros();
        frame.contacts.push(CondensedContact {
            frame: axes,
            value: Vec3::x() * -1e-4,
            friction: 0.5,
            force,
        });
        for row in axes.row_iter() {
            let bone = 6 * (i % BONES);
            let on = |c: usize| if (bone..bone + 3).contains(&c) { row[c - bone] } else { 0.0 };
            frame.rows.extend((0..n).map(on));
        }
    }
    let m = 3 * contacts;
    frame.local = (0..m * m).map(|i| if i / m == i % m { 5e-4 } else { 0.0 }).collect();
    assert!(frame.prepare(), "the bench's own frame");
    frame
}

/// Contact of one tick against proxies that wander, as the loop sees it: started from the last
/// tick.
#[divan::bench(args = [10, 60])]
fn shared_constraints(bencher: Bencher, contacts: usize) {
    let (_, _, bones) = hand();
    let frame = pressed(contacts, &bones);
    let mut shared = SharedConstraints::new(BONES, contacts);
    shared.begin(&frame);
    let mut proxies = bones.clone();
    let mut tick = 0.0_f64;
    bencher.bench_local(|| {
        tick += 1.0;
        for (i, proxy) in proxies.iter_mut().enumerate() {
            proxy.pose_WB.position.y = bones[i].pose_WB.position.y + 1e-3 * (0.01 * tick).sin();
        }
        shared.resolve(black_box(&frame), &proxies, 1e-3, 1e-3, 20)
    });
}

/// A tick with ten contacts in shared constraints, of bones that a frame has turned by 20 degrees,
/// with and without their joints.
#[divan::bench(args = [0, 15])]
fn whole_tick_shared(bencher: Bencher, joints: usize) {
    let (_, tracked, bones) = hand();
    let settings = HandSettings { mode: ProxyMode::SharedConstraints, ..HandSettings::default() };
    let mut hand =
        HapticHand::new(settings, vec![proxy(); BONES], &bones, 10).expect("the bench's own hand");
    let [at_parent, at_child] = [Vec3::x() * 0.01, Vec3::x() * -0.01];
    hand.set_joints((1..=joints).map(|child| BoneJoint {
        parent: child - 1,
        child,
        at_parent,
        at_child,
    }));
    let mut frame = BoneFrame::new(&bones, 10);
    frame.response = pressed(10, &bones);
    let mut now = 0;
    bencher.bench_local(|| {
        now += 1_000_000;
        frame.time_ns = now - now % 16_000_000;
        frame.step = now / 16_000_000;
        for (i, state) in tracked.iter().enumerate() {
            hand.lead(i, *state);
        }
        hand.tick(now, black_box(&frame))
    });
}

/// The eight stages for the five fingers of a glove.
#[divan::bench]
fn safety_5_fingers(bencher: Bencher) {
    let mut bank =
        Bank::<1>::new(&[Limits::cybergrasp(); 5], 4000).expect("the bench's own limits");
    bank.arm();
    let (mut now, mut forces) = (0, [[0.0]; 5]);
    bencher.bench_local(|| {
        now += 1_000_000;
        let signal = Signal {
            force: [if now < 10_000_000 { 0.0 } else { 3.0 }],
            velocity: [-0.05],
            simulation_ns: now,
            tracking_ns: now,
            device_ns: now,
            enabled: true,
        };
        bank.tick(now, black_box(&[signal; 5]), &mut forces);
        forces
    });
}
