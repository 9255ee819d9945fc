//! Grips of a session's hands, those of the scene and those that are asked for while it runs.

use super::{Entry, Session, drive};
use crate::build::BuiltHand;
use crate::grip::{
    GripHand, GripKind, GripMemory, GripState, Opposition, Order, Trouble, friction, narrowest,
    pads_middle, slip_limit, usual_force, way_to,
};
use crate::live::Mover;
use serde::{Serialize, Serializer};
use thenar_core::model::{BodyId, Motion};

/// An object is under the hand when its surface is this near to the middle of the pads \[m\]: a
/// finger's length.
const UNDER: f64 = 0.12;

/// Why a hand does not grip. Nothing has changed then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GripError {
    /// No hand has this index.
    #[error("there is no hand {hand}: the scene has {count}")]
    NoHand {
        /// Index given.
        hand: usize,
        /// Number of hands.
        count: usize,
    },
    /// No body has this name.
    #[error("no body is named \"{object}\"; there are {known}")]
    NoObject {
        /// Name given.
        object: String,
        /// Names of what can be gripped.
        known: String,
    },
    /// Nothing is near.
    #[error("nothing is within {} mm of the pads of hand `{hand}`", (UNDER * 1e3).round())]
    NothingNear {
        /// The hand's name.
        hand: String,
    },
    /// The hand cannot grip so.
    #[error("hand `{hand}`: {cause}")]
    Unfit {
        /// Name of the hand.
        hand: String,
        /// Reason why the hand cannot grip so.
        cause: String,
    },
    /// The force is none.
    #[error("a grip's force is more than 0 and at most {FORCE_MAX} N, got {0} N")]
    Force(f64),
}

/// Largest force that is taken \[N\]: twice the strongest grip of people.
pub const FORCE_MAX: f64 = 1000.0;

impl Session {
    /// Lets hand `hand` grip a body now, whatever the scene says: the one of this name, or where
    /// there is none the nearest one under its pads; with this force \[N\], or one that holds its
    /// weight. A hand that grips opens first. Returns the object's name. Takes some milliseconds
    /// the first time, and allocates.
    ///
    /// # Errors
    /// There is no such hand or body, or the hand cannot grip so.
    pub fn grip(
        &mut self,
        hand: usize,
        object: Option<&str>,
        kind: GripKind,
        force: Option<f64>,
    ) -> Result<String, GripError> {
        let body = match object {
            Some(name) => Some(self.named_object(hand, name)?),
            None => None,
        };
        let flesh = self.ready_to_grip(hand, kind)?;
        let body = match body {
            Some(body) => body,
            None => self.under(hand, kind)?,
        };
        let adapts = force.is_none() && kind.has_thumb();
        let force = force.unwrap_or_else(|| usual_force(self.world.desc(), flesh, body, kind));
        if !(force > 0.0 && force <= FORCE_MAX) {
            return Err(GripError::Force(force));
        }
        let order = Order::new(Some(body), kind, force, self.world.time(), None);
        let order = order.adapting(adapts);
        self.begin_grip(hand, &order)?;
        Ok(self.body_name(body).to_owned())
    }

    /// Begins a grip whose object is known by index.
    pub(super) fn begin_grip(&mut self, hand: usize, order: &Order) -> Result<(), GripError> {
        self.ready_to_grip(hand, order.kind)?;
        let is_object = |body| self.is_object(hand, body);
        if !order.fits(&self.world) || !order.object().is_none_or(is_object) {
            let known = self.known_objects(hand);
            return Err(GripError::NoObject { object: "?".into(), known });
        }
        if let Some(gripping) = &mut self.grips[hand] {
            gripping.begin(*order);
        }
        self.tell(Entry::Grip { hand, order });
        Ok(())
    }

    /// Opens a hand that grips.
    ///
    /// # Errors
    /// There is no such hand.
    pub fn release(&mut self, hand: usize) -> Result<(), GripError> {
        let count = self.grips.len();
        let Some(gripping) = self.grips.get_mut(hand) else {
            return Err(GripError::NoHand { hand, count });
        };
        if let Some(gripping) = gripping {
            gripping.release();
            self.tell(Entry::Release { hand });
        }
        Ok(())
    }

    /// State of the grip of hand `hand`; `None` while it grips nothing.
    pub fn grip_state(&self, hand: usize) -> Option<GripState> {
        self.grips.get(hand)?.as_ref()?.state()
    }

    /// Trouble with the present grip of a hand, in a sentence that names the object, the kind and
    /// the figure.
    pub fn grip_trouble(&self, hand: usize) -> Option<String> {
        let state = self.grip_state(hand)?;
        let opposition = self.grips[hand].as_ref()?.opposition(state.order.kind)?;
        let object = state.order.object().map_or("the other pad", |body| self.body_name(body));
        let said = state.trouble?.sentence(opposition, object, state.order.force);
        Some(format!("hand `{}`: {said}", self.built.hands[hand].name))
    }

