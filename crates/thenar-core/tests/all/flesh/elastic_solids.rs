//! Goal: flesh alone is the elastic solid that theory describes (validation B). Method: bars of
//! Kuhn cells held at one end, loaded, and stepped with steps so long that one is a static solve.

use crate::common::bar;
use thenar_core::model::{FixedNode, Flesh, Law, Material, SoftDesc, WorldDesc};
use thenar_core::{Pose, Vec3, World};

fn material(young: f64, poisson: f64) -> Material {
    Material { law: Law::Corotational, young, poisson, density: 1000.0 }
}

fn hold(flesh: &mut Flesh, axes: [bool; 3], held: impl Fn(&Vec3) -> bool) {
    let nodes = flesh.nodes.iter().enumerate().filter(|(_, x)| held(x));
    flesh.fixed.extend(nodes.map(|(n, _)| FixedNode { node: n as u32, axes }));
}

fn world(flesh: Flesh, gravity: Vec3, h: f64) -> World {
    let mut desc = WorldDesc { time_step: h, gravity, ..WorldDesc::default() };
    desc.solver.velocity_tolerance = 1e-15;
    desc.solver.cg_tolerance = 1e-12;
    desc.solver.cg_iterations_max = 20_000;
    desc.add_soft(SoftDesc {
        name: "solid".into(),
        flesh,
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    World::new(desc).unwrap()
}

/// Consistent nodal loads of a uniform traction on the surface triangles that `on` selects.
fn traction(flesh: &Flesh, total: Vec3, on: impl Fn(&Vec3) -> bool) -> Vec<Vec3> {
    let at: Vec<usize> = (flesh.collision.vertices.iter())
        .map(|v| {
            let k = (0..4).find(|&k| v.weights[k] == 1.0).unwrap();
            flesh.tets[v.tet as usize][k] as usize
        })
        .collect();
    let mut loads = vec![Vec3::zeros(); flesh.nodes.len()];
    let mut area = 0.0;
    for triangle in &flesh.collision.triangles {
        let nodes = triangle.map(|v| at[v as usize]);
        let x = nodes.map(|n| flesh.nodes[n]);
        if x.iter().all(&on) {
            let a = 0.5 * (x[1] - x[0]).cross(&(x[2] - x[0])).norm();
            area += a;
            nodes.iter().for_each(|&n| loads[n] += total * (a / 3.0));
        }
    }
    loads.iter_mut().for_each(|f| *f /= area);
    loads
}

fn mean_deflection(world: &World, rest: &[Vec3], on: impl Fn(&Vec3) -> bool) -> f64 {
    let moved: Vec<f64> = (rest.iter().zip(world.nodes(0)))
        .filter(|(rest, _)| on(rest))
        .map(|(rest, now)| (rest - now).y)
        .collect();
    moved.iter().sum::<f64>() / moved.len() as f64
}

/// B3: 100×20×20 mm, E = 100 kPa, ν = 0.3, end traction of 4 mN in total, at a thousandth of it.
/// Kuhn meshes are unique, so the (locked) deflection is known to six digits.
#[test]
fn cantilever_under_end_load() {
    for (cells, expected) in [([10, 2, 2], 0.522496), ([20, 4, 4], 0.806378)] {
        let mut flesh = bar(Vec3::new(0.1, 0.02, 0.02), cells, material(1e5, 0.3));
        hold(&mut flesh, [true; 3], |x| x.x == 0.0);
        let end = |x: &Vec3| (x.x - 0.1).abs() < 1e-9;
        let loads = traction(&flesh, Vec3::new(0.0, -4e-6, 0.0), end);
        let rest = flesh.nodes.clone();
        let mut world = world(flesh, Vec3::zeros(), 10.0);
        let mut input = world.input();
        input.node_forces = loads;
        for _ in 0..4 {
            world.step(&input, &mut ());
        }
        let mm = mean_deflection(&world, &rest, end) * 1e6;
        assert!((mm / expected - 1.0).abs() < 1e-5, "{cells:?}: {mm} mm");
    }
}

/// B4: the same bar under a thousandth of its own weight.
#[test]
fn cantilever_under_its_own_weight() {
    for (cells, expected) in [([10, 2, 2], 19.499608), ([20, 4, 4], 29.860907)] {
        let mut flesh = bar(Vec3::new(0.1, 0.02, 0.02), cells, material(1e5, 0.3));
        hold(&mut flesh, [true; 3], |x| x.x == 0.0);
        let rest = flesh.nodes.clone();
        let mut world = world(flesh, Vec3::new(0.0, -9.81e-3, 0.0), 10.0);
        let input = world.input();
        for _ in 0..4 {
            world.step(&input, &mut ());
        }
        let mm = mean_deflection(&world, &rest, |x| (x.x - 0.1).abs() < 1e-9) * 1e6;
        assert!((mm / expected - 1.0).abs() < 1e-5, "{cells:?}: {mm} mm");
    }
}

/// B6 and B7: a bar stretched or pressed, sides free: nominal stress and lateral stretch.
#[test]
fn uniaxial_stress() {
    let corotational = [(0.8, -10_000.0, 1.09)];
    let neo_hookean = [
        (0.7, -21_696.9, 1.170853),
        (0.9, -5_535.64, 1.048313),
        (1.1, 4_585.17, f64::NAN),
        (1.3, 11_968.16, f64::NAN),
        (1.5, 17_930.72, 0.830679),
    ];
    let cases = (corotational.iter().map(|c| (Law::Corotational, c)))
        .chain(neo_hookean.iter().map(|c| (Law::NeoHookean, c)));
    for (law, &(stretch, stress, lateral)) in cases {
        let material = Material { law, ..material(5e4, 0.45) };
        let mut flesh = bar(Vec3::new(0.02, 0.02, 0.02), [2, 2, 2], material);
        hold(&mut flesh, [true, false, false], |x| x.x == 0.0);
        hold(&mut flesh, [false, true, false], |x| x.y == 0.0);
        hold(&mut flesh, [false, false, true], |x| x.z == 0.0);
        let end = |x: &Vec3| (x.x - 0.02).abs() < 1e-9;
        let loads = traction(&flesh, Vec3::new(stress * 4e-4, 0.0, 0.0), end);
        let rest = flesh.nodes.clone();
        let mut world = world(flesh, Vec3::zeros(), 0.1);
        let mut input = world.input();
        for i in 0..400 {
            let ramp = f64::min(1.0, f64::from(i) / 200.0);
            for (f, load) in input.node_forces.iter_mut().zip(&loads) {
                *f = load * ramp;
            }
            world.step(&input, &mut ());
        }
        let corner = rest.iter().position(|x| x.iter().all(|&x| (x - 0.02).abs() < 1e-9)).unwrap();
        let ratio = world.nodes(0)[corner] / 0.02;
        assert!((ratio.x - stretch).abs() < 2e-6, "{law:?} {stretch}: {}", ratio.x);
        assert!(lateral.is_nan() || (ratio.y - lateral).abs() < 2e-6, "{law:?}: {}", ratio.y);
    }
}
