//! Goal: soft bodies that start inside each other, at any depth and mesh, come out without a kick,
//! whatever load rests on them, and the depth that is told is the true one. Method: cubes and balls
//! in each other, whose least way out geometry gives; whether they are out is asked of their
//! tetrahedra, and the energy that they may have is that of a body pushed at the speed of pushing
//! out.

use crate::common::{FLESH, bar, body};
use thenar_core::model::{Flesh, Material, Motion, SoftDesc, WorldDesc};
use thenar_core::random::Random;
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Pose, Quat, Vec3, World};
use thenar_testing::one_in;

const EDGE: f64 = 0.04;
/// How fast overlaps go at a contact margin of 1 mm \[m/s\]: an elastic body pushed so would rise
/// by a tenth of the margin, `2 s²/g`.
const SPEED: f64 = 0.02215;

/// A cube about the origin.
fn cube(edge: f64, cells: usize) -> Flesh {
    let material = Material { density: 1000.0, ..FLESH };
    let mut flesh = bar(Vec3::repeat(edge), [cells; 3], material);
    flesh.nodes.iter_mut().for_each(|x| *x -= Vec3::repeat(0.5 * edge));
    flesh.mass_damping = 1.0;
    flesh.stiffness_damping = 2e-3;
    flesh
}

/// A ball: shells of a cube made round.
fn ball(diameter: f64, cells: usize) -> Flesh {
    let mut flesh = cube(diameter, cells);
    for x in flesh.nodes.iter_mut().filter(|x| x.amax() > 0.0) {
        *x *= x.amax() / x.norm();
    }
    flesh
}

fn soft(desc: &mut WorldDesc, flesh: Flesh, at: Vec3, turn: Quat) -> u32 {
    let name = format!("soft {}", desc.softs.len());
    let pose_WM = Pose::new(at, turn);
    desc.add_soft(SoftDesc { name, flesh, pose_WM, velocity_W: Vec3::zeros(), coupling: None })
}

/// A world of two soft bodies, the second with its middle at `at` from the first's.
fn two(h: f64, [a, b]: [Flesh; 2], at: Vec3, turn: Quat) -> WorldDesc {
    let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
    soft(&mut desc, a, Vec3::y() * 0.5 * EDGE, Quat::identity());
    soft(&mut desc, b, Vec3::y() * 0.5 * EDGE + at, turn);
    desc
}

/// The nodes of one body inside the other's tetrahedra, but for a skin of a hundredth of these: so
/// deep contacts may rest.
fn inside(world: &World, a: u32, b: u32) -> usize {
    let (tets, x) = (&world.desc().softs[b as usize].flesh.tets, world.nodes(b));
    let is_in = |p: &Vec3, tet: &[u32; 4]| {
        let [o, i, j, k] = tet.map(|n| x[n as usize]);
        let weights = Mat3::from_columns(&[i - o, j - o, k - o]).try_inverse();
        weights.is_some_and(|m| {
            let w = m * (p - o);
            w.min() > 0.01 && w.sum() < 0.99
        })
    };
    world.nodes(a).iter().filter(|p| tets.iter().any(|tet| is_in(p, tet))).count()
}

fn told(world: &World) -> f64 {
    world.overlaps().first().map_or(0.0, |overlap| overlap.depth)
}

/// Steps until both are out, and half a second more; they may take twice as long as the way does at
/// the speed of pushing out. Returns the largest kinetic and the largest gain of total energy
/// \[J\].
fn comes_out(case: &str, world: &mut World, depth: f64) -> [f64; 2] {
    let (input, h) = (world.input(), world.time_step());
    let start = world.energy(&input).total();
    let [mut kinetic, mut gain] = [0.0_f64; 2];
    let steps = ((2.0 * depth / SPEED + 0.5) / h) as usize;
    for _ in 0..steps {
        let report = world.step(&input, &mut ());
        assert!(!report.fell_back && !report.non_finite, "{case}: {report:?}");
        assert_eq!(report.inverted_tets, 0, "{case}");
        let energy = world.energy(&input);
        kinetic = kinetic.max(energy.kinetic);
        gain = gain.max(energy.total() - start);
    }
    let left = [inside(world, 0, 1), inside(world, 1, 0)];
    assert_eq!(left, [0, 0], "{case}: nodes inside, {} mm told", told(world) * 1e3);
    assert!(told(world) < 1e-4, "{case}: {} m deep", told(world));
    [kinetic, gain]
}

/// Without weight: out, and not faster than an elastic body leaves that is pushed, and stretched by
/// that no more than it moves.
fn floats_out(case: &str, desc: WorldDesc, depth: f64, accuracy: f64) {
    let mut world = World::new(desc).unwrap();
    let off = told(&world) - depth;
    assert!(off.abs() < accuracy, "{case}: told {} of {depth} m", told(&world));
    let masses = [0, 1].map(|soft| world.node_masses(soft).iter().sum::<f64>());
    let most = 0.5 * (masses[0] + masses[1]) * (2.0 * SPEED).powi(2);
    let [kinetic, gain] = comes_out(case, &mut world, depth);
    assert!(kinetic < most && gain < 2.0 * most, "{case}: {kinetic}, {gain} of {most} J");
}

