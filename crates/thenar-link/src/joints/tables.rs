//! Tables from other orders of joints to ours, that of WebXR Hand Input
//! ([`TRACKED_JOINTS`](thenar_track::TRACKED_JOINTS)).

use thenar_core::Vec3;

/// Points of hands without metacarpals of the four fingers: Hand Tracking Streamer, MediaPipe.
pub const POINTS: usize = 21;

/// Our joint of each of these points: wrist, then for each finger four, from the thumb's
/// metacarpal and the other fingers' knuckles to the tip.
pub const WEBXR_OF_POINT: [usize; POINTS] =
    [0, 1, 2, 3, 4, 6, 7, 8, 9, 11, 12, 13, 14, 16, 17, 18, 19, 21, 22, 23, 24];

/// Joints of `XR_EXT_hand_tracking`: the palm, then ours.
pub const OPENXR_JOINTS: usize = 26;

/// Our joints of OpenXR's: the palm is left out.
pub fn webxr_of_openxr<T: Copy>(joints: &[T; OPENXR_JOINTS]) -> [T; 25] {
    std::array::from_fn(|i| joints[i + 1])
}

/// Our joints of Apple Vision Pro's, which has ours in our order, and two of the forearm after
/// them. `None` for another number: what follows is then no forearm.
pub fn webxr_of_apple<T: Copy>(joints: &[T]) -> Option<[T; 25]> {
    let hand = joints.first_chunk::<25>()?;
    matches!(joints.len(), 25 | 27).then_some(*hand)
}

/// A world landmark of MediaPipe (camera axes: x right, y down, z away) in our axes.
pub fn webxr_of_mediapipe(landmark: &Vec3) -> Vec3 {
    Vec3::new(landmark.x, -landmark.y, -landmark.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_track::TRACKED_JOINTS;

    /// The streamer's names, from its documentation, and OpenXR's, from the standard, both with
    /// the words that differ between vocabularies replaced.
    #[test]
    fn tables_agree_with_the_names_of_joints() {
        let names = |digit: &str, bones: &[&str]| -> Vec<String> {
            bones.iter().map(|bone| format!("{digit}-{bone}")).collect()
        };
        let thumb = ["metacarpal", "phalanx-proximal", "phalanx-distal", "tip"];
        let finger = ["phalanx-proximal", "phalanx-intermediate", "phalanx-distal", "tip"];
        let mut points = vec!["wrist".to_owned()];
        points.extend(names("thumb", &thumb));
        for digit in ["index-finger", "middle-finger", "ring-finger", "pinky-finger"] {
            points.extend(names(digit, &finger));
        }
        assert_eq!(points.len(), POINTS);
        for (name, ours) in points.iter().zip(WEBXR_OF_POINT) {
            assert_eq!(name, TRACKED_JOINTS[ours]);
        }

        let mut openxr = ["palm"; OPENXR_JOINTS];
        openxr[1..].copy_from_slice(&TRACKED_JOINTS);
        // XR_HAND_JOINT_THUMB_TIP_EXT is 5, ..._LITTLE_TIP_EXT is 25.
        assert_eq!((openxr[5], openxr[25]), ("thumb-tip", "pinky-finger-tip"));
        assert_eq!(webxr_of_openxr(&openxr), TRACKED_JOINTS);
    }

    #[test]
    fn apple_hands_have_25_or_27_joints() {
        let joints: Vec<usize> = (0..40).collect();
        for count in 0..40 {
            let hand = webxr_of_apple(&joints[..count]);
            let wanted = [25, 27].contains(&count);
            assert_eq!(hand.map(|h| (h[0], h[24])), wanted.then_some((0, 24)), "{count}");
        }
    }

    /// A camera that looks at a raised hand sees fingers up, at smaller y.
    #[test]
    fn up_is_up() {
        assert_eq!(webxr_of_mediapipe(&Vec3::new(0.1, -0.2, 0.3)), Vec3::new(0.1, 0.2, -0.3));
    }
}
