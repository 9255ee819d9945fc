//! Keyframes: there a replay is right, or is put right.

use super::Replay;
use super::trust::Trust;
use crate::recording::content::Keyframe;
use crate::recording::verdict::ReplayDrift;
use crate::session::Session;

/// Puts a session where a keyframe has it; false when it does not fit.
pub fn put(session: &mut Session, keyframe: &Keyframe) -> bool {
    match &keyframe.kept {
        Some(kept) => session.recall(&keyframe.state, &kept.memory),
        None => session.resume(&keyframe.state),
    }
}

/// True when a keyframe is not the state whose hash the mark before it has, of this number: both
/// were written at once.
pub fn is_forged(keyframe: &Keyframe, mark: Option<(u64, u64)>) -> bool {
    let own = mark.filter(|(number, _)| *number == keyframe.number);
    own.is_some_and(|(_, hash)| hash != keyframe.state.hash())
}

impl Replay {
    /// Counts the keyframe that was read last as damage, which costs nothing else.
    pub(super) fn leave_out(&mut self) {
        let known = self.trust == Trust::Sound;
        self.frames.reject();
        self.meet_damage();
        if known {
            self.settle(self.verdict.seconds);
        }
    }

    /// Passes over all steps before a keyframe that lacks nothing.
    pub(super) fn pass_to(&mut self, keyframe: &Keyframe) {
        let missing = keyframe.number.saturating_sub(self.number);
        self.pace.lose();
        self.number = keyframe.number;
        match self.trust {
            Trust::Lost => self.verdict.lost += missing,
            _ => self.verdict.passed += missing,
        }
    }

    /// At a keyframe the replay is right, or is put right.
    pub(super) fn compare(&mut self, early: bool, time_ns: u64, keyframe: &Keyframe) {
        // On the way to a later beginning only the last one counts.
        let last = self.begin.is_some_and(|begin| self.frames.offset() == begin);
        if early || keyframe.number != self.number {
            return;
        }
        let foreign = keyframe.kept.as_ref().is_some_and(|kept| kept.start != self.start_hash);
        let Some(session) = self.session.as_mut() else { return };
        if self.trust == Trust::Lost {
            match !foreign && put(session, keyframe) {
                true => self.settle(time_ns as f64 * 1e-9),
                false => self.trust = Trust::Foreign,
            }
            return;
        }
        let state = session.world().state();
        let moved = ReplayDrift::between(state, &keyframe.state);
        if state.hash() == keyframe.state.hash() && keyframe.remembers_as(session) {
            return;
        }
        if put(session, keyframe) && !last {
            let (times, most) = &mut self.verdict.put_right;
            *times += 1;
            *most = most.max(moved);
        }
    }
}
