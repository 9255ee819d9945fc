//! Steps and what enters between them.

use super::trust::Trust;
use super::{Event, Replay, ReplayError};
use crate::recording::content::StepMark;
use crate::recording::entry::Input;
use crate::recording::verdict::Difference;

/// More steps than this are not passed over one by one.
const PASSED_MAX: u64 = 10_000_000;

impl Replay {
    /// Steps that are missing before this number of them.
    pub(super) fn missing(&self, number: u64) -> Result<u64, ReplayError> {
        if self.session.is_none() {
            return Err(self.nonsense("it belongs to a scene that is not in the recording"));
        }
        match number.checked_sub(self.number) {
            Some(missing @ 0..=PASSED_MAX) => Ok(missing),
            _ => Err(self.nonsense("its step number does not follow")),
        }
    }

    /// Makes a step, whose mark may have been dropped.
    pub(super) fn step(
        &mut self,
        passing: bool,
        time_ns: u64,
        mark: Option<StepMark>,
    ) -> Option<Event> {
        let session = self.session.as_mut()?;
        self.number += 1;
        self.pace.step(session.world().time_step());
        if passing {
            session.pass(mark.is_some_and(|mark| mark.taken_back));
            match self.trust {
                Trust::Lost => self.verdict.lost += 1,
                _ => self.verdict.passed += 1,
            }
            return None;
        }
        let report = session.step(&mut ());
        let (taken_back, all_taken_back) = (report.non_finite, report.taken_back);
        let hash = session.world().state_hash();
        if let Trust::Doubtful(made) = self.trust {
            return self.try_step(made + 1, time_ns, mark, hash);
        }
        self.verdict.steps += 1;
        self.verdict.taken_back += u64::from(taken_back);
        match mark {
            None => self.verdict.unmarked += 1,
            Some(mark) if mark.hash == hash && mark.taken_back == all_taken_back => {
                self.verdict.same += 1;
            }
            Some(mark) => self.differs(mark.number, time_ns),
        }
        Some(Event::Stepped { time_ns, cost_ns: mark.map(|mark| mark.cost_ns) })
    }

    /// Lets something enter.
    pub(super) fn enter(&mut self, time_ns: u64, input: &Input) -> Option<Event> {
        let session = self.session.as_mut()?;
        let entered = input.what.with_entry(|entry| session.enter(entry));
        let refused = match entered {
            Some(Ok(())) => None,
            Some(Err(reason)) => Some(reason),
            None => Some("a pose has the wrong number of joints or angles".into()),
        };
        // What is refused where the session is not known says nothing.
        self.verdict.refused.extend(refused.filter(|_| self.trust == Trust::Sound));
        let (what, often) = (input.what.to_string(), input.what.is_often());
        Some(Event::Entered { time_ns, what, often })
    }

    /// A step gave something else.
    pub(super) fn differs(&mut self, step: u64, time_ns: u64) {
        let scene = self.verdict.scenes;
        let time = time_ns as f64 * 1e-9;
        self.verdict.first.get_or_insert(Difference { scene, step, time });
    }
}
