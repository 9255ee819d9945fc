//! A session that is made again.

use super::{Entry, Session, drive, load};
use crate::live::LiveError;
use thenar_core::world::State;

impl Session {
    /// Lets something enter that entered another session from the same source.
    ///
    /// # Errors
    /// It does not fit this session; says why. Nothing has changed then.
    pub fn enter(&mut self, entry: Entry<'_>) -> Result<(), String> {
        match entry {
            Entry::Pose { hand, time, pose } => {
                self.live_pose(hand, time, pose).map_err(|e| e.to_string())?;
            }
            Entry::Lost { hand } => {
                self.tracked(hand)?;
                self.live_lost(hand);
            }
            Entry::Script { hand } => {
                self.tracked(hand)?;
                self.follow_script(hand);
            }
            Entry::Lead { hand, targets } => {
                if !self.lead(hand, targets.iter().copied()) {
                    return Err(format!("hand {hand} cannot be led so"));
                }
            }
            Entry::LetGo { hand } if hand >= self.built.hands.len() => {
                let count = self.live.len();
                return Err(LiveError::NoHand { hand, count }.to_string());
            }
            Entry::LetGo { hand } => self.let_go(hand),
            Entry::Grip { hand, order } => {
                self.begin_grip(hand, order).map_err(|e| e.to_string())?;
            }
            Entry::Release { hand } => self.release(hand).map_err(|e| e.to_string())?,
            Entry::Resume { state } => {
                if !self.resume(state) {
                    return Err("the state does not fit the scene".into());
                }
            }
            Entry::Restart => self.restart(),
            Entry::Set { key, value } => self.set(key, value).map_err(|e| e.to_string())?,
        }
        Ok(())
    }

    /// Refuses a hand that poses cannot move: no pose ever reached it.
    fn tracked(&self, hand: usize) -> Result<(), String> {
        match self.live.get(hand) {
            Some(Ok(_)) => Ok(()),
            Some(Err(error)) => Err(error.to_string()),
            None => Err(LiveError::NoHand { hand, count: self.live.len() }.to_string()),
        }
    }

    /// Passes over a step: time, scripts and tracked hands move on, bodies stay. To be followed by
    /// [`Session::resume`]. `taken_back` tells that the step was, so that no time passed.
    pub fn pass(&mut self, taken_back: bool) {
        let before = self.world.time();
        let t = before + self.world.time_step();
        drive::fill(&mut self.input, &mut self.built, &mut self.live, &self.world, t);
        load::fill(&mut self.input, &self.built.loads, &self.world, t);
        drive::hold(&mut self.input, &mut self.built, &self.led, &self.world);
        self.steer_grips(t);
        drive::follow_leaders(&mut self.input, &self.built, &self.led);
        drive::carry(&mut self.input, &self.built, &self.led, &self.world);
        self.world.set_time(if taken_back { before } else { t });
        self.steps += 1;
    }

    /// Puts all bodies where another session from the same source, or another simulation of the
    /// same world, has them. False, and nothing changes, when the state does not fit.
    pub fn resume(&mut self, state: &State) -> bool {
        let fits = self.world.restore(state);
        if fits {
            self.tell(Entry::Resume { state });
        }
        fits
    }
}
