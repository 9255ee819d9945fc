//! Goal: layers of tissue add up. Method: a slab of three bonded layers of skin and fat, pressed
//! and sheared, against the sum of the layers' compliances.

use crate::common;
use thenar_core::model::{FixedNode, Flesh, Law, Material, SoftDesc, WorldDesc};
use thenar_core::{Pose, Vec3, World};

/// Thickness [m] and Young's modulus [Pa], from the skin down (Maeno et al. 1998).
const LAYERS: [[f64; 2]; 3] = [[0.5e-3, 136e3], [1e-3, 80e3], [4e-3, 34e3]];
const POISSON: f64 = 0.48;
const EDGE: f64 = 0.01;
/// A thousandth of 1 kPa: the theory is that of small strains.
const SCALE: f64 = 1e-3;

/// One column of cells, its bottom held, its sides by symmetry: they move along `free` alone.
fn slab(free: usize) -> Flesh {
    let mut flesh = common::bar(Vec3::new(EDGE, 3.0, EDGE), [1, 3, 1], common::FLESH);
    // The planes of the cells, from the bottom up.
    let mut planes = [0.0; 4];
    for (k, [thickness, _]) in LAYERS.iter().rev().enumerate() {
        planes[k + 1] = planes[k] + thickness;
    }
    for (t, tet) in flesh.tets.iter().enumerate() {
        let level = tet.iter().map(|&n| flesh.nodes[n as usize].y as usize).min().unwrap();
        let young = LAYERS[2 - level][1];
        let law = Law::Corotational;
        flesh.materials[t] = Material { law, young, poisson: POISSON, density: 1000.0 };
    }
    for x in &mut flesh.nodes {
        x.y = planes[x.y.round() as usize];
    }
    let nodes = flesh.nodes.iter().enumerate();
    flesh.fixed = nodes
        .map(|(n, x)| FixedNode {
            node: n as u32,
            axes: std::array::from_fn(|axis| x.y == 0.0 || axis != free),
        })
        .collect();
    flesh
}

/// How far the top goes along `axis` under 1 kPa along it [m].
fn moved(axis: usize) -> f64 {
    let flesh = slab(axis);
    let rest = flesh.nodes.clone();
    let height = rest.iter().map(|x| x.y).fold(0.0, f64::max);
    let top: Vec<usize> = (0..rest.len()).filter(|&n| rest[n].y == height).collect();
    let mut desc = WorldDesc { gravity: Vec3::zeros(), time_step: 10.0, ..WorldDesc::default() };
    desc.solver.velocity_tolerance = 1e-16;
    desc.add_soft(SoftDesc {
        name: "slab".into(),
        flesh,
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    // An even traction on the triangles of the top.
    for tet in &world.desc().softs[0].flesh.tets {
        let on_top = tet.map(|n| rest[n as usize].y == height);
        if on_top.iter().filter(|on| **on).count() == 3 {
            for &n in tet.iter().filter(|n| rest[**n as usize].y == height) {
                input.node_forces[n as usize][axis] -= 1e3 * SCALE * EDGE * EDGE / 2.0 / 3.0;
            }
        }
    }
    for _ in 0..12 {
        world.step(&input, &mut ());
    }
    let way = |&n: &usize| rest[n][axis] - world.nodes(0)[n][axis];
    top.iter().map(way).sum::<f64>() / top.len() as f64 / SCALE
}

/// Held at its sides and pressed, `Σ p d/M` with `M = E (1 − ν)/((1 + ν)(1 − 2ν))`; sheared,
/// `Σ τ d/G`. Layers at the limit of what elements can bear without locking: one column of cells is
/// exact.
#[test]
fn a_slab_of_skin_and_fat_gives_way_by_the_sum_of_its_layers() {
    for (axis, want) in [(1, 15.235_294e-6), (0, 0.396_118e-3)] {
        let got = moved(axis);
        assert!((got / want - 1.0).abs() < 2e-6, "axis {axis}: {got} m, not {want}");
    }
}