/// Upright, and offset so far that the side is nearer than the top at the deepest.
#[test]
fn a_cube_in_a_cube_leaves_by_the_least_way() {
    let meshes = [(5e-3, 1), (5e-3, 2), (1.0 / 60.0, 4), (1.0 / 60.0, 5)];
    let all = meshes.iter().flat_map(|&mesh| [0.05, 0.15, 0.5, 0.95].map(|part| (mesh, part)));
    let all = all.chain([((1e-3, 3), 0.3)]);
    let aside = [(1e-3_f64, 1.2e-3), (12e-3, 8e-3)];
    let all = all.flat_map(|(mesh, part)| aside.map(|at| (mesh, part, at)));
    for ((h, cells), part, (x, z)) in one_in(3, all) {
        let up = (1.0 - part) * EDGE;
        let case = format!("h {h}, {cells} cells, {part} deep, {x} m aside");
        let pair = [cube(EDGE, cells), cube(EDGE, cells)];
        let least = (EDGE - up).min(EDGE - x.max(z));
        let desc = two(h, pair, Vec3::new(x, up, z), Quat::identity());
        floats_out(&case, desc, least, 0.03 * least);
    }
}

/// About the vertical no vertex of the coarsest need be inside; about a horizontal axis an edge is
/// lowest.
#[test]
fn a_turned_cube_leaves_a_cube_by_the_least_way() {
    for (h, cells) in [(5e-3, 1), (1.0 / 60.0, 4)] {
        for part in [0.1, 0.3, 0.6] {
            for axis in [Vec3::y_axis(), Vec3::z_axis()] {
                let turn = Quat::from_axis_angle(&axis, std::f64::consts::FRAC_PI_6);
                let half = 0.5 * EDGE;
                let rot = turn.to_rotation_matrix();
                let below: f64 = (0..3).map(|k| half * rot[(1, k)].abs()).sum();
                let at = Vec3::new(1e-3, half + below - part * EDGE, 1.2e-3);
                let case = format!("h {h}, {cells} cells, {part} deep, about {axis:?}");
                let pair = [cube(EDGE, cells), cube(EDGE, cells)];
                floats_out(&case, two(h, pair, at, turn), part * EDGE, 0.05 * part * EDGE);
            }
        }
    }
}

/// Two balls of four cells across have flat places: their way is shorter by up to two heights of
/// those over the sphere, `1 - cos 22.5°` of the radius.
#[test]
fn a_ball_in_a_ball_leaves_it() {
    let flat = 0.076 * 0.5 * EDGE;
    for part in [0.15, 0.5, 0.9] {
        let at = Vec3::new(1e-3, (1.0 - part) * EDGE, 1.2e-3);
        let pair = [ball(EDGE, 4), ball(EDGE, 4)];
        let depth = EDGE - at.norm();
        let case = format!("{part} deep");
        floats_out(&case, two(1.0 / 60.0, pair, at, Quat::identity()), depth - flat, 1.01 * flat);
    }
}

/// Nothing cuts anything: the whole small cube has to go as far as from its lower side to the top.
#[test]
fn a_cube_that_another_has_swallowed_leaves_it() {
    for (cells, edge) in [([1, 1], 0.015), ([4, 3], 0.015), ([2, 4], 0.02)] {
        let at = Vec3::new(1e-3, 2e-3, 1.2e-3);
        let depth = 0.5 * (EDGE + edge) - at.y;
        let pair = [cube(EDGE, cells[0]), cube(edge, cells[1])];
        let case = format!("{cells:?} cells");
        floats_out(&case, two(5e-3, pair, at, Quat::identity()), depth, 1e-3 * depth);
    }
}

/// The load is lifted by no more than the depth, and what else is gained is the strain of the
/// column below it, which the load made.
#[test]
fn cubes_come_apart_under_a_load() {
    const LOAD: f64 = 5.0;
    let meshes = [(5e-3, 2), (1.0 / 60.0, 4)];
    let all = meshes.iter().flat_map(|&mesh| [0.15, 0.5].map(|part| (mesh, part)));
    for ((h, cells), part) in one_in(3, all) {
        let depth = part * EDGE;
        let at = Vec3::new(0.5e-3, EDGE - depth, 0.6e-3);
        let mut desc = two(h, [cube(EDGE, cells), cube(EDGE, cells)], at, Quat::identity());
        desc.gravity = Vec3::y() * -9.81;
        let mut ground = body("ground", 1.0, [1.0; 3], Vec3::zeros());
        (ground.motion, ground.shape) = (Motion::Prescribed, Some(Shape::HalfSpace));
        desc.add_rigid(ground);
        let mass = LOAD / 9.81;
        let top = 2.0 * EDGE - depth + 5.1e-3;
        // A plate that hardly tilts.
        let mut plate = body("plate", mass, [0.1 * mass; 3], Vec3::new(0.0, top, 0.0));
        plate.shape = Some(Shape::Cuboid { half: Vec3::new(0.06, 5e-3, 0.06) });
        desc.add_rigid(plate);
        let case = format!("h {h}, {cells} cells, {part} deep");
        let mut world = World::new(desc).unwrap();
        let weight: f64 = LOAD + 9.81 * world.node_masses(1).iter().sum::<f64>();
        let [_, gain] = comes_out(&case, &mut world, depth);
        assert!(gain < weight * depth, "{case}: {gain} of {} J", weight * depth);
    }
}

