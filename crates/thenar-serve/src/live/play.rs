//! A scene that plays: its script over and over, until somebody's hand takes over.

use super::haptics::Haptics;
use crate::protocol::{PoseBody, PoseMessage, flags};
use std::time::{Duration, Instant};
use thenar_core::model::Side;
use thenar_scene::grip::{GripKind, Trouble};
use thenar_scene::live::{LivePose, Mover};
use thenar_scene::session::{Session, Witness};
use thenar_scene::tuning::SettingValue;

/// After its end the script stays for so long before it starts again \[s\].
const HOLD: f64 = 1.5;
/// Time after which the script takes over once whoever moved a hand has gone.
const ABANDONED: Duration = Duration::from_secs(2);

/// A session and what moves its hands.
#[derive(Debug)]
pub struct Play {
    session: Session,
    /// Time at which whoever moved the hands left.
    abandoned: Option<Instant>,
    /// Newest pose message that acts.
    pose: u32,
    /// Trouble with a grip that was last reported.
    told: Option<Trouble>,
}

impl Play {
    /// Begins with the script.
    pub fn new(session: Session) -> Self {
        Self { session, abandoned: None, pose: 0, told: None }
    }

    /// The session.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Reports the session to `witness` from now on.
    pub fn set_witness(&mut self, witness: Box<dyn Witness>) {
        self.session.set_witness(witness);
    }

    /// Lets the witness go.
    pub fn take_witness(&mut self) -> Option<Box<dyn Witness>> {
        self.session.take_witness()
    }

    /// Changes a setting.
    ///
    /// # Errors
    /// There is no such setting, or the value does not fit.
    pub fn set(&mut self, key: &str, value: &SettingValue) -> Result<(), String> {
        self.session.set(key, value).map_err(|error| error.to_string())
    }

    /// One step; the script starts again where it is due.
    ///
    /// # Errors
    /// Devices cannot feel it; the text says why.
    pub fn step(&mut self, now: Instant, haptics: Option<&mut Haptics>) -> Result<(), String> {
        if self.abandoned.is_some_and(|since| now - since > ABANDONED) {
            self.follow_script();
        }
        let end = self.session.scene().duration + HOLD;
        if self.all(Mover::Script) && self.session.world().time() >= end {
            self.session.restart();
        }
        match haptics {
            Some(haptics) => haptics.step(&mut self.session),
            None => {
                self.session.step(&mut ());
                Ok(())
            }
        }
    }

    /// Back to the start. Tracked hands stay tracked.
    pub fn reset(&mut self) {
        if movers(&self.session).any(|mover| mover == Mover::Live) {
            self.session.restart();
        } else {
            self.follow_script();
        }
    }

    /// The script moves the hands again, from its start.
    pub fn follow_script(&mut self) {
        (0..self.session.hands().len()).for_each(|hand| self.session.follow_script(hand));
        self.session.restart();
        (self.abandoned, self.pose) = (None, 0);
    }

    /// A tracked pose moves all hands of its side from the next step on.
    ///
    /// # Errors
    /// The scene has no such hand, or it cannot follow.
    pub fn pose(&mut self, message: &PoseMessage) -> Result<(), String> {
        let hands: Vec<usize> = self.session.hands_of(message.side).collect();
        if hands.is_empty() {
            return Err(format!("the scene has no {} hand", side_name(message.side)));
        }
        let pose = match &message.body {
            PoseBody::Lost => None,
            PoseBody::Joints { poses, radii } => {
                Some(LivePose::Joints { joints: **poses, radii: **radii })
            }
            PoseBody::Angles { wrist, angles } => {
                Some(LivePose::Angles { wrist: *wrist, angles: **angles })
            }
        };
        // A scene may show one tracked hand twice: bare glove beside flesh. One that cannot follow
        // does not keep the others from it.
        let (mut followed, mut refused) = (false, None);
        for hand in hands {
            let done = match &pose {
                None => {
                    self.session.live_lost(hand);
                    Ok(())
                }
                Some(pose) => self.session.live_pose(hand, message.clock, pose),
            };
            match done {
                Ok(()) => followed = true,
                Err(error) => refused = Some(error),
            }
        }
        if let (false, Some(error)) = (followed, refused) {
            return Err(error.to_string());
        }
        self.abandoned = None;
        self.pose = self.pose.max(message.number);
        Ok(())
    }

