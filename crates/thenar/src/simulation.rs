//! A scene that is stepped.

use crate::{
    Body, Contact, FingerLoad, HandId, HandMut, HandRef, RigidId, RigidMut, RigidRef, SoftId,
    SoftMut, SoftRef,
};
use thenar_core::model::{BodyId, Digit};
use thenar_core::world::{ContactPoint, StepReport};
use thenar_scene::recording::{SnapshotError, go_on_from, snapshot};
use thenar_scene::session::{PARTS, Session};
use thenar_scene::tuning::{SettingError, SettingValue};

/// A scene that is stepped. Same inputs give the same bits on processors with the same vector
/// instructions.
///
/// Handles are those that [`Scene::add`](crate::Scene::add) gave, or that it is asked for by name.
#[derive(Debug)]
pub struct Simulation {
    pub(crate) session: Session,
    /// The world's index of each rigid body of the scene.
    pub(crate) rigids: Vec<u32>,
    /// The world's index of each soft body of the scene.
    pub(crate) softs: Vec<u32>,
    /// Hash of the state in which the scene starts.
    start: u64,
}

impl Simulation {
    /// Takes a session over.
    pub(crate) fn new(session: Session) -> Self {
        let desc = session.world().desc();
        let index = |name: &String| desc.rigids.iter().position(|rigid| rigid.name == *name);
        let scene = session.scene();
        let rigids =
            scene.rigid.iter().map(|r| index(&r.name.value).map_or(u32::MAX, |i| i as u32));
        let rigids = rigids.collect();
        let softs = session.softs().iter().map(|soft| soft.soft).collect();
        let hash = session.world().state_hash();
        let start = session.source().map_or(hash, |source| source.identity(hash));
        Self { session, rigids, softs, start }
    }

    /// Moves everything forward by one time step, and reports what happened. Allocates nothing.
    pub fn step(&mut self) -> StepReport {
        self.session.step(&mut ())
    }

    /// Steps for a while \[s\], and returns the report of the last step.
    pub fn run(&mut self, duration: f64) -> StepReport {
        let steps = (duration / self.time_step()).round().clamp(0.0, 1e15) as u64;
        (0..steps).for_each(|_| _ = self.step());
        self.report()
    }

    /// Simulated time \[s\].
    pub fn time(&self) -> f64 {
        self.session.world().time()
    }

    /// Time step \[s\].
    pub fn time_step(&self) -> f64 {
        self.session.world().time_step()
    }

    /// Report of the last step.
    pub fn report(&self) -> StepReport {
        *self.session.report()
    }

