//! Goal: a glitch of one sample is not felt, however seldom the hand is seen and whether or not the
//! sample before is lost or its own is repeated. Method: a finger pressed still on couplings that
//! no rule softens; half a newton at most.

use crate::rig::{PRESS, Rig, blocked};
use thenar_core::{Pose, Quat, Vec3};
use thenar_link::Rendering;
use thenar_track::live::LivePose;

/// Five centimetres of the fingertip: of the wrist's place, by its turn at the fingertip 17 cm
/// away, by the knuckle of the index finger, 9 cm away.
fn glitch(rig: &Rig, kind: usize) -> LivePose {
    let LivePose::Angles { mut wrist, mut angles } = rig.pose(PRESS) else { unreachable!() };
    match kind {
        0 => wrist.position.z += 0.05,
        1 => {
            let turn = Quat::from_scaled_axis(Vec3::x() * (0.05 / 0.17));
            wrist = Pose::new(wrist.position, turn * wrist.rotation);
        }
        2 => angles[4] -= 0.05 / 0.09,
        _ => angles[4] += 0.05 / 0.09,
    }
    LivePose::Angles { wrist, angles }
}

#[test]
fn a_glitch_of_one_sample_is_not_felt_at_any_rate() {
    let mut rig = Rig::new(&blocked(), Rendering::Tendons);
    rig.pressing();
    let home = rig.pose(PRESS);
    for period in [33, 17, 11, 8] {
        for beside in ["", "one lost before", "repeated"] {
            for kind in 0..4 {
                let (mut before, mut most, mut said) = (None, 0.0_f64, 0);
                for ms in 0..20 * period {
                    rig.blocked_frame();
                    let sample = ms / period;
                    if ms % period == 0 && !(sample == 9 && beside == "one lost before") {
                        let off = sample == 10;
                        let pose = if off { glitch(&rig, kind) } else { home.clone() };
                        rig.wearer.say(rig.now_ns, Some(pose));
                        said = rig.now_ns;
                    } else if sample == 10 && beside == "repeated" {
                        rig.wearer.say(said, Some(glitch(&rig, kind)));
                    }
                    rig.tick();
                    if sample >= 9 {
                        let force = rig.index_force();
                        most = most.max((force - *before.get_or_insert(force)).abs());
                    }
                }
                println!("every {period} ms, {beside}, kind {kind}: {most} N of {before:?} N");
                assert!(before.is_some_and(|force| force > 0.2), "{before:?}");
                assert!(most < 0.5, "every {period} ms, {beside}, kind {kind}: {most} N");
            }
        }
    }
}
