//! A hand of a simulation.

use crate::simulation::DIGITS;
use crate::{Body, HandId, HandPose, Simulation};
use thenar_core::model::{Digit, Side};
use thenar_core::{Pose, Vec3};
use thenar_scene::build::BuiltHand;
use thenar_scene::grip::GripKind;
use thenar_scene::session::{GripError, Session};
use thenar_track::live::{LiveError, Mover};

/// Load on the palm or on a finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FingerLoad {
    /// The palm, or the finger.
    pub digit: Digit,
    /// Sum of normal forces \[N\].
    pub normal: f64,
    /// Size of the summed tangential force \[N\].
    pub shear: f64,
    /// Area in contact \[m²\].
    pub area: f64,
    /// Mean pressure on the skin \[Pa\].
    pub pressure: f64,
}

/// A hand as it is after the last step.
#[derive(Clone, Copy, Debug)]
pub struct HandRef<'a> {
    session: &'a Session,
    hand: usize,
}

impl<'a> HandRef<'a> {
    pub(crate) fn new(session: &'a Session, hand: HandId) -> Self {
        let count = session.hands().len();
        assert!(hand.0 < count, "hand {} of a simulation with {count}", hand.0);
        Self { session, hand: hand.0 }
    }

    fn built(&self) -> &'a BuiltHand {
        &self.session.hands()[self.hand]
    }

    /// Name in the scene.
    pub fn name(&self) -> &'a str {
        &self.built().name
    }

    /// Left or right; `None` where its model does not say.
    pub fn side(&self) -> Option<Side> {
        self.built().model.side
    }

    /// Frame of the wrist in the world: -z towards the fingers, +y out of the back.
    pub fn wrist(&self) -> Pose {
        self.session.hand_wrist(self.hand)
    }

    /// Joint angles \[rad\]: of each finger, thumb first, base flexion and spread, then two
    /// flexions; NaN for those that it lacks. Flexion is positive when the hand closes.
    pub fn angles(&self) -> [f64; 20] {
        self.session.hand_angles(self.hand)
    }

    /// Name, digit and pose in the world of each bone, the palm first. A bone's frame has -z along
    /// it, away from the wrist, +y out of the back of the hand, and its origin at the centre of
    /// mass.
    pub fn bones(&self) -> impl Iterator<Item = (&'a str, Digit, Pose)> + use<'a> {
        let (hand, world) = (self.built(), self.session.world());
        let bones = hand.handle.bones.clone().zip(&hand.model.bones);
        bones.map(|(body, bone)| (bone.name.as_str(), bone.digit, world.rigid_pose(body)))
    }

    /// Vertices of the skin that touches, world \[m\]; none for a hand without flesh.
    pub fn vertices(&self) -> &'a [Vec3] {
        let world = self.session.world();
        self.built().flesh().map_or(&[], |soft| world.collision_vertices(soft))
    }

    /// Triangles of that skin, by vertex, counter-clockwise from outside.
    pub fn triangles(&self) -> &'a [[u32; 3]] {
        let softs = &self.session.world().desc().softs;
        let flesh = self.built().flesh();
        flesh.map_or(&[], |soft| &softs[soft as usize].flesh.collision.triangles)
    }

    /// Nodes of the flesh, world \[m\].
    pub fn nodes(&self) -> &'a [Vec3] {
        self.built().flesh().map_or(&[], |soft| self.session.world().nodes(soft))
    }

    /// Loads on palm, thumb, index, middle, ring and little finger.
    pub fn loads(&self) -> [FingerLoad; 6] {
        let loads = self.session.hand_loads(self.hand);
        std::array::from_fn(|k| {
            let load = &loads[k];
            let (normal, shear, area, pressure) =
                (load.normal, load.shear, load.area, load.pressure);
            FingerLoad { digit: DIGITS[k], normal, shear, area, pressure }
        })
    }

    /// A pose with the wrist's frame there in the world, whose fingers are bent from rest so that
    /// the middle of each named one's pad comes to its place \[m\], and how far the worst of them
    /// ends from it \[m\]. Inverse kinematics on this hand, to be [followed](HandMut::follow);
    /// contact and flesh do the rest.
    ///
    /// Pads are found on the skin the first time.
    ///
    /// # Errors
    /// Poses cannot move this hand, the palm is named, or wrist or places are not finite or the
    /// wrist is far away.
    pub fn reaching(
        &self,
        wrist: Pose,
        tips: &[(Digit, Vec3)],
    ) -> Result<(HandPose, f64), LiveError> {
        let mut places = [None; 5];
        for (digit, place) in tips {
            let finger = Digit::FINGERS.iter().position(|finger| finger == digit);
            let Some(finger) = finger else {
                let cause = "the palm is no fingertip".into();
                return Err(LiveError::Unfit { hand: self.name().to_owned(), cause });
            };
            places[finger] = Some(*place);
        }
        let (pose, misses) = self.session.reaching(self.hand, wrist, &places)?;
        Ok((pose, misses.into_iter().fold(0.0, f64::max)))
    }

    /// Source of the hand's motion: its script, poses, or nothing since poses were lost.
    pub fn mover(&self) -> Mover {
        self.session.mover(self.hand)
    }

    /// Force of a grip's two sides against each other \[N\]; `None` while it grips nothing.
    pub fn grip_force(&self) -> Option<f64> {
        self.session.grip_state(self.hand).map(|state| state.force)
    }

    /// Trouble with the present grip, in a sentence.
    pub fn grip_trouble(&self) -> Option<String> {
        self.session.grip_trouble(self.hand)
    }
}

