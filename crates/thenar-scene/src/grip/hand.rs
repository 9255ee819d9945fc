//! The grips of one hand, step by step.
//!
//! ```text
//!  reaching            closing               holding                 opening
//!  pads to places      pads go in until      targets go in by u,     back to the
//!  before the surface  each touches          u by the force felt     script
//! ```
//!
//! [`super::reaching`] has the first two, [`super::holding`] the third.

use super::felt::{Against, Use, carried, felt, foreseen, friction_used, side};
use super::kind::GripKind;
use super::memory::{GripMemory, Phase};
use super::opposition::Opposition;
use super::order::Order;
use super::pair::Scratch;
use super::size::{MARGIN, mass};
use super::squeeze::wanted;
use super::trouble::Trouble;
use crate::build::BuiltHand;
use crate::live::{Law, follow};
use crate::motion::Articulation;
use std::f64::consts::TAU;
use std::ops::Range;
use thenar_core::model::{BodyId, Digit};
use thenar_core::world::Target;
use thenar_core::{Pose, Vec3, World};
use thenar_track::reach::FREEDOMS_MAX;

/// Frequency \[Hz\] and fastest rate \[m/s\] of a palm that goes aside: half as fast as joints.
const ASIDE: (f64, f64) = (2.0, 0.15);
/// Time over which the felt force is smoothed \[s\].
const SMOOTHING: f64 = 0.01;
/// Time in which fingers open \[s\].
const OPENING: f64 = 0.5;
/// Time over which the use of friction is smoothed \[s\]: some steps at the usual ones.
const LOAD_SMOOTHING: f64 = 0.03;

/// An object is carried where pads bear this part of its weight: the rest is what shakes as it is
/// lifted.
const CARRIED: f64 = 0.9;

/// A hand that grips.
#[derive(Clone, Debug)]
pub struct GripHand {
    articulation: Articulation,
    /// One for each kind that is asked of it, in the order of [`GripKind::ALL`].
    oppositions: [Option<Box<Opposition>>; GripKind::ALL.len()],
    /// Grips of the scene, by time.
    orders: Vec<Order>,
    pub(super) memory: GripMemory,
    pub(super) scratch: Scratch,
    poses: Vec<Pose>,
    pub(super) script: Vec<[f64; 2]>,
    pub(super) script_rates: Vec<[f64; 2]>,
}

/// State of a grip, as reported to callers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripState {
    /// Grip that was asked for.
    pub order: Order,
    /// Present phase of the grip.
    pub phase: Phase,
    /// Force of the two sides against each other \[N\]: half of the sum of the normal forces of the
    /// pads.
    pub force: f64,
    /// Trouble of the grip, if any.
    pub trouble: Option<Trouble>,
}

impl GripHand {
    /// A hand without grips, in a world of `bodies` rigid bodies.
    ///
    /// # Errors
    /// Joints are no tree; says why.
    pub fn new(hand: &BuiltHand, bodies: usize) -> Result<Self, String> {
        let articulation = Articulation::new(&hand.model).map_err(|e| e.to_string())?;
        let (bones, joints) = (articulation.tree.bones(), articulation.tree.joints());
        let memory = GripMemory { script: Vec::with_capacity(joints), ..GripMemory::default() };
        Ok(Self {
            articulation,
            oppositions: Default::default(),
            orders: Vec::new(),
            memory,
            scratch: Scratch::for_bodies(bodies),
            poses: vec![Pose::identity(); bones],
            script: vec![[0.0; 2]; joints],
            script_rates: vec![[0.0; 2]; joints],
        })
    }

    /// Makes the hand ready for a kind. Takes some ten milliseconds the first time.
    ///
    /// # Errors
    /// The hand lacks a digit that it needs; says which.
    pub fn learn(&mut self, hand: &BuiltHand, kind: GripKind) -> Result<(), String> {
        let place = &mut self.oppositions[kind as usize];
        if place.is_none() {
            *place = Some(Box::new(Opposition::new(&hand.model, kind)?));
        }
        Ok(())
    }

