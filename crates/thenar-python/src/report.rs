//! The report of a step.

use pyo3::prelude::*;
use thenar_core::world;

/// The report of one step of a world.
#[pyclass(frozen, get_all, module = "thenar")]
#[derive(Clone, Debug)]
pub struct StepReport {
    /// Reason why the chosen solver did not make the step; None when it did.
    pub failure: Option<String>,
    /// True when a stand-in made the step, because the chosen solver could not.
    pub fell_back: bool,
    /// Parts in which the step was made: 1 unless contact did not carry it through.
    pub parts: u32,
    /// Contact points, near or touching.
    pub contacts: u32,
    /// Contact points that bear load.
    pub contacts_active: u32,
    /// Contact points left out for want of room; the deepest are kept.
    pub contacts_dropped: u32,
    /// Sweeps of the contact solver.
    pub contact_sweeps: u32,
    /// Velocity error that contact leaves, as estimated [m/s].
    pub contact_residual: f64,
    /// True when contact missed the accuracy asked for.
    pub contact_unconverged: bool,
    /// Joint limits that bear load.
    pub limits_active: u32,
    /// Deepest penetration at the end of the step [m].
    pub penetration_max: f64,
    /// Largest distance between the two sides of a joint [m].
    pub joint_gap_max: f64,
    /// Largest misalignment of a joint's axes [rad].
    pub joint_misalignment_max: f64,
    /// Elements of negative volume.
    pub inverted_tets: u32,
    /// Targets of bones that were not finite; their drives let go for the step.
    pub bad_targets: u32,
    /// True when a number was not finite: what hangs together with it is where it was, at rest.
    pub non_finite: bool,
    /// True when everything was taken back so, and no time passed.
    pub taken_back: bool,
}

impl From<&world::StepReport> for StepReport {
    fn from(report: &world::StepReport) -> Self {
        Self {
            failure: report.failure.map(|failure| failure.to_string()),
            fell_back: report.fell_back,
            parts: report.parts,
            contacts: report.contacts,
            contacts_active: report.contacts_active,
            contacts_dropped: report.contacts_dropped,
            contact_sweeps: report.contact_sweeps,
            contact_residual: report.contact_residual,
            contact_unconverged: report.contact_unconverged,
            limits_active: report.limits_active,
            penetration_max: report.penetration_max,
            joint_gap_max: report.joint_gap_max,
            joint_misalignment_max: report.joint_misalignment_max,
            inverted_tets: report.inverted_tets,
            bad_targets: report.bad_targets,
            non_finite: report.non_finite,
            taken_back: report.taken_back,
        }
    }
}

#[pymethods]
impl StepReport {
    fn __repr__(&self) -> String {
        let Self { contacts, contacts_active, contacts_dropped, penetration_max, parts, .. } = self;
        let troubles = [
            ("taken back", self.taken_back),
            ("not finite", self.non_finite),
            ("fell back", self.fell_back),
            ("contact unconverged", self.contact_unconverged),
        ];
        let told: Vec<&str> =
            troubles.iter().filter(|(_, is)| *is).map(|(word, _)| *word).collect();
        let told = if told.is_empty() { "sound".into() } else { told.join(", ") };
        format!(
            "<StepReport {told}: {contacts} contacts, {contacts_active} under load, {contacts_dropped} left out, \
             {:.3} mm deep, {parts} parts>",
            penetration_max * 1e3
        )
    }
}
