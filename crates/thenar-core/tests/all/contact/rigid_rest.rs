//! Goal: rigid bodies lie still. Method: every shape in every stable pose on a plane, a box, and
//! coarse and fine meshes, started at rest a little above; at 1, 5 and 16.7 ms. After 0.5 s it
//! neither travels nor moves, and it lies as high as its shape says.

use crate::common::body;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;
use thenar_core::model::{Motion, WorldDesc};
use thenar_core::shape::{DistanceGrid, MeshShape, PlacedShape, Shape};
use thenar_core::{Mat3, Pose, Quat, Vec3, World};

/// The top of every support.
const TOP: f64 = 0.01;

fn no_grid() -> DistanceGrid {
    DistanceGrid { origin: Vec3::repeat(1e3), cell: 1.0, dims: [2; 3], values: vec![1.0; 8] }
}

fn mesh(points: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Shape {
    Shape::Mesh(Arc::new(MeshShape::new(points, triangles, no_grid())))
}

/// A closed box of these half edges, each face of n × n squares.
fn mesh_box(half: Vec3, n: u32) -> Shape {
    let (mut points, mut triangles): (Vec<Vec3>, Vec<[u32; 3]>) = Default::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut at = |i: u32, j: u32| {
                let mut p = Vec3::zeros();
                p[axis] = side;
                p[(axis + 1) % 3] = 2.0 * f64::from(i) / f64::from(n) - 1.0;
                p[(axis + 2) % 3] = 2.0 * f64::from(j) / f64::from(n) - 1.0;
                let p = p.component_mul(&half);
                let known = points.iter().position(|q| (q - p).norm() < 1e-9);
                known.unwrap_or_else(|| {
                    points.push(p);
                    points.len() - 1
                }) as u32
            };
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                match side > 0.0 {
                    true => triangles.extend([[a, b, c], [a, c, d]]),
                    false => triangles.extend([[a, c, b], [a, d, c]]),
                }
            }
        }
    }
    mesh(points, triangles)
}

/// A prism with a regular base of n corners, standing on y.
fn prism(radius: f64, half: f64, n: u32) -> Shape {
    let ring = |y: f64| {
        (0..n).map(move |k| {
            let (s, c) = (TAU * f64::from(k) / f64::from(n)).sin_cos();
            Vec3::new(radius * c, y, radius * s)
        })
    };
    let points: Vec<Vec3> = ring(-half).chain(ring(half)).collect();
    let mut triangles = Vec::new();
    for k in 0..n {
        let next = (k + 1) % n;
        triangles.extend([[k, k + n, next + n], [k, next + n, next]]);
    }
    for k in 1..n - 1 {
        triangles.extend([[0, k, k + 1], [n, n + k + 1, n + k]]);
    }
    mesh(points, triangles)
}

/// A shape, how it lies, and how high its centre then is.
struct Lying {
    name: &'static str,
    shape: Shape,
    turn: Quat,
    height: f64,
    /// Free to roll: how far it goes is not looked at so closely.
    rolls: bool,
}

