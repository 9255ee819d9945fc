//! A hand reflected in the plane x = 0.

use crate::format::{Camera, Hand, MotionTable, Rotation, SideOfHandWord, TipsTable, WristTable};
use crate::math::Vec3;
use crate::text::{Located, SourcePlace};
use thenar_core::model::Side;

/// A value that no file holds.
pub fn unwritten<T>(value: T, key: &str) -> Located<T> {
    Located { value, place: SourcePlace::Text(0..0), key: key.into() }
}

/// The built-in hand of a side.
pub fn model(side: Side) -> Located<String> {
    unwritten(if side == Side::Left { "left" } else { "right" }.into(), "hand.model")
}

/// Makes a hand one of `side`, with the mirrored motion. A motion in a file of keyframes is left
/// out: the hand holds its start pose.
pub fn hand(hand: &mut Hand, side: Side) {
    hand.model = Some(model(side));
    hand.joint_names = None;
    hand.mesh = None;
    hand.position.x = -hand.position.x;
    if let Some(turn) = &mut hand.rotation {
        rotation(&mut turn.value);
    }
    let from_file = match hand.motion.as_mut().map(|motion| &mut motion.value) {
        Some(MotionTable::Keyframes(keys)) => {
            keys.key.iter_mut().filter_map(|key| key.wrist.as_mut()).for_each(wrist);
            keys.key.iter_mut().filter_map(|key| key.tips.as_mut()).for_each(tips);
            // The other side's joints may have slightly other limits.
            keys.limits = crate::format::LimitsWord::Clamp;
            false
        }
        Some(MotionTable::Recorded(recorded)) => {
            let was = match side {
                Side::Left => SideOfHandWord::Right,
                Side::Right => SideOfHandWord::Left,
            };
            recorded.hand.get_or_insert(was);
            if let Some(position) = &mut recorded.position {
                position.x = -position.x;
            }
            recorded.heading_deg = recorded.heading_deg.map(|heading| -heading);
            false
        }
        Some(MotionTable::File(_)) => true,
        None => false,
    };
    if from_file {
        hand.motion = None;
    }
}

/// Mirrors a camera.
pub fn camera(camera: &mut Camera) {
    for v in [&mut camera.position, &mut camera.target, &mut camera.up] {
        v.x = -v.x;
    }
}

/// Mirrors a wrist.
pub fn wrist(wrist: &mut WristTable) {
    for v in [&mut wrist.position, &mut wrist.fingers, &mut wrist.back].into_iter().flatten() {
        v.x = -v.x;
    }
    if let Some([_, y, z, _]) = &mut wrist.rotation {
        (*y, *z) = (-*y, -*z);
    }
}

/// Mirrors places of fingertips.
fn tips(tips: &mut TipsTable) {
    let TipsTable { thumb, index, middle, ring, little } = tips;
    [thumb, index, middle, ring, little].into_iter().flatten().for_each(|place| place.x = -place.x);
}

/// Mirrors a rotation: turns about y and z change their sense, turns about x keep it.
fn rotation(turn: &mut Rotation) {
    let flip = |v: &mut Vec3| (v.y, v.z) = (-v.y, -v.z);
    if let Some([_, y, z, _]) = &mut turn.quaternion {
        (*y, *z) = (-*y, -*z);
    }
    [&mut turn.axis, &mut turn.euler, &mut turn.euler_deg].into_iter().flatten().for_each(flip);
}
