//! The accuracy that is asked of contact, over a stretch of a run.

use thenar_core::world::StepReport;

/// Steps, and how many of them missed the accuracy.
#[derive(Default)]
pub struct Accuracy {
    steps: u32,
    missed: u32,
}

impl Accuracy {
    /// Counts a step. Whether it misses the accuracy or not, it does so by no more than 1 mm/s.
    pub fn note(&mut self, report: &StepReport) {
        self.steps += 1;
        self.missed += u32::from(report.contact_unconverged);
        assert!(report.contact_residual < 1e-3, "{report:?}");
    }

    /// No more than one step in a hundred missed it, rounded up.
    #[track_caller]
    pub fn is_met(&self) {
        let Self { steps, missed } = *self;
        assert!(missed <= steps.div_ceil(100), "{missed} of {steps} steps");
    }
}