/// A hand that is moved.
#[derive(Debug)]
pub struct HandMut<'a> {
    simulation: &'a mut Simulation,
    hand: usize,
}

impl<'a> HandMut<'a> {
    pub(crate) fn new(simulation: &'a mut Simulation, hand: HandId) -> Self {
        let count = simulation.session.hands().len();
        assert!(hand.0 < count, "hand {} of a simulation with {count}", hand.0);
        Self { simulation, hand: hand.0 }
    }

    /// Follows a tracked pose, taken now: joints of a tracker are carried over to the hand's bones,
    /// smoothed, and followed at limited speed. Give one before each step; after 0.1 s without, the
    /// hand holds still.
    ///
    /// # Errors
    /// The pose is not finite, too far away or otherwise no hand's. Nothing has changed then.
    pub fn follow(&mut self, pose: &HandPose) -> Result<(), LiveError> {
        let time = self.simulation.time();
        self.follow_at(time, pose)
    }

    /// Follows a pose that was taken at `time` \[s\] by a tracker's own clock.
    ///
    /// # Errors
    /// The pose is not finite, too far away or otherwise no hand's. Nothing has changed then.
    pub fn follow_at(&mut self, time: f64, pose: &HandPose) -> Result<(), LiveError> {
        self.simulation.session.live_pose(self.hand, time, pose)
    }

    /// Loses track of the hand: it holds still until the next pose.
    pub fn lose(&mut self) {
        self.simulation.session.live_lost(self.hand);
    }

    /// Goes back to the scene's own motion.
    pub fn follow_script(&mut self) {
        self.simulation.session.follow_script(self.hand);
    }

    /// Grips an object with a force \[N\], or with what holds its weight: fingers find their places
    /// on it by themselves. The wrist goes on following script or poses.
    ///
    /// # Errors
    /// It is no object, the hand cannot grip so, or the force is out of range. Nothing has changed
    /// then.
    pub fn grip(
        &mut self,
        object: impl Into<Body>,
        kind: GripKind,
        force: Option<f64>,
    ) -> Result<(), GripError> {
        let object = object.into();
        let unfit = || GripError::Unfit {
            hand: self.simulation.session.hands()[self.hand].name.clone(),
            cause: format!("{object:?} cannot be gripped: only objects can"),
        };
        let name = self.simulation.name_of(object).ok_or_else(unfit)?.to_owned();
        self.simulation.session.grip(self.hand, Some(&name), kind, force).map(|_| ())
    }

    /// Opens a grip.
    pub fn release(&mut self) {
        // A hand that there is opens.
        _ = self.simulation.session.release(self.hand);
    }
}
