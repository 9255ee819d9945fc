//! Other hands for a scene that was read: left, right or both, of a given length.

mod copies;
mod mirror;
mod remove;

use crate::format::{Hand, Scene};
use copies::{default_hand, holding_still};
use thenar_core::model::Side;

/// The hands that a scene is to have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Hands {
    /// The hands that the scene has.
    Scene,
    /// Left hands only.
    Left,
    /// Right hands only.
    Right,
    /// Both sides.
    Both,
}

/// Puts other hands into a scene.
///
/// - `Left` and `Right` keep the hands of that side and remove the others with all that refers to
///   them (probes, pairs, loads, bonds, joints). Where there is none of that side, all hands are
///   mirrored in the plane x = 0 instead, with their motions and the camera. Where there is none
///   at all, one is put beside the origin, 0.2 m up.
/// - `Both` adds a hand of each side that is missing. It holds still beside the others, as far as
///   the fingers of two hands reach and 5 cm more.
///
/// `lengths` are those of left and right hands, wrist to middle fingertip \[m\]; `None` leaves
/// them as they are.
pub fn with_hands(scene: &mut Scene, which: Hands, lengths: [Option<f64>; 2]) {
    match which {
        Hands::Scene => {}
        Hands::Left => only(scene, Side::Left),
        Hands::Right => only(scene, Side::Right),
        Hands::Both => {
            for side in [Side::Left, Side::Right] {
                if !scene.hand.iter().any(|hand| side_of(hand) == side) {
                    let hand = holding_still(scene, side, lengths);
                    scene.hand.push(hand);
                }
            }
        }
    }
    for hand in &mut scene.hand {
        hand.length = length_of(hand, lengths);
    }
}

/// Length of a hand with that asked for its side: `[left, right]` \[m\].
fn length_of(hand: &Hand, lengths: [Option<f64>; 2]) -> Option<f64> {
    lengths[usize::from(side_of(hand) == Side::Right)].or(hand.length)
}

/// The side of a hand: of a model from a file, what the file's name says.
pub fn side_of(hand: &Hand) -> Side {
    let model = hand.model.as_ref().map_or("right", |model| model.value.as_str());
    let file = model.rsplit(['/', '\\']).next().unwrap_or(model);
    if file.to_lowercase().contains("left") { Side::Left } else { Side::Right }
}

fn only(scene: &mut Scene, side: Side) {
    if scene.hand.iter().any(|hand| side_of(hand) == side) {
        let others = scene.hand.iter().filter(|hand| side_of(hand) != side);
        let others: Vec<String> = others.map(|hand| hand.name.value.clone()).collect();
        others.iter().for_each(|name| remove::hand(scene, name));
    } else if scene.hand.is_empty() {
        let hand = default_hand(scene, side);
        scene.hand.push(hand);
    } else {
        scene.hand.iter_mut().for_each(|hand| mirror::hand(hand, side));
        if let Some(camera) = &mut scene.camera {
            mirror::camera(camera);
        }
    }
}
