//! Bones of a finger that come too near to what its pad is to touch.
//!
//! Inverse kinematics knows the pad alone. A finger that reaches around a thing may have a bone
//! before the pad on it first, as one whose hand is too low over a ball has: it then bears on the
//! top of the ball, gives that up when the hand rises, and the other fingers hold the ball askew.

use super::surface::{clearance, nearest};
use thenar_core::model::{BodyId, HandModel};
use thenar_core::{Pose, Vec3, World};
use thenar_track::reach::{Angles, Chain, palmar_pad};

/// Distance of other bones' skin from the object when the pad touches, as part of what is between
/// skin and axis: pads give way by that where they press with 1 N.
const ROOM: f64 = 0.15;
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
            let lack = (1.0 + ROOM) * link.skin - clearance(world, object, &place);
            if lack > most
                && let Some(surface) = nearest(world, object, &place)
            {
                (most, way_P) = (lack, palm.inverse_vector(&surface.normal) * lack);
            }
        }
    });
    way_P
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::Session;
    use std::path::Path;
    use thenar_core::model::Digit;
    use thenar_track::reach::PadPlace;

    /// A hand at the origin, and a ball of 5 mm at `at` \[m\].
    fn session(at: Vec3) -> Session {
        let text = format!(
            "version = 1\n[[rigid]]\nname = \"ball\"\nmotion = \"fixed\"\n\
             shape = {{ kind = \"sphere\", radius = 0.005 }}\nposition = [{}, {}, {}]\n\
             [[hand]]\nname = \"hand\"\npreset = \"touch\"\n[hand.motion]\nkind = \"keyframes\"\n\
             [[hand.motion.key]]\ntime = 0\npose = \"rest\"\n\
             wrist = {{ position = [0, 0, 0], fingers = [0, 0, -1], back = [0, 1, 0] }}\n",
            at.x, at.y, at.z
        );
        Session::from_text(&text, Path::new("crowd.toml"), &[]).unwrap_or_else(|e| panic!("{e}"))
    }

    /// A ball that touches the skin below the end of the index finger's middle bone lacks the room
    /// of that bone, and keeps nothing off from 10 mm farther below.
    #[test]
    fn a_bone_on_the_object_lacks_its_room() {
        let far = session(Vec3::new(0.0, -1.0, 0.0));
        let model = &far.hands()[0].model;
        let chain = Chain::new(model, Digit::Index, PadPlace::Tip).expect("a chain");
        let (links, angles) = (links(model, &chain), chain.ease());
        let palm = far.world().rigid_pose(far.hands()[0].handle.bones.start);
        let link = *links.last().expect("a bone before the pad");
        let pad = palmar_pad(model, link.bone).expect("skin");
        let (mut end, mut below) = (Vec3::zeros(), Vec3::zeros());
        chain.bones_at(
            (&palm, [Vec3::zeros(); 2]),
            &angles,
            &Angles::default(),
            |bone, pose, _| {
                if bone == link.bone {
                    (end, below) = (pose.point(&link.ends_B[1]), pose.vector(&pad.normal_B));
                }
            },
        );
        let way = |gap: f64| {
            let session = session(end + below * (link.skin + 5e-3 + gap));
            let desc = session.world().desc();
            let ball = desc.rigids.iter().position(|rigid| rigid.name == "ball").expect("a ball");
            let object = BodyId::Rigid(ball as u32);
            let way_P = crowded(&links, &chain, &angles, &palm, (session.world(), object));
            palm.vector(&way_P)
        };
        let lacks = way(0.0);
        assert!((lacks.norm() / (ROOM * link.skin) - 1.0).abs() < 1e-3, "{lacks} of {}", link.skin);
        assert!(lacks.normalize().dot(&below) < -0.999, "{lacks}, {below}");
        assert_eq!(way(1e-2), Vec3::zeros());
    }
}
