//! Contacts between two soft surfaces, and of one with itself, are where surfaces meet: gaps are
//! found here without the code that made them.

use super::tests::{Scene, cube, moved};
use super::triangle::closest_on_triangle;
use super::truth_tests::to_mesh;
use super::*;
use crate::math::{Quat, Vec3};
use crate::random::Random;
use std::f64::consts::{FRAC_PI_4, TAU};

/// The bound of the gap's error: 1 % of edges of 5 mm, along the tube, and of 10 mm of the cubes.
const WITHIN: f64 = 5e-5;
const WITHIN_OF_CUBES: f64 = 1e-4;

type Mesh = (Vec<Vec3>, Vec<[u32; 3]>);

fn is_vertex(p: &SurfacePoint) -> bool {
    p.vertices[0] == p.vertices[1]
}

/// Start and direction of the edge on which a point lies.
fn edge_of(p: &SurfacePoint, x: &[Vec3]) -> (Vec3, Vec3) {
    let ends: Vec<usize> = (0..3).filter(|&k| p.weights[k] > 0.0).collect();
    let [i, j] = ends[..] else { panic!("not within an edge: {p:?}") };
    let [start, end] = [i, j].map(|k| x[p.vertices[k] as usize]);
    (start, (end - start).normalize())
}

/// Distance of two edges' lines, and the way from B to A along which it is found.
fn between_lines(a: (Vec3, Vec3), b: (Vec3, Vec3)) -> (f64, Vec3) {
    let across = a.1.cross(&b.1).normalize();
    let apart = across.dot(&(a.0 - b.0));
    (apart.abs(), across * apart.signum())
}

/// A contact of two edges: its gap is the distance of their lines along its normal, positive where
/// its points lie apart along it.
fn check_edges(c: &Contact, [p, q]: [&SurfacePoint; 2], [x_p, x_q]: [&[Vec3]; 2]) {
    let (distance, way) = between_lines(edge_of(p, x_p), edge_of(q, x_q));
    assert!((c.gap.abs() - distance).abs() < WITHIN, "gap {} of {distance}", c.gap);
    assert!((c.normal_W - way * c.gap.signum()).norm() < 1e-6 || distance < 1e-9);
    let [a, b] = [p.interpolate(x_p), q.interpolate(x_q)];
    assert!((c.normal_W.dot(&(a - b)) - c.gap).abs() < WITHIN);
    assert!((c.position_W - (a + b) / 2.0).norm() < WITHIN);
}

/// Half the edge of the cubes.
const HALF: f64 = 0.02;

/// A cube turned about the point `at` of one of its edges, that lies at the origin and looks along
/// y.
fn edge_up(at: f64, turn: Quat) -> (Mesh, impl Fn(&Vec3) -> Vec3) {
    let (mut points, triangles) = cube(2.0 * HALF, 4);
    let on_edge = Vec3::new(HALF, HALF, at);
    let turned = turn * Quat::from_scaled_axis(Vec3::z() * FRAC_PI_4);
    points.iter_mut().for_each(|p| *p = turned * (*p - on_edge));
    let back = move |p: &Vec3| turned.inverse() * p + on_edge;
    ((points, triangles), back)
}

/// Two cubes whose edges cross, one over the other and turned about all axes: the crossing is found
/// with the distance that the edges were given, and every contact beside it is as far as it says.
#[test]
fn gaps_of_edges_that_cross_are_their_distances() {
    let mut random = Random::new(21);
    let (mut apart, mut deep, mut beside) = (0, 0, 0);
    for _ in 0..300 {
        // Not where lattice points of the edges, 10 mm from each other, stand for them.
        let mut within =
            || 0.01 * ((3.0 * random.unit()).floor() - 1.5 + 0.8 * (random.unit() - 0.5));
        let [at_a, at_b] = [within(), within()];
        let tilt = |random: &mut Random| Quat::from_scaled_axis(random.vector(0.12));
        let yaw = Quat::from_scaled_axis(Vec3::y() * (0.8 + 1.5 * random.unit()));
        let turn_a = tilt(&mut random) * Quat::from_scaled_axis(Vec3::x() * std::f64::consts::PI);
        let turn_b = tilt(&mut random) * yaw;
        let ((mut a, triangles), back_a) = edge_up(at_a, turn_a);
        let ((b, _), back_b) = edge_up(at_b, turn_b);
        let normal = (turn_a * Vec3::z()).cross(&(turn_b * Vec3::z())).normalize();
        let normal = normal * normal.y.signum();
        let gap = 1e-3 * (1.9 * random.unit() - 1.0);
        moved(&mut a, normal * gap);
        let mut scene = Scene::new();
        scene.soft((a.clone(), triangles.clone()));
        scene.soft((b.clone(), triangles.clone()));
        let contacts = scene.find(1e-3);
        let crosses =
            |c: &&Contact| (c.gap - gap).abs() < 1e-9 && (c.normal_W - normal).norm() < 1e-6;
        assert!(contacts.iter().any(|c| crosses(&c)), "{gap} is not among {contacts:#?}");
        for c in &contacts {
            let (Site::Soft(p), Site::Soft(q)) = (&c.a, &c.b) else { panic!("both are soft") };
            let of = |p: &SurfacePoint| if p.soft == 0 { &a } else { &b };
            if is_vertex(p) {
                let local = if q.soft == 0 {
                    back_a(&(c.position_W - normal * gap))
                } else {
                    back_b(&c.position_W)
                };
                let nearest = to_mesh(&c.position_W, of(q), &triangles);
                let signed = if local.amax() < HALF { -nearest } else { nearest };
                assert!((signed - c.gap).abs() < WITHIN_OF_CUBES, "vertex: {} of {signed}", c.gap);
                beside += 1;
                continue;
            }
            check_edges(c, [p, q], [of(p), of(q)]);
            if c.gap > 0.0 {
                // Of two surfaces apart, the point of either is as far from the other.
                for (own, other) in [(p, q), (q, p)] {
                    let away = to_mesh(&own.interpolate(of(own)), of(other), &triangles);
                    assert!((away - c.gap).abs() < WITHIN_OF_CUBES, "edge: {} of {away}", c.gap);
                }
                apart += 1;
            } else {
                deep += 1;
            }
        }
    }
    assert!(apart > 100 && deep > 100, "{apart} apart, {deep} deep, {beside} vertices");
}

