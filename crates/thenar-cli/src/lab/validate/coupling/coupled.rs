//! Derivatives of skinning targets, coupling forces and elastic forces.

use super::FINGER;
use super::differences::Rows::{Coordinates, OneKind};
use super::differences::{Matrix, coordinates, differences, mismatch, scatter_bones};
use crate::lab::validate::case::{CaseError, Check, Figure};
use crate::lab::validate::run::Solver;
use thenar_core::kernels::{BlockMatrix, BoneSystem, EffectiveMass, skin_target};
use thenar_core::model::FleshInStep1;
use thenar_core::{Mat3, Quat, Vec3, World};
use thenar_scene::session::Random;

/// States tried for each figure.
const STATES: usize = 3;
const SOFT: u32 = 0;
/// Differences cost the square of the number of nodes.
const SMALL: &str = "soft.flesh.shape.cells=[4, 2, 2]";

fn flat<'a>(vectors: impl IntoIterator<Item = &'a Vec3>) -> Vec<f64> {
    vectors.into_iter().flat_map(|v| [v.x, v.y, v.z]).collect()
}

fn row(what: &str, setup: &str, worst: f64) -> Figure {
    Figure::new(what, setup, 1e-6, worst, Check::AtMost)
}

/// `[bones, nodes]` forces of the coupling springs.
fn coupling_forces(world: &World) -> Vec<f64> {
    let bones = 0..world.desc().rigids.len() as u32;
    let mut forces: Vec<f64> = bones.flat_map(|b| flat(&world.coupling_wrench(b))).collect();
    let mut on_nodes = vec![Vec3::zeros(); world.nodes(SOFT).len()];
    world.coupling_forces(SOFT).for_each(|(node, f)| on_nodes[node as usize] = f);
    forces.extend(flat(&on_nodes));
    forces
}

/// A block matrix as rows.
fn dense(A: &BlockMatrix) -> Matrix {
    let mut rows = vec![vec![0.0; 3 * A.rows()]; 3 * A.rows()];
    for i in 0..A.rows() {
        for k in A.row(i) {
            for (e, value) in A.blocks[k].iter().enumerate() {
                rows[3 * i + e % 3][3 * A.columns[k] as usize + e / 3] = *value;
            }
        }
    }
    rows
}

/// Contribution of the springs to the matrix of Eq. 9 for Δt = 1 s, with its sign turned: `∂F/∂q`.
fn coupling_blocks(world: &World) -> Matrix {
    let (model, state) = (world.model(), world.state());
    let mut A = model.pattern.clone();
    let mut b = vec![Vec3::zeros(); A.rows()];
    let mut bones = BoneSystem::new(model.rigids.len(), model.joints.len());
    let at_rest = vec![Vec3::zeros(); state.x.len()];
    let mass = &model.flesh.mass;
    let step1 = EffectiveMass { flesh: FleshInStep1::Frozen, mass };
    let (poses, x) = (&state.poses_WB, &state.x);
    let shares = model.coupling.shares(poses);
    let posed = model.coupling.offsets.with(&shares);
    model.coupling.assemble(poses, &posed, x, &at_rest, 1.0, &step1, &mut A, &mut b, &mut bones);
    negated(dense(&A))
}

fn negated(mut m: Matrix) -> Matrix {
    m.iter_mut().flatten().for_each(|x| *x = -*x);
    m
}

/// `∂f_i/∂q_j = [w I, turning]` of all bound nodes; by linear blending, turning is
/// `-(w R_j x_ij)×`.
fn target_jacobian(world: &World) -> Matrix {
    let mut rows = vec![vec![0.0; coordinates(world, Some(SOFT))]; 3 * world.nodes(SOFT).len()];
    let (coupling, poses) = (&world.model().coupling, &world.state().poses_WB);
    let shares = coupling.shares(poses);
    let posed = coupling.offsets.with(&shares);
    for bound in &coupling.bound {
        let target = skin_target(bound, poses, &posed);
        for j in 0..bound.bone_count() {
            let turning = target.turning.matrix(j);
            let moving = Mat3::from_diagonal_element(bound.weights[j]);
            for (part, block) in [moving, turning].iter().enumerate() {
                for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                    let column = 6 * bound.bones[j] as usize + 3 * part + c;
                    rows[3 * bound.node as usize + r][column] += block[(r, c)];
                }
            }
        }
    }
    rows
}

