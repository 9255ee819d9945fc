//! A step in parts: each is made, judged, and kept or made again.

use crate::world::parts::{StepPart, StepParts};
use crate::world::{Input, Stage, StageTimer, StepReport, World};

/// Findings about a part that was made.
struct Verdict {
    /// Contact carried it through.
    carried: bool,
    /// No element of flesh gained energy that the step did not put in.
    gained_nothing: bool,
    /// Flesh ended where the step foresaw it.
    foreseen: bool,
}

impl World {
    /// Makes a step in as many parts as it needs, and reports them as one.
    pub(super) fn make_in_parts(
        &mut self,
        input: &Input,
        timer: &mut impl StageTimer,
    ) -> StepReport {
        let mut report = StepReport::default();
        let mut parts = StepParts::whole(self.time_step, self.desc.solver.step_halvings_max);
        let (mut length, mut flesh_retries) = (self.time_step, 0);
        while let Some(part) = parts.next() {
            self.remember_for(length, part.h);
            length = part.h;
            let mut done = self.make(part, input, timer);
            timer.begin(Some(Stage::Detect));
            let verdict = self.judge(part, &mut done);
            if self.makes_again(&verdict, &mut parts) {
                flesh_retries += u32::from(!(verdict.foreseen && verdict.gained_nothing));
                // Sides are swapped only when a part is kept.
                self.state.copy_motion(&self.scratch.before);
                continue;
            }
            if !verdict.foreseen && !done.non_finite {
                self.cut_flesh_short(part);
            }
            debug_assert_eq!(self.validate_led(part, input, &done), Ok(()), "a part of a step");
            self.keep(part, &done);
            parts.accept();
            report = done.after(&report);
        }
        self.remember_for(length, self.time_step);
        StepReport { flesh_retries, ..report }
    }

    fn judge(&mut self, part: StepPart, done: &mut StepReport) -> Verdict {
        let foreseen = self.flesh_was_foreseen(part, done);
        let gained_nothing = self.flesh_gained_nothing(part, done);
        Verdict { carried: self.was_carried(done), gained_nothing, foreseen }
    }

    /// True when the part is made again, as `parts` then has it.
    fn makes_again(&self, verdict: &Verdict, parts: &mut StepParts) -> bool {
        match verdict {
            Verdict { carried: false, .. } => parts.retry(self.reach()),
            Verdict { gained_nothing: false, .. } => parts.retry(0.0),
            Verdict { foreseen: false, .. } => parts.retry_flesh(),
            _ => false,
        }
    }

    /// Keeps the part just made, with the sides that were seen and the memory of its flesh.
    fn keep(&mut self, part: StepPart, done: &StepReport) {
        let Self { model, state, scratch, .. } = self;
        std::mem::swap(&mut state.sides, &mut scratch.sides);
        if !done.taken_back {
            model.flesh.relax(&scratch.before.x, &state.x, part.h, &mut state.faded);
        }
    }
}