    /// Hands of a side, or all, grip a body, or what is under them.
    ///
    /// # Errors
    /// None of them grips; the text says why.
    pub fn grip(
        &mut self,
        side: Option<Side>,
        object: Option<&str>,
        kind: GripKind,
        force: Option<f64>,
    ) -> Result<(), String> {
        let (mut grips, mut refused) = (false, None);
        for hand in self.hands_of(side) {
            match self.session.grip(hand, object, kind, force) {
                Ok(_) => grips = true,
                Err(error) => refused = Some(error.to_string()),
            }
        }
        match (grips, refused) {
            (true, _) => Ok(()),
            (false, Some(error)) => Err(error),
            (false, None) => Err(format!("the scene has no {} hand", side.map_or("", side_name))),
        }
    }

    /// Hands of a side, or all, open.
    pub fn release(&mut self, side: Option<Side>) {
        for hand in self.hands_of(side) {
            // There is such a hand.
            let _ = self.session.release(hand);
        }
    }

    /// Returns a message on trouble with a grip, if it is new.
    pub fn grip_news(&mut self) -> Option<String> {
        let hand = (0..self.session.hands().len()).find(|hand| {
            self.session.grip_state(*hand).is_some_and(|state| state.trouble.is_some())
        });
        let trouble = hand.and_then(|hand| self.session.grip_state(hand)?.trouble);
        // A trouble's figure may change; the same is told once.
        let kind = |trouble: &Option<Trouble>| trouble.as_ref().map(std::mem::discriminant);
        let is_new = trouble.is_some() && kind(&self.told) != kind(&trouble);
        self.told = trouble;
        if is_new { self.session.grip_trouble(hand?) } else { None }
    }

    fn hands_of(&self, side: Option<Side>) -> Vec<usize> {
        match side {
            Some(side) => self.session.hands_of(side).collect(),
            None => (0..self.session.hands().len()).collect(),
        }
    }

    /// Whoever moved the hands does so no more.
    pub fn abandon(&mut self, now: Instant) {
        if !self.all(Mover::Script) {
            (0..self.session.hands().len()).for_each(|hand| self.session.live_lost(hand));
            self.abandoned = Some(now);
        }
        self.pose = 0;
    }

    /// Flags of a snapshot.
    pub fn flags(&self) -> u16 {
        mover_flags(&self.session)
    }

    /// Newest pose message that acts, 0 if none.
    pub fn newest_pose(&self) -> u32 {
        self.pose
    }

    fn all(&self, mover: Mover) -> bool {
        movers(&self.session).all(|one| one == mover)
    }
}

fn movers(session: &Session) -> impl Iterator<Item = Mover> {
    (0..session.hands().len()).map(|hand| session.mover(hand))
}

/// Flags of a snapshot that tell who moves the hands.
pub fn mover_flags(session: &Session) -> u16 {
    let script = movers(session).all(|mover| mover == Mover::Script);
    let tracked = movers(session).any(|mover| mover == Mover::Live);
    (if script { flags::SCRIPT } else { 0 }) | if tracked { flags::TRACKED } else { 0 }
}

fn side_name(side: Side) -> &'static str {
    match side {
        Side::Left => "left",
        Side::Right => "right",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use thenar_core::Pose;

    /// Two right hands, of which the first perhaps follows poses and the second does not.
    fn play(first_driven: bool) -> Play {
        let hand = |name: &str, driven: bool| {
            format!("[[hand]]\nname = \"{name}\"\nflesh = false\ndriven = {driven}\n")
        };
        let text = format!("version = 1\n{}{}", hand("one", first_driven), hand("two", false));
        Play::new(Session::from_text(&text, Path::new("test.toml"), &[]).unwrap())
    }

    #[test]
    fn a_hand_that_cannot_follow_does_not_keep_another_from_it() {
        let body = PoseBody::Angles { wrist: Pose::identity(), angles: Box::new([0.0; 20]) };
        let message = PoseMessage { side: Side::Right, number: 7, clock: 0.0, body };
        let mut one = play(true);
        assert_eq!(one.pose(&message), Ok(()));
        assert_eq!((one.newest_pose(), one.flags()), (7, flags::TRACKED));
        let mut none = play(false);
        assert!(none.pose(&message).is_err());
        assert_eq!((none.newest_pose(), none.flags()), (0, flags::SCRIPT));
    }
}