    /// Adds a grip of the scene, whose kind it has learnt, later than those before.
    pub fn plan(&mut self, order: Order) {
        self.orders.push(order);
    }

    /// Grips of the scene.
    pub fn orders(&self) -> &[Order] {
        &self.orders
    }

    /// The pads of a kind that it has learnt.
    pub fn opposition(&self, kind: GripKind) -> Option<&Opposition> {
        self.oppositions[kind as usize].as_deref()
    }

    /// Begins a grip, of a kind that it has learnt, now; a hand that grips opens first.
    pub fn begin(&mut self, order: Order) {
        let memory = &mut self.memory;
        match memory.order {
            None => (memory.order, memory.phase, memory.since) = (Some(order), Phase::Idle, 0.0),
            Some(_) => {
                self.release();
                self.memory.waiting = Some(order);
            }
        }
    }

    /// Opens, if it grips.
    pub fn release(&mut self) {
        let memory = &mut self.memory;
        memory.waiting = None;
        match memory.phase {
            Phase::Opening => {}
            Phase::Idle => memory.order = None,
            _ => (memory.phase, memory.since) = (Phase::Opening, 0.0),
        }
    }

    /// Forgets all that went on: the scene starts over.
    pub fn restart(&mut self) {
        let mut script = std::mem::take(&mut self.memory.script);
        script.clear();
        self.memory = GripMemory { script, ..GripMemory::default() };
    }

    /// All that the next step depends on besides the scene and what enters.
    pub fn memory(&self) -> &GripMemory {
        &self.memory
    }

    /// Goes on from what a hand of the same scene remembered, whose kind it has learnt.
    pub fn recall(&mut self, kept: &GripMemory) {
        let mut script = std::mem::take(&mut self.memory.script);
        script.clear();
        script.extend_from_slice(&kept.script);
        self.memory = GripMemory { script, ..kept.clone() };
    }

    /// State of the grip; `None` while nothing is gripped.
    pub fn state(&self) -> Option<GripState> {
        let GripMemory { order, phase, force, trouble, .. } = &self.memory;
        order.map(|order| GripState { order, phase: *phase, force: *force, trouble: *trouble })
    }

    /// Moves on by a step of `h` that ends at time `t` \[s\]: `targets`, which scripts and poses
    /// have filled, become those of the grip where digits take part in it. A hand that is not
    /// `scripted` but moved live leaves the scene's grips to who moves it.
    pub fn step(
        &mut self,
        world: &World,
        hand: &BuiltHand,
        (h, t): (f64, f64),
        scripted: bool,
        targets: &mut [Option<Target>],
    ) {
        if !self.read_script(h, targets) {
            return;
        }
        self.begin_by_script(t, scripted);
        self.go_aside(h, targets);
        let Some(palm) = targets.first().copied().flatten() else { return };
        let Some(order) = self.memory.order else { return };
        let over = order.open.is_some_and(|open| t >= open);
        let is_order = |other: &Order| other.adapting(order.adapts) == order;
        let left = !scripted && self.orders.iter().any(is_order);
        if (over || left) && self.memory.phase != Phase::Opening {
            self.release();
        }
        let Some(opposition) = self.oppositions[order.kind as usize].take() else { return };
        let actual = world.rigid_pose(hand.handle.bones.start);
        self.go_on(&opposition, world, hand, &order, &actual, h);
        self.write(&opposition, &palm, targets);
        self.oppositions[order.kind as usize] = Some(opposition);
    }

