//! Trouble that a grip finds while it is under way.

use super::choose::REACH;
use super::hand::GripHand;
use super::kind::GripKind;
use super::memory::GripMemory;
use super::opposition::Opposition;
use super::order::Order;
use super::squeeze::RANGE;
use super::trouble::Trouble;
use crate::build::BuiltHand;
use thenar_core::World;

/// A force is lacking when after so long \[s\] so much of it is not there.
const LACKING: (f64, f64) = (2.0, 0.1);
/// An object that was pressed with the first part of what is wanted, and after that for so long
/// \[s\] with less than the last part, is gone.
const LOST: (f64, f64, f64) = (0.5, 0.2, 0.05);
/// Pads that went so much farther in than where they touched, and feel nothing there, have nothing
/// between them \[m\].
const NOTHING: f64 = 0.02;

impl GripHand {
    /// Trouble as the grip takes hold: what was foreseen, unless pads got out of that, or what they
    /// met.
    pub(super) fn met(
        &self,
        opposition: &Opposition,
        world: &World,
        hand: &BuiltHand,
    ) -> Option<Trouble> {
        let foreseen = self.memory.trouble;
        let ends = |pad: u8| self.miss(opposition, usize::from(pad), world, hand);
        match foreseen {
            // What was to be out of reach may have been met all the same, though not where another
            // side is.
            Some(Trouble::OutOfReach { pad, .. }) => {
                let miss = ends(pad).filter(|miss| *miss > REACH);
                let still = miss.map(|miss| Trouble::OutOfReach { pad, miss });
                still.or(self.untouched(opposition, world, hand))
            }
            Some(Trouble::Wide { width, opening, pad, .. }) => {
                let miss = ends(pad).filter(|miss| *miss > REACH);
                let still = miss.map(|miss| Trouble::Wide { width, opening, pad, miss });
                still.or(self.untouched(opposition, world, hand))
            }
            Some(_) => foreseen,
            None => self.untouched(opposition, world, hand),
        }
    }

    /// How far a pad is from its place \[m\]; `None` of one that has none, or is the palm.
    fn miss(
        &self,
        opposition: &Opposition,
        pad: usize,
        world: &World,
        hand: &BuiltHand,
    ) -> Option<f64> {
        let chain = opposition.chain(pad)?;
        let (place, _) = self.memory.pads[pad].anchor?.now(world);
        let bone = hand.handle.bones.start + chain.pad.bone as u32;
        let centre = world.rigid_pose(bone).point(&chain.pad.centre_B);
        Some(((place - centre).norm() - chain.pad.radius).max(0.0))
    }

    /// What is amiss where pads have met nothing.
    fn untouched(
        &self,
        opposition: &Opposition,
        world: &World,
        hand: &BuiltHand,
    ) -> Option<Trouble> {
        let part = |pad: &usize| self.memory.pads[*pad].anchor.is_some();
        let mut pads = (0..opposition.pads()).filter(part);
        if !pads.clone().any(|pad| self.memory.pads[pad].touched) {
            return Some(Trouble::Missed);
        }
        // A hook has no places, and fingers that the thumb does not meet have none to be short of.
        let has_object = self.memory.order.is_some_and(|order| order.object().is_some());
        if opposition.kind == GripKind::Hook || !has_object {
            return None;
        }
        let short = pads.find(|pad| !self.memory.pads[*pad].touched)?;
        let miss = self.miss(opposition, short, world, hand)?;
        Some(Trouble::OutOfReach { pad: short as u8, miss })
    }

    /// Tells when pads are as far in as they go and bear less than was asked for, or have nothing
    /// between them.
    pub(super) fn tell_weak(&mut self, order: &Order) {
        let memory = &mut self.memory;
        let met = memory.pads.iter().any(|pad| pad.touched)
            && order.object().is_some()
            && order.kind.has_thumb();
        if met && memory.depth > NOTHING && memory.force < LOST.2 * memory.reflex.wanted {
            lose(memory);
            return;
        }
        let lacking = order.force - memory.force > LACKING.1 * order.force;
        if memory.since > LACKING.0 && lacking && memory.depth >= RANGE[1] {
            memory.trouble.get_or_insert(Trouble::Weak { felt: memory.force });
        }
    }

    /// True when an object that was held is gone: fingers then stay as they are, and press again
    /// when they meet it.
    pub(super) fn is_lost(&mut self, order: &Order, h: f64) -> bool {
        let memory = &mut self.memory;
        let GripMemory { reflex, force, trouble, .. } = memory;
        reflex.held |= *force > LOST.0 * reflex.wanted;
        let is_felt = *force > LOST.2 * reflex.wanted;
        reflex.gone = if reflex.held && !is_felt { reflex.gone + h } else { 0.0 };
        let lost = reflex.gone > LOST.1 && order.object().is_some();
        if lost {
            lose(memory);
        } else if is_felt && matches!(trouble, Some(Trouble::Lost { .. })) {
            *trouble = None;
        }
        lost
    }
}

/// Tells that the object is gone, unless it never fitted.
fn lose(memory: &mut GripMemory) {
    let never = matches!(
        memory.trouble,
        Some(Trouble::TooLarge { .. } | Trouble::NoOpposite { .. } | Trouble::Wide { .. })
    );
    if !never {
        memory.trouble = Some(Trouble::Lost { wanted: memory.reflex.wanted });
    }
}
