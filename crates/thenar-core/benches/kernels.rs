//! One bench per kernel of a step, and one per whole step, on bars of flesh around a jointed
//! two-bone finger. Run with `cargo bench -p thenar`.

#[path = "../tests/common/mod.rs"]
mod common;

use common::{FLESH, bar, body, finger};
use divan::{Bencher, black_box};
use thenar_core::kernels::{
    BlockDiagonal, BlockMatrix, CgWorkspace, PAIRS, RestTet, conjugate_gradients, respond,
    rotation_of,
};
use thenar_core::model::{
    Binding, Drive, Law, Material, Motion, Relaxation, SolverKind, Springs, WorldDesc,
};
use thenar_core::random::Random;
use thenar_core::shape::Shape;
use thenar_core::world::{Input, Target};
use thenar_core::{Mat3, Pose, Quat, Vec3, World};

fn main() {
    divan::main();
}

const CELLS: [[usize; 3]; 3] = [[11, 3, 3], [14, 5, 5], [30, 10, 10]];

/// The finger with finer flesh, above or pressed into the ground.
fn world(cells: [usize; 3], height: f64, h: f64) -> World {
    let mut desc: WorldDesc = finger(1e8, h);
    let size = Vec3::new(0.06, 0.016, 0.016);
    let fine = bar(size, cells, FLESH);
    let soft = &mut desc.softs[0];
    if let Some(coupling) = &mut soft.coupling {
        let weight = |x: &Vec3| ((x.x - 0.02) / 0.02).clamp(0.0, 1.0);
        coupling.bindings = (fine.nodes.iter())
            .map(|x| Binding { bones: [0, 1], weights: [1.0 - weight(x), weight(x)] })
            .collect();
        let volume = size.product() / fine.nodes.len() as f64;
        let volumes = vec![volume; fine.nodes.len()];
        coupling.springs = Springs::PerVolume { stiffness: 1e8, volumes };
    }
    soft.flesh = fine;
    let mut plane = body("ground", 1.0, [1.0; 3], Vec3::zeros());
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    plane.pose_WB = Pose::translation(0.0, -height, 0.0);
    desc.add_rigid(plane);
    World::new(desc).expect("the bench's own world")
}

#[divan::bench(args = CELLS)]
fn whole_step_free(bencher: Bencher, cells: [usize; 3]) {
    let mut world = world(cells, 10.0, 1e-3);
    let input = world.input();
    bencher.bench_local(|| world.step(black_box(&input), &mut ()));
}

#[divan::bench(args = CELLS)]
fn whole_step_resting_on_the_ground(bencher: Bencher, cells: [usize; 3]) {
    let mut world = world(cells, 0.0, 1e-3);
    let input = world.input();
    for _ in 0..100 {
        world.step(&input, &mut ());
    }
    bencher.bench_local(|| world.step(black_box(&input), &mut ()));
}

/// Laws, and one with memory.
const TISSUES: [(Law, bool); 5] = [
    (Law::Corotational, false),
    (Law::StableNeoHookean, false),
    (Law::Ogden { alpha: 8.0 }, false),
    (Law::Corotational, true),
    (Law::Ogden { alpha: 8.0 }, true),
];

/// A tissue with a name for the table.
#[derive(Clone, Copy)]
struct Tissue((Law, bool));

impl std::fmt::Display for Tissue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (law, remembers) = self.0;
        write!(f, "{law:?}{}", if remembers { " with memory" } else { "" })
    }
}

