//! Goal: the default hand's own motion is not felt, whatever it does in empty air, in any mode, and no stop closes. Method: a
//! fist that closes and opens, the thumb alone, turns of the wrist and the shipped scene of free motion; short, as a
//! simulation within the tick takes most of the time.

use crate::held::Worn;
use crate::rig::MS;
use std::f64::consts::TAU;
use thenar::model::Digit;
use thenar::{Pose, Quat, Vec3};
use thenar_link::Rendering;
use thenar_link::haptic_loop::{LoopMode, Settings};
use thenar_track::live::LivePose;

const SCENE: &str = include_str!("../../../../scenes/free-motion.toml");
/// Still or up to 0.1 m/s, and up to 1 m/s \[N\].
const MOST: [f64; 2] = [0.02, 0.05];

/// Steps of the scene, and ticks of a simulation within the tick \[ms\]: long, to be quick.
const STEP: u64 = 20;

/// With steps of so many milliseconds.
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

/// Armed, and arrived where the script is at this time; on the couplings as they are, of which the rule would only make less.
fn armed(mode: LoopMode, time: f64) -> Worn {
    let settings = Settings { mode, grip: None, ..Settings::default() };
    let mut worn = Worn::of(&with_step(STEP), settings, Rendering::Stops);
    worn.rig.wearer.alive(worn.rig.now_ns);
    worn.rig.clock.remote().arm();
    most(&mut worn, 900, |worn, _| worn.pose(time));
    worn
}

/// Where the script is at this time, fingers bent by so much more of a quarter turn at their knuckles and a bit more at the
/// joints beyond, the thumb by so much of half of it.
fn closed(worn: &mut Worn, time: f64, fingers: f64, thumb: f64) -> LivePose {
    let LivePose::Angles { wrist, mut angles } = worn.pose(time) else { unreachable!() };
    for finger in 0..5 {
        let part = if finger == 0 { 0.5 * thumb } else { fingers };
        for (joint, most) in [(0, 0.8), (2, 1.0), (3, 0.6)] {
            angles[4 * finger + joint] += part * most;
        }
    }
    LivePose::Angles { wrist, angles }
}

/// 0 to 1 and back within `period` \[s\].
fn to_and_fro(t: f64, period: f64) -> f64 {
    0.5 - 0.5 * (TAU * t / period).cos()
}

/// Fingers that close slowly, fingertips at 0.1 m/s; that close and open within 0.6 s, at up to 1 m/s; the thumb alone, as fast;
/// the wrist, by 40 degrees to either side about each of its axes.
fn moves(worn: &mut Worn, time: f64) -> [f64; 6] {
    let slow = most(worn, 800, |worn, t| {
        let part = 0.35 * to_and_fro(t, 1.6);
        closed(worn, time, part, part)
    });
    assert!(slow < MOST[0], "slowly: {slow} N");
    let open = fingertip(worn);
    most(worn, 200, |worn, _| worn.pose(time));
    let mut bent = 0.0_f64;
    let fist = most(worn, 600, |worn, t| {
        bent = bent.max((fingertip(worn) - open).norm());
        closed(worn, time, to_and_fro(t, 0.6), 0.0)
    });
    assert!(bent > 0.04, "the hand itself moves, by {bent} m");
    let thumb = most(worn, 300, |worn, t| closed(worn, time, 0.0, to_and_fro(t, 0.3)));
    let turns = [0, 1, 2].map(|axis| {
        most(worn, 250, |worn, t| {
            let LivePose::Angles { wrist, angles } = worn.pose(time) else { unreachable!() };
            let way = Vec3::ith(axis, 0.7 * (TAU * t / 0.25).sin().powi(3));
            let turned = Quat::from_scaled_axis(way) * wrist.rotation;
            LivePose::Angles { wrist: Pose::new(wrist.position, turned), angles }
        })
    });
    [slow, fist, thumb, turns[0], turns[1], turns[2]]
}

/// The last bone of the index finger beside the palm, as it is simulated.
fn fingertip(worn: &Worn) -> Vec3 {
    let hand = &worn.rig.session.hands()[0];
    let bone = hand.model.bones.iter().rposition(|b| b.digit == Digit::Index).expect("a finger");
    worn.rig.clock.core(|core| {
        let bones = core.hands()[0].touch().bones();
        bones[0].pose_WB.inverse_point(&bones[bone].pose_WB.position)
    })
}

/// The shipped scene as its script has it: a hand that opens, closes to a fist, points, pinches and waves. In all of it nothing brakes;
/// then it moves as above.
#[test]
fn the_scene_of_free_motion_is_not_felt() {
    let mut worn = armed(LoopMode::Shared, 0.0);
    let parts = [[0.0, 1.2], [1.2, 4.1], [4.1, 6.0]];
    let felt = parts.map(|[from, to]| {
        most(&mut worn, (1e3 * (to - from)) as u64, |worn, t| worn.pose(from + t))
    });
    let moved = moves(&mut worn, 6.0);
    println!("the script: {felt:?}, then {moved:?} N");
    // Fist and pinch touch themselves, and that is felt.
    assert!(felt[0] < MOST[1] && felt[2] < MOST[1], "{felt:?} N");
    assert!(moved.iter().all(|most| *most < MOST[1]), "{moved:?} N");
}

/// The part of the script in which it waves at up to 1 m/s, and the same moves, in the other modes. (Multirate is asked for no more
/// than to state it: it is as little.)
#[test]
fn other_modes_feel_as_little_of_free_motion() {
    for mode in [LoopMode::Multirate, LoopMode::SingleRate] {
        let mut worn = armed(mode, 4.1);
        let waves = most(&mut worn, 800, |worn, t| worn.pose(4.1 + t));
        let moved = moves(&mut worn, 4.9);
        println!("{mode:?}: waves {waves}, then {moved:?} N");
        assert!(waves < MOST[1], "{mode:?}: {waves} N");
        assert!(moved.iter().all(|most| *most < MOST[1]), "{mode:?}: {moved:?} N");
    }
}
