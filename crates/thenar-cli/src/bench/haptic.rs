//! What one tick of the haptic loop costs.

use super::samples::Samples;
use std::hint::black_box;
use std::time::Instant;
use thenar::model::Side;
use thenar::{Mat3, Pose, Quat, Vec3};
use thenar_link::haptic_loop::{ManualLoop, Settings, page_tracker};
use thenar_link::now_ns;
use thenar_scene::live::LivePose;
use thenar_scene::motion::ANGLES;
use thenar_touch::{CouplingDesign, Proxies, RigidState, TrackerTiming};

const BONES: usize = 16;
/// Ticks that are timed together, since one is hardly longer than reading the clock.
const TOGETHER: u32 = 20;

/// Median and 99th percentile of a whole tick \[us\]: a new pose of a tracked hand, 16 proxies, five
/// guarded fingers, records, beside the newest frame of a hand that grasps bread.
///
/// # Errors
/// The scene or the loop cannot be made.
pub fn tick_us() -> Result<(f64, f64), String> {
    let told = |error: &dyn std::fmt::Display| error.to_string();
    let scene = std::path::Path::new("bread-grasp");
    let mut session =
        crate::run::open(scene, &["hand.hand.preset=paper".to_owned()]).map_err(|e| told(&e))?;
    let opened = thenar_link::open("null:right").map_err(|e| told(&e))?;
    let (mut poses, page) = page_tracker(TrackerTiming::HEADSET);
    let displays = opened.display.into_iter().collect();
    let mut ticks =
        ManualLoop::new(&Settings::default(), vec![page], displays).map_err(|e| told(&e))?;
    let mut port = ticks.port();
    port.attach(&session).map_err(|e| told(&e))?;
    ticks.remote().arm();
    let palm = session.hands()[0].handle.bones.start;
    let wrist = session.world().rigid_pose(palm) * session.hands()[0].wrist_B();
    let mut times = Samples::default();
    for k in 0..3000_u32 {
        if k.is_multiple_of(20) {
            port.before_step(&mut session, now_ns()).map_err(|e| told(&e))?;
            session.step(&mut ());
            port.after_step(&mut session, now_ns());
        }
        let flexion = 0.3 * (1.0 - (f64::from(k) * 6e-3).cos());
        let pose = LivePose::Angles { wrist, angles: [flexion; ANGLES] };
        poses.put(Side::Right, Some(pose));
        // Ticks as far apart as they would be, so that steps are of that length.
        let now = now_ns();
        let begun = Instant::now();
        ticks.tick(now);
        times.push(begun.elapsed().as_secs_f64() * 1e6);
        while ticks.records.pop().is_ok() {}
        while now_ns() - now < 1_000_000 {
            std::hint::spin_loop();
        }
    }
    Ok((times.quantile(0.5), times.quantile(0.99)))
}

/// Prints what a tick costs.
///
/// # Errors
/// As [`tick_us`].
pub fn run() -> Result<(), String> {
    let (proxies, proxies_p99) = proxies_us();
    println!("{:44}{:>10}{:>10}", "", "median", "p99");
    println!("{:44}{proxies:>7.2} us{proxies_p99:>7.2} us", "16 proxies, two couplings each");
    let (tick, tick_p99) = tick_us()?;
    println!("{:44}{tick:>7.2} us{tick_p99:>7.2} us", "a whole tick, pose to guarded forces");
    Ok(())
}

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
