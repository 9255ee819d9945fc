//! Cost of one tick of the haptic loop.

use super::samples::Samples;
use std::hint::black_box;
use std::time::Instant;
use thenar_core::model::Side;
use thenar_core::{Mat3, Pose, Quat, Vec3};
use thenar_link::haptic_loop::{ManualLoop, Settings, page_tracker};
use thenar_link::now_ns;
use thenar_scene::live::LivePose;
use thenar_touch::{CouplingDesign, Proxies, RigidState, TrackerTiming};

const BONES: usize = 16;
/// Ticks that are timed together, since one is hardly longer than reading the clock.
const TOGETHER: u32 = 20;
/// Ticks from frame to frame: the scene's time step.
const FRAME: u32 = 10;
/// Time of the scene at which the hand lies on the table \[s\].
const DOWN: f64 = 1.2;
/// Then its fingers flex by so much more \[rad\].
const PRESS: f64 = 0.25;

/// Time of whole ticks \[us\]: a new pose of a tracked hand in each, 16 proxies, five guarded
/// fingers, records, beside the newest frame of the simulation.
#[derive(Default)]
struct Ticks {
    /// Ticks in which nothing pressed.
    free: Samples,
    /// Ticks in which simulated contacts pressed.
    pressing: Samples,
}

/// Ticks of a hand that presses a table as its scene's motion and then some more flexion have it,
/// and what led to them kept for incidents.
///
/// # Errors
/// The scene or the loop cannot be made.
fn ticks() -> Result<Ticks, String> {
    let told = |error: &dyn std::fmt::Display| error.to_string();
    let scene = std::path::Path::new("table-press");
    let mut session =
        crate::run::open(scene, &["hand.hand.preset=paper".to_owned()]).map_err(|e| told(&e))?;
    let opened = thenar_link::open("null:right").map_err(|e| told(&e))?;
    let (mut poses, page) = page_tracker(TrackerTiming::HEADSET);
    let displays = opened.display.into_iter().collect();
    let settings = Settings { trip_folder: Some(std::env::temp_dir()), ..Settings::default() };
    let mut ticks = ManualLoop::new(&settings, vec![page], displays).map_err(|e| told(&e))?;
    let mut port = ticks.port();
    port.attach(&session).map_err(|e| told(&e))?;
    ticks.remote().arm();
    let mut live = session.live_hand(0).map_err(|e| told(&e))?;
    let bones = session.hands()[0].handle.bones.clone();
    let mut targets = session.input().targets[bones.start as usize..bones.end as usize].to_vec();
    let mut motion = session.hands()[0].motion.clone();
    let mut times = Ticks::default();
    for k in 0..6000_u32 {
        if k.is_multiple_of(FRAME) {
            port.before_step(&mut session, now_ns()).map_err(|e| told(&e))?;
            session.step(&mut ());
            port.after_step(&mut session, now_ns());
        }
        let seconds = 1e-3 * f64::from(k);
        if let Some(motion) = &mut motion {
            motion.sample((seconds - 1.0).clamp(0.0, DOWN), &mut targets);
        }
        let mut pose = live.pose_of(&targets);
        if let LivePose::Angles { angles, .. } = &mut pose {
            let press = PRESS * (seconds - 1.0 - DOWN).clamp(0.0, 1.0);
            (1..5).for_each(|finger| angles[4 * finger] += press);
        }
        poses.put(Side::Right, Some(pose));
        // Ticks as far apart as they would be, so that steps are of that length.
        let now = now_ns();
        let begun = Instant::now();
        ticks.tick(now);
        let took = begun.elapsed().as_secs_f64() * 1e6;
        let mut pressing = false;
        while let Ok(record) = ticks.records.pop() {
            pressing |= record.contacts > 0;
        }
        if let Some(incident_reader) = &mut ticks.incident_reader {
            incident_reader.drain();
        }
        if pressing {
            times.pressing.push(took)
        } else {
            times.free.push(took)
        }
        while now_ns() - now < 1_000_000 {
            std::hint::spin_loop();
        }
    }
    Ok(times)
}

/// Prints what a tick costs.
///
/// # Errors
/// As [`ticks`].
pub fn run() -> Result<(), String> {
    let (proxies, proxies_p99) = proxies_us();
    println!("{:52}{:>10}{:>10}{:>10}{:>10}", "", "least", "median", "p99", "largest");
    println!(
        "{:52}{:>10}{proxies:>7.2} us{proxies_p99:>7.2} us",
        "16 proxies, two couplings each", ""
    );
    let Ticks { mut free, mut pressing } = ticks()?;
    for (what, times) in [("free", &mut free), ("pressing a table", &mut pressing)] {
        let [least, median, p99, most] = [0.0, 0.5, 0.99, 1.0].map(|part| times.quantile(part));
        let what = format!("a whole tick, shared, incidents kept, {what}");
        println!("{what:52}{least:>7.2} us{median:>7.2} us{p99:>7.2} us{most:>7.1} us");
    }
    Ok(())
}

/// Median and 99th percentile of a step of 16 proxies, each with two couplings \[us\]: tracked
/// poses and simulated bones are a centimetre and 20 degrees apart.
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
