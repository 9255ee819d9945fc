//! A grip that holds: pads press with the force that was asked for.

use super::{FOLLOW, GripHand, ROUNDS, part};
use crate::build::BuiltHand;
use crate::grip::hook::Around;
use crate::grip::kind::GripKind;
use crate::grip::memory::{GripMemory, PadMemory, Reflex};
use crate::grip::opposition::Opposition;
use crate::grip::order::Order;
use crate::grip::squeeze::{RANGE, further, push, slope, wanted};
use crate::grip::trouble::Trouble;
use thenar_core::World;
use thenar_track::reach::{Angles, Chain, FREEDOMS_MAX, Goal, solve};

/// A force is lacking when after so long \[s\] so much of it is not there.
const LACKING: (f64, f64) = (2.0, 0.1);
/// An object that was pressed with the first part of what is wanted, and after that for so long \[s\] with less than the
/// last part, is gone.
const LOST: (f64, f64, f64) = (0.5, 0.2, 0.05);

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
        self.memory.reflex.wanted = self.memory.reflex.wanted.max(order.force);
        if self.is_lost(order, h) {
            self.memory.pads.iter_mut().for_each(|pad| pad.rates = [0.0; FREEDOMS_MAX]);
            return;
        }
        let bound = stiffness(opposition, world, hand);
        let memory = &mut self.memory;
        if order.adapts {
            let Reflex { wanted: before, used, .. } = memory.reflex;
            memory.reflex.wanted = wanted(before, order.force, memory.force, used, h);
        }
        let met = slope(memory.depth, memory.force, bound);
        let before = memory.depth;
        memory.depth = push(before, memory.force, memory.reflex.wanted, bound, h);
        if let Some(object) = order.object().filter(|_| opposition.kind == GripKind::Hook) {
            memory.depth = memory.depth.max(before);
            let palm = world.rigid_pose(hand.handle.bones.start);
            let around = Around { opposition, model: &hand.model, world, object, palm };
            around.tighten(&mut memory.pads, memory.depth - before, h);
            memory.pads.iter_mut().for_each(|kept| turn_to(kept, h));
            return self.tell_weak(order);
        }
        let fingers = (1..opposition.pads()).filter(|pad| memory.pads[*pad].anchor.is_some());
        let share = 1.0 / fingers.count().max(1) as f64;
        let shares =
            order.object().is_some() && opposition.kind.has_thumb() && memory.reflex.gone == 0.0;
        for pad in 0..opposition.pads() {
            let kept = &mut memory.pads[pad];
            let (Some(chain), Some(_)) = (opposition.chain(pad), kept.anchor) else { continue };
            let inwards = if pad == 0 { memory.axis_P } else { memory.axis_P * -share };
            let mut centre = kept.point_P + inwards * memory.depth;
            if pad > 0 && shares && memory.reflex.held {
                let (felt, mean) = (memory.felt[part(chain.digit)], share * memory.force);
                let more = &mut memory.reflex.further[pad];
                *more = further(*more, felt, mean, met, h);
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
        self.tell_weak(order);
    }

    /// Tells when pads are as far in as they go and bear less than was asked for.
    fn tell_weak(&mut self, order: &Order) {
        let memory = &mut self.memory;
        let lacking = order.force - memory.force > LACKING.1 * order.force;
        if memory.since > LACKING.0 && lacking && memory.depth >= RANGE[1] {
            memory.trouble.get_or_insert(Trouble::Weak { felt: memory.force });
        }
    }

    /// True when an object that was held is gone: fingers then stay as they are, and press again when they meet it.
    fn is_lost(&mut self, order: &Order, h: f64) -> bool {
        let GripMemory { reflex, force, trouble, .. } = &mut self.memory;
        reflex.held |= *force > LOST.0 * reflex.wanted;
        let is_felt = *force > LOST.2 * reflex.wanted;
        reflex.gone = if reflex.held && !is_felt { reflex.gone + h } else { 0.0 };
        let lost = reflex.gone > LOST.1 && order.object().is_some();
        if lost {
            *trouble = Some(Trouble::Lost { wanted: reflex.wanted });
        } else if is_felt && matches!(trouble, Some(Trouble::Lost { .. })) {
            *trouble = None;
        }
        lost
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

/// A bound of the stiffness with which the thumb, or of a hook all fingers, are pushed \[N/m\]: all bones as far as the
/// pads, and turned as if each were a lever of [`LEVER`].
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
pub(in crate::grip) const LEVER: f64 = 0.05;
