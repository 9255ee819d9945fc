//! A hand whose samples nobody observes upstream: for studies and tests of couplings by themselves, where a bone has no
//! hand around it. The felt path of the product does not go through here: its samples are observed once, by
//! `thenar_track::live`, and lead the hand directly.

mod track;
mod tracked_hand;

pub use track::{Sample, Track, Tracked};

use crate::{FastToSlow, HandReport, HapticHand, Prediction, RigidState, SlowToFast, Touch};
use thenar::World;
use thenar::math::{Pose, Vec3};
use thenar::world::Input;
use tracked_hand::TrackedHand;

/// How fast a hand is led to where its samples found it \[s\]; half a metre in most of a second.
const GLIDE: f64 = 0.15;
/// A tick longer than this is taken as if it were this long \[s\].
const STEP_MAX: f64 = 0.02;

/// Samples in, the same forces out: a [`Touch`] with an estimator of its own before it.
/// Bones that no sample ever told of may be led past the estimator.
pub struct Sampled<T: ?Sized> {
    hand: TrackedHand,
    tracked: Vec<RigidState>,
    wrenches: Vec<[Vec3; 2]>,
    touch: Box<T>,
}

impl<T: Touch + ?Sized> Sampled<T> {
    /// Before this touch, for a tracker of 72 to 120 Hz.
    pub fn new(touch: Box<T>) -> Self {
        let hand = TrackedHand::new(Prediction::TRACKER, GLIDE, touch.bones());
        let (tracked, wrenches) = (touch.tracked().to_vec(), touch.device_wrenches().to_vec());
        Self { hand, tracked, wrenches, touch }
    }

    /// Takes a pose of bone `bone` measured at `time_ns`; see [`Track::push`].
    pub fn track(
        &mut self,
        bone: usize,
        time_ns: u64,
        pose_WB: Pose,
        velocity: Option<[Vec3; 2]>,
    ) -> Sample {
        self.hand.push(bone, time_ns, pose_WB, velocity)
    }

    /// The touch behind.
    pub fn touch(&self) -> &T {
        &self.touch
    }

    /// The touch behind, to be changed.
    pub fn touch_mut(&mut self) -> &mut T {
        &mut self.touch
    }
}

impl<T: Touch + ?Sized> Touch for Sampled<T> {
    fn lead(&mut self, bone: usize, state: RigidState) {
        self.touch.lead(bone, state);
    }

    fn set_out(&mut self, bone: usize) {
        self.touch.set_out(bone);
    }

    fn tick(&mut self, now_ns: u64, frame: &SlowToFast) -> HandReport {
        let h = self.hand.passed(now_ns, STEP_MAX);
        let tracking_age = self.hand.place(now_ns, h, self.touch.bones());
        for (bone, target) in self.hand.targets().iter().enumerate() {
            if self.hand.is_known(bone) {
                if self.hand.set_out_from_bone(bone) {
                    self.touch.set_out(bone);
                }
                self.touch.lead(bone, *target);
            }
        }
        let report = self.touch.tick(now_ns, frame);
        let sampled = |bone: usize| self.hand.is_known(bone);
        for (bone, felt) in self.touch.device_wrenches().iter().enumerate() {
            self.wrenches[bone] = felt.map(|wrench| wrench * self.hand.share(bone));
            let hand = if sampled(bone) { self.hand.tracked() } else { self.touch.tracked() };
            self.tracked[bone] = hand[bone];
        }
        let any = (0..self.tracked.len()).any(sampled);
        HandReport { tracking_age: if any { tracking_age } else { report.tracking_age }, ..report }
    }

    fn publish(&self, now_ns: u64, to: &mut FastToSlow) {
        self.touch.publish(now_ns, to);
    }

    fn tracked(&self) -> &[RigidState] {
        &self.tracked
    }

    fn jumped(&self, bone: usize) -> bool {
        self.hand.jumped(bone) || self.touch.jumped(bone)
    }

    fn bones(&self) -> &[RigidState] {
        self.touch.bones()
    }

    fn added_delay(&self, bone: usize, observed: f64) -> f64 {
        self.touch.added_delay(bone, observed)
    }

    fn device_wrenches(&self) -> &[[Vec3; 2]] {
        &self.wrenches
    }

    fn input_mut(&mut self) -> Option<&mut Input> {
        self.touch.input_mut()
    }

    fn beside(&self) -> Option<&HapticHand> {
        self.touch.beside()
    }

    fn world(&self) -> Option<&World> {
        self.touch.world()
    }
}
