//! Goal: the area of every contact is that of the patch in which surfaces touch. Method: a soft pad
//! of fine triangles on a base, under shapes and another pad that a load presses down without
//! tilting; the patch is the part of the deformed surface nearer than 20 µm to the other, by small
//! pieces and formulas of distance of this test's own, or, between two pads, what the load asks for
//! at the peak pressure where meshes do not resolve it; of these Hertz says how large it is.

use crate::common::{FLESH, bar, body};
use thenar_core::model::{
    Binding, BodyId, Coupling, FixedNode, Flesh, Material, Skinning, SoftDesc, Springs, WorldDesc,
};
use thenar_core::readout::ContactReadout;
use thenar_core::shape::Shape;
use thenar_core::world::Input;
use thenar_core::{Mat3, Pose, Quat, Vec3, World};

/// What is nearer touches \[m\]: the definition of the read-out.
const TOUCHING: f64 = 20e-6;
/// Of a pad: half its width, and its height \[m\].
const HALF: f64 = 8e-3;
const HEIGHT: f64 = 8e-3;
/// So many points of the surface in a patch make it one whose area is told to 15 %.
const POINTS_MIN: usize = 20;
/// Mass of what presses \[kg\].
const MASS: f64 = 0.05;
const STEP: f64 = 5e-3;

/// A pad as firm as a fingertip that is pressed, with triangles of so many millimetres: flat, or
/// bulging towards its middle.
fn pad(triangle: f64, bulge: f64) -> Flesh {
    let cells = |length: f64| (length / triangle).round() as usize;
    let firm = Material { young: 3e5, ..FLESH };
    let size = Vec3::new(2.0 * HALF, HEIGHT, 2.0 * HALF);
    let mut flesh = bar(size, [cells(size.x), cells(size.y), cells(size.z)], firm);
    for x in &mut flesh.nodes {
        *x -= Vec3::new(HALF, 0.0, HALF);
        x.y *= 1.0 - bulge * x.xz().norm_squared() / (2.0 * HALF * HALF);
    }
    flesh.mass_damping = 5.0;
    flesh.stiffness_damping = 2e-3;
    flesh
}

/// A world in which a load presses body `rigid` on the pad, soft body 0.
struct Press {
    world: World,
    input: Input,
    rigid: u32,
}