fn bodies() -> Vec<Lying> {
    let up = Quat::identity();
    let side = Quat::from_axis_angle(&Vec3::z_axis(), FRAC_PI_2);
    let lying = |name, shape, turn, height| Lying { name, shape, turn, height, rolls: false };
    let rolling = |name, shape, turn, height| Lying { name, shape, turn, height, rolls: true };
    let (radius, tall) = (0.01, 0.03);
    let slant = f64::hypot(radius, tall);
    // Along its side the centroid, 3/4 of the height from the apex, is 3/4 h sin of half the angle
    // high.
    let on_side = Quat::from_axis_angle(&Vec3::z_axis(), -(FRAC_PI_2 + (radius / tall).atan()));
    let part = |shape, pose_SP| PlacedShape { shape, pose_SP };
    let table = vec![
        part(
            Shape::Cuboid { half: Vec3::new(0.02, 0.002, 0.012) },
            Pose::translation(0.0, 0.006, 0.0),
        ),
        part(
            Shape::Cylinder { radius: 0.003, half_length: 0.008 },
            Pose::translation(0.014, -0.002, 0.0),
        ),
        part(
            Shape::Cylinder { radius: 0.003, half_length: 0.008 },
            Pose::translation(-0.014, -0.002, 0.007),
        ),
        part(
            Shape::Cone { radius: 0.004, height: 0.016 },
            Pose::translation(-0.014, -0.006, -0.007),
        ),
    ];
    vec![
        lying("box", Shape::Cuboid { half: Vec3::new(0.01, 0.006, 0.015) }, up, 0.006),
        lying("standing box", Shape::Cuboid { half: Vec3::new(0.005, 0.015, 0.005) }, up, 0.015),
        rolling("ball", Shape::Sphere { radius: 0.003 }, up, 0.003),
        rolling("big ball", Shape::Sphere { radius: 0.04 }, up, 0.04),
        rolling("capsule", Shape::Capsule { radius: 0.008, half_length: 0.02 }, side, 0.008),
        lying("cylinder", Shape::Cylinder { radius: 0.01, half_length: 0.012 }, up, 0.012),
        lying("coin", Shape::Cylinder { radius: 0.012, half_length: 0.001 }, up, 0.001),
        rolling("log", Shape::Cylinder { radius: 0.01, half_length: 0.02 }, side, 0.01),
        lying("cone", Shape::Cone { radius, height: tall }, up, 0.25 * tall),
        rolling("cone on its side", Shape::Cone { radius, height: tall }, on_side, {
            0.75 * tall * radius / slant
        }),
        lying("ellipsoid", Shape::Ellipsoid { half: Vec3::new(0.02, 0.008, 0.014) }, up, 0.008),
        lying("mesh box", mesh_box(Vec3::new(0.01, 0.006, 0.015), 1), up, 0.006),
        lying("fine mesh box", mesh_box(Vec3::new(0.01, 0.006, 0.015), 6), up, 0.006),
        lying("prism", prism(0.01, 0.012, 7), up, 0.012),
        lying("table", Shape::Compound(Arc::new(table)), up, 0.01),
    ]
}

fn supports() -> Vec<(&'static str, Shape, f64)> {
    let half = Vec3::new(0.05, 0.005, 0.06);
    vec![
        ("plane", Shape::HalfSpace, 0.0),
        ("box", Shape::Cuboid { half }, 0.005),
        ("coarse mesh", mesh_box(half, 1), 0.005),
        ("fine mesh", mesh_box(half, 9), 0.005),
    ]
}

/// The body on the support, dropped from a hundredth of a millimetre at this place.
fn world(lying: &Lying, support: &(&str, Shape, f64), h: f64, at: [f64; 2]) -> World {
    let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
    let mut ground = body(support.0, 1.0, [1.0; 3], Vec3::y() * (TOP - support.2));
    ground.motion = Motion::Prescribed;
    ground.shape = Some(support.1.clone());
    desc.add_rigid(ground);
    let place = Vec3::new(at[0], TOP + lying.height + 1e-5, at[1]);
    let mut thing = body(lying.name, 0.1, [1e-5; 3], place);
    thing.inertia = Mat3::from_diagonal_element(1e-5);
    thing.pose_WB.rotation = lying.turn;
    thing.shape = Some(lying.shape.clone());
    desc.add_rigid(thing);
    World::new(desc).expect("a sound world")
}

