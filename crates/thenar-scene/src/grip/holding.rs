//! Pads that press: how deep, by the force that is felt.
//!
//! The depth `u` of all pads together answers to force, and a finger that bears next to nothing
//! goes farther in: one loop for each pad would let an object wander that its weight presses on one
//! side.

use super::hand::{GripHand, part};
use super::hook::Around;
use super::kind::GripKind;
use super::memory::{GripMemory, PadMemory};
use super::opposition::Opposition;
use super::order::Order;
use super::reaching::{BEFORE, FOLLOW, ROUNDS};
use super::squeeze::{FURTHER_MAX, RATE, further, least_share, push, slope};
use crate::build::BuiltHand;
use std::ops::Range;
use thenar_core::{Vec3, World};
use thenar_track::reach::{Angles, Chain, FREEDOMS_MAX, Goal, solve};

/// Rate at which sides that give way aside of each other are led back \[1/s\]: half of that at
/// which force settles, so that neither loop drives the other.
const OPPOSE: f64 = 0.5 * RATE;

impl GripHand {
    /// Pads press with the force that was asked for.
    pub(super) fn hold(
        &mut self,
        opposition: &Opposition,
        world: &World,
        hand: &BuiltHand,
        order: &Order,
        h: f64,
    ) {
        // A keyframe of an older program does not say what is wanted.
        let reflex = &mut self.memory.reflex;
        if !order.adapts || reflex.wanted <= 0.0 {
            reflex.wanted = reflex.wanted.max(order.force);
        }
        if self.is_lost(opposition, world, hand, order, h) {
            self.memory.pads.iter_mut().for_each(|pad| pad.rates = [0.0; FREEDOMS_MAX]);
            return;
        }
        let bound = stiffness(opposition, world, hand);
        let memory = &mut self.memory;
        let met = slope(memory.depth, memory.force, bound);
        let before = memory.depth;
        memory.depth = push(before, memory.force, memory.reflex.wanted, bound, h);
        if let Some(object) = order.object().filter(|_| opposition.kind == GripKind::Hook) {
            memory.depth = memory.depth.max(before);
            let palm = world.rigid_pose(hand.handle.bones.start);
            let around = Around { opposition, model: &hand.model, world, object, palm };
            around.tighten(&mut memory.pads, memory.depth - before, h);
            memory.pads.iter_mut().for_each(|kept| turn_to(kept, h));
            return self.tell_weak(opposition, order);
        }
        let fingers = (1..opposition.pads()).filter(|pad| memory.pads[*pad].anchor.is_some());
        let count = fingers.count().max(1);
        let (share, least) = (1.0 / count as f64, least_share(count));
        let shares =
            order.object().is_some() && opposition.kind.has_thumb() && memory.reflex.gone == 0.0;
        let palm = world.rigid_pose(hand.handle.bones.start);
        if shares && memory.reflex.held {
            stay_opposite(opposition, world, hand, memory, h);
        }
        for pad in 0..opposition.pads() {
            let kept = &mut memory.pads[pad];
            let (Some(chain), Some(anchor)) = (opposition.chain(pad), kept.anchor) else {
                continue;
            };
            let inwards = match pad {
                0 => memory.axis_P,
                // Fingers that stand around what is round press half way to where its middle is.
                _ if count > 1 => half_way(&-memory.axis_P, &-kept.normal_P) * share,
                _ => memory.axis_P * -share,
            };
            let mut centre = kept.point_P + inwards * memory.depth;
            if pad > 0 && shares && memory.reflex.held {
                let (felt, mean) = (memory.felt[part(chain.digit)], share * memory.force);
                let place = anchor.now(world).0;
                let short = kept.point_P - palm.inverse_point(&place);
                let short = short.dot(&kept.normal_P) - chain.pad.radius;
                let most = FURTHER_MAX + short.clamp(0.0, BEFORE);
                let more = &mut memory.reflex.further[pad];
                *more = further(*more, felt, (mean, least), (met, most), h);
                centre -= kept.normal_P * *more;
            }
            solve(
                chain,
                &chain.ease(),
                &mut kept.goal,
                &Goal { centre, normal: -kept.normal_P },
                ROUNDS,
            );
            turn_to(kept, h);
        }
        self.tell_weak(opposition, order);
    }
}