/// The finger of 2100 tetrahedra of some tissue, strained by a few per cent.
fn tissue((law, remembers): (Law, bool)) -> World {
    let mut desc = world(CELLS[1], 10.0, 1e-3).desc().clone();
    let flesh = &mut desc.softs[0].flesh;
    flesh.materials.iter_mut().for_each(|material| material.law = law);
    if remembers {
        let terms = [[0.7, 4e-3], [0.15, 0.07], [0.08, 1.4]];
        let relaxation = Relaxation::new(&terms).expect("three terms");
        flesh.relaxation = vec![relaxation; flesh.tets.len()];
    }
    let mut world = World::new(desc).expect("the bench's own world");
    let mut random = Random::new(7);
    let strained: Vec<Vec3> = (world.nodes(0).iter()).map(|x| x + random.vector(5e-5)).collect();
    world.set_nodes(0, &strained);
    world
}

#[divan::bench(args = TISSUES.map(Tissue))]
fn whole_step_of_tissue(bencher: Bencher, of: Tissue) {
    let mut world = tissue(of.0);
    let input = world.input();
    bencher.bench_local(|| world.step(black_box(&input), &mut ()));
}

#[divan::bench(args = TISSUES.map(Tissue))]
fn assembly_of_tissue(bencher: Bencher, of: Tissue) {
    let world = tissue(of.0);
    let (model, state) = (world.model(), world.state());
    let (mut A, row0) = (model.pattern.clone(), 2 * model.rigids.len());
    let mut b = vec![Vec3::zeros(); A.rows()];
    let (x, v, faded) = (&state.x, &state.v[row0..], &state.faded);
    bencher
        .bench_local(|| model.flesh.assemble(black_box(x), v, faded, 1e-3, row0, &mut A, &mut b));
}

const KINDS: [SolverKind; 2] = [SolverKind::TwoStep, SolverKind::Monolithic];

/// The finger, with firm coupling and its bones driven down by this much \[m\] onto the ground.
fn driven(cells: [usize; 3], kind: SolverKind, height: f64, down: f64) -> (World, Input) {
    let mut desc = world(cells, height, 1e-3).desc().clone();
    desc.solver.kind = kind;
    let springs = desc.softs[0].coupling.as_mut().map(|coupling| &mut coupling.springs);
    if let Some(Springs::PerVolume { stiffness, .. }) = springs {
        *stiffness *= 10.0;
    }
    let drive =
        Drive { stiffness: 400.0, damping: 2.0, angular_stiffness: 0.4, angular_damping: 1e-3 };
    (desc.drives[0], desc.drives[1]) = (Some(drive), Some(drive));
    let mut world = World::new(desc).expect("the bench's own world");
    let mut input = world.input();
    for b in 0..2 {
        let pose = world.rigid_pose(b);
        input.targets[b as usize] = Some(Target {
            pose_WB: Pose::new(pose.position - Vec3::y() * down, pose.rotation),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        });
    }
    for _ in 0..200 {
        world.step(&input, &mut ());
    }
    (world, input)
}

/// Bending to and fro, so that no step repeats the last.
fn sway(world: &World, input: &mut Input) {
    let angle = 0.3 * (world.time() * 6.0).sin();
    if let Some(target) = &mut input.targets[1] {
        target.pose_WB.rotation = Quat::from_scaled_axis(Vec3::z() * angle);
    }
}

#[divan::bench(args = CELLS, consts = [0, 1])]
fn solvers_free<const KIND: usize>(bencher: Bencher, cells: [usize; 3]) {
    let (mut world, mut input) = driven(cells, KINDS[KIND], 10.0, 0.0);
    bencher.bench_local(|| {
        sway(&world, &mut input);
        world.step(&input, &mut ())
    });
}

#[divan::bench(args = CELLS, consts = [0, 1])]
fn solvers_pressed<const KIND: usize>(bencher: Bencher, cells: [usize; 3]) {
    let (mut world, mut input) = driven(cells, KINDS[KIND], 0.0, 0.004);
    bencher.bench_local(|| {
        sway(&world, &mut input);
        world.step(&input, &mut ())
    });
}

