//! The sensors of a CyberGlove and what they say of a hand.

use thenar_core::{Pose, Quat, Vec3};
use thenar_track::ANGLES;

/// Sensors of the larger gloves.
pub const SENSORS: usize = 22;

/// Names of the sensors in profiles, in the order in which 22-sensor gloves send them.
pub const NAMES: [&str; SENSORS] = [
    "thumb_roll",
    "thumb_mpj",
    "thumb_ij",
    "thumb_abduction",
    "index_mpj",
    "index_pij",
    "index_dij",
    "middle_mpj",
    "middle_pij",
    "middle_dij",
    "middle_abduction",
    "ring_mpj",
    "ring_pij",
    "ring_dij",
    "ring_abduction",
    "little_mpj",
    "little_pij",
    "little_dij",
    "little_abduction",
    "palm_arch",
    "wrist_pitch",
    "wrist_yaw",
];

/// Sensors of the four outer finger joints, which gloves with 18 sensors lack.
const OUTER: [usize; 4] = [6, 9, 13, 17];
/// An outer finger joint bends so much of the middle one's flexion.
const OUTER_PER_MIDDLE: f64 = 2.0 / 3.0;

/// Sensor of the `k`-th value of a glove with `count` sensors.
pub fn place(k: usize, count: usize) -> Option<usize> {
    match count {
        SENSORS => (k < SENSORS).then_some(k),
        _ => (0..SENSORS).filter(|place| !OUTER.contains(place)).nth(k),
    }
}

/// Fills in the outer joints of a glove with 18 sensors.
pub fn complete(degrees: &mut [f64; SENSORS]) {
    for outer in OUTER {
        degrees[outer] = OUTER_PER_MIDDLE * degrees[outer - 1];
    }
}

/// The twenty angles \[rad\] of sensor angles \[degrees\]. Spread is measured between neighbours:
/// the middle finger stands still, the ring finger's is its own, the little finger's adds to that.
/// The palm's arch has no counterpart in a hand with one bone in its palm.
pub fn hand(degrees: &[f64; SENSORS]) -> [f64; ANGLES] {
    let d = degrees;
    let by_digit = [
        [d[0], d[3], d[1], d[2]],
        [d[4], d[10], d[5], d[6]],
        [d[7], 0.0, d[8], d[9]],
        [d[11], d[14], d[12], d[13]],
        [d[15], d[14] + d[18], d[16], d[17]],
    ];
    std::array::from_fn(|k| by_digit[k / 4][k % 4].to_radians())
}

/// The hand turned against the forearm: pitch flexes towards the palm, yaw turns to the little
/// finger's side of a right hand.
pub fn wrist(forearm: &Pose, degrees: &[f64; SENSORS]) -> Pose {
    let turn = |axis: Vec3, degrees: f64| Quat::from_scaled_axis(axis * -degrees.to_radians());
    let rotation = turn(Vec3::y(), degrees[21]) * turn(Vec3::x(), degrees[20]);
    Pose::new(forearm.position, forearm.rotation * rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The order that CyberGlove's 18-sensor models are known to have.
    #[test]
    fn eighteen_sensors_are_the_others() {
        let names: Vec<_> = (0..18).map(|k| NAMES[place(k, 18).unwrap()]).collect();
        assert_eq!(
            names.join(" "),
            "thumb_roll thumb_mpj thumb_ij thumb_abduction index_mpj index_pij \
            middle_mpj middle_pij middle_abduction ring_mpj ring_pij ring_abduction little_mpj \
            little_pij little_abduction palm_arch wrist_pitch wrist_yaw"
        );
        assert_eq!((place(18, 18), place(21, 22), place(22, 22)), (None, Some(21), None));
    }

    #[test]
    fn a_flexed_wrist_points_the_fingers_down() {
        let mut degrees = [0.0; SENSORS];
        degrees[20] = 90.0;
        let turned = wrist(&Pose::translation(1.0, 2.0, 3.0), &degrees);
        assert_eq!(turned.position, Vec3::new(1.0, 2.0, 3.0));
        // Fingers along -z, palm down: flexed by a right angle they point down.
        assert!((turned.vector(&-Vec3::z()) + Vec3::y()).norm() < 1e-12);
        degrees = [0.0; SENSORS];
        degrees[21] = 90.0;
        let turned = wrist(&Pose::identity(), &degrees);
        assert!((turned.vector(&-Vec3::z()) - Vec3::x()).norm() < 1e-12);
    }
}