    /// Foreseeable troubles with the grips of the scene, a sentence each: objects that are too
    /// large, or slip out.
    pub(super) fn grip_warnings(&self) -> Vec<String> {
        let hands = self.grips.iter().zip(&self.built.hands);
        let orders = hands.flat_map(|(gripping, hand)| {
            let gripping = gripping.iter();
            gripping.flat_map(move |g| g.orders().iter().map(move |order| (hand, g, order)))
        });
        orders.filter_map(|(hand, g, order)| self.grip_warning(hand, g, order)).collect()
    }

    fn grip_warning(&self, hand: &BuiltHand, g: &GripHand, order: &Order) -> Option<String> {
        let opposition = g.opposition(order.kind)?;
        let (object, opening) = (order.object()?, opposition.opening());
        let width = narrowest(&self.world, object);
        let trouble = match width.is_finite() && width > opening {
            true => Trouble::TooLarge { width, opening },
            false => self.slippery(hand, order, object)?,
        };
        let said = trouble.sentence(opposition, self.body_name(object), order.force);
        Some(format!("hand `{}`: {said}", hand.name))
    }

    /// Trouble with an object that moves and that friction alone carries, where all hands that hold
    /// it at that time press with less than its weight needs.
    fn slippery(&self, hand: &BuiltHand, order: &Order, object: BodyId) -> Option<Trouble> {
        let fixed = matches!(object, BodyId::Rigid(i)
            if self.world.desc().rigids[i as usize].motion != Motion::Dynamic);
        if fixed || !order.kind.has_thumb() {
            return None;
        }
        let flesh = hand.flesh()?;
        let together = |other: &Order| {
            other.object() == Some(object)
                && order.open.is_none_or(|open| other.at < open)
                && other.open.is_none_or(|open| order.at < open)
        };
        // A hand grips once at a time.
        let of_hand = |orders: &[Order]| {
            let forces = orders.iter().filter(|other| together(other)).map(|other| other.force);
            forces.fold(0.0, f64::max)
        };
        let gripping = self.grips.iter().flatten();
        let force: f64 = gripping.map(|gripping| of_hand(gripping.orders())).sum();
        let needed = slip_limit(self.world.desc(), flesh, object);
        let friction = friction(self.world.desc(), flesh, object);
        (force < needed).then_some(Trouble::Slippery { needed, friction })
    }

    /// Puts the grips' targets over those of scripts and poses, for a step that ends at time `t`
    /// \[s\].
    pub(super) fn steer_grips(&mut self, t: f64) {
        let h = self.world.time_step();
        for k in 0..self.grips.len() {
            let scripted = self.mover(k) == Mover::Script;
            let hand = &self.built.hands[k];
            if let Some(gripping) = &mut self.grips[k] {
                if self.led[k].is_some() {
                    gripping.be_led();
                }
                let targets = &mut self.input.targets[drive::bones(hand)];
                gripping.step(&self.world, hand, (h, t), scripted, targets);
            }
        }
    }

    /// Takes in what the last step's contacts did.
    pub(super) fn feel_grips(&mut self) {
        for (gripping, hand) in self.grips.iter_mut().zip(&self.built.hands) {
            if let Some(gripping) = gripping {
                gripping.feel(&self.world, hand);
            }
        }
    }