/// Along a tube \[m\], around it, and its radius.
const LENGTH: f64 = 0.2;
const AROUND: u32 = 10;
const RINGS: u32 = 39;
const RADIUS: f64 = 0.006;

/// A closed tube along x with rounded ends.
fn tube() -> Mesh {
    let mut points = vec![Vec3::x() * (-0.5 * LENGTH)];
    for i in 1..=RINGS {
        let x = 2.0 * f64::from(i) / f64::from(RINGS + 1) - 1.0;
        for j in 0..AROUND {
            let (s, c) = (TAU * f64::from(j) / f64::from(AROUND)).sin_cos();
            let r = RADIUS * (1.0 - x.powi(8)).sqrt();
            points.push(Vec3::new(0.5 * LENGTH * x, r * c, r * s));
        }
    }
    points.push(Vec3::x() * (0.5 * LENGTH));
    let at = |i: u32, j: u32| 1 + i * AROUND + j % AROUND;
    let last = points.len() as u32 - 1;
    let mut triangles = Vec::new();
    for j in 0..AROUND {
        triangles.push([0, at(0, j + 1), at(0, j)]);
        for i in 0..RINGS - 1 {
            triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
        triangles.push([last, at(RINGS - 1, j), at(RINGS - 1, j + 1)]);
    }
    (points, triangles)
}

/// A tube wound into a coil, at random so far that its ends lie beside each other, above or below:
/// what touches is as far from the far end, by all of that end's triangles, as it says.
#[test]
fn gaps_of_a_surface_with_itself_are_its_distances() {
    let mut random = Random::new(23);
    let (mut vertices, mut inside, mut edges) = (0, 0, 0);
    for _ in 0..60 {
        let (rest, triangles) = tube();
        // More than once around, what lies above each other apart by about two radii.
        let (turns, rise) =
            (1.3 + 0.2 * random.unit(), 2.0 * RADIUS + 1e-3 * (random.unit() - 1.2));
        let radius = LENGTH / (TAU * turns);
        let coiled = |p: &Vec3| {
            let (s, c) = (TAU * turns * p.x / LENGTH).sin_cos();
            let up = rise * (turns * p.x / LENGTH);
            Vec3::new((radius + p.y) * c, up + p.z, (radius + p.y) * s)
        };
        let x: Vec<Vec3> = rest.iter().map(|p| coiled(p) + random.vector(1e-4)).collect();
        let mut scene = Scene::new();
        let soft = scene.soft((rest.clone(), triangles.clone()));
        scene.desc.self_contact.push(soft);
        scene.surfaces[0].0.clone_from(&x);
        for c in scene.find(1e-3) {
            let (Site::Soft(p), Site::Soft(q)) = (&c.a, &c.b) else { panic!("both are soft") };
            let place = p.interpolate(&rest).x;
            let is_far = |t: &&[u32; 3]| {
                t.iter().all(|v| (rest[*v as usize].x - place).abs() > 0.3 * LENGTH)
            };
            let far: Vec<[u32; 3]> = triangles.iter().filter(is_far).copied().collect();
            if !is_vertex(p) {
                check_edges(&c, [p, q], [&x, &x]);
                edges += 1;
                continue;
            }
            assert_eq!(c.position_W, x[p.vertices[0] as usize]);
            let nearest = to_mesh(&c.position_W, &x, &far);
            assert!((nearest - c.gap.abs()).abs() < WITHIN, "{} of {nearest}", c.gap);
            vertices += 1;
            // Behind the nearest of these triangles is inside.
            let to = |t: &[u32; 3]| {
                closest_on_triangle(&c.position_W, &t.map(|v| x[v as usize])).distance_squared
            };
            let of = far.iter().min_by(|s, t| to(s).total_cmp(&to(t))).expect("a far end");
            let [i, j, k] = of.map(|v| x[v as usize]);
            let height = (j - i).cross(&(k - i)).normalize().dot(&(c.position_W - i));
            if (height.abs() - nearest).abs() < 1e-12 {
                assert!((height - c.gap).abs() < WITHIN, "{} at a height of {height}", c.gap);
            }
            inside += usize::from(c.gap < 0.0);
        }
    }
    assert!(vertices > 100 && inside > 30 && edges > 30, "{vertices} {inside} {edges}");
}
