//! Ranges of joints: the limits that the solver holds.

use super::{HANDS, still};
use crate::lab::validate::case::{Basis, CaseError, Check, Figure};
use crate::lab::validate::run::Solver;
use thenar_core::model::JointKind;

/// Limits of the flexion of a joint \[degrees\], of one that bends about two axes also of the
/// other.
fn limits(
    run: &mut crate::lab::validate::run::Run,
    name: &str,
) -> Result<[[f64; 2]; 2], CaseError> {
    let joints = &run.world().desc().joints;
    let joint = joints.iter().find(|j| j.name.ends_with(&format!("/{name}")));
    let joint = joint.ok_or_else(|| CaseError::Missing(format!("the hand has no joint {name}")))?;
    let of = |k: usize| {
        joint.axes[k].limit.map_or([f64::NAN; 2], |l| [l.min.to_degrees(), l.max.to_degrees()])
    };
    Ok(match joint.kind {
        JointKind::Universal => [of(1), of(0)],
        _ => [of(0), [f64::NAN; 2]],
    })
}

/// Tables of e-hand and AAOS \[degrees\]: joint, least and greatest flexion.
const RANGES: [(&str, f64, f64); 6] = [
    ("index-mcp", -45.0, 90.0),
    ("index-pip", 0.0, 100.0),
    ("index-dip", 0.0, 85.0),
    ("middle-mcp", -45.0, 90.0),
    ("thumb-mcp", -10.0, 55.0),
    ("thumb-ip", -15.0, 80.0),
];

/// Room that a joint is given beyond its range where the mesh rests outside it, 0.03 rad
/// \[degrees\].
const ROOM: f64 = 1.8;

/// Case G3: ranges of motion.
pub fn ranges(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for hand in HANDS {
        let mut run = still(solver, hand)?;
        for (joint, low, high) in RANGES {
            let [flexion, _] = limits(&mut run, joint)?;
            for (what, want, got) in [("least", low, flexion[0]), ("greatest", high, flexion[1])] {
                figures.push(
                    Figure::new(
                        format!("{joint}: {what} flexion [deg]"),
                        hand.name,
                        want,
                        got,
                        Check::Absolute(ROOM),
                    )
                    .rests_on(Basis::Construction)
                    .or_cannot("the mesh rests beyond the range, which is widened to hold it"),
                );
            }
        }
        let [_, spread] = limits(&mut run, "index-mcp")?;
        figures.push(
            Figure::new(
                "index-mcp: spread to a side [deg]",
                hand.name,
                20.0,
                spread[1],
                Check::Absolute(ROOM),
            )
            .rests_on(Basis::Construction),
        );
    }
    Ok(figures)
}

/// G4: what people reach by themselves.
pub fn active(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for hand in HANDS {
        let mut run = still(solver, hand)?;
        for (joint, band) in
            [("index-mcp", [77.0, 97.0]), ("index-pip", [80.0, 114.0]), ("index-dip", [82.0, 85.0])]
        {
            let [flexion, _] = limits(&mut run, joint)?;
            let what = format!("{joint}: greatest flexion [deg]");
            figures.push(
                Figure::within(what, hand.name, band, flexion[1]).rests_on(Basis::Construction),
            );
        }
    }
    Ok(figures)
}