fn targets(world: &World) -> Vec<f64> {
    let mut out = world.nodes(SOFT).to_vec();
    world.skin_targets(SOFT, &mut out);
    flat(&out)
}

/// Targets, forces and every block of Eq. 7-9, by "lbs" or "joint".
pub fn coupling(solver: Solver, skinning: &str) -> Result<Vec<Figure>, CaseError> {
    let skinning = format!("soft.flesh.skinning={skinning}");
    let undamped = "soft.flesh.bind_damping_time=0".into();
    let mut run = solver.open(&FINGER, &[SMALL.into(), undamped, skinning])?;
    let input = run.session().world().input();
    let setup = format!("{STATES} states, {}", run.mesh());
    let (mut random, mut worst) = (Random::new(6), [0.0_f64; 7]);
    for _ in 0..STATES {
        let mut world = run.world().clone();
        scatter_bones(&mut world, 0.01, &mut random);
        let bones = 6 * world.desc().rigids.len();
        let soft = Some(SOFT);
        let mut keep = |k: usize, value: f64| worst[k] = worst[k].max(value);

        let numeric = differences(&world, soft, targets);
        keep(0, mismatch(&world, OneKind, &target_jacobian(&world), &numeric, |_, j| j < bones));
        let slope = differences(&world, soft, |w| vec![-w.energy(&input).coupling]);
        keep(1, mismatch(&world, OneKind, &vec![coupling_forces(&world)], &slope, |_, _| true));
        let (blocks, numeric) =
            (coupling_blocks(&world), differences(&world, soft, coupling_forces));
        keep(2, mismatch(&world, Coordinates, &blocks, &numeric, |i, j| i >= bones && j >= bones));
        keep(3, mismatch(&world, Coordinates, &blocks, &numeric, |i, j| i >= bones && j < bones));
        keep(4, mismatch(&world, Coordinates, &blocks, &numeric, |i, j| i < bones && j >= bones));
        keep(6, mismatch(&world, Coordinates, &blocks, &numeric, |i, j| i < bones && j < bones));

        let mut relaxed = world.nodes(SOFT).to_vec();
        world.skin_targets(SOFT, &mut relaxed);
        world.set_nodes(SOFT, &relaxed);
        let (blocks, numeric) =
            (coupling_blocks(&world), differences(&world, soft, coupling_forces));
        keep(5, mismatch(&world, Coordinates, &blocks, &numeric, |i, j| i < bones && j < bones));
    }
    let [jacobian, force, node, node_bone, bone_node, relaxed, stretched] = worst;
    let row = |what: &str, worst: f64| row(what, &setup, worst);
    Ok(vec![
        row("df/dq of the targets", jacobian),
        row("coupling force = -dE/dq", force),
        row("coupling block node, node", node),
        row("coupling block node, bone", node_bone),
        row("coupling block bone, node", bone_node),
        row("coupling block bone, bone, springs relaxed", relaxed),
        row("coupling block bone, bone, springs stretched", stretched).or_cannot(
            "as in the paper, A_s holds k (df/dq)^T df/dq only: the turning of a stretched \
             spring's lever, which is left out, would make it indefinite",
        ),
    ])
}

/// Contribution of the flesh to the matrix of Eq. 9 for Δt = 1 s without mass, with its sign
/// turned.
fn flesh_blocks(world: &World) -> Matrix {
    let (model, state) = (world.model(), world.state());
    let mut flesh = model.flesh.clone();
    flesh.mass.fill(0.0);
    let row0 = 2 * model.rigids.len();
    let mut A = model.pattern.clone();
    let mut b = vec![Vec3::zeros(); A.rows()];
    let at_rest = vec![Vec3::zeros(); state.x.len()];
    flesh.assemble(&state.x, &at_rest, &state.faded, 1.0, row0, &mut A, &mut b);
    negated(dense(&A))
}

