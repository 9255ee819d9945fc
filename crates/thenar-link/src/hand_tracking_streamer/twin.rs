//! Lines that the app sends for a hand, byte for byte: for trials without a headset.

use super::Points;
use crate::joints::WEBXR_OF_POINT;
use std::fmt::Write;
use thenar_core::model::Side;
use thenar_core::{Pose, Vec3};

/// The two lines of one frame of a hand. Numbers of frame and time are left out where `None`.
pub fn lines(
    side: Side,
    joints: &[Pose; 25],
    points: Points,
    metadata: Option<(i64, i64)>,
) -> String {
    let side = match side {
        Side::Left => "Left",
        Side::Right => "Right",
    };
    let metadata = metadata.map_or(String::new(), |(f, t)| format!(" | f={f} | t={t}"));
    let mut text = format!("{side} wrist{metadata}: ");
    let wrist = &joints[0];
    let q = wrist.rotation.coords;
    number(&mut text, &unity(&wrist.position));
    number(&mut text, &[-q.x, -q.y, q.z, q.w]);
    end(&mut text);
    let _ = write!(text, "{side} landmarks{metadata}: ");
    for joint in WEBXR_OF_POINT {
        let place = joints[joint].position;
        let world = points == Points::World;
        number(&mut text, &unity(&if world { place } else { wrist.inverse_point(&place) }));
    }
    end(&mut text);
    text
}

/// Unity's axes: z forward.
fn unity(place: &Vec3) -> [f64; 3] {
    [place.x, place.y, -place.z]
}

fn number(text: &mut String, numbers: &[f64]) {
    // Writing to a string cannot fail.
    numbers.iter().for_each(|x| _ = write!(text, "{x:.6}, "));
}

fn end(text: &mut String) {
    text.truncate(text.trim_end_matches([',', ' ']).len());
    text.push('\n');
}
