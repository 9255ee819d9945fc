//! A session that runs on for hours: moved from outside, started over, tuned.

use super::{Entry, Session, drive};
use crate::live::{LiveError, LiveHand, LivePose, Mover};
use crate::tuning::{self, Setting, SettingError, SettingValue};
use thenar_core::model::Side;
use thenar_core::world::{StepReport, Target};

impl Session {
    /// Moves hand `hand` by a pose that the client took at `time` \[s\] by its own clock. The
    /// newest pose counts; it acts in the next step.
    ///
    /// # Errors
    /// There is no such hand, it cannot be moved this way, or the pose is none. Nothing has
    /// changed then.
    pub fn live_pose(&mut self, hand: usize, time: f64, pose: &LivePose) -> Result<(), LiveError> {
        let count = self.live.len();
        let live = self.live.get_mut(hand).ok_or(LiveError::NoHand { hand, count })?;
        let live = live.as_mut().map_err(|error| error.clone())?;
        live.pose(time, pose, &self.input.targets[drive::bones(&self.built.hands[hand])])?;
        self.tell(Entry::Pose { hand, time, pose });
        Ok(())
    }

    /// The hand is not tracked any more: if poses moved it, it holds still until the next one.
    pub fn live_lost(&mut self, hand: usize) {
        if let Some(Ok(live)) = self.live.get_mut(hand) {
            live.lose();
            self.tell(Entry::Lost { hand });
        }
    }

    /// Hands a hand that poses moved back to its script.
    pub fn follow_script(&mut self, hand: usize) {
        if let Some(Ok(live)) = self.live.get_mut(hand) {
            live.follow_script();
            self.tell(Entry::Script { hand });
        }
    }

    /// Leads the bones of hand `hand` to these targets from the next step on, whatever its script
    /// and its poses say; this is how the haptic loop moves a hand. Allocates the first time.
    /// Returns false, and changes nothing, when there is no such hand, when it has no drives or
    /// another number of bones, or when a number is not finite.
    pub fn lead(
        &mut self,
        hand: usize,
        targets: impl ExactSizeIterator<Item = Target> + Clone,
    ) -> bool {
        let Some(built) = self.built.hands.get(hand) else { return false };
        let fits = built.driven && drive::bones(built).len() == targets.len();
        if !fits || !targets.clone().all(|target| target.is_finite()) {
            return false;
        }
        let led = self.led[hand].get_or_insert_with(|| Vec::with_capacity(targets.len()));
        led.clear();
        led.extend(targets);
        if let Some(witness) = &mut self.witness {
            witness.entered(Entry::Lead { hand, targets: led });
        }
        true
    }

    /// Leads a hand no more: its script or its poses move it, from where it is.
    pub fn let_go(&mut self, hand: usize) {
        let Some(Some(_)) = self.led.get_mut(hand).map(Option::take) else { return };
        if let Some(Ok(live)) = self.live.get_mut(hand) {
            live.return_from(&self.input.targets[drive::bones(&self.built.hands[hand])]);
        }
        self.tell(Entry::LetGo { hand });
    }

    /// True while hand `hand` is led.
    pub fn is_led(&self, hand: usize) -> bool {
        self.led.get(hand).is_some_and(Option::is_some)
    }

    /// A hand as poses may move it, for who leads it; see [`LiveHand`].
    ///
    /// # Errors
    /// There is no such hand, or poses cannot move it.
    pub fn live_hand(&self, hand: usize) -> Result<LiveHand, LiveError> {
        let count = self.live.len();
        let built = self.built.hands.get(hand).ok_or(LiveError::NoHand { hand, count })?;
        super::open::live_hand(built).map(|live| *live)
    }

    /// Present mover of a hand.
    pub fn mover(&self, hand: usize) -> Mover {
        match self.live.get(hand) {
            _ if self.is_led(hand) => Mover::Live,
            Some(Ok(live)) => live.mover(),
            _ => Mover::Script,
        }
    }

    /// Length of the hand whose poses move hand `hand`, wrist to middle fingertip \[m\]; `None`
    /// before its first pose with joints.
    pub fn wearer_length(&self, hand: usize) -> Option<f64> {
        self.live.get(hand)?.as_ref().ok()?.length()
    }

    /// Hands of a side, in the order of the scene.
    pub fn hands_of(&self, side: Side) -> impl Iterator<Item = usize> {
        let hands = self.built.hands.iter().enumerate();
        hands.filter(move |(_, hand)| hand.model.side == Some(side)).map(|(i, _)| i)
    }

    /// Back to the start: time 0, bodies at their start, scripts from the beginning. A hand that
    /// poses move goes on being moved by them and sets out from its start place. Settings stay.
    pub fn restart(&mut self) {
        self.world.restart();
        self.report = StepReport::default();
        self.steps = 0;
        self.start();
        self.tell(Entry::Restart);
    }

    /// All settings that have a meaning in this scene, as they are now.
    pub fn settings(&self) -> Vec<Setting> {
        self.tuning.settings()
    }

    /// Changes a setting. It acts in the next step; nothing else changes. Takes 1 to 3
    /// milliseconds, as the system matrix is laid out anew.
    ///
    /// # Errors
    /// There is no such setting, or the value is out of its range. Nothing has changed then.
    pub fn set(&mut self, key: &str, value: &SettingValue) -> Result<(), SettingError> {
        let value = &match value {
            SettingValue::Choice(word) => {
                SettingValue::Choice(tuning::spelled_now(key, word).into())
            }
            SettingValue::Number(number) => SettingValue::Number(*number),
        };
        let (tuning, desc) = self.tuning.with(key, value)?;
        let gravity = desc.gravity;
        self.world
            .retune(desc)
            .map_err(|e| SettingError::World { key: key.into(), cause: e.to_string() })?;
        self.input.gravity = gravity;
        self.tuning = tuning;
        self.tell(Entry::Set { key, value });
        Ok(())
    }
}
