//! Soft bodies pressed slowly without friction: force and contact radius.

use super::{FINGER_PAD, HERTZ, LAYER};
use crate::lab::validate::case::{CaseError, Check, Figure};
use crate::lab::validate::run::{Run, Solver};
use std::f64::consts::PI;
use thenar_scene::format::{LatticeShape, SoftShape};

/// Hertz, R = 8 mm, E = 50 kPa, ν = 0.45: depth \[mm\], force \[N\], contact radius \[mm\].
const HERTZ_VALUES: [[f64; 3]; 3] =
    [[0.2, 0.021148, 1.2649], [0.5, 0.083595, 2.0], [1.0, 0.236441, 2.8284]];

/// Result of a press.
struct Press {
    force: f64,
    /// Force on the bone.
    bone: f64,
    radius_mm: f64,
    setup: String,
}

/// Force and radius of a quarter model, times four.
fn quarter(mut run: Run, until: f64) -> Result<Press, CaseError> {
    let [force, bone] = run.to(until)?.values(["press.fy", "bone.fy"])?;
    let radius_mm = 1e3 * (4.0 * run.bearing_area() / PI).sqrt();
    Ok(Press { force: 4.0 * force.abs(), bone: 4.0 * bone.abs(), radius_mm, setup: run.setup() })
}

/// The force on the bone over the force on the plate: they must be equal.
fn bone_figure(press: &Press) -> Figure {
    let what = "force on the bone / contact force";
    Figure::new(what, &press.setup, 1.0, press.bone / press.force, Check::Relative(0.01))
}

/// The Hertz scene at a depth \[mm\], its mesh scaled with the contact radius.
fn hertz_at(solver: Solver, [depth, _, radius]: [f64; 3]) -> Result<Press, CaseError> {
    let planes = planes(solver)?.map(|p| p.iter().map(|x| x * radius / 2.0).collect::<Vec<f64>>());
    let y = 8e-3 - 1e-3 * depth;
    let overrides = [
        format!("soft.block.shape.coordinates={planes:?}"),
        format!("rigid.sphere.keyframes.1.position=[0, {y}, 0]"),
    ];
    quarter(solver.open(&HERTZ, &overrides)?, 0.1)
}

/// The cell planes of the scene, which are made for a contact radius of 2 mm.
fn planes(solver: Solver) -> Result<[Vec<f64>; 3], CaseError> {
    let mut run = solver.open(&HERTZ, &[])?;
    match &run.session().scene().soft[0].shape.value {
        SoftShape::Lattice(LatticeShape { coordinates: Some(planes), .. }) => Ok(planes.clone()),
        _ => Err(CaseError::Missing("the scene has no cell planes".into())),
    }
}

fn hertz_figures(press: &Press, [depth, force, radius]: [f64; 3]) -> [Figure; 3] {
    let (f, a) = (format!("F at {depth} mm [N]"), format!("contact radius at {depth} mm [mm]"));
    [
        Figure::new(f, &press.setup, force, press.force, Check::Relative(0.1)),
        Figure::new(a, &press.setup, radius, press.radius_mm, Check::Relative(0.15)),
        bone_figure(press),
    ]
}

pub fn hertz(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    Ok(hertz_figures(&hertz_at(solver, HERTZ_VALUES[1])?, HERTZ_VALUES[1]).into())
}

/// All three depths on meshes scaled with the contact radius, and the exponent of F over d.
pub fn hertz_depths(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let presses = HERTZ_VALUES
        .iter()
        .map(|v| hertz_at(solver, *v))
        .collect::<Result<Vec<Press>, CaseError>>()?;
    let pairs = presses.iter().zip(HERTZ_VALUES);
    let mut figures: Vec<Figure> = pairs.flat_map(|(p, v)| hertz_figures(p, v)).collect();
    let exponent = (presses[2].force / presses[0].force).ln() / 5.0_f64.ln();
    let setup = &presses[1].setup;
    figures.push(Figure::new("exponent of F over d", setup, 1.5, exponent, Check::Absolute(0.08)));
    Ok(figures)
}

/// Depths with a tolerance, and one past small strain for the reader.
pub fn layer(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for (depth, force, radius, check) in [
        (0.2, 0.02706, 1.33, Check::Relative(0.1)),
        (0.4, 0.08600, 1.94, Check::Relative(0.1)),
        (0.8, 0.28844, 2.88, Check::Report),
    ] {
        let y = 8e-3 - 1e-3 * depth;
        let down = format!("rigid.sphere.keyframes.1.position=[0, {y}, 0]");
        let press = quarter(solver.open(&LAYER, &[down])?, 0.1)?;
        let (f, a) = (format!("F at {depth} mm [N]"), format!("contact radius at {depth} mm [mm]"));
        figures.push(Figure::new(f, &press.setup, force, press.force, check));
        figures.push(Figure::new(a, &press.setup, radius, press.radius_mm, check));
        figures.push(bone_figure(&press));
    }
    Ok(figures)
}

pub fn finger_pad(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    pad_at(solver, 0.4, 0.08184, 1.90, 0.1)
}

pub fn finger_pad_depths(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = pad_at(solver, 0.2, 0.02648, 1.34, 0.1)?;
    figures.extend(pad_at(solver, 0.8, 0.25573, 2.74, 0.15)?);
    Ok(figures)
}

fn pad_at(
    solver: Solver,
    depth: f64,
    force: f64,
    radius: f64,
    tolerance: f64,
) -> Result<Vec<Figure>, CaseError> {
    let y = -8e-3 + 1e-3 * depth;
    let up = format!("rigid.plate.keyframes.1.position=[0, {y}, 0]");
    let mut run = solver.open(&FINGER_PAD, &[up])?;
    let [plate, bone] = run.to(0.075)?.values(["press.fy", "bone.fy"])?;
    let radius_mm = 1e3 * (run.bearing_area() / PI).sqrt();
    let press = Press { force: plate, bone, radius_mm, setup: run.setup() };
    let check = Check::Relative(tolerance);
    let a = format!("contact radius at {depth} mm [mm]");
    Ok(vec![
        Figure::new(format!("F at {depth} mm [N]"), &press.setup, force, plate, check),
        Figure::new(a, &press.setup, radius, press.radius_mm, check),
        bone_figure(&press),
    ])
}
