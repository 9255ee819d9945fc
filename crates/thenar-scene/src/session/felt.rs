//! A session as the haptic loop sees it.

use super::Session;
use crate::live::{LiveError, LiveHand};
use std::ops::Range;
use thenar_core::World;
use thenar_core::condensed::BoneFrame;
use thenar_core::world::{Input, State, Target};
use thenar_touch::haptic_loop::{SimulatedHand, Simulation};

impl Simulation for Session {
    fn world(&self) -> &World {
        self.world()
    }

    fn steps(&self) -> u64 {
        self.steps()
    }

    fn input(&self) -> &Input {
        self.input()
    }

    fn hand(&self, index: usize) -> Option<SimulatedHand<'_>> {
        let hand = self.hands().get(index)?;
        let (bones, flesh) = (hand.handle.bones.clone(), hand.flesh());
        Some(SimulatedHand { model: &hand.model, bones, flesh, driven: hand.driven })
    }

    fn live_hand(&self, index: usize) -> Result<LiveHand, LiveError> {
        self.live_hand(index)
    }

    fn resume(&mut self, state: &State) -> bool {
        self.resume(state)
    }

    fn lead(
        &mut self,
        index: usize,
        targets: impl ExactSizeIterator<Item = Target> + Clone,
    ) -> bool {
        self.lead(index, targets)
    }

    fn let_go(&mut self, index: usize) {
        self.let_go(index);
    }

    fn condense(&mut self, bones: Range<u32>, to: &mut BoneFrame) -> bool {
        self.condense(bones, to)
    }
}
