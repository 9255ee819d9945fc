//! The simulation as the loop sees it: what a [`SimulationPort`](super::SimulationPort) asks of
//! whoever steps.

use crate::BoneFrame;
use std::ops::Range;
use thenar_core::World;
use thenar_core::model::HandModel;
use thenar_core::world::{Input, State, Target};
use thenar_track::live::{LiveError, LiveHand};

/// A hand of a world that is stepped, as the loop sees it.
pub struct SimulatedHand<'a> {
    /// The model it was made from.
    pub model: &'a HandModel,
    /// Bones among the rigid bodies, the palm first.
    pub bones: Range<u32>,
    /// Flesh among the soft bodies, if the hand has any.
    pub flesh: Option<u32>,
    /// True if its bones have drives.
    pub driven: bool,
}

/// A world that is stepped at its own pace, with hands that may be led.
pub trait Simulation {
    /// The world.
    fn world(&self) -> &World;

    /// Steps done; fewer than before when it has begun anew.
    fn steps(&self) -> u64;

    /// Returns the input of the last step.
    fn input(&self) -> &Input;

    /// Hand `index`; `None` behind the last one.
    fn hand(&self, index: usize) -> Option<SimulatedHand<'_>>;

    /// A hand as poses may move it, for who leads it.
    ///
    /// # Errors
    /// There is no such hand, or poses cannot move it.
    fn live_hand(&self, index: usize) -> Result<LiveHand, LiveError>;

    /// Puts all bodies where another simulation of the same world has them. False, and nothing
    /// changes, when the state does not fit.
    fn resume(&mut self, state: &State) -> bool;

    /// Leads a hand to these targets from the next step on. False, and nothing changes, when it
    /// cannot be led there.
    fn lead(
        &mut self,
        index: usize,
        targets: impl ExactSizeIterator<Item = Target> + Clone,
    ) -> bool;

    /// Leads a hand no more.
    fn let_go(&mut self, index: usize);

    /// Fills how bones answer after a step. False where nobody knows.
    fn condense(&mut self, bones: Range<u32>, to: &mut BoneFrame) -> bool;
}