    /// Known problems of the scene as it is set, and bodies that start inside each other: a
    /// sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let overlaps = self.session.start_overlaps().iter().map(ToString::to_string);
        self.session.warnings().into_iter().chain(overlaps).collect()
    }

    /// Back to the start: time 0, bodies at their places. Hands that follow poses go on doing so.
    pub fn restart(&mut self) {
        self.session.restart();
    }

    /// Everything that the next steps depend on, as bytes.
    pub fn state(&self) -> Vec<u8> {
        snapshot(&self.session, self.start)
    }

    /// Goes on from a state of this scene, with the same bits.
    ///
    /// # Errors
    /// The bytes are of another scene, cut or damaged. Nothing has changed then.
    pub fn set_state(&mut self, state: &[u8]) -> Result<(), SnapshotError> {
        go_on_from(&mut self.session, self.start, state)
    }

    /// Hash of every bit of the state.
    pub fn state_hash(&self) -> u64 {
        self.session.world().state_hash()
    }

    /// Changes a setting while it runs, e.g. `("friction", 0.4)`; acts in the next step.
    ///
    /// # Errors
    /// There is no such setting, or the value is out of its range. Nothing has changed then.
    pub fn set(&mut self, key: &str, value: f64) -> Result<(), SettingError> {
        self.session.set(key, &SettingValue::Number(value))
    }

    /// The hands.
    pub fn hands(&self) -> impl Iterator<Item = HandId> + use<> {
        (0..self.session.hands().len()).map(HandId)
    }

    /// The rigid objects.
    pub fn rigids(&self) -> impl Iterator<Item = RigidId> + use<> {
        (0..self.rigids.len()).map(RigidId)
    }

    /// The soft objects.
    pub fn softs(&self) -> impl Iterator<Item = SoftId> + use<> {
        (0..self.softs.len()).map(SoftId)
    }

    /// The hand of this name.
    pub fn hand_named(&self, name: &str) -> Option<HandId> {
        self.hands().find(|&id| self.hand(id).name() == name)
    }

    /// The rigid object of this name.
    pub fn rigid_named(&self, name: &str) -> Option<RigidId> {
        self.rigids().find(|&id| self.rigid(id).name() == name)
    }

    /// The soft object of this name.
    pub fn soft_named(&self, name: &str) -> Option<SoftId> {
        self.softs().find(|&id| self.soft(id).name() == name)
    }

    /// A hand, to be read.
    ///
    /// # Panics
    /// The handle is of another scene, which has more hands.
    pub fn hand(&self, hand: HandId) -> HandRef<'_> {
        HandRef::new(&self.session, hand)
    }

    /// A hand, to be moved.
    ///
    /// # Panics
    /// The handle is of another scene, which has more hands.
    pub fn hand_mut(&mut self, hand: HandId) -> HandMut<'_> {
        HandMut::new(self, hand)
    }

    /// A rigid object, to be read.
    ///
    /// # Panics
    /// The handle is of another scene, which has more rigid objects.
    pub fn rigid(&self, rigid: RigidId) -> RigidRef<'_> {
        RigidRef { world: self.session.world(), body: self.rigids[rigid.0] }
    }

    /// A rigid object, to be put elsewhere.
    ///
    /// # Panics
    /// The handle is of another scene, which has more rigid objects.
    pub fn rigid_mut(&mut self, rigid: RigidId) -> RigidMut<'_> {
        RigidMut { body: self.rigids[rigid.0], world: self.session.world_mut() }
    }

    /// A soft object, to be read.
    ///
    /// # Panics
    /// The handle is of another scene, which has more soft objects.
    pub fn soft(&self, soft: SoftId) -> SoftRef<'_> {
        SoftRef { world: self.session.world(), soft: self.softs[soft.0] }
    }

    /// A soft object, to be put elsewhere.
    ///
    /// # Panics
    /// The handle is of another scene, which has more soft objects.
    pub fn soft_mut(&mut self, soft: SoftId) -> SoftMut<'_> {
        SoftMut { soft: self.softs[soft.0], world: self.session.world_mut() }
    }

    /// Loads on palm, thumb, index, middle, ring and little finger of a hand.
    ///
    /// # Panics
    /// The handle is of another scene, which has more hands.
    pub fn loads(&self, hand: HandId) -> [FingerLoad; 6] {
        self.hand(hand).loads()
    }

    /// All contacts of the last step, those that bear force and those that are only near.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        self.session.world().contacts().iter().map(|contact| self.contact(contact))
    }

    fn contact(&self, contact: &ContactPoint) -> Contact {
        let body = |side: usize| self.body(contact.bodies[side], contact.vertices[side]);
        Contact {
            bodies: [body(0), body(1)],
            point: contact.position_W,
            normal: contact.normal_W,
            force: contact.force_W,
            gap: contact.gap,
            area: contact.area,
            friction: contact.friction,
            slips: contact.slips,
        }
    }

    fn body(&self, body: BodyId, vertex: Option<u32>) -> Body {
        for (place, hand) in self.session.hands().iter().enumerate() {
            let id = HandId(place);
            match body {
                BodyId::Soft(soft) if hand.flesh() == Some(soft) => {
                    let digits = &hand.model.collision_digits;
                    let digit = vertex.and_then(|v| digits.get(v as usize));
                    return Body::Skin(id, digit.copied().unwrap_or(Digit::Palm));
                }
                BodyId::Rigid(bone) if hand.handle.bones.contains(&bone) => {
                    let bone = (bone - hand.handle.bones.start) as usize;
                    return Body::Bone(id, hand.model.bones[bone].digit);
                }
                _ => {}
            }
        }
        let place = |list: &[u32], index: u32| list.iter().position(|i| *i == index);
        let found = match body {
            BodyId::Rigid(i) => place(&self.rigids, i).map(|at| Body::Rigid(RigidId(at))),
            BodyId::Soft(i) => place(&self.softs, i).map(|at| Body::Soft(SoftId(at))),
        };
        found.unwrap_or(Body::Figure)
    }

    /// The name of a body that can be gripped.
    pub(crate) fn name_of(&self, body: Body) -> Option<&str> {
        let desc = self.session.world().desc();
        match body {
            Body::Rigid(id) => Some(&desc.rigids.get(*self.rigids.get(id.0)? as usize)?.name),
            Body::Soft(id) => Some(&desc.softs.get(*self.softs.get(id.0)? as usize)?.name),
            _ => None,
        }
    }

    /// The session below, of `thenar-scene`: probes, recordings, the world.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// The session below, to be changed.
    pub fn session_mut(&mut self) -> &mut Session {
        &mut self.session
    }
}

/// Part names in the order of loads.
pub(crate) const DIGITS: [Digit; 6] = PARTS;
