//! Trouble that a grip finds while it is under way.

use super::choose::REACH;
use super::hand::{GripHand, part};
use super::kind::GripKind;
use super::loss::Loss;
use super::memory::{GripMemory, Reflex};
use super::opposition::Opposition;
use super::order::Order;
use super::squeeze::{RANGE, least_share};
use super::trouble::Trouble;
use crate::build::BuiltHand;
use thenar_core::World;

/// Time after which a force counts as lacking \[s\], and the part of it that is then not there.
const LACKING: (f64, f64) = (2.0, 0.1);
/// Part of the wanted force with which an object counts as held, and time \[s\] with less than the
/// last part after which it is gone: a bounce of a fingertip of 20 g on its drive of 500 N/m takes
/// a tenth of that, π √(m/k) = 20 ms.
const LOST: (f64, f64, f64) = (0.5, 0.2, 0.05);
/// A pad that was short of its place is there when it bears this part of its least share.
const LATE: f64 = 0.5;
/// Depth past the first touch, in radii of the thumb's pad, at which pads that feel nothing have
/// nothing between them: the whole pad has passed by.
const PASSED: f64 = 2.0;

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

    /// Returns the distance of a pad from its place \[m\]; `None` of one that has none, or is the
    /// palm.
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

    /// Returns the trouble of pads that have met nothing.
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
        // In a power grip others bear what a finger does that comes late.
        let count = pads.clone().filter(|pad| self.memory.pads[*pad].touched && *pad > 0).count();
        let late = |pad: usize| opposition.kind == GripKind::Power && pad > 0 && count >= 2;
        let short = pads.find(|pad| !self.memory.pads[*pad].touched && !late(*pad))?;
        let miss = self.miss(opposition, short, world, hand)?;
        Some(Trouble::OutOfReach { pad: short as u8, miss })
    }

    /// Reports pads that are as far in as they go and bear less than was asked for, and drops the
    /// report of a pad that was short of its place and bears its least share now.
    pub(super) fn tell_weak(&mut self, opposition: &Opposition, order: &Order) {
        let memory = &mut self.memory;
        if let Some(Trouble::OutOfReach { pad, .. }) = memory.trouble {
            let fingers = (1..opposition.pads()).filter(|pad| memory.pads[*pad].anchor.is_some());
            let count = fingers.count().max(1);
            let share = LATE * least_share(count) * memory.reflex.wanted / count as f64;
            let chain = opposition.chain(usize::from(pad));
            if chain.is_some_and(|chain| memory.felt[part(chain.digit)] > share) {
                memory.trouble = None;
            }
        }
        let lacking = order.force - memory.force > LACKING.1 * order.force;
        if memory.since > LACKING.0 && lacking && memory.depth >= RANGE[1] {
            memory.trouble.get_or_insert(Trouble::Weak { felt: memory.force });
        }
    }

    /// True when an object that was held is gone: fingers then stay as they are, and press again
    /// when they meet it. What was met and never held is gone, too, where pads passed by each
    /// other: they go on.
    pub(super) fn is_lost(
        &mut self,
        opposition: &Opposition,
        world: &World,
        hand: &BuiltHand,
        order: &Order,
        h: f64,
    ) -> bool {
        let memory = &mut self.memory;
        let met = memory.pads.iter().any(|pad| pad.touched) && order.kind.has_thumb();
        let thumb = opposition.chain(0).map_or(f64::INFINITY, |chain| chain.pad.radius);
        let passed = met && memory.depth > PASSED * thumb;
        let reflex = &mut memory.reflex;
        let gone = reflex.is_gone(memory.force, passed, h) && order.object().is_some();
        let (held, is_felt) = (reflex.held, reflex.gone == 0.0);
        let told = matches!(memory.trouble, Some(Trouble::Lost { .. } | Trouble::LostFor { .. }));
        if gone && !told {
            let cause = hand.flesh().and_then(|flesh| self.cause(opposition, world, flesh, order));
            lose(&mut self.memory, cause);
        } else if is_felt && told {
            memory.trouble = None;
        }
        gone && held
    }
}

impl Reflex {
    /// True when the object has been gone for longer than a bounce, after a step of `h` \[s\] in
    /// which pads pressed with `force` \[N\]: one that was held, or one that they have `passed`.
    fn is_gone(&mut self, force: f64, passed: bool, h: f64) -> bool {
        self.held |= force > LOST.0 * self.wanted;
        let is_felt = force > LOST.2 * self.wanted;
        self.gone = if (self.held || passed) && !is_felt { self.gone + h } else { 0.0 };
        self.gone > LOST.1
    }
}

/// Reports that the object is gone, and why, unless it never fitted.
fn lose(memory: &mut GripMemory, cause: Option<Loss>) {
    let never = matches!(
        memory.trouble,
        Some(Trouble::TooLarge { .. } | Trouble::NoOpposite { .. } | Trouble::Wide { .. })
    );
    if !never {
        let wanted = memory.reflex.wanted;
        memory.trouble = Some(match cause {
            Some(cause) => Trouble::LostFor { wanted, cause },
            None => Trouble::Lost { wanted },
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step without contact is a bounce at every step; 0.2 s and more are a loss, and contact
    /// begins the time anew.
    #[test]
    fn an_object_is_gone_after_a_dwell() {
        for h in [1e-3, 5e-3, 1.0 / 60.0] {
            let mut reflex = Reflex { wanted: 1.0, ..Reflex::default() };
            assert!(!reflex.is_gone(0.9, false, h) && reflex.held);
            let until_gone = |reflex: &mut Reflex| {
                let steps = (1..1000).find(|_| reflex.is_gone(0.0, false, h));
                f64::from(steps.expect("gone")) * h
            };
            let dwell = until_gone(&mut reflex);
            assert!(dwell > LOST.1 - 1e-9 && dwell < LOST.1 + 1.5 * h, "{h}: {dwell} s");
            assert!(!reflex.is_gone(0.9, false, h));
            assert_eq!(until_gone(&mut reflex), dwell);
        }
    }

    /// An object that was never held is gone only where pads have passed by each other, and after
    /// the same dwell.
    #[test]
    fn what_was_never_held_is_gone_when_pads_passed() {
        let mut reflex = Reflex { wanted: 1.0, ..Reflex::default() };
        assert!((0..100).all(|_| !reflex.is_gone(0.0, false, 1e-2)));
        let steps = (1..100).find(|_| reflex.is_gone(0.0, true, 1e-2));
        assert!(steps.is_some_and(|steps| (20..=21).contains(&steps)), "{steps:?}");
    }
}
