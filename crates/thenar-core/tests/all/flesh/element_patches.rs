//! Goal: patches of tetrahedra bend as flesh does, at any compressibility, and keep what makes
//! single tetrahedra safe. Method: bars on body-centred lattices against refined solutions, and
//! worlds of one octahedron.

use crate::common::boundary;
use thenar_core::model::{
    ElementPatches, FixedNode, Flesh, Law, Material, Relaxation, SoftDesc, WorldDesc, patches,
};
use thenar_core::{Pose, Quat, Vec3, World};

fn material(law: Law, poisson: f64) -> Material {
    Material { law, young: 1e5, poisson, density: 1000.0 }
}

/// A box of body-centred cubes with one corner at the origin: four tetrahedra around every edge
/// between two centres, two between a centre and a face of the box.
fn lattice_bar(size: Vec3, cubes: [usize; 3], material: Material) -> Flesh {
    let corners = cubes.map(|c| c + 1);
    let corner = |p: [usize; 3]| (p[0] + corners[0] * (p[1] + corners[1] * p[2])) as u32;
    let first = corners.iter().product::<usize>();
    let center = |p: [usize; 3]| (first + p[0] + cubes[0] * (p[1] + cubes[1] * p[2])) as u32;
    let cells = |n: [usize; 3]| {
        (0..n[2]).flat_map(move |k| (0..n[1]).flat_map(move |j| (0..n[0]).map(move |i| [i, j, k])))
    };
    let place = |p: [usize; 3], shift: f64| {
        Vec3::from_fn(|a, _| size[a] * (p[a] as f64 + shift) / cubes[a] as f64)
    };
    let nodes: Vec<Vec3> =
        cells(corners).map(|p| place(p, 0.0)).chain(cells(cubes).map(|p| place(p, 0.5))).collect();
    let mut tets: Vec<[u32; 4]> = Vec::new();
    for cube in cells(cubes) {
        for axis in 0..3 {
            let (e, g) = ((axis + 1) % 3, (axis + 2) % 3);
            for side in [0, 1] {
                let at = |de: usize, dg: usize| {
                    let mut p = cube;
                    p[axis] += side;
                    p[e] += de;
                    p[g] += dg;
                    corner(p)
                };
                let ring = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
                let outside =
                    if side == 1 { cube[axis] + 1 == cubes[axis] } else { cube[axis] == 0 };
                if outside {
                    tets.push([center(cube), ring[0], ring[1], ring[2]]);
                    tets.push([center(cube), ring[0], ring[2], ring[3]]);
                } else if side == 1 {
                    let mut next = cube;
                    next[axis] += 1;
                    for k in 0..4 {
                        tets.push([center(cube), center(next), ring[k], ring[(k + 1) % 4]]);
                    }
                }
            }
        }
    }
    for tet in &mut tets {
        let x = tet.map(|n| nodes[n as usize]);
        if (x[1] - x[0]).cross(&(x[2] - x[0])).dot(&(x[3] - x[0])) < 0.0 {
            tet.swap(2, 3);
        }
    }
    Flesh {
        materials: vec![material; tets.len()],
        collision: boundary(&tets),
        nodes,
        tets,
        relaxation: Vec::new(),
        mass_damping: 0.0,
        stiffness_damping: 0.0,
        fixed: Vec::new(),
        friction: 0.5,
    }
}

