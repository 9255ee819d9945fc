//! Trust in a replay after damage.

use super::item::DecodedFrame;
use super::{Event, Replay};
use crate::recording::content::StepMark;
use crate::recording::verdict::Loss;
use thenar_record::Fault;

/// Number of steps made after damage to find out whether anything of the session is missing.
const DOUBTED_MAX: u64 = 100;

/// Degree to which the session is known to be what was recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trust {
    /// Nothing is known to be missing.
    Sound,
    /// Something is missing, of the session or of a channel only. This number of steps was made
    /// since: the hash after one of them tells.
    Doubtful(u64),
    /// Something of the session is missing: steps are passed over up to a keyframe.
    Lost,
    /// The scene itself is missing: all is left out up to another.
    Foreign,
}

impl Replay {
    /// Takes note of what has been left out before the frame that was read.
    pub(super) fn meet_damage(&mut self) {
        let met = self.verdict.losses.len();
        for damage in &self.frames.damages()[met..] {
            let from = self.verdict.seconds;
            // A frame that was rejected is all that is missing there.
            if damage.fault != Fault::Content {
                self.pace.lose();
            }
            self.verdict.losses.push(Loss { damage: *damage, from, until: None });
            if self.trust == Trust::Sound {
                self.trust = Trust::Doubtful(0);
            }
        }
    }

    /// The session is known again, from a time on \[s\].
    pub(super) fn settle(&mut self, seconds: f64) {
        self.trust = Trust::Sound;
        let open = |loss: &&mut Loss| loss.until.is_none();
        self.verdict.losses.iter_mut().filter(open).for_each(|loss| loss.until = Some(seconds));
    }

    /// The session is not known any more.
    pub(super) fn lose(&mut self) {
        if let Trust::Doubtful(made) = self.trust {
            self.verdict.lost += made;
        }
        self.trust = Trust::Lost;
    }

    /// True for what belongs to a scene that damage has hidden.
    pub(super) fn is_foreign(&mut self, item: &DecodedFrame) -> bool {
        let number = match item {
            DecodedFrame::Input(input) => input.number,
            DecodedFrame::Step(mark) => mark.number.saturating_sub(1),
            DecodedFrame::Keyframe(keyframe) => keyframe.number,
            _ => return false,
        };
        let follows = self.session.is_some() && number >= self.number;
        if self.trust != Trust::Sound && !follows {
            self.lose();
            self.trust = Trust::Foreign;
        }
        self.trust == Trust::Foreign
    }

    /// After damage: nothing is reported before a hash agrees.
    pub(super) fn try_step(
        &mut self,
        made: u64,
        time_ns: u64,
        mark: Option<StepMark>,
        hash: u64,
    ) -> Option<Event> {
        self.trust = Trust::Doubtful(made);
        match mark {
            Some(mark) if mark.hash == hash => {
                let from = self.verdict.losses.iter().find(|loss| loss.until.is_none());
                let from = from.map_or(0.0, |loss| loss.from);
                self.settle(from);
                self.verdict.steps += made;
                self.verdict.unmarked += made - 1;
                self.verdict.same += 1;
                return Some(Event::Stepped { time_ns, cost_ns: Some(mark.cost_ns) });
            }
            None if made < DOUBTED_MAX => {}
            _ => self.lose(),
        }
        None
    }
}