    /// Takes in what contact did in the last step.
    pub fn feel(&mut self, world: &World, hand: &BuiltHand) {
        let Some(order) = self.memory.order else { return };
        if self.memory.phase == Phase::Idle {
            return;
        }
        let against = order.object().map_or(Against::OtherSide(order.kind), Against::Object);
        self.memory.felt = felt(world, hand, against);
        let Some(opposition) = self.oppositions[order.kind as usize].as_deref() else { return };
        let side = |pads: Range<usize>| {
            let mut own = [false; 6];
            let chains = pads.filter_map(|pad| opposition.chain(pad));
            chains.for_each(|chain| own[part(chain.digit)] = true);
            side(world, hand, against, own)
        };
        let sides = [side(0..1), side(1..opposition.pads())];
        let down = world.desc().gravity.try_normalize(1e-9);
        let used = friction_used(&sides, &down.unwrap_or_else(Vec3::zeros));
        let weight = |object: BodyId| mass(world.desc(), object) * world.desc().gravity.norm();
        let carried = order
            .object()
            .zip(down)
            .is_some_and(|(object, down)| carried(&sides, &down) > CARRIED * weight(object));
        let h = world.time_step();
        let reflex = &mut self.memory.reflex;
        reflex.used += (1.0 - (-h / LOAD_SMOOTHING).exp()) * (used.load - reflex.used);
        if order.adapts && self.memory.phase == Phase::Holding && reflex.gone == 0.0 {
            let falls = down.filter(|_| order.object().is_some());
            let ahead = falls.map_or(0.0, |down| foreseen(&sides, &down));
            let used = Use { load: reflex.used, slant: used.slant.max(ahead), carried };
            let foreseen = [order.force, MARGIN];
            reflex.wanted = wanted(reflex.wanted, foreseen, self.memory.force, used, h);
        }
    }

    /// Forgets that the palm is aside: a leader has taken it over.
    pub fn be_led(&mut self) {
        let reflex = &mut self.memory.reflex;
        (reflex.aside_P, reflex.shift_P) = (Vec3::zeros(), [Vec3::zeros(); 2]);
    }

    /// Moves the palm, and the hand with it, to where pads reach their places, and back when the
    /// grip is over.
    fn go_aside(&mut self, h: f64, targets: &mut [Option<Target>]) {
        let GripMemory { order, phase, since, reflex, .. } = &mut self.memory;
        // Fingers that hold take the object with them: they open first.
        let open = *phase == Phase::Opening && *since > 0.5 * OPENING;
        if order.is_none() || open {
            reflex.aside_P = Vec3::zeros();
        }
        let law = Law { omega: TAU * ASIDE.0, speed: ASIDE.1 };
        let [shift_P, rate_P] = &mut reflex.shift_P;
        for k in 0..3 {
            [shift_P[k], rate_P[k]] =
                follow([shift_P[k], rate_P[k]], [reflex.aside_P[k], 0.0], law, h);
        }
        // What is left of a way back is nothing.
        if reflex.aside_P == Vec3::zeros() && shift_P.norm() < 1e-9 && rate_P.norm() < 1e-9 {
            reflex.shift_P = [Vec3::zeros(); 2];
            return;
        }
        let Some(palm) = targets.first().copied().flatten() else { return };
        let [shift_W, rate_W] = reflex.shift_P.map(|v| palm.pose_WB.vector(&v));
        for target in targets.iter_mut().flatten() {
            target.pose_WB.position += shift_W;
            target.velocity_W += rate_W + palm.angular_velocity_W.cross(&shift_W);
        }
    }

    /// Angles of the script and their rates; false while some bone has no target.
    fn read_script(&mut self, h: f64, targets: &[Option<Target>]) -> bool {
        for (pose, target) in self.poses.iter_mut().zip(targets) {
            let Some(target) = target else { return false };
            *pose = target.pose_WB;
        }
        self.articulation.tree.angles(&self.poses, &mut self.script);
        let before = &mut self.memory.script;
        let known = before.len() == self.script.len();
        if !known {
            before.clear();
            before.extend_from_slice(&self.script);
        }
        for (j, now) in self.script.iter().enumerate() {
            self.script_rates[j] = [0, 1].map(|k| (now[k] - before[j][k]) / h);
        }
        before.copy_from_slice(&self.script);
        true
    }