fn desc(flesh: Flesh, patched: bool, h: f64) -> WorldDesc {
    let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
    desc.solver.velocity_tolerance = 1e-14;
    if patched {
        let of_tet = patches(&flesh.nodes, &flesh.tets, &flesh.materials, &flesh.relaxation);
        desc.patches.push(ElementPatches { soft: 0, of_tet });
    }
    desc.add_soft(SoftDesc {
        name: "solid".into(),
        flesh,
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    desc
}

/// Work-averaged displacement [m/N] along an even traction `load` \[N\] on the box's faces that
/// `on` selects, where the box is clamped at the nodes that `clamped` selects.
fn compliance(
    mut flesh: Flesh,
    patched: bool,
    load: Vec3,
    clamped: impl Fn(&Vec3) -> bool,
    on: impl Fn(&Vec3) -> bool,
) -> f64 {
    let held = flesh.nodes.iter().enumerate().filter(|(_, x)| clamped(x));
    flesh.fixed = held.map(|(n, _)| FixedNode { node: n as u32, axes: [true; 3] }).collect();
    let mut loads = vec![Vec3::zeros(); flesh.nodes.len()];
    let mut whole = 0.0;
    for tet in &flesh.tets {
        for k in 0..4 {
            let face = [tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]];
            let x = face.map(|n| flesh.nodes[n as usize]);
            if x.iter().all(&on) {
                let area = 0.5 * (x[1] - x[0]).cross(&(x[2] - x[0])).norm();
                whole += area;
                face.iter().for_each(|&n| loads[n as usize] += load * (area / 3.0));
            }
        }
    }
    loads.iter_mut().for_each(|f| *f /= whole);
    let rest = flesh.nodes.clone();
    let mut world = World::new(desc(flesh, patched, 10.0)).unwrap();
    let mut input = world.input();
    input.node_forces = loads.clone();
    for _ in 0..12 {
        world.step(&input, &mut ());
    }
    let work: f64 = (world.nodes(0).iter().zip(&rest).zip(&loads))
        .map(|((now, rest), load)| (now - rest).dot(load))
        .sum();
    work / load.norm_squared()
}

/// A bar 60×15×15 mm clamped at one end, an even traction across it at the other. The refined
/// compliances come from hexahedra of 27 nodes, up to 24×6×6, extrapolated by their observed order
/// (a program apart).
#[test]
fn bars_bend_as_refined_ones_at_any_compressibility() {
    for (poisson, refined) in [(0.3, 0.17605), (0.43, 0.17358), (0.49, 0.17200)] {
        for cubes in [2, 3, 4] {
            let size = Vec3::new(0.06, 0.015, 0.015);
            let compliance = |patched| {
                let flesh = lattice_bar(
                    size,
                    [4 * cubes, cubes, cubes],
                    material(Law::Corotational, poisson),
                );
                compliance(
                    flesh,
                    patched,
                    Vec3::new(0.0, -4e-6, 0.0),
                    |x| x.x == 0.0,
                    |x| (x.x - size.x).abs() < 1e-9,
                )
            };
            let (single, patched) = (refined / compliance(false), refined / compliance(true));
            // Least excess of single tetrahedra, most of patches.
            let (locked, most) = match cubes {
                2 => (0.40, 0.19),
                3 => (0.15, 0.08),
                _ => (0.08, 0.045),
            };
            assert!(single > 1.0 + locked, "{poisson} {cubes}: single {single}");
            assert!((1.0..1.0 + most).contains(&patched), "{poisson} {cubes}: patched {patched}");
        }
    }
}

/// A pad 16×16×12 mm clamped below, pressed evenly on the middle 8×8 mm of its top. Refined
/// compliances as above, up to 12×12×9.
#[test]
fn pads_give_way_as_refined_ones_at_any_compressibility() {
    for (poisson, refined) in [(0.3, 874.9e-6), (0.43, 802.2e-6), (0.49, 761e-6)] {
        for fine in [1, 2] {
            let size = Vec3::new(0.016, 0.016, 0.012);
            let top = |x: &Vec3| {
                (x.z - 0.012).abs() < 1e-9
                    && (x.x - 0.008).abs() < 0.004 + 1e-9
                    && (x.y - 0.008).abs() < 0.004 + 1e-9
            };
            let compliance = |patched| {
                let flesh = lattice_bar(
                    size,
                    [4 * fine, 4 * fine, 3 * fine],
                    material(Law::Corotational, poisson),
                );
                compliance(flesh, patched, Vec3::new(0.0, 0.0, -1e-6), |x| x.z == 0.0, top)
            };
            let (single, patched) = (refined / compliance(false), refined / compliance(true));
            let (locked, most) = if fine == 1 { (0.23, 0.16) } else { (0.07, 0.046) };
            assert!(single > 1.0 + locked, "{poisson} {fine}: single {single}");
            assert!((1.0..1.0 + most).contains(&patched), "{poisson} {fine}: patched {patched}");
        }
    }
}

/// Every edge between two centres inside a box of body-centred cubes makes an octahedron, every
/// centre and face of the box a pyramid, however the box is turned.
#[test]
fn a_body_centred_lattice_falls_into_octahedra_and_pyramids() {
    let cubes = [3, 4, 2];
    let mut flesh =
        lattice_bar(Vec3::new(0.03, 0.04, 0.02), cubes, material(Law::Corotational, 0.3));
    let turn = Quat::from_euler_angles(0.3, 0.2, 0.9);
    flesh.nodes.iter_mut().for_each(|x| *x = turn * *x);
    let of_tet = patches(&flesh.nodes, &flesh.tets, &flesh.materials, &flesh.relaxation);
    let count = *of_tet.iter().max().unwrap() as usize + 1;
    let mut sizes = vec![0; count];
    of_tet.iter().for_each(|&p| sizes[p as usize] += 1);
    let [a, b, c] = cubes;
    let inner = (a - 1) * b * c + a * (b - 1) * c + a * b * (c - 1);
    let outer = 2 * (a * b + b * c + c * a);
    assert_eq!(sizes.iter().filter(|&&size| size == 4).count(), inner);
    assert_eq!(sizes.iter().filter(|&&size| size == 2).count(), outer);
    assert_eq!(count, inner + outer);
}

/// The loss of momenta of a block of one law that spins freely, pulled out of shape at the start,
/// and its gain of energy, 0.3 s later, relative to what it had.
fn lost(law: Law, relaxation: Relaxation, patched: bool) -> [f64; 3] {
    let mut flesh = lattice_bar(Vec3::new(0.03, 0.02, 0.02), [3, 2, 2], material(law, 0.43));
    flesh.relaxation = vec![relaxation; flesh.tets.len()];
    flesh.collision = Default::default();
    let mut world = World::new(desc(flesh, patched, 1e-3)).unwrap();
    let mut input = world.input();
    let spin = Vec3::new(3.0, -8.0, 5.0);
    let kicks =
        world.nodes(0).iter().zip(world.node_masses(0)).map(|(x, mass)| {
            (spin.cross(x) + Vec3::new(x.x * 20.0, x.z * 10.0, 0.1)) * *mass / 1e-3
        });
    input.node_forces = kicks.collect();
    world.step(&input, &mut ());
    input = world.input();
    let ([p, l], before) = (world.momentum(), world.energy(&input).total());
    for _ in 0..300 {
        world.step(&input, &mut ());
    }
    let ([p_now, l_now], now) = (world.momentum(), world.energy(&input).total());
    [(p_now - p).norm() / p.norm(), (l_now - l).norm() / l.norm(), now / before - 1.0]
}

/// No more is lost than with single tetrahedra, where the step of hyperelastic laws costs some
/// spin; with memory, where these lose none, what the implicit step takes from the spread while it
/// rings: a millionth.
#[test]
fn a_free_block_keeps_its_momenta_and_gains_no_energy() {
    let laws =
        [Law::Corotational, Law::NeoHookean, Law::StableNeoHookean, Law::Ogden { alpha: 8.0 }];
    let memory = Relaxation::new(&[[0.5, 0.01], [0.2, 0.1]]).unwrap();
    for (law, memory) in laws.iter().flat_map(|&l| [(l, Relaxation::NONE), (l, memory)]) {
        let (single, patched) = (lost(law, memory, false), lost(law, memory, true));
        assert!(patched[0] < 1e-12, "{law:?}: {patched:?}");
        assert!(
            patched[1] < 1.1 * single[1] + 1e-6 && patched[1] < 0.05,
            "{law:?}: {patched:?} {single:?}"
        );
        assert!(patched[2] < 0.0, "{law:?}: {patched:?}");
    }
}

/// A bar whose stress fades to g∞ = 0.4 gives way 2.5 times as far in the end; to the digit, since
/// what patches deviate by fades with it.
#[test]
fn relaxed_patches_give_way_by_what_has_faded() {
    let bar = |terms: &[[f64; 2]]| {
        let size = Vec3::new(0.06, 0.015, 0.015);
        let mut flesh = lattice_bar(size, [8, 2, 2], material(Law::Corotational, 0.43));
        flesh.relaxation = vec![Relaxation::new(terms).unwrap(); flesh.tets.len()];
        let load = Vec3::new(0.0, -4e-6, 0.0);
        compliance(flesh, true, load, |x| x.x == 0.0, |x| (x.x - size.x).abs() < 1e-9)
    };
    let ratio = bar(&[[0.4, 0.01], [0.2, 0.1]]) / bar(&[]);
    assert!((ratio / 2.5 - 1.0).abs() < 1e-5, "{ratio}");
}

/// A block of two laws that meet in its middle: no patch has both.
#[test]
fn a_patch_has_one_law() {
    let mut flesh =
        lattice_bar(Vec3::new(0.03, 0.02, 0.02), [3, 2, 2], material(Law::Corotational, 0.3));
    for (tet, material) in flesh.tets.iter().zip(&mut flesh.materials) {
        let middle = tet.iter().map(|&n| flesh.nodes[n as usize].x).sum::<f64>() / 4.0;
        material.law = if middle < 0.015 { Law::Corotational } else { Law::NeoHookean };
    }
    assert!(World::new(desc(flesh, true, 1e-3)).is_ok());
}

/// Twenty needles around one long edge: more than a patch may have, and more than twice as many.
#[test]
fn needles_around_one_edge_are_several_patches() {
    const COUNT: u32 = 20;
    let ring = (0..COUNT).map(|k| {
        let turn = std::f64::consts::TAU * f64::from(k) / f64::from(COUNT);
        Vec3::new(0.005 * turn.cos(), 0.005 * turn.sin(), 0.0)
    });
    let mut flesh = lattice_bar(Vec3::repeat(0.01), [1, 1, 1], material(Law::Corotational, 0.3));
    flesh.nodes = [-0.02, 0.02].map(|z| Vec3::new(0.0, 0.0, z)).into_iter().chain(ring).collect();
    flesh.tets = (0..COUNT).map(|k| [0, 2 + k, 2 + (k + 1) % COUNT, 1]).collect();
    flesh.materials = vec![flesh.materials[0]; flesh.tets.len()];
    flesh.collision = Default::default();
    let desc = desc(flesh, true, 1e-3);
    let of_tet = &desc.patches[0].of_tet;
    let largest = (0..COUNT).map(|p| of_tet.iter().filter(|&&q| q == p).count()).max();
    assert!(largest <= Some(8), "{of_tet:?}");
    assert!(World::new(desc).is_ok());
}

#[test]
fn patches_that_make_no_sense_are_refused() {
    let flesh = lattice_bar(Vec3::repeat(0.01), [2, 1, 1], material(Law::Corotational, 0.3));
    let count = flesh.tets.len();
    let error = |soft: u32, of_tet: Vec<u32>, laws: &[Law]| {
        let mut desc = desc(flesh.clone(), false, 1e-3);
        for (material, law) in desc.softs[0].flesh.materials.iter_mut().zip(laws) {
            material.law = *law;
        }
        desc.patches.push(ElementPatches { soft, of_tet });
        World::new(desc).err().map(|e| e.to_string()).unwrap_or_default()
    };
    let fine = patches(&flesh.nodes, &flesh.tets, &flesh.materials, &flesh.relaxation);
    assert_eq!(error(0, fine.clone(), &[]), "");
    assert_eq!(
        error(1, fine.clone(), &[]),
        "patches: deformable body 1 does not exist (there are 1)"
    );
    let short = format!("solid: patches of tetrahedra has 3 entries, expected {count}");
    assert_eq!(error(0, vec![0; 3], &[]), short);
    let gaps = "solid: numbers of patches must be 0, 1, 2, ... without gaps, got 1";
    assert_eq!(error(0, vec![1; count], &[]), gaps);
    let many = format!("solid: tetrahedra of a patch must be at most 8, got {count}");
    assert_eq!(error(0, vec![0; count], &[]), many);
    let mut mixed = desc(flesh.clone(), true, 1e-3);
    let count = mixed.softs[0].flesh.tets.len();
    mixed.softs[0].flesh.relaxation = vec![Relaxation::NONE; count];
    mixed.softs[0].flesh.relaxation[0] = Relaxation::new(&[[0.5, 0.1]]).unwrap();
    let told = World::new(mixed).err().map(|e| e.to_string());
    assert_eq!(told.as_deref(), Some("solid: relaxations of a patch must be one, got 2"));
    let laws = "solid: laws of a patch must be one, got 2";
    assert_eq!(error(0, fine, &[Law::NeoHookean]), laws);
}
