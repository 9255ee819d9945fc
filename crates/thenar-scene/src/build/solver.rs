//! Solver settings.

use crate::format::{ConeWord, FleshWord, JointLimitsWord, SolverTable, SolverWord};
use thenar_core::model::{Cone, FleshInStep1, JointLimits, SolverKind, SolverSettings};

/// The library's defaults with the table's changes.
pub fn settings(table: Option<&SolverTable>) -> SolverSettings {
    let mut s = SolverSettings::default();
    let Some(t) = table else { return s };
    if let Some(kind) = t.kind {
        s.kind = match kind {
            SolverWord::TwoStep => SolverKind::TwoStep,
            SolverWord::Monolithic => SolverKind::Monolithic,
        };
    }
    if let Some(cone) = t.cone {
        s.cone = match cone {
            ConeWord::Circular => Cone::Circular,
            ConeWord::Linearised => Cone::Linearised,
        };
    }
    if let Some(limits) = t.limits {
        s.limits = match limits {
            JointLimitsWord::Rows => JointLimits::Rows,
            JointLimitsWord::Springs => JointLimits::Springs,
        };
    }
    if let Some(flesh) = t.step1_flesh {
        s.step1_flesh = match flesh {
            FleshWord::Lumped => FleshInStep1::Lumped,
            FleshWord::Frozen => FleshInStep1::Frozen,
        };
    }
    // Frozen flesh is the paper's scheme, which leaves the joints to the next step.
    s.close_joints = s.step1_flesh == FleshInStep1::Lumped;
    set(&mut s.close_joints, t.close_joints);
    set(&mut s.velocity_tolerance, t.velocity_tolerance);
    set(&mut s.cg_tolerance, t.cg_tolerance);
    set(&mut s.cg_iterations_max, t.cg_iterations_max);
    set(&mut s.contact_tolerance, t.contact_tolerance);
    set(&mut s.contact_sweeps_max, t.contact_sweeps_max);
    s.contact_work_max = t.contact_work_max.map(|most| most as u64);
    set(&mut s.contact_inner_passes, t.contact_inner_passes);
    set(&mut s.contact_margin, t.contact_margin);
    set(&mut s.step_halvings_max, t.step_halvings_max);
    s
}

/// Takes over a value that is given.
pub fn set<T>(target: &mut T, given: Option<T>) {
    if let Some(value) = given {
        *target = value;
    }
}
