//! One step of the haptic loop's parts, for a hand of 16 bones. Run with
//! `cargo bench -p thenar --bench haptic`.

use divan::{Bencher, black_box};
use thenar::haptic::{CouplingDesign, Proxies, RigidState};
use thenar::{Mat3, Pose, Quat, Vec3};

fn main() {
    divan::main();
}

const BONES: usize = 16;

/// Tracked poses and simulated bones that a press has driven apart by a centimetre and 20 degrees.
fn hand() -> (Proxies, Vec<RigidState>, Vec<RigidState>) {
    let inertia = Mat3::from_diagonal(&Vec3::new(3e-7, 3e-8, 3.1e-7));
    let proxy = CouplingDesign::default().proxy(0.004, &inertia);
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
    let proxies = Proxies::new(vec![proxy; BONES], &bones).expect("the bench's own proxies");
    (proxies, tracked, bones)
}

/// The paper: 95 µs on a 2.4 GHz quad-core of 2009.
#[divan::bench]
fn proxies_16_bones(bencher: Bencher) {
    let (mut proxies, tracked, bones) = hand();
    bencher.bench_local(|| proxies.step(1e-3, black_box(&tracked), black_box(&bones)));
}
