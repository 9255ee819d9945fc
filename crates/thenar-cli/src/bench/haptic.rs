//! What one tick of the haptic loop costs.

use super::samples::Samples;
use std::hint::black_box;
use std::time::Instant;
use thenar::haptic::{CouplingDesign, Proxies, RigidState};
use thenar::{Mat3, Pose, Quat, Vec3};

const BONES: usize = 16;
/// Ticks that are timed together, since one is hardly longer than reading the clock.
const TOGETHER: u32 = 20;

/// Median and 99th percentile of a step of 16 proxies, each with two couplings \[us\]: tracked poses
/// and simulated bones are a centimetre and 20 degrees apart.
pub fn proxies_us() -> (f64, f64) {
    let bones: Vec<RigidState> = (0..BONES)
        .map(|i| RigidState {
            velocity_W: Vec3::new(0.1, -0.02, 0.05),
            angular_velocity_W: Vec3::new(1.0, 0.5, -2.0),
            ..RigidState::at_rest(Pose::translation(0.02 * i as f64, 0.01, -0.03))
        })
        .collect();
    let turn = Quat::from_scaled_axis(Vec3::new(0.3, 0.1, -0.1));
    let tracked: Vec<RigidState> = bones
        .iter()
        .map(|bone| {
            let place = bone.pose_WB.position - Vec3::y() * 0.01;
            RigidState { pose_WB: Pose::new(place, turn), ..*bone }
        })
        .collect();
    let inertia = Mat3::from_diagonal(&Vec3::new(3e-7, 3e-8, 3.1e-7));
    let proxy = CouplingDesign::default().proxy(0.004, &inertia);
    let Ok(mut proxies) = Proxies::new(vec![proxy; BONES], &bones) else {
        return (f64::NAN, f64::NAN);
    };
    let mut times = Samples::default();
    for _ in 0..2000 {
        let begun = Instant::now();
        for _ in 0..TOGETHER {
            proxies.step(1e-3, black_box(&tracked), black_box(&bones));
        }
        times.push(begun.elapsed().as_secs_f64() * 1e6 / f64::from(TOGETHER));
    }
    (times.quantile(0.5), times.quantile(0.99))
}
