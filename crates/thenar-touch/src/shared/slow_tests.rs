//! A hand that nothing holds, felt over a simulation that is slower than real time: the frame's
//! bones are not yet where they come to rest.

use crate::{
    BoneFrame, CouplingDesign, HandSettings, HapticHand, Proxy, ProxyMode, RigidState, Touch,
};
use thenar_core::math::{Mat3, Pose};
use thenar_core::model::Drive;

const MS: u64 = 1_000_000;
/// Simulated time per frame \[s\], and its real time \[ms\]: half of real time.
const STEP: f64 = 5e-3;
const PERIOD: u64 = 10;
const MASS: f64 = 0.1;

/// Farthest that the bone goes from the hand in two seconds \[m\], set out a millimetre away. The
/// hand holds still; the bone hangs on its coupling alone and steps by backward Euler.
fn farthest(proxy: Proxy) -> f64 {
    let drive = proxy.bone;
    let hand = Pose::identity();
    let mut bone = RigidState::at_rest(Pose::translation(1e-3, 0.0, 0.0));
    let settings = HandSettings { mode: ProxyMode::SharedConstraints, ..HandSettings::default() };
    let mut touch = HapticHand::new(settings, vec![proxy], &[bone], 0).unwrap();
    let mut frame = BoneFrame::new(&[bone], 0);
    let mut next = frame.clone();
    let mut farthest = 0.0_f64;
    for ms in 1..=2000 {
        if ms % PERIOD == 0 {
            // The step that began a period ago is done; the next begins.
            frame.copy_from(&next);
            let target = touch.proxies().states()[0];
            let (at, v) = (bone.pose_WB.position, bone.velocity_W);
            let pull = (target.pose_WB.position - at) * drive.stiffness
                + target.velocity_W * drive.damping;
            let resist = MASS + STEP * drive.damping + STEP * STEP * drive.stiffness;
            bone.velocity_W = (v * MASS + pull * STEP) / resist;
            bone.pose_WB.position = at + bone.velocity_W * STEP;
            next.bones[0] = bone;
            let response = &mut next.response;
            response.clear();
            response.springs.push(drive);
            response.targets.push(target);
            let answers = [drive.stiffness, drive.angular_stiffness].map(|k| [1.0 / k; 3]).concat();
            let entry = |i: usize| if usize::is_multiple_of(i, 7) { answers[i / 7] } else { 0.0 };
            response.compliance.extend((0..36).map(entry));
            // Where it comes to rest: at its target.
            let way = target.pose_WB.position - bone.pose_WB.position;
            response.rest.extend(way.iter().chain(&[0.0; 3]));
            assert!(response.prepare());
            (next.time_ns, next.step) = (ms * MS, next.step + 1);
        }
        touch.lead(0, RigidState::at_rest(hand));
        touch.tick(ms * MS, &frame);
        if ms > 1000 {
            farthest = farthest.max(bone.pose_WB.position.norm());
        }
    }
    farthest
}

/// Held to the hand five times softer than to the bone, or as firmly: it comes to rest at the hand.
/// Felt where the bone is, instead of where it comes to rest, both are thrown about ever farther.
#[test]
fn a_slow_simulation_does_not_oscillate() {
    let own = CouplingDesign { device_stiffness: 200.0, ..CouplingDesign::default() };
    let own = own.proxy(MASS, &Mat3::from_diagonal_element(2e-4));
    let drive =
        Drive { stiffness: 1000.0, damping: 10.0, angular_stiffness: 10.0, angular_damping: 0.1 };
    for proxy in [Proxy { bone: drive, ..own }, own.driven_by(&drive).0] {
        let farthest = farthest(proxy);
        assert!(farthest < 1e-4, "{farthest} m");
    }
}
