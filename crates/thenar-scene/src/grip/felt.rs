//! What the digits of a hand feel of an object.

use crate::build::BuiltHand;
use thenar::World;
use thenar::model::{BodyId, Digit};
use thenar::world::ContactPoint;

/// Sum of the normal forces between an object, or where there is none other digits of the hand, and each digit (palm, thumb, index, middle, ring, little), on skin and on
/// bones where flesh is crushed, in the last step \[N\].
pub fn felt(world: &World, hand: &BuiltHand, object: Option<BodyId>) -> [f64; 6] {
    let mut felt = [0.0; 6];
    for contact in world.contacts() {
        for side in 0..2 {
            let Some(digit) = digit_touched(contact, side, hand) else { continue };
            let counts = match object {
                Some(object) => contact.bodies[1 - side] == object,
                None => digit_touched(contact, 1 - side, hand).is_some_and(|other| other != digit),
            };
            if counts {
                felt[usize::from(digit.part())] += contact.force_W.dot(&contact.normal_W);
            }
        }
    }
    felt
}

/// The digit of a hand that a point touches on this side.
pub fn digit_touched(contact: &ContactPoint, side: usize, hand: &BuiltHand) -> Option<Digit> {
    match contact.bodies[side] {
        BodyId::Soft(soft) if Some(soft) == hand.flesh() => {
            hand.model.collision_digits.get(contact.vertices[side]? as usize).copied()
        }
        BodyId::Rigid(bone) if hand.handle.bones.contains(&bone) => {
            Some(hand.model.bones[(bone - hand.handle.bones.start) as usize].digit)
        }
        _ => None,
    }
}