    /// Memories of grips, one for each hand.
    pub(crate) fn grips_memory(&self, if_none: IfNone) -> GripsRef<'_> {
        GripsRef(self, if_none)
    }

    /// Reflexes of grips, one for each hand.
    pub(crate) fn reflexes(&self, if_none: IfNone) -> ReflexesRef<'_> {
        ReflexesRef(self, if_none)
    }

    /// True when this can be gone on from.
    pub(super) fn takes_grips(&self, kept: &[Option<GripMemory>]) -> bool {
        let joints = |k: usize| self.built.hands[k].model.joints.len();
        let fits = |(k, kept): (usize, &Option<GripMemory>)| {
            kept.as_ref().is_none_or(|kept| {
                self.built.hands[k].driven
                    && [0, joints(k)].contains(&kept.script.len())
                    && kept.is_of(&self.world)
            })
        };
        (kept.is_empty() || kept.len() == self.grips.len()) && kept.iter().enumerate().all(fits)
    }

    /// Continues from what [`Session::takes_grips`]; grips without memory begin anew.
    pub(super) fn recall_grips(&mut self, kept: &[Option<GripMemory>]) {
        for k in 0..self.grips.len() {
            let Some(kept) = kept.get(k).and_then(Option::as_ref) else {
                if let Some(gripping) = &mut self.grips[k] {
                    gripping.restart();
                }
                continue;
            };
            for order in kept.order.iter().chain(&kept.waiting) {
                // A kind that the hand lacks was never begun.
                let _ = self.ready_to_grip(k, order.kind);
            }
            if let Some(gripping) = &mut self.grips[k] {
                gripping.recall(kept);
            }
        }
    }

    /// Makes a hand ready for a kind of grip, and returns the index of its flesh.
    fn ready_to_grip(&mut self, hand: usize, kind: GripKind) -> Result<u32, GripError> {
        let count = self.built.hands.len();
        let Some(built) = self.built.hands.get(hand) else {
            return Err(GripError::NoHand { hand, count });
        };
        let unfit = |cause: String| GripError::Unfit { hand: built.name.clone(), cause };
        if !built.driven {
            return Err(unfit("the scene says `driven = false`".into()));
        }
        let Some(flesh) = built.flesh() else {
            return Err(unfit("it has no flesh, and touches nothing".into()));
        };
        let place = &mut self.grips[hand];
        if place.is_none() {
            let bodies = self.world.desc().rigids.len();
            *place = Some(Box::new(GripHand::new(built, bodies).map_err(unfit)?));
        }
        if let Some(gripping) = place {
            gripping.learn(built, kind).map_err(unfit)?;
        }
        Ok(flesh)
    }

    fn body_name(&self, body: BodyId) -> &str {
        let desc = self.world.desc();
        match body {
            BodyId::Rigid(i) => &desc.rigids[i as usize].name,
            BodyId::Soft(i) => &desc.softs[i as usize].name,
        }
    }

    /// All bodies, rigid first.
    fn all_bodies(&self) -> impl Iterator<Item = BodyId> + use<> {
        let desc = self.world.desc();
        let (rigids, softs) = (desc.rigids.len() as u32, desc.softs.len() as u32);
        (0..rigids).map(BodyId::Rigid).chain((0..softs).map(BodyId::Soft))
    }

    /// True if a hand could have its fingers around a body: not a part of any hand, and with a
    /// surface.
    fn is_object(&self, hand: usize, body: BodyId) -> bool {
        let is_part = |built: &BuiltHand| match body {
            BodyId::Rigid(i) => built.handle.bones.contains(&i),
            BodyId::Soft(i) => built.flesh() == Some(i),
        };
        let own = self.built.hands.get(hand).is_some_and(is_part);
        let bone = matches!(body, BodyId::Rigid(_)) && self.built.hands.iter().any(is_part);
        !own && !bone && way_to(&self.world, body, &crate::math::Vec3::zeros()).is_some()
    }

    fn named_object(&self, hand: usize, name: &str) -> Result<BodyId, GripError> {
        let found = self.all_bodies().find(|body| self.body_name(*body) == name);
        found.filter(|body| self.is_object(hand, *body)).ok_or_else(|| GripError::NoObject {
            object: name.into(),
            known: self.known_objects(hand),
        })
    }

    fn known_objects(&self, hand: usize) -> String {
        let bodies = self.all_bodies().filter(|body| self.is_object(hand, *body));
        let names: Vec<_> = bodies.map(|body| format!("\"{}\"", self.body_name(body))).collect();
        if names.is_empty() { "none".into() } else { names.join(", ") }
    }

    /// The body that moves and is nearest to the pads of a hand that is ready for this kind.
    fn under(&self, hand: usize, kind: GripKind) -> Result<BodyId, GripError> {
        let built = &self.built.hands[hand];
        let opposition: Option<&Opposition> =
            self.grips[hand].as_ref().and_then(|gripping| gripping.opposition(kind));
        let palm = self.world.rigid_pose(built.handle.bones.start);
        let middle = opposition.map(|opposition| pads_middle(&palm, opposition));
        let hands_flesh = |body: &BodyId| {
            self.built.hands.iter().any(|other| other.flesh().map(BodyId::Soft) == Some(*body))
        };
        let moves = |body: &BodyId| match body {
            BodyId::Rigid(i) => self.world.desc().rigids[*i as usize].motion == Motion::Dynamic,
            BodyId::Soft(_) => true,
        };
        let near = self
            .all_bodies()
            .filter(|body| self.is_object(hand, *body) && moves(body) && !hands_flesh(body));
        let ways = near.filter_map(|body| Some((way_to(&self.world, body, &middle?)?, body)));
        let nearest = ways.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(way, _)| *way < UNDER);
        nearest
            .map(|(_, body)| body)
            .ok_or_else(|| GripError::NothingNear { hand: built.name.clone() })
    }
}

/// Form in which grips are written where nothing grips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IfNone {
    /// Nothing at all, as before hands gripped.
    Nothing,
    /// One `None` for each hand, so that more can come after.
    Each,
}

/// Memories of grips, read in place.
#[derive(Clone, Copy, Debug)]
pub struct GripsRef<'a>(&'a Session, IfNone);

impl Serialize for GripsRef<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        // Of a session in which nothing was ever gripped there is nothing to tell: its frames are
        // those of before.
        if self.1 == IfNone::Nothing && self.0.grips.iter().all(Option::is_none) {
            return to.serialize_unit();
        }
        let grips = self.0.grips.iter();
        to.collect_seq(grips.map(|gripping| gripping.as_ref().map(|gripping| gripping.memory())))
    }
}

/// Reflexes of grips, read in place.
#[derive(Clone, Copy, Debug)]
pub struct ReflexesRef<'a>(&'a Session, IfNone);

impl Serialize for ReflexesRef<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        if self.1 == IfNone::Nothing && self.0.grips.iter().all(Option::is_none) {
            return to.serialize_unit();
        }
        let grips = self.0.grips.iter();
        to.collect_seq(grips.map(|g| g.as_ref().map(|gripping| gripping.memory().reflex())))
    }
}
