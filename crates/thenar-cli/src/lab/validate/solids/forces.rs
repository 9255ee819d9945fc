//! Laws that any elastic solid obeys: constant stress under an affine boundary, no force from a
//! rigid motion, forces that turn with the body and balance.

use super::{PATCH, RIGID_MOTION};
use crate::lab::validate::case::{Basis, CaseError, Check, Figure};
use crate::lab::validate::run::Solver;
use thenar_core::kernels::{RestTet, respond};
use thenar_core::{Quat, Vec3};
use thenar_scene::session::{Random, Session};

/// Random rigid motions.
const MOTIONS: usize = 1000;
/// Young's modulus \[Pa\], cross-section \[m²\] and volume \[m³\] of the body that moves.
const YOUNG: f64 = 50e3;
const AREA: f64 = 0.02 * 0.025;
const VOLUME: f64 = 0.03 * 0.02 * 0.025;

/// The scene's affine map.
const MAP: [[f64; 3]; 3] = [[1.01, 0.006, -0.004], [-0.002, 0.992, 0.005], [0.003, -0.007, 1.004]];
const OFFSET: [f64; 3] = [0.001, 0.002, 0.003];

pub fn patch(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&PATCH, &[])?;
    run.to(200.0)?;
    let stress = run.values(["stress.xx", "stress.yy", "stress.zz"])?;
    let spread = run.value("stress.spread")? / Vec3::from_column_slice(&stress).norm();
    let setup = run.setup();
    let session = run.session();
    let map = affine_map();
    let (mut off, mut moved) = (0.0_f64, 0.0_f64);
    for (rest, now) in session.meshes()[0].nodes.iter().zip(session.world().nodes(0)) {
        let expected = map(rest);
        off = off.max((now - expected).norm());
        moved = moved.max((expected - rest).norm());
    }
    Ok(vec![
        Figure::new(
            "nodes off the affine map / displacement",
            &setup,
            1e-9,
            off / moved,
            Check::AtMost,
        ),
        Figure::new("stress off its mean / stress", setup, 1e-9, spread, Check::AtMost),
    ])
}

fn affine_map() -> impl Fn(&Vec3) -> Vec3 {
    let rows = MAP.map(|r| Vec3::new(r[0], r[1], r[2]));
    let offset = Vec3::new(OFFSET[0], OFFSET[1], OFFSET[2]);
    move |x| Vec3::new(rows[0].dot(x), rows[1].dot(x), rows[2].dot(x)) + offset
}

/// The worst of the random motions in each respect.
#[derive(Default)]
struct Worst {
    force: f64,
    energy: f64,
    turned: f64,
    sum: f64,
    torque: f64,
}

pub fn rigid_motions(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut random = Random::new(2);
    let mut worst = Worst::default();
    let strain =
        [[1.2, 0.1, 0.0], [-0.05, 0.85, 0.2], [0.1, 0.0, 1.1]].map(|r| Vec3::new(r[0], r[1], r[2]));
    let mut unmoved = solver.open(&RIGID_MOTION, &[matrix(&strain), offset(&Vec3::zeros())])?;
    let setup = unmoved.setup();
    let still = internal_forces(unmoved.session());
    let largest = still.iter().map(Vec3::norm).fold(0.0, f64::max);
    for k in 0..MOTIONS {
        let mut draw = || random.vector(1.0);
        let axis = draw().try_normalize(1e-9).unwrap_or(Vec3::x());
        // Every tenth by 179.9 degrees, where the rotation is hardest to find.
        let degrees = if k % 10 == 0 { 179.9 } else { 180.0 * draw().x };
        let R = Quat::from_scaled_axis(axis * degrees.to_radians());
        let shift = draw();

        let turned = [Vec3::x(), Vec3::y(), Vec3::z()].map(|e| R.inverse() * e);
        let mut run = solver.open(&RIGID_MOTION, &[matrix(&turned), offset(&shift)])?;
        worst.energy = worst.energy.max(run.value("energy.elastic")?.abs() / (YOUNG * VOLUME));
        let force = internal_forces(run.session()).iter().map(Vec3::norm).fold(0.0, f64::max);
        worst.force = worst.force.max(force / (YOUNG * AREA));

        // A deformed state, turned: row i of R·D is Σ_k R_ik (row k of D).
        let both = turned.map(|row| strain[0] * row.x + strain[1] * row.y + strain[2] * row.z);
        let mut run = solver.open(&RIGID_MOTION, &[matrix(&both), offset(&shift)])?;
        let forces = internal_forces(run.session());
        let off = |(f, s): (&Vec3, &Vec3)| (f - R * s).norm() / largest;
        worst.turned = forces.iter().zip(&still).map(off).fold(worst.turned, f64::max);
        let places = run.session().world().nodes(0);
        let torque: Vec3 = forces.iter().zip(places).map(|(f, x)| x.cross(f)).sum();
        worst.sum = worst.sum.max(forces.iter().sum::<Vec3>().norm() / largest);
        worst.torque = worst.torque.max(torque.norm() / (largest * 0.03));
    }
    let figure = |what: &str, bound, got| Figure::new(what, &setup, bound, got, Check::AtMost);
    Ok(vec![
        figure("1000 rigid motions: force / (E A)", 1e-9, worst.force),
        figure("1000 rigid motions: energy / (E V)", 1e-12, worst.energy),
        figure("deformed and turned: force off / force", 1e-9, worst.turned),
        figure("sum of forces / force", 1e-9, worst.sum).rests_on(Basis::Construction),
        figure("sum of torques / (force x length)", 1e-9, worst.torque),
    ])
}

fn matrix(rows: &[Vec3; 3]) -> String {
    let rows = rows.map(|r| [r.x, r.y, r.z]);
    format!("soft.block.deform.0.matrix={rows:?}")
}

fn offset(v: &Vec3) -> String {
    format!("soft.block.deform.0.offset={:?}", [v.x, v.y, v.z])
}

/// Elastic force on every node of the first soft body \[N\].
fn internal_forces(session: &Session) -> Vec<Vec3> {
    let mesh = &session.meshes()[0];
    let materials = &session.world().desc().softs[0].flesh.materials;
    let x = session.world().nodes(0);
    let mut forces = vec![Vec3::zeros(); x.len()];
    for (tet, material) in mesh.tets.iter().zip(materials) {
        let rest = tet.map(|n| mesh.nodes[n as usize]);
        if let Some(element) = RestTet::new(&rest, material) {
            let response = respond(&element, &tet.map(|n| x[n as usize]));
            tet.iter().zip(response.forces).for_each(|(n, f)| forces[*n as usize] += f);
        }
    }
    forces
}