fn flesh_forces(world: &World) -> Vec<f64> {
    let (model, state) = (world.model(), world.state());
    let row0 = 2 * model.rigids.len();
    let mut A = model.pattern.clone();
    let mut b = vec![Vec3::zeros(); A.rows()];
    let at_rest = vec![Vec3::zeros(); state.x.len()];
    model.flesh.assemble(&state.x, &at_rest, &state.faded, 1.0, row0, &mut A, &mut b);
    flat(&b)
}

/// Nodes at `F X` with F of these principal stretches between random rotations.
fn stretch(world: &mut World, stretches: Vec3, noise: f64, random: &mut Random) {
    let mut vector = || random.vector(1.0);
    let mut turn = || Quat::from_scaled_axis(vector() * 1.5).to_rotation_matrix().into_inner();
    let F = turn() * Mat3::from_diagonal(&stretches) * turn();
    let moved: Vec<Vec3> =
        world.nodes(SOFT).iter().map(|x| F * x).map(|x| x + vector() * noise).collect();
    world.set_nodes(SOFT, &moved);
}

/// Elastic forces at random strain, and their stiffness where theory says that nothing of it is
/// left out.
pub fn flesh(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for law in ["corotational", "neo-hookean", "stable-neo-hookean"] {
        // Without damping the matrix for Δt = 1 s holds the stiffness alone.
        let undamped = "soft.flesh.stiffness_damping=0".into();
        let law_key = format!("soft.flesh.material.law=\"{law}\"");
        let run = solver.open(&FINGER, &[SMALL.into(), undamped, law_key])?;
        let setup = format!("{STATES} states, {}", run.mesh());
        let (mut random, mut worst) = (Random::new(7), [0.0_f64; 3]);
        for _ in 0..STATES {
            let mut keep = |k: usize, value: f64| worst[k] = worst[k].max(value);
            let mut world = run.world().clone();
            let input = world.input();
            let bones = 6 * world.desc().rigids.len();
            let nodes = |_: usize, j: usize| j >= bones;
            stretch(&mut world, Vec3::new(1.3, 0.9, 0.8), 5e-4, &mut random);
            let slope = differences(&world, Some(SOFT), |w| vec![-w.energy(&input).elastic]);
            keep(0, mismatch(&world, OneKind, &vec![flesh_forces(&world)], &slope, nodes));
            let numeric = differences(&world, Some(SOFT), flesh_forces);
            keep(2, mismatch(&world, Coordinates, &flesh_blocks(&world), &numeric, nodes));

            let mut world = run.world().clone();
            let gentle = if law == "corotational" {
                Vec3::new(1.0, 1.0, 1.0)
            } else {
                Vec3::new(1.06, 1.04, 1.02)
            };
            stretch(&mut world, gentle, 0.0, &mut random);
            let numeric = differences(&world, Some(SOFT), flesh_forces);
            keep(1, mismatch(&world, Coordinates, &flesh_blocks(&world), &numeric, nodes));
        }
        let left_out = match law {
            "corotational" => "the element's stiffness leaves out the derivative of its rotation",
            _ => "negative eigenvalues of the element's stiffness are set to zero",
        };
        let gentle = if law == "corotational" { "unstrained" } else { "in tension" };
        let row = |what: String, worst: f64| row(&what, &setup, worst);
        figures.push(row(format!("{law}: force = -dE/dx"), worst[0]));
        figures.push(row(format!("{law}: stiffness, {gentle}"), worst[1]));
        figures.push(
            row(format!("{law}: stiffness, strained"), worst[2])
                .or_cannot(format!("{left_out}, so that A_f stays positive definite")),
        );
    }
    Ok(figures)
}
