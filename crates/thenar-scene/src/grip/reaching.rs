//! Pads on their way: to places before the surface, and in until they touch; or around a handle.
//!
//! Pads follow places of the object until they touch, and the palm from then on: an object that is
//! held moves with the hand and is held by the drives' springs, not followed where it slips.

use super::choose::{Choice, choose, each_other};
use super::hand::{GripHand, part};
use super::holding::sides_at;
use super::hook::Around;
use super::kind::GripKind;
use super::memory::{PadMemory, Phase, Reflex};
use super::opposition::{Base, Opposition};
use super::order::Order;
use super::size::friction;
use crate::build::BuiltHand;
use crate::live::{Law, follow};
use std::f64::consts::TAU;
use std::ops::Range;
use thenar_core::{Pose, World};
use thenar_track::reach::{Chain, FREEDOMS_MAX, Goal, solve};

/// Distance before the surface at which pads gather \[m\]: they clear what they go around, and are
/// there a fifth of a second later.
pub(super) const BEFORE: f64 = 12e-3;
/// Skin of a hook this near to the handle is on it \[m\]: contacts begin there.
const TOUCHES: f64 = 1e-3;
/// Speed at which pads go in \[m/s\]. A fingertip of 20 g on its drive of 500 N/m meets what is
/// hard with `v √(k m)` = 0.1 N.
pub(super) const CLOSING: f64 = 0.04;
/// Depth behind the surface to which pads look for it \[m\].
const BEHIND: f64 = 8e-3;
/// Rate at which targets make up for what pads lack \[1/s\], and the most by which they do \[m\].
const LEAD: (f64, f64) = (8.0, 0.015);
/// Frequency at which joints follow while nothing is held \[Hz\], and their fastest rate \[rad/s\]:
/// a reach takes half a second.
pub(super) const FOLLOW: (f64, f64) = (4.0, 4.0);
/// A palm this near has arrived \[m\].
const THERE: f64 = 2e-3;
/// Pads close when all targets are this near to where they make for \[rad\].
const GATHERED: f64 = 0.05;
/// Longest reach, and longest wait of a pad that touches for the others \[s\].
const PATIENCE: [f64; 2] = [1.0, 0.8];
/// Part of the force at which a pad is said to touch, and the most of it \[N\].
const TOUCH: (f64, f64) = (0.05, 0.1);
/// Rounds of inverse kinematics in a step.
pub(super) const ROUNDS: usize = 3;

impl GripHand {
    /// Chooses places for the pads.
    pub(super) fn set_out(
        &mut self,
        opposition: &Opposition,
        world: &World,
        hand: &BuiltHand,
        order: &Order,
        palm: &Pose,
    ) {
        let choice = self.choice(opposition, world, hand, order, palm);
        let bends = order.kind == GripKind::Hook && order.object().is_some();
        let Self { memory, script, script_rates, .. } = self;
        for (pad, kept) in memory.pads.iter_mut().enumerate() {
            let (angles, rates) = match opposition.chain(pad) {
                Some(chain) => (chain.read(script), chain.read(script_rates)),
                None => Default::default(),
            };
            *kept = PadMemory {
                anchor: choice.anchors[pad],
                goal: if bends { angles } else { choice.angles[pad] },
                angles,
                rates,
                ..PadMemory::default()
            };
        }
        (memory.phase, memory.since, memory.depth) = (Phase::Reaching, 0.0, 0.0);
        (memory.felt, memory.force, memory.trouble) = ([0.0; 6], 0.0, choice.trouble);
        // The palm may still be aside for the grip before.
        let shift_P = memory.reflex.shift_P;
        let aside_P = shift_P[0] + choice.shift_P;
        memory.reflex = Reflex { wanted: order.force, aside_P, shift_P, ..Reflex::default() };
    }

    /// Returns the places where pads are to go, and the palm's shift for that.
    fn choice(
        &mut self,
        opposition: &Opposition,
        world: &World,
        hand: &BuiltHand,
        order: &Order,
        palm: &Pose,
    ) -> Choice {
        let Some(object) = order.object() else {
            return each_other(opposition, hand.handle.bones.start);
        };
        let friction = hand.flesh().map(|flesh| friction(world.desc(), flesh, object));
        let thing = (object, friction.unwrap_or(1.0));
        let choice = choose(opposition, world, thing, palm, &mut self.scratch);
        if order.kind != GripKind::Hook {
            return choice;
        }
        let around = Around { opposition, model: &hand.model, world, object, palm: *palm };
        around.choose(choice)
    }

