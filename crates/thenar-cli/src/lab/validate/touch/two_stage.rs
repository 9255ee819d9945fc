//! Glove, proxy, bone: springs in series.

use super::refused;
use crate::lab::validate::case::{Basis, CaseError, Check, Figure};
use crate::lab::validate::run::Solver;
use thenar_core::{Mat3, Pose};
use thenar_touch::{
    BoneFrame, CouplingDesign, HandSettings, HapticHand, RigidState, Touch, series_stiffness,
};

/// The glove moves on by 1, 3 and 10 mm, the bone is blocked: force over displacement at rest.
pub fn stiffness(_: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for (device_stiffness, bone_stiffness, expected) in
        [(800.0, 800.0, 400.0), (1000.0, 600.0, 375.0)]
    {
        let design = CouplingDesign { device_stiffness, bone_stiffness, ..Default::default() };
        for displacement in [1e-3, 3e-3, 10e-3] {
            let force = force_at_rest(&design, displacement)?;
            let what = format!(
                "stiffness of {device_stiffness} and {bone_stiffness} N/m at {} mm [N/m]",
                displacement * 1e3
            );
            let got = force / displacement;
            figures.push(Figure::new(what, "T = 1 ms", expected, got, Check::Relative(0.01)));
        }
        let series = series_stiffness(device_stiffness, bone_stiffness);
        let what = "the same by formula [N/m]";
        let figure = Figure::new(what, "", expected, series, Check::Relative(1e-12));
        figures.push(figure.rests_on(Basis::Construction));
    }
    Ok(figures)
}

/// Force on the glove after two seconds \[N\].
fn force_at_rest(design: &CouplingDesign, displacement: f64) -> Result<f64, CaseError> {
    let start = [RigidState::at_rest(Pose::identity())];
    let proxy = design.proxy(0.004, &Mat3::from_diagonal_element(1e-7));
    let mut hand =
        HapticHand::new(HandSettings::default(), vec![proxy], &start, 0).map_err(refused)?;
    let mut frame = BoneFrame::new(&start, 0);
    for tick in 1..=2000u64 {
        let now_ns = tick * 1_000_000;
        let there = displacement * (tick as f64 / 500.0).min(1.0);
        hand.lead(0, RigidState::at_rest(Pose::translation(there, 0.0, 0.0)));
        frame.time_ns = now_ns;
        hand.tick(now_ns, &frame);
    }
    Ok(-hand.device_wrenches()[0][0].x)
}
