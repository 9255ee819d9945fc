//! Goal: what goes wrong with trackers, devices and clocks is borne in the default mode as well,
//! while something is held. Method: a hand holds a loaf, forces by the rule; one fault after the
//! other, with nothing but time between them. It is the default hand where trackers fail, and the
//! paper's, which is quick, where all else does.

use crate::held::{BREAD, Watched, holding};
use crate::rig::small;
use thenar_core::{Pose, Vec3};
use thenar_track::live::LivePose;

/// Forces are back to within a tenth this long after a fault \[ms\]: 0.2 s without a pause, a ramp
/// of half a second, and 0.1 s for what the flesh makes up.
const BACK: usize = 800;

fn shifted(pose: &LivePose, by: Vec3) -> LivePose {
    let LivePose::Angles { wrist, angles } = pose else { unreachable!() };
    let wrist = Pose::new(wrist.position + by, wrist.rotation);
    LivePose::Angles { wrist, angles: *angles }
}

fn returns(held: &mut Watched, full: f64, what: &str, back: usize) {
    let forces = held.go(back as u64 + 300, |rig, pose, _| rig.wearer.say(rig.now_ns, Some(pose)));
    assert_eq!(held.tripped(), None, "{what}");
    let least = forces[back..].iter().copied().fold(f64::INFINITY, f64::min);
    assert!(least > 0.9 * full, "{what}: {least} of {full} N");
}

/// Poses that are none, that repeat themselves, and none at all, for 0.3 s each; then poses two
/// metres apart in turn, which make it another hand: what that held is not felt.
#[test]
fn a_tracker_that_fails_while_something_is_held() {
    let mut held = holding(BREAD);
    let full = held.total();
    for what in ["no numbers", "the same again", "unseen", "silent", "in doubt"] {
        let (then, mut odd) = (held.now_ns(), false);
        let forces = held.go(300, |rig, pose, _| match what {
            "no numbers" => {
                let LivePose::Angles { wrist, .. } = pose else { unreachable!() };
                let pose = LivePose::Angles { wrist, angles: [f64::NAN; 20] };
                rig.wearer.say(rig.now_ns, Some(pose));
            }
            "the same again" => rig.wearer.say(then, Some(pose)),
            "unseen" => rig.wearer.say(rig.now_ns, None),
            "in doubt" => {
                odd = !odd;
                let by = Vec3::x() * if odd { 1.0 } else { -1.0 };
                rig.wearer.say(rig.now_ns, Some(shifted(&pose, by)));
            }
            _ => (),
        });
        assert!(forces[80] > 0.9 * full, "{what}: {} of {full} N", forces[80]);
        assert!(forces[170..].iter().all(|force| *force == 0.0), "{what}: {:?}", &forces[170..]);
        if what != "in doubt" {
            returns(&mut held, full, what, BACK);
        }
    }
    assert_eq!(held.tripped(), None);
}

/// A glitch of 5 cm for one sample, a device that is silent for 0.2 s, a simulation for 0.3 s, a
/// loop for 50 ms; then a teleport: from the first tick that knows of it no force rises, within 20
/// ms none is left, and nothing of the hand's ways there and back is felt.
#[test]
fn devices_and_clocks_that_fail_while_something_is_held() {
    let mut held = holding(&small(BREAD));
    let full = held.total();
    for by in [Vec3::x() * 0.05, Vec3::y() * -0.05] {
        let forces = held.go(200, |rig, pose, k| {
            let by = if k == 1 { by } else { Vec3::zeros() };
            rig.wearer.say(rig.now_ns, Some(shifted(&pose, by)));
        });
        let most = forces.iter().fold(0.0_f64, |most, force| most.max((force - full).abs()));
        assert!(most < 0.5, "{by}: {most} N from {full} N");
    }
    held.silent = true;
    let forces = held.go(200, |rig, pose, _| rig.wearer.say(rig.now_ns, Some(pose)));
    assert!(forces[100..].iter().all(|force| *force == 0.0), "device: {forces:?}");
    held.silent = false;
    returns(&mut held, full, "device", BACK);
    held.frozen = true;
    let forces = held.go(300, |rig, pose, _| rig.wearer.say(rig.now_ns, Some(pose)));
    assert!(forces[120..].iter().all(|force| *force == 0.0), "simulation: {forces:?}");
    held.frozen = false;
    // Frames that were late by 0.3 s are felt softer, by e^(-2.8 · 0.3) at most, and grow back by
    // e^(0.7 t): within 1.2 s and the ramp.
    returns(&mut held, full, "simulation", 2 * BACK);
    held.stall(50);
    let forces = held.go(200, |rig, pose, _| rig.wearer.say(rig.now_ns, Some(pose)));
    assert!(forces.iter().all(|force| *force == 0.0), "loop: {forces:?}");
    returns(&mut held, full, "loop", BACK);
    // Suddenly 30 cm away, for 0.2 s.
    let forces = held.go(200, |rig, pose, _| {
        rig.wearer.say(rig.now_ns, Some(shifted(&pose, Vec3::new(0.2, 0.2, 0.1))));
    });
    // The second sample bears out the first.
    let known = forces.iter().position(|force| *force < 0.99 * full).expect("it lets go");
    assert!(known <= 24, "{known} ms");
    let rises = forces.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    assert!(rises < 1e-3, "{rises} N: {forces:?}");
    assert!(forces[known + 20..].iter().all(|force| *force == 0.0), "{forces:?}");
    let forces = held.go(900, |rig, pose, _| rig.wearer.say(rig.now_ns, Some(pose)));
    assert!(forces.iter().all(|force| *force == 0.0), "{forces:?}");
    assert_eq!(held.tripped(), None);
}