/// The direction half way between two.
fn half_way(one: &Vec3, other: &Vec3) -> Vec3 {
    (one + other).try_normalize(1e-6).unwrap_or(*one)
}

/// Returns the mean place, of each of the two sides, of the pads that have met the object, or of
/// all that have a place where none has, in the palm's frame \[m\]; `None` where a side has none.
pub(super) fn sides_at(
    opposition: &Opposition,
    world: &World,
    hand: &BuiltHand,
    memory: &GripMemory,
) -> Option<[Vec3; 2]> {
    let palm = world.rigid_pose(hand.handle.bones.start);
    let mean = |pads: Range<usize>, touched: bool| {
        let pads = pads.filter(|pad| memory.pads[*pad].anchor.is_some());
        let pads = pads.filter(|pad| memory.pads[*pad].touched || !touched);
        let centres = pads.filter_map(|pad| opposition.chain(pad)).map(|chain| {
            let bone = hand.handle.bones.start + chain.pad.bone as u32;
            palm.inverse_point(&world.rigid_pose(bone).point(&chain.pad.centre_B))
        });
        let (sum, count) =
            centres.fold((Vec3::zeros(), 0.0), |(sum, count), at| (sum + at, count + 1.0));
        (count > 0.0).then(|| sum / count)
    };
    let side = |pads: Range<usize>| mean(pads.clone(), true).or_else(|| mean(pads, false));
    Some([side(0..1)?, side(1..opposition.pads())?])
}

/// Leads the two sides' targets aside of each other so that pads stay opposite as they press:
/// digits give way aside, each in its own direction, and what lies between pads that do so rolls.
/// Targets go no farther to the other side than pads are on this one: pads that friction keeps
/// where they are would be led on until they slide.
fn stay_opposite(
    opposition: &Opposition,
    world: &World,
    hand: &BuiltHand,
    memory: &mut GripMemory,
    h: f64,
) {
    let Some([base, fingers]) = sides_at(opposition, world, hand, memory) else { return };
    let (apart, axis) = (fingers - base, memory.axis_P);
    let mean = |pads: Range<usize>| {
        let pads = pads.filter(|pad| memory.pads[*pad].anchor.is_some());
        let pads = pads.map(|pad| memory.pads[pad].point_P);
        let (sum, count) = pads.fold((Vec3::zeros(), 0.0), |(sum, n), at| (sum + at, n + 1.0));
        sum / f64::max(count, 1.0)
    };
    let led = mean(1..opposition.pads()) - mean(0..1);
    let level = |v: Vec3| v - axis * axis.dot(&v);
    let [apart, led] = [level(apart), level(led)];
    if -led.dot(&apart) > apart.norm_squared() {
        return;
    }
    let aside = apart * (0.5 * (OPPOSE * h).min(1.0));
    for (pad, kept) in memory.pads.iter_mut().enumerate() {
        kept.point_P += if pad == 0 { aside } else { -aside };
    }
}

/// Puts the targets of a pad where its goal is, no faster than joints go.
fn turn_to(kept: &mut PadMemory, h: f64) {
    let before: Angles = kept.angles;
    for k in 0..FREEDOMS_MAX {
        let most = FOLLOW.1 * h;
        kept.angles[k] += (kept.goal[k] - before[k]).clamp(-most, most);
        kept.rates[k] = (kept.angles[k] - before[k]) / h;
    }
}

/// A bound of the stiffness with which the thumb, or of a hook all fingers, are pushed \[N/m\]: all
/// bones as far as the pads, and turned as if each were a lever of [`LEVER`].
fn stiffness(opposition: &Opposition, world: &World, hand: &BuiltHand) -> f64 {
    let drive = |bone: &usize| {
        let drive = world.desc().drives[hand.handle.bones.start as usize + bone];
        drive.map_or(0.0, |d| d.stiffness + d.angular_stiffness / (LEVER * LEVER))
    };
    let of = |chain: &Chain| chain.bones[1..].iter().map(drive).sum::<f64>();
    let thumb = opposition.chain(0).map(of);
    thumb.unwrap_or_else(|| opposition.fingers.iter().map(of).sum()).max(1.0)
}

/// A finger's lever \[m\].
pub(super) const LEVER: f64 = 0.05;
