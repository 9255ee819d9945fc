//! The grips of one hand, step by step.
//!
//! ```text
//!  reaching            closing               holding                 opening
//!  pads to places      pads go in until      targets go in by u,     back to the
//!  before the surface  each touches          u by the force felt     script
//! ```
//!
//! Pads follow places of the object until they touch, and the palm from then on: an object that is
//! held moves with the hand and is held by the drives' springs, not followed where it slips. The
//! depth `u` of all pads together answers to force, and a finger that bears next to nothing goes
//! farther in: one loop for each pad would let an object wander that its weight presses on one
//! side.

use super::choose::{Choice, Scratch, choose, each_other};
use super::felt::{Against, felt, friction_used};
use super::hook::Around;
use super::kind::GripKind;
use super::memory::{GripMemory, PadMemory, Phase, Reflex};
use super::opposition::{Base, Opposition};
use super::order::Order;
use super::size::friction;
use super::squeeze::{FURTHER_MAX, further, least_share, push, slope, wanted};
use super::trouble::Trouble;
use crate::build::BuiltHand;
use crate::live::{Law, follow};
use crate::motion::Articulation;
use std::f64::consts::TAU;
use std::ops::Range;
use thenar_core::model::Digit;
use thenar_core::world::Target;
use thenar_core::{Pose, Vec3, World};
use thenar_track::reach::{Angles, Chain, FREEDOMS_MAX, Goal, solve};

/// How far before the surface pads gather \[m\]: they clear what they go around, and are there a
/// fifth of a second later.
const BEFORE: f64 = 12e-3;
/// Skin of a hook this near to the handle is on it \[m\]: contacts begin there.
const TOUCHES: f64 = 1e-3;
/// How fast they go in \[m/s\]. A fingertip of 20 g on its drive of 500 N/m meets what is hard with
/// `v √(k m)` = 0.1 N.
const CLOSING: f64 = 0.04;
/// How far behind the surface they look for it \[m\].
const BEHIND: f64 = 8e-3;
/// How fast targets make up for what pads lack \[1/s\], and by how much at most \[m\].
const LEAD: (f64, f64) = (8.0, 0.015);
/// Frequency at which joints follow while nothing is held \[Hz\], and their fastest rate \[rad/s\]:
/// a reach takes half a second.
const FOLLOW: (f64, f64) = (4.0, 4.0);
/// Frequency \[Hz\] and fastest rate \[m/s\] of a palm that goes aside: half as fast as joints.
const ASIDE: (f64, f64) = (2.0, 0.15);
/// A palm this near has arrived \[m\].
const THERE: f64 = 2e-3;
/// Pads close when all targets are this near to where they make for \[rad\].
const GATHERED: f64 = 0.05;
/// Longest reach, and longest wait of a pad that touches for the others \[s\].
const PATIENCE: [f64; 2] = [1.0, 0.8];
/// Part of the force at which a pad is said to touch, and the most of it \[N\].
const TOUCH: (f64, f64) = (0.05, 0.1);
/// Time over which the felt force is smoothed \[s\].
const SMOOTHING: f64 = 0.01;
/// Time in which fingers open \[s\].
const OPENING: f64 = 0.5;
/// Time over which the use of friction is smoothed \[s\]: some steps at the usual ones.
const LOAD_SMOOTHING: f64 = 0.03;
/// Rounds of inverse kinematics in a step.
const ROUNDS: usize = 3;

/// A hand that grips.
#[derive(Clone, Debug)]
pub struct GripHand {
    articulation: Articulation,
    /// One for each kind that is asked of it, in the order of [`GripKind::ALL`].
    oppositions: [Option<Box<Opposition>>; GripKind::ALL.len()],
    /// Grips of the scene, by time.
    orders: Vec<Order>,
    pub(super) memory: GripMemory,
    scratch: Scratch,
    poses: Vec<Pose>,
    script: Vec<[f64; 2]>,
    script_rates: Vec<[f64; 2]>,
}

/// What a grip does, for who asks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripState {
    /// What was asked for.
    pub order: Order,
    /// Present phase of the grip.
    pub phase: Phase,
    /// Force of the two sides against each other \[N\]: half of the sum of the normal forces of the
    /// pads.
    pub force: f64,
    /// What is amiss.
    pub trouble: Option<Trouble>,
}

impl GripHand {
    /// A hand without grips.
    ///
    /// # Errors
    /// Joints are no tree; says why.
    pub fn new(hand: &BuiltHand) -> Result<Self, String> {
        let articulation = Articulation::new(&hand.model).map_err(|e| e.to_string())?;
        let (bones, joints) = (articulation.tree.bones(), articulation.tree.joints());
        let memory = GripMemory { script: Vec::with_capacity(joints), ..GripMemory::default() };
        Ok(Self {
            articulation,
            oppositions: Default::default(),
            orders: Vec::new(),
            memory,
            scratch: Scratch::default(),
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
        let used = |pads: Range<usize>| {
            let mut own = [false; 6];
            let chains = pads.filter_map(|pad| opposition.chain(pad));
            chains.for_each(|chain| own[part(chain.digit)] = true);
            friction_used(world, hand, against, own)
        };
        let used = used(0..1).max(used(1..opposition.pads()));
        let blend = 1.0 - (-world.time_step() / LOAD_SMOOTHING).exp();
        self.memory.reflex.used += blend * (used - self.memory.reflex.used);
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

    /// Chooses places for the pads.
    fn set_out(
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

    /// Where pads are to go, and the palm for that.
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
    fn reach(
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
        if closing && (touching || waited > (BEFORE + BEHIND) / CLOSING + PATIENCE[1]) {
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
        let (mut fingers, mut count) = (Vec3::zeros(), 0.0);
        let mut base = None;
        for pad in 0..opposition.pads() {
            let kept = &mut memory.pads[pad];
            let Some(anchor) = kept.anchor else { continue };
            let Some(chain) = opposition.chain(pad) else { continue };
            if !kept.touched {
                kept.point_P = chain.reach(&kept.angles).centre;
                kept.normal_P = palm.inverse_vector(&anchor.now(world).1);
            }
            let bone = hand.handle.bones.start + chain.pad.bone as u32;
            let centre = palm.inverse_point(&world.rigid_pose(bone).point(&chain.pad.centre_B));
            if pad == 0 {
                base = Some(centre);
            } else {
                fingers += centre;
                count += 1.0;
            }
        }
        let ready = opposition.at(0.0).axis;
        let along = base.filter(|_| count > 0.0).map(|base| fingers / count - base);
        memory.axis_P = match &opposition.base {
            Base::Palm(_, normal) => *normal,
            Base::Thumb(_) => along.and_then(|way| way.try_normalize(1e-4)).unwrap_or(ready),
        };
        (memory.phase, memory.since, memory.depth) = (Phase::Holding, 0.0, 0.0);
        self.memory.trouble = self.met(opposition, world, hand);
    }

    /// Pads press with the force that was asked for.
    fn hold(
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
        let count = fingers.count().max(1);
        let (share, least) = (1.0 / count as f64, least_share(count));
        let shares =
            order.object().is_some() && opposition.kind.has_thumb() && memory.reflex.gone == 0.0;
        let palm = world.rigid_pose(hand.handle.bones.start);
        for pad in 0..opposition.pads() {
            let kept = &mut memory.pads[pad];
            let (Some(chain), Some(anchor)) = (opposition.chain(pad), kept.anchor) else {
                continue;
            };
            let inwards = if pad == 0 { memory.axis_P } else { memory.axis_P * -share };
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
        self.tell_weak(order);
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
fn part(digit: Digit) -> usize {
    usize::from(digit.part())
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