    /// Pads go to their places, then in until they touch; fingers of a hook bend around what they
    /// are to carry.
    pub(super) fn reach(
        &mut self,
        opposition: &Opposition,
        world: &World,
        hand: &BuiltHand,
        palm: &Pose,
        h: f64,
    ) {
        let object = self.memory.order.and_then(|order| order.object());
        if let Some(object) = object.filter(|_| opposition.kind == GripKind::Hook) {
            let around = Around { opposition, model: &hand.model, world, object, palm: *palm };
            return self.bend_around(&around, hand, h);
        }
        let closing = self.memory.phase == Phase::Closing;
        let before = match closing {
            true => (BEFORE - CLOSING * self.memory.since).max(-BEHIND),
            false => BEFORE,
        };
        let wanted = self.memory.order.map_or(0.0, |order| order.force);
        let touch = (TOUCH.0 * wanted).min(TOUCH.1);
        let Reflex { aside_P, shift_P, .. } = &self.memory.reflex;
        let (mut gathered, mut touching) = ((aside_P - shift_P[0]).norm() < THERE, true);
        for pad in 0..opposition.pads() {
            let kept = &mut self.memory.pads[pad];
            let Some(anchor) = kept.anchor else { continue };
            let (point, normal) = anchor.now(world);
            let normal_P = palm.inverse_vector(&normal);
            let place_P = palm.inverse_point(&point);
            let Some(chain) = opposition.chain(pad) else {
                // The palm itself waits where it is.
                (kept.touched, kept.point_P, kept.normal_P) = (true, place_P, normal_P);
                continue;
            };
            let felt = self.memory.felt[part(chain.digit)];
            if kept.touched {
                kept.rates = [0.0; FREEDOMS_MAX];
                continue;
            }
            let bone = hand.handle.bones.start + chain.pad.bone as u32;
            let pad_P = palm.inverse_point(&world.rigid_pose(bone).point(&chain.pad.centre_B));
            let goal = place_P + normal_P * (chain.pad.radius + before);
            let miss = goal - pad_P;
            if closing {
                let lead = kept.lead_P + miss * (LEAD.0 * h).min(1.0);
                let size = lead.norm();
                kept.lead_P = if size > LEAD.1 { lead * (LEAD.1 / size) } else { lead };
            }
            let goal = Goal { centre: goal + kept.lead_P, normal: -normal_P };
            solve(chain, &chain.ease(), &mut kept.goal, &goal, ROUNDS);
            gathered &= advance(kept, chain, h) < GATHERED;
            if closing && felt > touch {
                kept.touched = true;
                kept.point_P = chain.reach(&kept.angles).centre;
                kept.normal_P = normal_P;
            } else {
                touching = false;
            }
        }
        let waited = self.memory.since;
        // Where both sides are met no pad is waited for that has found nothing where it was to
        // touch.
        let touched = |mut pads: Range<usize>| pads.any(|pad| self.memory.pads[pad].touched);
        let met = touched(0..1) && touched(1..opposition.pads());
        let patience = if met { 0.0 } else { PATIENCE[1] };
        if closing && (touching || waited > (BEFORE + BEHIND) / CLOSING + patience) {
            self.take_hold(opposition, world, hand, palm);
        } else if !closing && (gathered || waited > PATIENCE[0]) {
            (self.memory.phase, self.memory.since) = (Phase::Closing, 0.0);
        }
    }

    /// Fingers bend until they are around the object, or as bent as they go.
    fn bend_around(&mut self, around: &Around, hand: &BuiltHand, h: f64) {
        let (memory, opposition) = (&mut self.memory, around.opposition);
        memory.phase = Phase::Closing;
        let mut around_it = true;
        for pad in 1..opposition.pads() {
            let kept = &mut memory.pads[pad];
            let (Some(chain), Some(_)) = (opposition.chain(pad), kept.anchor) else { continue };
            around_it &= !around.bend(pad, &mut kept.goal, h);
            around_it &= advance(kept, chain, h) < GATHERED;
            kept.touched = around.way(pad, &kept.angles) < TOUCHES;
        }
        if around_it || memory.since > PATIENCE[0] + PATIENCE[1] {
            self.take_hold(opposition, around.world, hand, &around.palm);
        }
    }

    /// From here on the palm carries the pads.
    fn take_hold(&mut self, opposition: &Opposition, world: &World, hand: &BuiltHand, palm: &Pose) {
        let memory = &mut self.memory;
        for pad in 0..opposition.pads() {
            let kept = &mut memory.pads[pad];
            let (Some(anchor), Some(chain)) = (kept.anchor, opposition.chain(pad)) else {
                continue;
            };
            if !kept.touched {
                kept.point_P = chain.reach(&kept.angles).centre;
                kept.normal_P = palm.inverse_vector(&anchor.now(world).1);
            }
        }
        let ready = opposition.at(0.0).axis;
        memory.axis_P = match &opposition.base {
            Base::Palm(_, normal) => *normal,
            Base::Thumb(_) => {
                let sides = sides_at(opposition, world, hand, memory);
                let along = sides.and_then(|[base, fingers]| (fingers - base).try_normalize(1e-4));
                along.unwrap_or(ready)
            }
        };
        (memory.phase, memory.since, memory.depth) = (Phase::Holding, 0.0, 0.0);
        self.memory.trouble = self.met(opposition, world, hand);
    }
}

/// Moves the targets of a pad smoothly towards its goal; how far off they are \[rad\].
fn advance(kept: &mut PadMemory, chain: &Chain, h: f64) -> f64 {
    let law = Law { omega: TAU * FOLLOW.0, speed: FOLLOW.1 };
    let mut off = 0.0f64;
    for k in 0..chain.freedoms.len() {
        let now = [kept.angles[k], kept.rates[k]];
        [kept.angles[k], kept.rates[k]] = follow(now, [kept.goal[k], 0.0], law, h);
        off = off.max((kept.goal[k] - kept.angles[k]).abs());
    }
    off
}
