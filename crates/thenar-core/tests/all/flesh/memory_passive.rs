//! Goal: tissue with memory never gives back more than was put in. Method: elements thrown out of
//! shape, held there or not, and let go; and elements led round closed paths of shape.

use crate::common::bar;
use thenar_core::model::{
    EmbeddedSurface, FixedNode, Flesh, Law, Material, Relaxation, SoftDesc, WorldDesc,
};
use thenar_core::random::Random;
use thenar_core::world::State;
use thenar_core::{Mat3, Pose, Vec3, World};
use thenar_testing::one_in;

const EDGE: f64 = 0.01;
const PULP: [[f64; 2]; 3] = [[0.7, 4e-3], [0.15, 0.07], [0.08, 1.4]];

fn tetrahedron(material: Material, terms: &[[f64; 2]]) -> Flesh {
    let mut flesh = bar(Vec3::repeat(EDGE), [1, 1, 1], material);
    flesh.nodes = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()].map(|x| x * EDGE).to_vec();
    flesh.tets = vec![[0, 1, 2, 3]];
    flesh.materials.truncate(1);
    flesh.collision = EmbeddedSurface::default();
    flesh.relaxation = vec![Relaxation::new(terms).unwrap()];
    flesh
}

fn world(flesh: Flesh, h: f64) -> World {
    let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
    desc.solver.velocity_tolerance = 1e-12;
    desc.add_soft(SoftDesc {
        name: "element".into(),
        flesh,
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    World::new(desc).unwrap()
}

const STEPS: [f64; 3] = [1e-3, 5e-3, 0.0167];

const SHAPES: [[f64; 3]; 12] = [
    [1.0, 1.0, -1.0],
    [1.6, 1.5, -0.2],
    [2.0, 2.0, 0.25],
    [1.5, 1.5, -1.4],
    [1.0, 0.9, -0.899],
    [1.0, 1e-6, 1.0],
    [1.0, 0.01, 0.02],
    [0.1, 0.12, 0.09],
    [0.4, 0.3, 0.4],
    [3.0, 0.5, 0.7],
    [0.7, 0.7, 0.7],
    [1.4, 0.6, 1.3],
];

fn laws() -> Vec<Material> {
    let of = |law, poisson| Material { law, young: 5e4, poisson, density: 1000.0 };
    vec![
        of(Law::Corotational, 0.43),
        of(Law::StableNeoHookean, 0.43),
        of(Law::Ogden { alpha: 4.0 }, 0.0),
        of(Law::Ogden { alpha: 8.0 }, 0.43),
        of(Law::Ogden { alpha: 8.0 }, 0.49),
        of(Law::Ogden { alpha: 20.0 }, 0.3),
    ]
}

/// Thrown out of shape, held there until most of its stress has faded or not at all, and let go: an
/// element never has more than was put in, in motion or in all, and comes right.
#[test]
fn a_crushed_element_gives_back_no_more_than_was_put_in() {
    for (material, h) in laws().into_iter().flat_map(|law| STEPS.map(|h| (law, h))) {
        for (shape, held) in SHAPES.into_iter().flat_map(|shape| [(shape, 0.0), (shape, 0.1)]) {
            // Crushed along all axes below μ/(λ + μ) = 0.14 stable neo-Hookean elements stay so.
            if material.law == Law::StableNeoHookean && shape[0] < 0.14 {
                continue;
            }
            let flesh = tetrahedron(material, &PULP);
            let mut world = world(flesh.clone(), h);
            let turned = world.nodes(0).iter().map(|x| x.component_mul(&Vec3::from(shape)));
            let turned: Vec<Vec3> = turned.collect();
            world.set_nodes(0, &turned);
            let input = world.input();
            let put = world.energy(&input).total();
            if held > 0.0 {
                let state = faded(flesh, world.state(), h, (held / h) as usize);
                assert!(world.restore(&state));
            }
            let place = format!("{:?} {} {h} {shape:?} {held}", material.law, material.poisson);
            for _ in 0..(0.6 / h) as usize {
                let report = world.step(&input, &mut ());
                assert!(!report.non_finite, "{place}: {report:?}");
                let energy = world.energy(&input);
                let (kinetic, total) = (energy.kinetic / put, energy.total() / put);
                assert!(kinetic < 1.0 && total < 1.001, "{place}: {kinetic}, {total}");
            }
            assert_eq!(world.step(&input, &mut ()).inverted_tets, 0, "{place}");
        }
    }
}

/// The state after so many steps in which nothing moves.
fn faded(mut flesh: Flesh, state: &State, h: f64, steps: usize) -> State {
    let all = 0..flesh.nodes.len() as u32;
    flesh.fixed = all.map(|node| FixedNode { node, axes: [true; 3] }).collect();
    let mut held = world(flesh, h);
    assert!(held.restore(state));
    let input = held.input();
    (0..steps).for_each(|_| _ = held.step(&input, &mut ()));
    held.state().clone()
}

/// Led round closed paths of shape, from small ones to such that crush it and turn it inside out,
/// in 1 to 100 ms each: by the forces on its nodes an element takes work in, at any time. Steps are
/// so fine that a hundredth is not reached by the quadrature of the work, of which single paths
/// have ten million times the energy of others.
#[test]
fn work_round_closed_paths_is_never_gained() {
    let mut random = Random::new(7);
    let parts = 400;
    let paths: Vec<u32> = one_in(3, 0..60).collect();
    let mut inside_out = 0;
    for (material, size) in
        laws().into_iter().flat_map(|law| [0.3, 0.6, 1.0, 2.0].map(|s| (law, s)))
    {
        for path in &paths {
            let time = 10f64.powf(-2.0 + random.symmetric());
            let mut world = world(tetrahedron(material, &PULP), time / f64::from(parts));
            let rest = world.nodes(0).to_vec();
            let [a, b, c] = [0; 3].map(|_| Mat3::from_fn(|_, _| size * random.symmetric()));
            let (mut work, mut least, mut most) = (0.0, 0.0_f64, 0.0_f64);
            let (mut x0, mut f0) = (rest.clone(), inner_forces(&world));
            for k in 1..=3 * parts {
                let t = std::f64::consts::TAU * f64::from(k) / f64::from(parts);
                let F = Mat3::identity() + a * t.sin() + b * (1.0 - t.cos()) + c * (2.0 * t).sin();
                let x: Vec<Vec3> = rest.iter().map(|x| F * x).collect();
                let mut state = world.state().clone();
                world.model().flesh.relax(&x0, &x, world.time_step(), &mut state.faded);
                state.x.clone_from(&x);
                assert!(world.restore(&state));
                let f = inner_forces(&world);
                work -= (0..4).map(|n| 0.5 * (f[n] + f0[n]).dot(&(x[n] - x0[n]))).sum::<f64>();
                (x0, f0) = (x, f);
                (least, most) = (least.min(work), most.max(work));
                inside_out += u32::from(F.determinant() < 0.0);
            }
            assert!(
                least > -0.01 * most,
                "{:?} {} of size {size}, path {path}: {least} of {most} J",
                material.law,
                material.poisson
            );
        }
    }
    assert!(inside_out > 100_000 / 60 * paths.len() as u32, "{inside_out}");
}

/// Forces of the flesh at this instant.
fn inner_forces(world: &World) -> Vec<Vec3> {
    let (model, state) = (world.model(), world.state());
    let mut A = model.pattern.clone();
    let mut b = vec![Vec3::zeros(); A.rows()];
    let rest = vec![Vec3::zeros(); state.x.len()];
    // So short that nothing fades in it.
    let h = 1e-13;
    model.flesh.assemble(&state.x, &rest, &state.faded, h, 0, &mut A, &mut b);
    b.iter().map(|b| b / h).collect()
}
