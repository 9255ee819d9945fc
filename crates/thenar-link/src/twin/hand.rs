//! A hand of 25 joints that opens and closes: what a simulated tracker sees.

use std::f64::consts::FRAC_PI_2;
use thenar_core::model::Side;
use thenar_core::{Pose, Quat, Vec3};

/// Position of each finger's first joint, in a right wrist's frame (-z towards the fingers, +y out
/// of the back of the hand), and the lengths of the bones from there to the tip \[m\]. Fingers
/// begin at their metacarpal.
const FINGERS: [([f64; 3], [f64; 4]); 4] = [
    ([-0.016, 0.0, -0.036], [0.060, 0.045, 0.026, 0.024]),
    ([-0.002, 0.0, -0.036], [0.060, 0.050, 0.030, 0.025]),
    ([0.011, 0.0, -0.034], [0.055, 0.046, 0.028, 0.025]),
    ([0.022, 0.0, -0.032], [0.050, 0.036, 0.020, 0.023]),
];
/// Turn of each metacarpal towards the little finger \[rad\].
const SPREAD: [f64; 4] = [-0.12, -0.02, 0.1, 0.2];
const THUMB: ([f64; 3], [f64; 3]) = ([-0.020, -0.012, -0.025], [0.046, 0.033, 0.027]);
/// Flexion of a closed finger's three joints, and of a thumb's \[rad\].
const CLOSED: [f64; 3] = [1.4, 1.7, 1.0];
const THUMB_CLOSED: [f64; 3] = [0.3, 0.8, 1.0];

/// The joints in WebXR's order, wrist there, each digit curled so far: 0 open to 1 closed.
pub fn joints(side: Side, wrist: Pose, curls: [f64; 5]) -> [Pose; 25] {
    let mirror = if side == Side::Right { 1.0 } else { -1.0 };
    let turned =
        |axis: Vec3, angle: f64| Pose::new(Vec3::zeros(), Quat::from_scaled_axis(axis * angle));
    // Bending brings -z towards -y.
    let bent = |angle: f64| turned(Vec3::x(), -angle);
    let begin = |place: [f64; 3]| Pose::translation(mirror * place[0], place[1], place[2]);
    let mut joints = [wrist; 25];
    // The thumb points to the side, its pad to the fingers.
    let aside = turned(Vec3::y(), mirror * 0.7) * turned(Vec3::z(), mirror * 0.5 * FRAC_PI_2);
    let mut at = wrist * begin(THUMB.0) * aside;
    for (k, length) in THUMB.1.into_iter().enumerate() {
        at = at * bent(curls[0] * THUMB_CLOSED[k]);
        joints[1 + k] = at;
        at = at * Pose::translation(0.0, 0.0, -length);
    }
    joints[4] = at;
    for (finger, (place, lengths)) in FINGERS.into_iter().enumerate() {
        let first = 5 + 5 * finger;
        let mut at = wrist * begin(place) * turned(Vec3::y(), -mirror * SPREAD[finger]);
        for (k, length) in lengths.into_iter().enumerate() {
            if k > 0 {
                at = at * bent(curls[1 + finger] * CLOSED[k - 1]);
            }
            joints[first + k] = at;
            at = at * Pose::translation(0.0, 0.0, -length);
        }
        joints[first + 4] = at;
    }
    joints
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joints::{WEBXR_OF_POINT, rebuild};
    use thenar_track::live::checked;

    /// Hands pass the checks of other parts of the program: they are sound, flex as they were
    /// curled, and their points alone give a hand again.
    #[test]
    fn it_is_a_hand() {
        for side in [Side::Left, Side::Right] {
            let wrist = Pose::translation(0.1, 1.0, -0.2);
            for curl in [0.0, 0.3, 1.0] {
                let hand = joints(side, wrist, [curl; 5]);
                let radii = [0.01; 25];
                let pose = thenar_track::live::LivePose::Joints { joints: hand, radii };
                checked(0.0, &pose).unwrap();
                assert!(rebuild(side, &WEBXR_OF_POINT.map(|j| hand[j].position)).is_ok());
                // The middle finger's bones.
                for (joint, closed) in [(11, 1.4), (12, 1.7), (13, 1.0)] {
                    let angle = hand[joint - 1].rotation.angle_to(&hand[joint].rotation);
                    assert!((angle - curl * closed).abs() < 1e-9, "{side:?} {joint}");
                }
                // Tips go to the palm's side.
                let tip = wrist.inverse_point(&hand[14].position);
                assert!(if curl > 0.0 { tip.y < -0.01 } else { tip.y.abs() < 1e-9 });
                let thumb = wrist.inverse_point(&hand[4].position);
                let outside = if side == Side::Right { -thumb.x } else { thumb.x };
                // A closed thumb goes across the palm.
                assert!(outside > 0.02 || curl == 1.0, "the thumb is on its side");
            }
        }
    }
}
