//! The accuracy that is asked of contact, over the first seconds of a run.

use thenar_scene::session::Session;

/// Steps until a time, and how many of them missed the accuracy.
pub struct Accuracy {
    until: f64,
    steps: u32,
    missed: u32,
}

impl Accuracy {
    /// Until this time of the scene \[s\].
    pub fn until(until: f64) -> Self {
        Self { until, steps: 0, missed: 0 }
    }

    /// Looks at the step that was just made: it misses the accuracy by no more than 1 mm/s.
    pub fn note(&mut self, session: &Session) {
        if session.world().time() > self.until + 1e-9 {
            return;
        }
        let report = session.report();
        self.steps += 1;
        self.missed += u32::from(report.contact_unconverged);
        assert!(report.contact_residual < 1e-3, "{report:?}");
    }

    /// Fewer than one step in a hundred missed it.
    #[track_caller]
    pub fn is_met(&self) {
        let Self { steps, missed, .. } = *self;
        assert!(steps > 100 && 100 * missed < steps, "{missed} of {steps} steps");
    }
}
