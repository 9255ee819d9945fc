//! Goal: the default hand's own motion is not felt, whatever it does in empty air, in any mode, and
//! no stop closes. Method: a fist that closes and opens, the thumb alone, turns of the wrist and
//! the shipped scene of free motion; short, as a simulation within the tick takes most of the time.

use crate::held::Worn;
use crate::rig::MS;
use std::f64::consts::TAU;
use thenar_core::{Pose, Quat, Vec3};
use thenar_link::Rendering;
use thenar_link::haptic_loop::{LoopMode, Settings};
use thenar_track::live::LivePose;

const SCENE: &str = include_str!("../../../thenar-scene/scenes/free-motion.toml");
/// Still or up to 0.1 m/s, and up to 1 m/s \[N\].
const MOST: [f64; 2] = [0.02, 0.05];

/// With steps of so many milliseconds, of which those within the tick are ticks.
fn with_step(ms: u64) -> String {
    SCENE.replace("time_step = 0.01", &format!("time_step = {}", 1e-3 * ms as f64))
}

/// Goes on for so many milliseconds; the largest wish of any pad. Nothing brakes, nothing trips.
fn most(worn: &mut Worn, ms: u64, mut pose: impl FnMut(&mut Worn, f64) -> LivePose) -> f64 {
    let rig = &worn.rig;
    let within = rig.clock.core(|core| core.hands()[0].touch().world().is_some());
    let step = (1e3 * rig.session.world().time_step()).round() as u64;
    let tick = if within { step } else { 1 };
    let mut most = 0.0_f64;
    for k in (0..ms).step_by(tick as usize) {
        if k % step == 0 {
            worn.rig.simulated_frame();
        }
        let said = pose(worn, 1e-3 * k as f64);
        let rig = &mut worn.rig;
        rig.wearer.say(rig.now_ns, Some(said));
        rig.now_ns += (tick - 1) * MS;
        rig.tick();
        let wanted = rig.clock.core(|core| {
            let readings = core.hands()[0].readings();
            readings.iter().flatten().map(|r| r.pad_force.abs()).fold(0.0, f64::max)
        });
        most = most.max(wanted);
        let last = rig.wearer.last();
        assert!(
            last.digits.iter().all(|digit| digit.curl_at_contact.is_none()),
            "braked at {k} ms"
        );
        assert_eq!(rig.clock.core(|core| core.tripped()), None);
    }
    most
}

/// Armed, and arrived where the script begins; on the couplings as they are, of which the rule
/// would only make less.
fn armed(mode: LoopMode, step: u64) -> Worn {
    let settings = Settings { mode, grip: None, ..Settings::default() };
    let mut worn = Worn::of(&with_step(step), settings, Rendering::Stops);
    worn.rig.wearer.alive(worn.rig.now_ns);
    worn.rig.clock.remote().arm();
    most(&mut worn, 900, |worn, _| worn.pose(0.0));
    worn
}

/// Fingers closed by so much of their way to a fist, the thumb by so much.
fn closed(worn: &mut Worn, fingers: f64, thumb: f64) -> LivePose {
    let LivePose::Angles { wrist, mut angles } = worn.pose(0.0) else { unreachable!() };
    for finger in 0..5 {
        let part = if finger == 0 { thumb } else { fingers };
        // Knuckle and the two joints beyond it.
        for (joint, most) in [(0, 0.9), (2, 1.2), (3, 0.7)] {
            angles[4 * finger + joint] += part * if finger == 0 { 0.4 * most } else { most };
        }
    }
    LivePose::Angles { wrist, angles }
}

/// 0 to 1 and back within `period` \[s\].
fn to_and_fro(t: f64, period: f64) -> f64 {
    0.5 - 0.5 * (TAU * t / period).cos()
}

/// A fist in half a second and open again: fingertips at up to 0.6 m/s. The thumb as fast; the
/// wrist by 40 degrees to either side, about each of its axes.
#[test]
fn fists_thumbs_and_turns_of_the_wrist_are_not_felt() {
    for (mode, step) in
        [(LoopMode::Shared, 16), (LoopMode::Multirate, 16), (LoopMode::SingleRate, 5)]
    {
        let mut worn = armed(mode, step);
        let fist = most(&mut worn, 1000, |worn, t| closed(worn, to_and_fro(t, 1.0), 0.0));
        let thumb = most(&mut worn, 500, |worn, t| closed(worn, 0.0, to_and_fro(t, 0.5)));
        let mut turns = [0.0; 3];
        for (axis, turns) in turns.iter_mut().enumerate() {
            *turns = most(&mut worn, 500, |worn, t| {
                let LivePose::Angles { wrist, angles } = worn.pose(0.0) else { unreachable!() };
                let way = Vec3::ith(axis, 0.7 * (TAU * t / 0.5).sin().powi(3));
                let turned = Quat::from_scaled_axis(way) * wrist.rotation;
                LivePose::Angles { wrist: Pose::new(wrist.position, turned), angles }
            });
        }
        println!("{mode:?}: fist {fist}, thumb {thumb}, turns {turns:?} N");
        assert!(fist < MOST[1] && thumb < MOST[1], "{mode:?}: {fist}, {thumb} N");
        assert!(turns.iter().all(|most| *most < MOST[1]), "{mode:?}: {turns:?} N");
    }
}

/// A third of a fist within 0.8 s, with fingertips at about 0.1 m/s: 20 mN, in every mode.
#[test]
fn a_fist_that_closes_slowly_is_not_felt() {
    for (mode, step) in
        [(LoopMode::Shared, 16), (LoopMode::Multirate, 16), (LoopMode::SingleRate, 8)]
    {
        let mut worn = armed(mode, step);
        let slow = most(&mut worn, 800, |worn, t| {
            let part = 0.35 * to_and_fro(t, 3.2);
            closed(worn, part, part)
        });
        println!("{mode:?}: {slow} N");
        assert!(slow < MOST[0], "{mode:?}: {slow} N");
    }
}

/// The shipped scene, as its script has it, where its hand touches nothing, not even itself: it
/// opens, and it waves at up to 1 m/s.
#[test]
fn the_scene_of_free_motion_is_not_felt() {
    for (mode, step) in
        [(LoopMode::Shared, 16), (LoopMode::Multirate, 16), (LoopMode::SingleRate, 8)]
    {
        let mut worn = armed(mode, step);
        let opens = most(&mut worn, 900, |worn, t| worn.pose(t));
        // Relaxed again, by a way of its own, and on with the script where it waves.
        most(&mut worn, 900, |worn, _| worn.pose(4.1));
        let waves = most(&mut worn, 800, |worn, t| worn.pose(4.1 + t));
        println!("{mode:?}: {opens} and {waves} N");
        assert!(opens < MOST[1] && waves < MOST[1], "{mode:?}: {opens}, {waves} N");
    }
}
