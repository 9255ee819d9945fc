//! What the digits of a hand feel of an object.

use super::kind::GripKind;
use crate::build::BuiltHand;
use thenar_core::model::{BodyId, Digit};
use thenar_core::world::ContactPoint;
use thenar_core::{Vec3, World};

/// Things that the digits of a grip touch.
#[derive(Clone, Copy, Debug)]
pub enum Against {
    /// A body.
    Object(BodyId),
    /// The digits on the other side of a grip of this kind: fingers beside each other that touch do
    /// not press.
    OtherSide(GripKind),
}

/// Sum of the normal forces between each digit (palm, thumb, index, middle, ring, little) and what
/// it grips, on skin and on bones where flesh is crushed, in the last step \[N\].
pub fn felt(world: &World, hand: &BuiltHand, against: Against) -> [f64; 6] {
    let mut felt = [0.0; 6];
    touches(world, hand, against, |part, contact, _| {
        felt[part] += contact.force_W.dot(&contact.normal_W);
    });
    felt
}

/// How much of what friction can give the digits `own` of a side use together: pull and twist over
/// the most of each, as the two half axes of an ellipse [Howe and Cutkosky 1996]; 1 where they
/// slip. Forces within a pad that cancel count for nothing. Zero of digits that touch nothing.
pub fn friction_used(world: &World, hand: &BuiltHand, against: Against, own: [bool; 6]) -> f64 {
    let (mut centre, mut normal_W, mut load) = (Vec3::zeros(), Vec3::zeros(), 0.0);
    touches(world, hand, against, |part, contact, sign| {
        if own[part] {
            let normal = contact.force_W.dot(&contact.normal_W);
            centre += contact.position_W * normal;
            normal_W += contact.normal_W * (sign * normal);
            load += normal;
        }
    });
    let Some(axis) = normal_W.try_normalize(1e-9).filter(|_| load > 0.0) else { return 0.0 };
    centre /= load;
    let (mut pull_W, mut twist, mut most) = (Vec3::zeros(), 0.0, [0.0; 2]);
    touches(world, hand, against, |part, contact, sign| {
        if own[part] {
            let normal = contact.force_W.dot(&contact.normal_W);
            let along_W = (contact.force_W - contact.normal_W * normal) * sign;
            let arm = contact.position_W - centre;
            pull_W += along_W;
            twist += arm.cross(&along_W).dot(&axis);
            most[0] += contact.friction * normal;
            most[1] += contact.friction * normal * axis.cross(&arm).norm();
        }
    });
    pull_W -= axis * axis.dot(&pull_W);
    let part = |what: f64, most: f64| if most > 0.0 { what / most } else { 0.0 };
    part(pull_W.norm(), most[0]).hypot(part(twist.abs(), most[1])).min(1.0)
}

/// Contacts of a hand's digits with what they grip: the number of the digit, the contact, and the
/// sign that makes its force that on the digit.
fn touches(
    world: &World,
    hand: &BuiltHand,
    against: Against,
    mut then: impl FnMut(usize, &ContactPoint, f64),
) {
    for contact in world.contacts() {
        for side in 0..2 {
            let Some(digit) = digit_touched(contact, side, hand) else { continue };
            let counts = match against {
                Against::Object(object) => contact.bodies[1 - side] == object,
                Against::OtherSide(kind) => digit_touched(contact, 1 - side, hand)
                    .is_some_and(|other| kind.opposes(digit, other)),
            };
            if counts {
                then(usize::from(digit.part()), contact, [1.0, -1.0][side]);
            }
        }
    }
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