/// A pad on its base.
fn based(flesh: Flesh) -> WorldDesc {
    let mut desc = WorldDesc { gravity: Vec3::zeros(), time_step: STEP, ..WorldDesc::default() };
    let mut flesh = flesh;
    let low = flesh.nodes.iter().enumerate().filter(|(_, x)| x.y < 1e-9);
    flesh.fixed = low.map(|(n, _)| FixedNode { node: n as u32, axes: [true; 3] }).collect();
    desc.add_soft(SoftDesc {
        name: "pad".into(),
        flesh,
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    desc
}

/// A body that does not turn: its inertia is that of a wheel of 100 m.
fn level(name: &str, pose: Pose) -> thenar_core::model::RigidDesc {
    let mut level = body(name, MASS, [1.0; 3], pose.position);
    level.inertia = Mat3::identity() * (MASS * 1e4);
    level.pose_WB = pose;
    level
}

impl Press {
    fn with_shape(flesh: Flesh, shape: &Shape, rotation: Quat, lowest: f64) -> Self {
        let mut desc = based(flesh);
        let mut presser =
            level("presser", Pose::new(Vec3::y() * (HEIGHT + lowest + 1e-4), rotation));
        presser.shape = Some(shape.clone());
        let rigid = desc.add_rigid(presser);
        let world = World::new(desc).unwrap();
        Self { input: world.input(), world, rigid }
    }

    /// Another pad over it, upside down, on a bone.
    fn with_pads([below, flesh]: [Flesh; 2]) -> Self {
        let mut desc = based(below);
        let at = Vec3::new(0.4e-3, 2.0 * HEIGHT + 1e-4, 0.3e-3);
        let over = Pose::new(at, Quat::from_scaled_axis(Vec3::x() * std::f64::consts::PI));
        let rigid = desc.add_rigid(level("bone", Pose::new(at, Quat::identity())));
        let held = |x: &Vec3| if x.y < 1e-9 { 1e4 } else { 0.0 };
        let coupling = Coupling {
            bindings: vec![Binding { bones: [rigid; 2], weights: [1.0, 0.0] }; flesh.nodes.len()],
            springs: Springs::PerNode(flesh.nodes.iter().map(held).collect()),
            damping_time: 1e-3,
            skinning: Skinning::Linear,
        };
        desc.add_soft(SoftDesc {
            name: "pad above".into(),
            flesh,
            pose_WM: over,
            velocity_W: Vec3::zeros(),
            coupling: Some(coupling),
        });
        let world = World::new(desc).unwrap();
        Self { input: world.input(), world, rigid }
    }

    /// Until it rests under `load` \[N\].
    fn settle(&mut self, load: f64) {
        let before = self.input.wrenches[self.rigid as usize][0].y;
        for step in 1..=60 {
            let part = f64::from(step.min(30)) / 30.0;
            let force = before + (-load - before) * part;
            self.input.wrenches[self.rigid as usize] = [Vec3::y() * force, Vec3::zeros()];
            assert!(!self.world.step(&self.input, &mut ()).non_finite);
        }
        let speed = self.world.rigid_velocity(self.rigid)[0].norm();
        assert!(speed < 2e-3, "{load} N: still at {speed} m/s");
    }

    /// The area of a pad where `distance` is below [`TOUCHING`], to pieces of the 2^`depth`th part
    /// of an edge.
    fn area_near(&self, soft: u32, depth: u32, distance: impl Fn(&Vec3) -> f64) -> f64 {
        let x = self.world.collision_vertices(soft);
        let triangles = &self.world.desc().softs[soft as usize].flesh.collision.triangles;
        triangles.iter().map(|t| near(&t.map(|v| x[v as usize]), depth, &distance)).sum()
    }

    /// The read-out's area against `patch`, where `of_point` is what a vertex of the surface stands
    /// for, and pressure times area against the load.
    fn is_told(&self, scene: &str, load: f64, patch: f64, of_point: f64) {
        let mut readout = ContactReadout::new(&self.world);
        readout.read(&self.world);
        let whole = readout.body(&self.world, BodyId::Soft(0));
        let surfaces = 0..self.world.desc().softs.len() as u32;
        let vertices = surfaces.flat_map(|soft| readout.vertices(soft));
        let peak = vertices.map(|v| v.pressure).fold(0.0, f64::max);
        let patch =
            if self.world.desc().softs.len() > 1 { patch.max(whole.normal / peak) } else { patch };
        let off = (whole.area - patch).abs();
        let points = self.world.contacts().iter().filter(|c| c.gap < TOUCHING).count();
        let allowed = if points >= POINTS_MIN { 0.15 * patch } else { of_point };
        assert!(off < allowed, "{scene} under {load} N: {} m2, patch {patch} m2", whole.area);
        let pressed: f64 = readout.vertices(0).iter().map(|v| v.pressure * v.area).sum();
        let mean = whole.pressure_mean() * whole.area;
        let borne = self.world.contacts().iter().map(|c| c.force_W.dot(&c.normal_W)).sum::<f64>();
        assert!((pressed / borne - 1.0).abs() < 0.01, "{pressed} of {borne} N");
        assert!((mean / borne - 1.0).abs() < 0.01, "{mean} of {borne} N");
        assert!((whole.force_W.y / -load - 1.0).abs() < 0.01, "{} of {load} N", whole.force_W);
    }
}

/// Signed distance to what presses, in its frame.
type Distance = fn(&Vec3) -> f64;

/// The shapes, how they are turned, how far their lowest point lies below the middle, and their
/// distances.
fn shapes() -> [(&'static str, Shape, Quat, f64, Distance); 4] {
    let lying = Quat::from_scaled_axis(Vec3::x() * std::f64::consts::FRAC_PI_2);
    let on_edge = Quat::from_scaled_axis(Vec3::x() * std::f64::consts::FRAC_PI_4);
    let plate = Vec3::new(0.03, 0.005, 0.03);
    let corner = 0.02_f64;
    [
        ("ball", Shape::Sphere { radius: 0.012 }, Quat::identity(), 0.012, |p| p.norm() - 0.012),
        ("plate", Shape::Cuboid { half: plate }, Quat::identity(), 0.005, |p| p.y.abs() - 0.005),
        ("cylinder", Shape::Cylinder { radius: 0.01, half_length: 0.03 }, lying, 0.01, |p| {
            p.xz().norm() - 0.01
        }),
        (
            "edge",
            Shape::Cuboid { half: Vec3::new(0.03, corner, corner) },
            on_edge,
            corner * std::f64::consts::SQRT_2,
            |p| {
                let [y, z] = [p.y.abs() - 0.02, p.z.abs() - 0.02];
                y.max(0.0).hypot(z.max(0.0)) + y.max(z).min(0.0)
            },
        ),
    ]
}

/// The area of the part of a triangle where a distance is below [`TOUCHING`]: none changes by more
/// than its place, so that most pieces are decided at their middle, and the others are cut in four.
fn near(x: &[Vec3; 3], depth: u32, distance: &impl Fn(&Vec3) -> f64) -> f64 {
    let middle = (x[0] + x[1] + x[2]) / 3.0;
    let radius = x.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
    let beyond = distance(&middle) - TOUCHING;
    if beyond.abs() >= radius || depth == 0 {
        let area = (x[1] - x[0]).cross(&(x[2] - x[0])).norm() / 2.0;
        return if beyond < 0.0 { area } else { 0.0 };
    }
    let half = [0, 1, 2].map(|k| (x[k] + x[(k + 1) % 3]) / 2.0);
    let at_corners = (0..3).map(|k| near(&[x[k], half[k], half[(k + 2) % 3]], depth - 1, distance));
    at_corners.sum::<f64>() + near(&half, depth - 1, distance)
}

/// Area of the pad nearer than 20 µm to what presses.
fn patch(press: &Press, distance: Distance) -> f64 {
    let pose = press.world.rigid_pose(press.rigid);
    press.area_near(0, 8, |p| distance(&pose.inverse_point(p)))
}

const TRIANGLE: f64 = 2e-3;

fn table(name: &str) {
    let all = shapes();
    let (_, shape, rotation, lowest, distance) = all.iter().find(|s| s.0 == name).expect("a shape");
    let mut press = Press::with_shape(pad(TRIANGLE, 0.0), shape, *rotation, *lowest);
    for load in [0.1, 2.0, 20.0] {
        press.settle(load);
        press.is_told(name, load, patch(&press, *distance), TRIANGLE * TRIANGLE);
    }
}

#[test]
fn under_a_ball() {
    table("ball");
}

#[test]
fn under_a_plate() {
    table("plate");
}

#[test]
fn under_a_cylinder() {
    table("cylinder");
}

#[test]
fn under_an_edge() {
    table("edge");
}

/// Distance of `p` to a triangle.
fn to_triangle(p: &Vec3, [a, b, c]: [Vec3; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let is_within =
        [(a, b), (b, c), (c, a)].iter().all(|(s, e)| normal.cross(&(e - s)).dot(&(p - s)) >= 0.0);
    if is_within {
        return (normal.dot(&(p - a)) / normal.norm()).abs();
    }
    let to_edge = |s: Vec3, e: Vec3| {
        let t = ((p - s).dot(&(e - s)) / (e - s).norm_squared()).clamp(0.0, 1.0);
        (p - s - (e - s) * t).norm()
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

/// Distance of `p` to a surface, where that is below `reach`.
fn to_surface(p: &Vec3, triangles: &[([Vec3; 3], Vec3, f64)], reach: f64) -> f64 {
    let within =
        triangles.iter().filter(|(_, middle, radius)| (p - middle).norm() < radius + reach);
    within.map(|(t, _, _)| to_triangle(p, *t)).fold(reach, f64::min)
}

/// Half of what touches on either side, of pads that bulge as fingertips do, with triangles of
/// these sizes.
fn pad_on_pad(triangles: [f64; 2], loads: &[f64]) {
    let mut press = Press::with_pads(triangles.map(|triangle| pad(triangle, 0.25)));
    let triangle = triangles[0].max(triangles[1]);
    for &load in loads {
        press.settle(load);
        let patch = [(0, 1), (1, 0)].map(|(own, other)| {
            let x = press.world.collision_vertices(other);
            let triangles = &press.world.desc().softs[other as usize].flesh.collision.triangles;
            let with_ball = |t: &[u32; 3]| {
                let t = t.map(|v| x[v as usize]);
                let middle = (t[0] + t[1] + t[2]) / 3.0;
                (t, middle, t.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max))
            };
            let triangles: Vec<_> = triangles.iter().map(with_ball).collect();
            // No piece is larger than a triangle.
            0.5 * press.area_near(own, 5, |p| to_surface(p, &triangles, 2.0 * triangle))
        });
        press.is_told("pad", load, patch.iter().sum(), triangle * triangle);
    }
}

#[test]
fn between_pads() {
    pad_on_pad([2e-3; 2], &[0.1, 2.0, 20.0]);
}

#[test]
fn between_finer_pads() {
    pad_on_pad([1.6e-3; 2], &[2.0]);
}

#[test]
fn between_a_coarse_and_a_fine_pad() {
    pad_on_pad([4e-3, 1.6e-3], &[2.0, 10.0]);
    pad_on_pad([1.6e-3, 4e-3], &[2.0]);
}

/// Hertz: two bodies of radius R and modulus E that F presses together touch over a circle with
/// `a³ = 3 F R (1 - ν²)/(4 E)`. The pads are 8 mm high and held below, which makes them firmer than
/// that, and their triangles are not small beside a: of the area between a half and all is told.
#[test]
fn pads_touch_over_the_area_of_hertz() {
    let (bulge, firmness) = (0.25, 3e5 / (1.0 - FLESH.poisson * FLESH.poisson));
    let radius = HALF * HALF / (bulge * HEIGHT);
    let mut press = Press::with_pads([TRIANGLE; 2].map(|triangle| pad(triangle, bulge)));
    for load in [0.1, 0.3, 1.0] {
        press.settle(load);
        let mut readout = ContactReadout::new(&press.world);
        readout.read(&press.world);
        let area = readout.body(&press.world, BodyId::Soft(0)).area;
        let hertz = std::f64::consts::PI * (0.75 * load * radius / firmness).powf(2.0 / 3.0);
        println!("{load} N: {area:e} m2, by Hertz {hertz:e}");
        assert!(area > 0.5 * hertz && area < hertz, "{load} N: {area} of {hertz} m2");
    }
}

/// With ever finer triangles the area under a ball comes to rest, and is that of the patch.
#[test]
fn areas_converge() {
    let (radius, distance): (f64, Distance) = (0.06, |p| p.norm() - 0.06);
    let shape = Shape::Sphere { radius };
    let told = [4e-3, 2e-3, 4e-3 / 3.0].map(|triangle| {
        let mut press = Press::with_shape(pad(triangle, 0.0), &shape, Quat::identity(), radius);
        press.settle(2.0);
        let mut readout = ContactReadout::new(&press.world);
        readout.read(&press.world);
        let area = readout.body(&press.world, BodyId::Soft(0)).area;
        let patch = patch(&press, distance);
        (area, area / patch - 1.0)
    });
    let [coarse, middle, fine] = told;
    assert!((fine.0 - middle.0).abs() < 0.5 * (middle.0 - coarse.0).abs(), "{told:?}");
    assert!(fine.1.abs() < 0.05, "{told:?}");
}
