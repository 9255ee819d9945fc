//! One interface to the three modes of touch: what the loop around ticks, whatever is inside.

use crate::{BoneFrame, HapticHand, LedHand, ProxyTargets, RigidState, TickReport};
use thenar_core::math::Vec3;
use thenar_core::world::{Input, World};

/// A hand at the device's rate: [`HapticHand`](crate::HapticHand) beside a slower
/// simulation, or [`SingleRate`](crate::SingleRate) with the simulation within.
///
/// Each tick: where the hand is (`lead`), the step (`tick`), where the simulated bones should
/// go (`write_targets`), and forces (`Pad::read`). Nothing here allocates, waits or knows the time.
pub trait Touch {
    /// The wearer's hand.
    fn hand(&self) -> &LedHand;

    /// The wearer's hand, to be led.
    fn hand_mut(&mut self) -> &mut LedHand;

    /// Leads bone `bone` in the tick that comes. The state is of that tick, as it was observed
    /// upstream, and is taken as it is; what is not finite leads nowhere.
    fn lead(&mut self, bone: usize, state: RigidState) {
        self.hand_mut().lead(bone, state);
    }

    /// Bone `bone` of the hand is somewhere else from the next tick on, as where a scene began
    /// anew: nothing of before goes on.
    fn set_out(&mut self, bone: usize) {
        self.hand_mut().set_out(bone);
    }

    /// One tick, on the newest simulation frame (which single-rate does not look at).
    fn tick(&mut self, now_ns: u64, frame: &BoneFrame) -> TickReport;

    /// Writes the targets of the simulated bones.
    fn write_targets(&self, now_ns: u64, to: &mut ProxyTargets);

    /// Returns the states that the hand was taken to have in the last tick.
    fn tracked(&self) -> &[RigidState] {
        self.hand().states()
    }

    /// True for a bone that jumped in the last tick: it was lost and found elsewhere, or
    /// teleported.
    fn jumped(&self, bone: usize) -> bool {
        self.hand().has_set_out(bone)
    }

    /// Returns the states that the simulated bones were taken to have in the last tick.
    fn bones(&self) -> &[RigidState];

    /// Returns the delay that frames of the simulation and observation, which alone adds
    /// `observed`, together add from a motion of bone `bone` to the force that answers it \[s\].
    fn added_delay(&self, bone: usize, observed: f64) -> f64;

    /// Force \[N\] and torque about the bone's centre \[N m\] on the wearer, world, per bone.
    fn device_wrenches(&self) -> &[[Vec3; 2]];

    /// Returns what else acts, until changed, in a simulation that runs within: objects, loads,
    /// other hands. The hand's own targets are overwritten each tick.
    fn input_mut(&mut self) -> Option<&mut Input> {
        None
    }

    /// The hand beside a slower simulation; `None` where the simulation is within.
    fn beside(&self) -> Option<&HapticHand> {
        None
    }

    /// The simulation, when it is within.
    fn world(&self) -> Option<&World> {
        None
    }
}