    /// Begins the scene's next grip when its time has come, or passes it over.
    fn begin_by_script(&mut self, t: f64, scripted: bool) {
        while let Some(order) = self.orders.get(self.memory.begun as usize) {
            if t < order.at {
                return;
            }
            self.memory.begun += 1;
            if scripted && order.open.is_none_or(|open| t < open) {
                self.begin(*order);
            }
        }
    }

    /// Goes on with what the grip is doing.
    fn go_on(
        &mut self,
        opposition: &Opposition,
        world: &World,
        hand: &BuiltHand,
        order: &Order,
        palm: &Pose,
        h: f64,
    ) {
        self.memory.since += h;
        let blend = 1.0 - (-h / SMOOTHING).exp();
        self.memory.force += blend * (self.felt(opposition) - self.memory.force);
        match self.memory.phase {
            Phase::Idle => {
                self.set_out(opposition, world, hand, order, palm);
                self.reach(opposition, world, hand, palm, h);
            }
            Phase::Reaching | Phase::Closing => self.reach(opposition, world, hand, palm, h),
            Phase::Holding => self.hold(opposition, world, hand, order, h),
            Phase::Opening if self.memory.since >= OPENING => {
                self.memory.order = self.memory.waiting.take();
                (self.memory.phase, self.memory.since) = (Phase::Idle, 0.0);
            }
            Phase::Opening => {}
        }
    }

    /// Force of the two sides against each other in the last step \[N\].
    fn felt(&self, opposition: &Opposition) -> f64 {
        let palm = if opposition.kind.has_thumb() { 0.0 } else { self.memory.felt[0] };
        let digits = (0..opposition.pads()).filter_map(|pad| opposition.chain(pad));
        0.5 * (palm + digits.map(|chain| self.memory.felt[part(chain.digit)]).sum::<f64>())
    }

    /// Puts the targets of the digits that take part where the grip has them.
    fn write(&self, opposition: &Opposition, palm: &Target, targets: &mut [Option<Target>]) {
        let memory = &self.memory;
        if memory.phase == Phase::Idle {
            return;
        }
        let root = [palm.velocity_W, palm.angular_velocity_W];
        // How much of the grip is left, and how fast that falls.
        let (left, fall) = match memory.phase {
            Phase::Opening => ease(1.0 - memory.since / OPENING),
            _ => (1.0, 0.0),
        };
        for pad in 0..opposition.pads() {
            let kept = &memory.pads[pad];
            let (Some(chain), Some(_)) = (opposition.chain(pad), kept.anchor) else { continue };
            let (script, rates) = (chain.read(&self.script), chain.read(&self.script_rates));
            let still = memory.phase == Phase::Opening;
            let (mut angles, mut turning) = ([0.0; FREEDOMS_MAX], [0.0; FREEDOMS_MAX]);
            for k in 0..chain.freedoms.len() {
                let own = if still { 0.0 } else { kept.rates[k] };
                let apart = kept.angles[k] - script[k];
                angles[k] = script[k] + left * apart;
                turning[k] = rates[k] + left * (own - rates[k]) - fall / OPENING * apart;
            }
            chain.bones_at((&palm.pose_WB, root), &angles, &turning, |bone, pose_WB, [v, w]| {
                let target = Target { pose_WB, velocity_W: v, angular_velocity_W: w };
                if let Some(place) = targets.get_mut(bone).filter(|_| target.is_finite()) {
                    *place = Some(target);
                }
            });
        }
    }
}

/// Smooth step from 0 to 1 and its slope.
fn ease(u: f64) -> (f64, f64) {
    let u = u.clamp(0.0, 1.0);
    (u * u * u * (10.0 + u * (6.0 * u - 15.0)), 30.0 * u * u * (1.0 - u) * (1.0 - u))
}

/// Number of a digit among the felt forces.
pub(super) fn part(digit: Digit) -> usize {
    usize::from(digit.part())
}
