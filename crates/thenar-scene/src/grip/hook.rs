//! Fingers of a hook: they bend around a handle and carry it by their shape, as one carries a bag.
//!
//! ```text
//!   knuckle o                 1. joints bend from the knuckle on, each until a bone that it moves has its skin on the
//!           |( )                 handle, or it is at its end
//!           o___| last bone   2. all three tighten until the force is there that was asked for
//! ```
//!
//! No pad is brought to a place: fingers close as those of adaptive grippers do [Hirose and Umetani
//! 1978], so that a handle of any section ends between the first bones and the last. What hangs
//! there is held by no friction, and a load that comes on top is no reason to let go: tightening
//! never goes back.

use super::choose::Choice;
use super::holding::LEVER;
use super::memory::PadMemory;
use super::opposition::{Opposition, PADS_MAX};
use super::reaching::CLOSING;
use super::size::pads_middle;
use super::surface::{clearance, nearest};
use super::trouble::Trouble;
use thenar_core::model::{BodyId, HandModel};
use thenar_core::{Pose, Vec3, World};
use thenar_track::reach::{Angles, Chain, palmar_pad};

/// Bones of a finger that bend, and joints that bend them: from the knuckle on, the last of its
/// chain.
const BENT: usize = 3;
/// Places along a bone at which its way to the object is taken: some 5 mm apart, a finger being 15
/// mm thick.
const PLACES: usize = 6;
/// Skin this near to the object is on it \[m\]: less than skin gives way by where it is touched at
/// all.
const ON_SKIN: f64 = 1e-4;
/// Time in which a bone would cover the way that is left \[s\], were it not to slow down: that of
/// pads which gather.
const APPROACH: f64 = 0.2;
/// Fastest that joints bend \[rad/s\]: as fast as they follow.
const FASTEST: f64 = 4.0;
/// Shortest lever by which a joint moves skin \[m\]: nearer to its axis any turn counts as this.
const ARM_MIN: f64 = 1e-4;

/// From the axes of the bones that bend to the skin of the palm's side \[m\].
pub type Skin = [f64; BENT];

/// A finger's skin; `None` of one that has no three bones to bend, the last angle of each joint
/// bending one.
pub fn skin(hand: &HandModel, chain: &Chain) -> Option<Skin> {
    let first = chain.freedoms.len().checked_sub(BENT)?;
    let bends = |(bone, k): (&usize, usize)| {
        let joint = &hand.joints[chain.freedoms[first + k].joint];
        joint.child as usize == *bone
    };
    if chain.bones.len() <= BENT || !bent(chain).iter().zip(0..).all(bends) {
        return None;
    }
    let mut skin = [0.0; BENT];
    for (skin, bone) in skin.iter_mut().zip(bent(chain)) {
        *skin = palmar_pad(hand, *bone)?.radius;
    }
    Some(skin)
}

/// Fingers that bend around an object.
pub struct Around<'a> {
    /// Fingers and their skin.
    pub opposition: &'a Opposition,
    /// The hand that has them.
    pub model: &'a HandModel,
    /// World that has the object.
    pub world: &'a World,
    /// The object that they bend around.
    pub object: BodyId,
    /// Pose of the palm, world.
    pub palm: Pose,
}