#[test]
fn bodies_lie_still_on_every_support() {
    let mut wrong = Vec::new();
    for lying in &bodies() {
        for support in &supports() {
            for (h, at) in
                [(1e-3, [0.0, 0.0]), (5e-3, [0.0071, -0.0133]), (1.0 / 60.0, [-0.011, 0.004])]
            {
                let mut world = world(lying, support, h, at);
                let input = world.input();
                let steps = |seconds: f64| (seconds / h).round() as usize;
                for _ in 0..steps(0.3) {
                    world.step(&input, &mut ());
                }
                let early = world.rigid_pose(1).position;
                let (mut speed, mut rate) = (0.0_f64, 0.0_f64);
                for k in 0..steps(0.4) {
                    world.step(&input, &mut ());
                    if k >= steps(0.2) {
                        let [v, w] = world.rigid_velocity(1);
                        (speed, rate) = (speed.max(v.norm()), rate.max(w.norm()));
                    }
                }
                let end = world.rigid_pose(1).position;
                let travel = (end.x - at[0]).hypot(end.z - at[1]);
                let sunk = TOP + lying.height - end.y;
                let turned = if lying.rolls { 0.0 } else { rate };
                // Rollers are free to roll on from how they came to lie.
                let still = travel < if lying.rolls { 1e-3 } else { 2e-4 }
                    && speed < 1e-3
                    && turned < 0.05
                    && (end.y - early.y).abs() < 1e-5
                    && sunk.abs() < 2e-5;
                if !still {
                    wrong.push(format!(
                        "{} on {} at {:.1} ms: travelled {:.4} mm, {:.3} mm/s, {:.3} rad/s, {:.4} mm deep",
                        lying.name,
                        support.0,
                        h * 1e3,
                        travel * 1e3,
                        speed * 1e3,
                        rate,
                        sunk * 1e3
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), bodies().len() * 12, wrong.join("\n"));
}

/// A ball of any size on a plate of 3 mm given as twelve triangles rests on it as on a box.
#[test]
fn balls_rest_on_a_thin_mesh() {
    for radius in [0.003, 0.006, 0.01, 0.02, 0.04] {
        let plate = ("plate", mesh_box(Vec3::new(0.05, 0.0015, 0.05), 1), 0.0015);
        let ball = Lying {
            name: "ball",
            shape: Shape::Sphere { radius },
            turn: Quat::identity(),
            height: radius,
            rolls: true,
        };
        let mut world = world(&ball, &plate, 1e-3, [0.013, 0.011]);
        let input = world.input();
        for _ in 0..500 {
            world.step(&input, &mut ());
        }
        for _ in 0..200 {
            world.step(&input, &mut ());
            let gap = world.rigid_pose(1).position.y - TOP - radius;
            assert!(gap.abs() < 1e-6, "radius {radius}: {gap:e} m over the plate");
        }
    }
}

/// A thin plate that turns fast about its middle takes a small ball along instead of passing it,
/// and does not meet one beyond its reach.
#[test]
fn a_plate_that_turns_fast_meets_what_is_in_its_way_only() {
    let spin = 40.0;
    for (h, far, met) in [(1.0 / 60.0, 0.06, true), (5e-3, 0.06, true), (1.0 / 60.0, 0.115, false)]
    {
        let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
        let mut plate = body("plate", 1.0, [1.0; 3], Vec3::zeros());
        plate.motion = Motion::Prescribed;
        plate.shape = Some(Shape::Cuboid { half: Vec3::new(0.1, 0.02, 0.0005) });
        desc.add_rigid(plate);
        let angle: f64 = 0.35;
        let place = Vec3::new(far * angle.cos(), 0.0, -far * angle.sin());
        let mut ball = body("ball", 0.01, [1e-6; 3], place);
        ball.shape = Some(Shape::Sphere { radius: 0.004 });
        desc.add_rigid(ball);
        let mut world = World::new(desc).expect("a sound world");
        let mut input = world.input();
        input.prescribed[0] = [Vec3::zeros(), Vec3::y() * spin];
        let mut behind = false;
        let mut turned = 0.0;
        while turned + spin * h < angle + 0.5 * PI {
            world.step(&input, &mut ());
            turned += spin * h;
            let in_plate = world.rigid_pose(0).inverse_point(&world.rigid_pose(1).position);
            behind |= in_plate.x > 0.0 && in_plate.x < 0.1 && in_plate.z > 0.002;
        }
        let speed = world.rigid_velocity(1)[0].norm();
        assert_eq!(speed > 0.1, met, "h {h}: {speed} m/s");
        assert!(!met || !behind, "h {h}: passed");
    }
}
