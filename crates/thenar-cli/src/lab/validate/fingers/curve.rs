//! Force and area over depth, as a plate comes up to a pad. Each curve is computed once in a run of
//! the program.

use super::{HandVariant, PRESS};
use crate::lab::press::Plate;
use crate::lab::validate::case::CaseError;
use crate::lab::validate::run::{Run, Solver};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use thenar_core::Vec3;
use thenar_core::model::Digit;

/// Speed of the press \[m/s\].
pub const RATE: f64 = 5e-3;
/// The plate sets out so far before it touches \[m\].
pub const START: f64 = 0.25e-3;
/// The press ends at this force \[N\] or depth \[m\].
const FORCE_MAX: f64 = 6.5;
const DEPTH_MAX: f64 = 6e-3;

/// Quantities that are measured at each step.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Depth from touch \[m\].
    pub depth: Vec<f64>,
    /// Force along the plate's normal \[N\].
    pub force: Vec<f64>,
    /// Area of contact \[m²\].
    pub area: Vec<f64>,
    /// Part of the load that flesh bears, and not bone where it is crushed.
    pub skin: Vec<f64>,
    /// Volume of the flesh within 10 mm of the place of touch (of a hand of 190 mm), over that at
    /// rest.
    pub volume: Vec<f64>,
    /// Mesh and step.
    pub setup: String,
}

impl Curve {
    /// The first row that bears this force.
    pub fn at(&self, force: f64) -> Result<usize, CaseError> {
        let found = self.force.iter().position(|f| *f >= force);
        found.ok_or_else(|| CaseError::Missing(format!("the press does not reach {force} N")))
    }

    /// Slope of the force over seven steps around a row \[N/m\], by least squares.
    pub fn stiffness(&self, row: usize) -> f64 {
        let rows = row.saturating_sub(3)..(row + 4).min(self.depth.len());
        let (d, f) = (&self.depth[rows.clone()], &self.force[rows]);
        line(d, f).1
    }
}

/// The straight line through points: value at 0, slope, and the square of the correlation.
pub fn line(x: &[f64], y: &[f64]) -> (f64, f64, f64) {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (mx, my) = (mean(x), mean(y));
    let sum = |a: &[f64], ma: f64, b: &[f64], mb: f64| -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).sum()
    };
    let (xx, xy, yy) = (sum(x, mx, x, mx), sum(x, mx, y, my), sum(y, my, y, my));
    (my - mx * xy / xx, xy / xx, xy * xy / (xx * yy))
}

/// Opens the press of an index pad with a course of the plate, `[time, depth]`.
pub fn open(
    solver: Solver,
    hand: HandVariant,
    angle_deg: f64,
    course: &[[f64; 2]],
    more: &[String],
) -> Result<(Run, Plate), CaseError> {
    let mut changes: Vec<String> = hand.changes.iter().map(|c| (*c).to_string()).collect();
    changes.extend(more.iter().cloned());
    let mut still = solver.open(&PRESS, &changes)?;
    let plate = Plate::at(still.session(), "plate", Digit::Index, angle_deg)
        .ok_or_else(|| CaseError::Missing("the hand has no index pad".into()))?;
    changes.extend(plate.changes.iter().cloned());
    changes.extend(plate.moves("plate", course));
    Ok((solver.open(&PRESS, &changes)?, plate))
}

/// Force along the plate's way and area, of the step just done.
pub fn force_and_area(run: &mut Run, plate: &Plate) -> Result<(f64, f64), CaseError> {
    let [x, y, z, area] = run.values(["press.fx", "press.fy", "press.fz", "press.area"])?;
    Ok((Vec3::new(x, y, z).dot(&plate.way), area))
}

type Key = (bool, HandVariant, u32);
type CurveCell = Arc<OnceLock<Result<Arc<Curve>, CaseError>>>;

/// The press of an index pad at an angle \[degrees\], computed when it is first asked for.
pub fn pressed(solver: Solver, hand: HandVariant, angle_deg: u32) -> Result<Arc<Curve>, CaseError> {
    static CURVES: Mutex<BTreeMap<Key, CurveCell>> = Mutex::new(BTreeMap::new());
    let cell = {
        let mut curves = CURVES.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(curves.entry((solver == Solver::Monolithic, hand, angle_deg)).or_default())
    };
    cell.get_or_init(|| press(solver, hand, f64::from(angle_deg)).map(Arc::new)).clone()
}

fn press(solver: Solver, hand: HandVariant, angle_deg: f64) -> Result<Curve, CaseError> {
    let end = (DEPTH_MAX + START) / RATE;
    let (mut run, plate) = open(solver, hand, angle_deg, &[[0.0, -START], [end, DEPTH_MAX]], &[])?;
    let near = near(&mut run, &plate);
    let mut curve =
        Curve { setup: format!("{}, {angle_deg}°, h = 5 ms", hand.name), ..Curve::default() };
    while run.time() < end && curve.force.last().is_none_or(|f| *f < FORCE_MAX) {
        run.step()?;
        let (force, area) = force_and_area(&mut run, &plate)?;
        curve.depth.push(RATE * run.time() - START);
        curve.force.push(force);
        curve.area.push(area);
        let [mean, all] = run.values(["press.pressure_mean", "press.normal_sum"])?;
        curve.skin.push(if all > 0.0 { mean * area / all } else { 1.0 });
        curve.volume.push(volume(&run, &near.0) / near.1);
    }
    Ok(curve)
}

/// The elements of the pad, and their volume at rest \[m³\].
fn near(run: &mut Run, plate: &Plate) -> (Vec<[u32; 4]>, f64) {
    let length = run.session().hands()[0].model.length;
    let reach = 0.010 * length / 0.19;
    let world = run.world();
    let face = plate.touch + plate.way * (0.5 * 0.01 * length / 0.19);
    let nodes = world.nodes(0);
    let inside = |t: &&[u32; 4]| t.iter().all(|n| (nodes[*n as usize] - face).norm() < reach);
    let tets: Vec<[u32; 4]> =
        world.desc().softs[0].flesh.tets.iter().filter(inside).copied().collect();
    let all = volume(run, &tets);
    (tets, all)
}

fn volume(run: &Run, tets: &[[u32; 4]]) -> f64 {
    let x = run.world().nodes(0);
    let of = |t: &[u32; 4]| {
        let [a, b, c, d] = t.map(|n| x[n as usize]);
        (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0
    };
    tets.iter().map(of).sum()
}