#[divan::bench]
fn polar_rotation(bencher: Bencher) {
    let turn = Quat::from_scaled_axis(Vec3::new(0.4, -0.9, 0.2)).to_rotation_matrix();
    let F = turn * Mat3::new(1.1, 0.05, 0.0, 0.02, 0.93, -0.04, 0.0, 0.03, 1.02);
    bencher.bench_local(|| rotation_of(black_box(&F)));
}

#[divan::bench(args = [Law::Corotational, Law::StableNeoHookean])]
fn element_response(bencher: Bencher, law: Law) {
    let x = [Vec3::zeros(), Vec3::x() * 0.01, Vec3::y() * 0.01, Vec3::z() * 0.01];
    let material = Material { law, ..FLESH };
    let rest = RestTet::new(&x, &material).expect("a tetrahedron of positive volume");
    let now = x.map(|x| x + Vec3::new(0.1 * x.y, -0.05 * x.z, 0.08 * x.x));
    bencher.bench_local(|| respond(black_box(&rest), black_box(&now)));
}

/// The flesh matrix of a bar, diagonally dominated as a step of 1/60 s makes it.
fn matrix(cells: [usize; 3]) -> (BlockMatrix, BlockDiagonal) {
    let flesh = bar(Vec3::new(0.06, 0.016, 0.016), cells, FLESH);
    let pairs =
        flesh.tets.iter().flat_map(|t| (0..4).flat_map(move |a| (0..a).map(move |b| (t[a], t[b]))));
    let mut a = BlockMatrix::with_pattern(flesh.nodes.len(), pairs);
    for (tet, material) in flesh.tets.iter().zip(&flesh.materials) {
        let x = tet.map(|n| flesh.nodes[n as usize]);
        let rest = RestTet::new(&x, material).expect("a tetrahedron of positive volume");
        let response = respond(&rest, &x);
        for node in tet {
            a.add_scalar(a.diagonal[*node as usize], 0.25 * rest.volume * material.density);
        }
        for (block, (i, j)) in response.stiffness.iter().zip(PAIRS) {
            let block = block / 3600.0;
            a.add(a.entry(tet[i], tet[j]), &block);
            if i != j {
                a.add(a.entry(tet[j], tet[i]), &block.transpose());
            }
        }
    }
    let mut d = BlockDiagonal::new(0, flesh.nodes.len());
    assert!(d.refresh(&a), "the matrix is positive definite");
    (a, d)
}

/// Eight elements at a time, with their rotations, into the matrix.
#[divan::bench(args = CELLS)]
fn assembly(bencher: Bencher, cells: [usize; 3]) {
    let world = world(cells, 10.0, 1e-3);
    let (model, x) = (world.model(), &world.state().x);
    let (mut A, row0) = (model.pattern.clone(), 2 * model.rigids.len());
    let mut b = vec![Vec3::zeros(); A.rows()];
    let v = &world.state().v[row0..];
    bencher.bench_local(|| model.flesh.assemble(black_box(x), v, &[], 1e-3, row0, &mut A, &mut b));
}

#[divan::bench(args = CELLS)]
fn sparse_product(bencher: Bencher, cells: [usize; 3]) {
    let (a, _) = matrix(cells);
    let x = vec![Vec3::new(1.0, 2.0, 3.0); a.rows()];
    let mut y = x.clone();
    bencher.bench_local(|| a.times(black_box(&x), &mut y));
}

#[divan::bench(args = CELLS)]
fn conjugate_gradients_to_1e5(bencher: Bencher, cells: [usize; 3]) {
    let (a, d) = matrix(cells);
    let b: Vec<Vec3> = (0..a.rows()).map(|i| Vec3::new((i as f64).sin(), 1.0, 0.0)).collect();
    let mut work = CgWorkspace::new(a.rows());
    let mut x = vec![Vec3::zeros(); a.rows()];
    bencher.bench_local(|| {
        x.fill(Vec3::zeros());
        conjugate_gradients(&a, &d, black_box(&b), &mut x, 1e-5, 1000, &mut work)
    });
}