/// Rods whose edges cross far from any vertex: 1 mm, by the edges alone.
#[test]
fn crossed_rods_touch_with_their_edges() {
    const DEPTH: f64 = 1e-3;
    let rod = |size: Vec3, cells| {
        let mut flesh = bar(size, cells, FLESH);
        flesh.nodes.iter_mut().for_each(|x| *x -= 0.5 * size);
        flesh
    };
    let (thin, long) = (0.008, 0.06);
    let along_x = rod(Vec3::new(long, thin, thin), [3, 1, 1]);
    let along_z = rod(Vec3::new(thin, thin, long), [1, 1, 3]);
    let eighth = std::f64::consts::FRAC_PI_4;
    let mut desc = WorldDesc { gravity: Vec3::zeros(), ..WorldDesc::default() };
    soft(&mut desc, along_x, Vec3::zeros(), Quat::from_axis_angle(&Vec3::x_axis(), eighth));
    let up = Vec3::y() * (thin * std::f64::consts::SQRT_2 - DEPTH);
    soft(&mut desc, along_z, up, Quat::from_axis_angle(&Vec3::z_axis(), eighth));
    let mut world = World::new(desc).unwrap();
    let off = told(&world) - DEPTH;
    assert!(off.abs() < 1e-9, "{} m", told(&world));
    world.step(&world.input(), &mut ());
    let contact = world.contacts().iter().min_by(|a, b| a.gap.total_cmp(&b.gap)).unwrap();
    assert!((contact.normal_W.y.abs() - 1.0).abs() < 1e-6, "{}", contact.normal_W);
}

/// The least translation that frees two boxes, by the fifteen axes of Gottschalk et al. (1996).
fn least_translation(halves: [Vec3; 2], apart: Vec3, turn: &Quat) -> f64 {
    let R = turn.to_rotation_matrix();
    let own = [Vec3::x(), Vec3::y(), Vec3::z()];
    let turned = own.map(|axis| R * axis);
    let crossed = own.iter().flat_map(|a| turned.map(|b| a.cross(&b)));
    let extent = |half: &Vec3, axes: &[Vec3; 3], along: &Vec3| -> f64 {
        axes.iter().zip(half.iter()).map(|(axis, half)| half * axis.dot(along).abs()).sum()
    };
    let axes = own.into_iter().chain(turned).chain(crossed);
    let overlaps = axes.filter_map(|axis| axis.try_normalize(1e-6)).map(|along| {
        extent(&halves[0], &own, &along) + extent(&halves[1], &turned, &along)
            - apart.dot(&along).abs()
    });
    overlaps.fold(f64::INFINITY, f64::min)
}

/// Corners and edges of boxes that are a little in each other are told at most four times as deep
/// as they are, whatever lies behind them: a way through the length of one of them is none.
#[test]
fn corners_are_not_told_many_times_as_deep() {
    let sizes = [Vec3::new(0.1, 0.03, 0.03), Vec3::new(0.024, 0.02, 0.02)];
    let mut random = Random::new(5);
    let (mut cases, mut worst) = (0, 0.0_f64);
    while cases < 400 {
        let turn = Quat::from_scaled_axis(random.vector(3.0));
        let apart = random.vector(1.0).component_mul(&Vec3::new(0.07, 0.03, 0.03));
        let exact = least_translation(sizes.map(|s| 0.5 * s), apart, &turn);
        if !(0.5e-3..4e-3).contains(&exact) {
            continue;
        }
        cases += 1;
        let centred = |size: Vec3, cells: [usize; 3]| {
            let mut flesh = bar(size, cells, FLESH);
            flesh.nodes.iter_mut().for_each(|x| *x -= 0.5 * size);
            flesh
        };
        let boxes = [centred(sizes[0], [10, 3, 3]), centred(sizes[1], [2, 2, 2])];
        let told = told(&World::new(two(1e-3, boxes, apart, turn)).unwrap());
        worst = worst.max(told / exact);
    }
    assert!(worst < 4.0, "told {worst} times as deep");
}