impl Around<'_> {
    /// Bends finger `pad` on for a step of `h` \[s\], from `goal`; false where it does not go on.
    pub fn bend(&self, pad: usize, goal: &mut Angles, h: f64) -> bool {
        let Some(chain) = self.opposition.chain(pad) else { return false };
        let ways = self.ways(pad, chain, goal);
        let first = chain.freedoms.len() - BENT;
        // Joints bend one after another: bent together they would close the finger in front of the
        // handle.
        (0..BENT).any(|joint| {
            let [_, high] = chain.freedoms[first + joint].range;
            let by = self.room(&ways, joint, h).min(high - goal[first + joint]).max(0.0);
            goal[first + joint] += by;
            by > 0.0
        })
    }

    /// Bends all fingers further by what moves their ends by `by` \[m\], and after a handle that
    /// came to lie elsewhere.
    pub fn tighten(&self, pads: &mut [PadMemory; PADS_MAX], by: f64, h: f64) {
        for (i, chain) in self.opposition.fingers.iter().enumerate() {
            let goal = &mut pads[i + 1].goal;
            self.bend(i + 1, goal, h);
            let first = chain.freedoms.len() - BENT;
            goal[first..].iter_mut().take(BENT).for_each(|angle| *angle += by / LEVER);
            *goal = chain.within(*goal);
        }
    }

    /// From the skin of finger `pad` to the object \[m\], at these angles.
    pub fn way(&self, pad: usize, angles: &Angles) -> f64 {
        let Some(chain) = self.opposition.chain(pad) else { return f64::INFINITY };
        let ways = self.ways(pad, chain, angles);
        ways.iter().flat_map(|bone| bone.places).map(|(_, way)| way).fold(f64::INFINITY, f64::min)
    }

    /// Returns the angle by which a joint may turn in a step of `h` \[s\], so that no bone that it
    /// moves goes into the object \[rad\].
    fn room(&self, ways: &[Ways; BENT], joint: usize, h: f64) -> f64 {
        let moved = ways[joint..].iter().flat_map(|bone| bone.places);
        let rooms = moved.map(|(place, way)| {
            let arm = (place - ways[joint].from).norm().max(ARM_MIN);
            let most = ((CLOSING + way / APPROACH) * h).min(way);
            if way < ON_SKIN { 0.0 } else { most / arm }
        });
        rooms.fold(FASTEST * h, f64::min)
    }

    /// Bones that bend, at these angles, and their ways to the object.
    fn ways(&self, pad: usize, chain: &Chain, angles: &Angles) -> [Ways; BENT] {
        let mut ways = [Ways { from: Vec3::zeros(), places: [(Vec3::zeros(), 0.0); PLACES] }; BENT];
        let still = [Vec3::zeros(); 2];
        let skin = self.opposition.skins[pad - 1];
        chain.bones_at((&self.palm, still), angles, &Angles::default(), |bone, pose, _| {
            if let Some(k) = bent(chain).iter().position(|own| *own == bone) {
                ways[k] = self.ways_of(bone, &pose, skin[k]);
            }
        });
        ways
    }

    /// A bone at a pose, and its ways to the object beneath skin of this thickness.
    fn ways_of(&self, bone: usize, pose: &Pose, skin: f64) -> Ways {
        let [from, to] = self.model.bones[bone].ends_B.map(|end| pose.point(&end));
        let places = std::array::from_fn(|i| {
            let place = from + (to - from) * ((i + 1) as f64 / PLACES as f64);
            (place, clearance(self.world, self.object, &place) - skin)
        });
        Ways { from, places }
    }
}

/// A bone: its joint, and places along it with their skin's ways to the object, world \[m\].
#[derive(Clone, Copy)]
struct Ways {
    from: Vec3,
    places: [(Vec3, f64); PLACES],
}

impl Around<'_> {
    /// All fingers take part where the object is near them at all; `chosen` is what was found for
    /// pads.
    pub fn choose(&self, chosen: Choice) -> Choice {
        let mut choice = Choice { trouble: None, shift_P: Vec3::zeros(), ..chosen };
        if let Some(trouble @ (Trouble::Far { .. } | Trouble::TooLarge { .. })) = chosen.trouble {
            choice.trouble = Some(trouble);
            return choice;
        }
        let middle = pads_middle(&self.palm, self.opposition);
        let place = nearest(self.world, self.object, &middle).map(|place| place.anchor);
        choice.anchors[..self.opposition.pads()].fill(place);
        choice
    }
}

/// The bones of a finger that bend.
fn bent(chain: &Chain) -> &[usize] {
    &chain.bones[chain.bones.len() - BENT..]
}
