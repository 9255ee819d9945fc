//! The ball of Hertz's contact, held down and then dragged aside or turned about the normal.

use super::{MINDLIN, TORSION};
use crate::lab::validate::case::{CaseError, Check, Figure};
use crate::lab::validate::run::{Run, Solver};
use std::f64::consts::PI;

/// Flesh, ball and pair of both scenes: E \[Pa\], ν, R \[m\], μ.
const YOUNG: f64 = 50e3;
const POISSON: f64 = 0.45;
const RADIUS: f64 = 8e-3;
const FRICTION: f64 = 0.5;

/// An element's edge in parts of the contact radius: points slide one by one.
const ELEMENT: f64 = 0.25;

/// Hertz's contact at this depth \[m\]: force \[N\] and contact radius \[m\].
fn hertz(depth: f64) -> [f64; 2] {
    let modulus = YOUNG / (1.0 - POISSON * POISSON);
    [4.0 / 3.0 * modulus * (RADIUS * depth.powi(3)).sqrt(), (RADIUS * depth).sqrt()]
}

/// Cattaneo and Mindlin, a rigid ball on a half space: `8 a G / (2 - ν)` \[N/m\].
fn tangential_stiffness(radius: f64) -> f64 {
    let shear = YOUNG / (2.0 * (1.0 + POISSON));
    8.0 * radius * shear / (2.0 - POISSON)
}

/// Place of a ball, the forces with which it is pressed and held, and the part of its patch that
/// sticks.
struct Drag {
    way: f64,
    normal: f64,
    shear: f64,
    /// Part of the patch's area that sticks.
    sticks: f64,
}

fn drag(run: &mut Run) -> Result<Drag, CaseError> {
    let [way, normal, shear] = run.values(["ball.x", "press.fy", "press.fx"])?;
    let contacts = run.world().contacts().iter().filter(|c| c.force_W.dot(&c.normal_W) > 0.0);
    let [mut area, mut slides] = [0.0; 2];
    for contact in contacts {
        area += contact.area;
        slides += if contact.slips { contact.area } else { 0.0 };
    }
    Ok(Drag { way, normal, shear: -shear, sticks: 1.0 - slides / area })
}

/// A half space (half of it, by symmetry) pressed by 0.5 mm, then dragged until all slides. With
/// the way δ and `δ* = 3 μ F (2 - ν) / (16 a G)` at which all slides,
/// `Q / μF = 1 - (1 - δ/δ*)^(3/2)`, and the part of the patch that still sticks is a disc of radius
/// `c = a √(1 - δ/δ*)`.
pub fn mindlin(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&MINDLIN, &[])?;
    let setup = run.setup();
    let [force, radius] = hertz(0.5e-3);
    let stiffness = tangential_stiffness(radius);
    let all = 1.5 * FRICTION * force / stiffness;
    let row = |what: String, expected, got, check| Figure::new(what, &setup, expected, got, check);
    run.to(0.1)?;
    let mut figures = Vec::new();
    let mut targets = [0.1, 0.25, 0.5, 0.75].into_iter().peekable();
    let end = loop {
        run.step()?;
        let now = drag(&mut run)?;
        let part = now.way / all;
        if let Some(target) = targets.next_if(|target| part >= *target) {
            let law = 1.0 - (1.0 - part).powf(1.5);
            let what = format!("drag of {:.2} of full slip: Q / (mu F)", target);
            let held = now.shear / (FRICTION * now.normal);
            figures.push(row(what, law, held, Check::Relative(0.1)));
            let what = format!("drag of {:.2} of full slip: c / a", target);
            figures.push(row(
                what,
                (1.0 - part).sqrt(),
                now.sticks.sqrt(),
                Check::Absolute(ELEMENT),
            ));
        }
        if part >= 1.3 {
            break now;
        }
    };
    let what = "dragged on: Q / (mu F)".into();
    figures.push(row(what, 1.0, end.shear / (FRICTION * end.normal), Check::Relative(0.05)));
    Ok(figures)
}

/// The holding torque once all slides: `3π/16 μ F a`, 1.970e-4 N m at 1 mm.
pub fn torsion(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&TORSION, &[])?;
    let setup = run.setup();
    let [torque, normal, slips] = run.to(0.2)?.values(["on.ty", "press.fy", "press.slipping"])?;
    let area = run.bearing_area();
    let [force, radius] = hertz(1e-3);
    let law = |force: f64, radius: f64| 3.0 * PI / 16.0 * FRICTION * force * radius;
    let row = |what: &str, expected, got, check| Figure::new(what, &setup, expected, got, check);
    Ok(vec![
        row("part of the load that slides", 0.9, slips, Check::AtLeast),
        row("holding torque [N m]", law(force, radius), torque.abs(), Check::Relative(0.1)),
        row(
            "the same for its own force and area [N m]",
            law(normal, (area / PI).sqrt()),
            torque.abs(),
            Check::Relative(0.05),
        ),
    ])
}
