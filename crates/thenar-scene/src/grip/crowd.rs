//! Bones of a finger that come too near to what its pad is to touch.
//!
//! Inverse kinematics knows the pad alone. A finger that reaches around a thing may have a bone
//! before the pad on it first, as one whose hand is too low over a ball has: it then bears on the
//! top of the ball, gives that up when the hand rises, and the other fingers hold the ball askew.

use super::surface::{clearance, nearest};
use thenar_core::model::{BodyId, HandModel};
use thenar_core::{Pose, Vec3, World};
use thenar_track::reach::{Angles, Chain, palmar_pad};

/// Skin of other bones is to be so far from the object when the pad touches \[m\]: pads give way by
/// that where they press with 1 N.
const ROOM: f64 = 1.5e-3;
/// Places along a bone at which its way to the object is taken.
const PLACES: usize = 3;

/// A bone before a finger's pad.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    bone: usize,
    ends_B: [Vec3; 2],
    skin: f64,
}

/// Bones from the knuckle to the one that has the pad, that one left out.
pub fn links(hand: &HandModel, chain: &Chain) -> Vec<Link> {
    let before = chain.bones[1..].iter().take_while(|bone| **bone != chain.pad.bone);
    let link = |bone: &usize| {
        let skin = palmar_pad(hand, *bone)?.radius;
        Some(Link { bone: *bone, ends_B: hand.bones[*bone].ends_B, skin })
    };
    before.filter_map(link).collect()
}

/// Way that the bone which comes nearest to a rigid object is to go to leave room for the pad, in
/// the palm's frame \[m\].
pub fn crowded(
    links: &[Link],
    chain: &Chain,
    angles: &Angles,
    palm: &Pose,
    (world, object): (&World, BodyId),
) -> Vec3 {
    let (mut most, mut way_P) = (0.0, Vec3::zeros());
    if let BodyId::Soft(_) = object {
        return way_P;
    }
    let still = [Vec3::zeros(); 2];
    chain.bones_at((palm, still), angles, &Angles::default(), |bone, pose, _| {
        let Some(link) = links.iter().find(|link| link.bone == bone) else { return };
        let [from, to] = link.ends_B.map(|end| pose.point(&end));
        for i in 1..=PLACES {
            let place = from + (to - from) * (i as f64 / PLACES as f64);
            let lack = ROOM + link.skin - clearance(world, object, &place);
            if lack > most
                && let Some(surface) = nearest(world, object, &place)
            {
                (most, way_P) = (lack, palm.inverse_vector(&surface.normal) * lack);
            }
        }
    });
    way_P
}
