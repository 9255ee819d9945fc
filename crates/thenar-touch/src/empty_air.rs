//! Contact is all that is felt: the coupling's force less that of the same hand, led the same way,
//! in empty air.
//!
//! The simulated flesh resists bending, springs act at its joints, and a hand lags behind its
//! drives. All of this the couplings bear, and none of it is the wearer's to feel: a hand of one's
//! own has flesh already. So each mode keeps, beside the hand that is simulated, what this hand
//! would do if it touched nothing and bore no load, and subtracts what its couplings bear:
//!
//! | mode | the hand in empty air |
//! |---|---|
//! | shared constraints | the frame's response without contacts ([`SharedConstraints::in_empty_air`]), own proxies |
//! | single-rate | the hand alone in a world of its own ([`EmptyAirHand`]), stepped while something acts |
//! | multirate | the same, stepped always, and own proxies; what is felt comes with frames |
//!
//! Both hands have the same limits of joints, weight and flesh. Where nothing touches and nothing
//! loads the hand they do the same, number by number, and what is felt is zero however it moves.
//!
//! [`SharedConstraints::in_empty_air`]: crate::shared::SharedConstraints::in_empty_air

use crate::RigidState;
use crate::turn::rotation_vector;
use std::ops::Range;
use thenar_core::math::{Pose, Quat, Vec3};
use thenar_core::world::{Input, ModelError, State, SubWorld, Target, World};

/// A hand of a world, in empty air.
#[derive(Clone, Debug)]
pub struct EmptyAirHand {
    sub_world: SubWorld,
    input: Input,
    weightless: bool,
}

impl EmptyAirHand {
    /// The hand of these bones as it is. Of a weightless one the input carries the weight, as
    /// wrenches on its bones and forces on its nodes. Allocates all it needs.
    ///
    /// # Errors
    /// Its bones cannot be taken out of the world.
    pub fn of(world: &World, bones: Range<u32>, weightless: bool) -> Result<Self, ModelError> {
        let sub_world = world.sub_world(bones)?;
        let input = sub_world.input();
        Ok(Self { sub_world, input, weightless })
    }

    /// Goes on from where the hand is in a state of the whole world.
    pub fn resume(&mut self, whole: &State) {
        self.sub_world.resume(whole);
    }

    /// Takes over the parameters that its world has now, and goes on from where it is. Allocates.
    ///
    /// # Errors
    /// It is another world by now.
    pub fn retune(&mut self, world: &World) -> Result<(), ModelError> {
        self.sub_world.retune(world)
    }

    /// One step of `h` \[s\] to these targets. What else acts in the whole world acts here but for
    /// contact and loads: wrenches on the bones.
    pub fn step(&mut self, h: f64, targets: impl Iterator<Item = Option<Target>>, whole: &Input) {
        let Self { sub_world, input, weightless } = self;
        sub_world.copy_input(whole, input);
        input.targets.iter_mut().zip(targets).for_each(|(to, target)| *to = target);
        if *weightless {
            for (wrench, bone) in input.wrenches.iter_mut().zip(&sub_world.world().model().rigids) {
                wrench[0] = Vec3::zeros() - input.gravity * bone.mass;
            }
        }
        sub_world.step(h, input);
    }

    /// Bone `i`, counted from the hand's first.
    pub fn bone(&self, i: usize) -> RigidState {
        RigidState::of(self.sub_world.world(), i as u32)
    }

    /// All bones, into a frame.
    pub fn write_bones(&self, to: &mut Vec<RigidState>) {
        to.clear();
        to.extend((0..self.input.targets.len()).map(|i| self.bone(i)));
    }
}

/// Displacement of a bone by contact, from its pose in empty air \[m\], \[rad\].
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct Held([Vec3; 2]);

impl Held {
    pub fn between(bone: &RigidState, free: &RigidState) -> Self {
        let turn = bone.pose_WB.rotation * free.pose_WB.rotation.inverse();
        Self([bone.pose_WB.position - free.pose_WB.position, rotation_vector(&turn)])
    }

    /// Returns the state that a bone held like this would have in empty air.
    pub fn let_go(&self, bone: &RigidState) -> RigidState {
        let rotation = Quat::from_scaled_axis(-self.0[1]) * bone.pose_WB.rotation;
        RigidState { pose_WB: Pose::new(bone.pose_WB.position - self.0[0], rotation), ..*bone }
    }
}

#[cfg(test)]
mod tests {
    use crate::{BoneFrame, CouplingDesign, HandSettings, HapticHand, RigidState, Touch};
    use thenar_core::math::{Mat3, Pose, Vec3};

    /// Contact holds a bone 5 mm off for some frames, which tell of the hand in empty air; then
    /// frames come that do not: nothing of that contact is left, and all that the coupling bears is
    /// felt, nothing for a bone where its hand is.
    #[test]
    fn frames_without_a_hand_in_empty_air_forget_its_contact() {
        let at = |x: f64| RigidState::at_rest(Pose::translation(x, 0.0, 0.0));
        let proxy = CouplingDesign::default().proxy(0.004, &Mat3::from_diagonal_element(1e-7));
        let mut hand =
            HapticHand::new(HandSettings::default(), vec![proxy], &[at(0.0)], 0).unwrap();
        let mut frame = BoneFrame::new(&[at(0.0)], 0);
        let mut run = |free: Option<RigidState>, bone: RigidState, from: u64| {
            for ms in from..from + 1500 {
                frame.free.clear();
                frame.free.extend(free);
                frame.bones[0] = bone;
                (frame.time_ns, frame.step) = (ms * 1_000_000, ms);
                hand.lead(0, at(0.005));
                hand.tick(ms * 1_000_000, &frame);
            }
            hand.device_wrenches()[0][0]
        };
        let held = run(Some(at(0.005)), at(0.0), 1);
        assert!((held + Vec3::x() * (400.0 * 0.005)).norm() < 1e-3, "{held}");
        let let_go = run(None, at(0.005), 1501);
        assert!(let_go.norm() < 1e-3, "{let_go} N of a contact that is no more");
        let blocked = run(None, at(0.0), 3001);
        assert!((blocked + Vec3::x() * (400.0 * 0.005)).norm() < 1e-3, "{blocked}");
    }
}
