//! Goal: every contact of every pair of rigid shapes says how far the surfaces are apart. Method:
//! random placements; the distance is found by projecting to and fro between the two surfaces
//! from many starts, which shares nothing with the detector but the signed distances.

use crate::contact::grid::tests::grid_of;
use crate::contact::tests::{Scene, boxed, cube};
use crate::contact::{Contact, MeshShape, PlacedShape, Shape};
use crate::math::{Pose, Quat, Vec3};
use crate::model::Motion;
use crate::random::Random;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Allowed error of contacts \[m\].
const ALLOWED: f64 = 1e-5;

/// A ball as a mesh of latitudes and longitudes.
pub(super) fn mesh_ball(radius: f64, n: u32) -> Shape {
    let mut points = vec![Vec3::y() * radius];
    for i in 1..n {
        let (s, c) = (PI * f64::from(i) / f64::from(n)).sin_cos();
        for j in 0..2 * n {
            let (sj, cj) = (TAU * f64::from(j) / f64::from(2 * n)).sin_cos();
            points.push(radius * Vec3::new(s * sj, c, s * cj));
        }
    }
    points.push(Vec3::y() * -radius);
    let at = |i: u32, j: u32| 1 + (i - 1) * 2 * n + j % (2 * n);
    let last = points.len() as u32 - 1;
    let mut triangles = Vec::new();
    for j in 0..2 * n {
        triangles.extend([[0, at(1, j), at(1, j + 1)], [at(n - 1, j), last, at(n - 1, j + 1)]]);
        for i in 1..n - 1 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh(points, triangles, &Shape::Sphere { radius }, 2.0 * radius)
}

fn mesh(points: Vec<Vec3>, triangles: Vec<[u32; 3]>, like: &Shape, reach: f64) -> Shape {
    Shape::Mesh(Arc::new(MeshShape::new(points, triangles, grid_of(like, reach, 17))))
}

pub(super) fn mesh_cube(half: f64, n: u32) -> Shape {
    let (points, triangles) = cube(2.0 * half, n);
    mesh(points, triangles, &boxed(half), 2.0 * half)
}

fn shapes() -> Vec<Shape> {
    let part = |shape, pose_SP| PlacedShape { shape, pose_SP };
    let lying = Quat::from_scaled_axis(Vec3::z() * 0.5 * PI);
    let dumbbell = vec![
        part(
            Shape::Cylinder { radius: 0.004, half_length: 0.015 },
            Pose::new(Vec3::zeros(), lying),
        ),
        part(Shape::Sphere { radius: 0.01 }, Pose::translation(0.015, 0.0, 0.0)),
        part(boxed(0.007), Pose::translation(-0.017, 0.0, 0.0)),
    ];
    vec![
        Shape::Sphere { radius: 0.012 },
        Shape::Capsule { radius: 0.008, half_length: 0.012 },
        Shape::Cuboid { half: Vec3::new(0.01, 0.015, 0.02) },
        Shape::Cylinder { radius: 0.012, half_length: 0.016 },
        Shape::Ellipsoid { half: Vec3::new(0.02, 0.012, 0.015) },
        Shape::Cone { radius: 0.015, height: 0.03 },
        Shape::Compound(Arc::new(dumbbell)),
        mesh_cube(0.012, 1),
        mesh_cube(0.015, 5),
        mesh_ball(0.015, 8),
    ]
}

fn name(shape: &Shape) -> String {
    format!("{shape:?}").chars().take(90).collect()
}

/// A shape at a place.
struct At<'a>(&'a Shape, Pose);

impl At<'_> {
    fn distance(&self, p: &Vec3) -> f64 {
        self.0.distance(&self.1.inverse_point(p)).value
    }

    fn nearest(&self, p: &Vec3) -> Vec3 {
        let d = self.0.distance(&self.1.inverse_point(p));
        p - d.value * self.1.vector(&d.gradient)
    }

    fn outward(&self, p: &Vec3) -> Vec3 {
        self.1.vector(&self.0.distance(&self.1.inverse_point(p)).gradient)
    }
}

/// The distance of two shapes that are apart: to and fro between them from many starts, with the
/// momentum of Nesterov's method, begun anew whenever it leads away.
fn apart(a: &At, b: &At, random: &mut Random) -> (f64, Vec3) {
    let mut starts: Vec<(f64, Vec3)> = (0..12)
        .map(|_| {
            let p = descended(a, b, a.1.position + random.vector(0.03), 20);
            (b.distance(&p).abs(), p)
        })
        .collect();
    starts.sort_by(|x, y| x.0.total_cmp(&y.0));
    let ends = starts[..3].iter().map(|s| descended(a, b, s.1, 250));
    let near = |p: Vec3| (b.distance(&p).abs(), b.outward(&p));
    ends.map(near).min_by(|x, y| x.0.total_cmp(&y.0)).expect("three starts")
}

fn descended(a: &At, b: &At, start: Vec3, rounds: usize) -> Vec3 {
    let (mut p, mut ahead, mut t, mut least) = (a.nearest(&start), start, 1.0_f64, f64::INFINITY);
    for _ in 0..rounds {
        let next = a.nearest(&b.nearest(&ahead));
        let d = b.distance(&next).abs();
        let (t_next, away) = (0.5 * (1.0 + (1.0 + 4.0 * t * t).sqrt()), d > least);
        let momentum = if away { 0.0 } else { (t - 1.0) / t_next };
        ahead = next + momentum * (next - p);
        (p, t, least) = (next, if away { 1.0 } else { t_next }, d);
    }
    p
}

/// Returns the distance of the farther of two shapes at the place where it is least; below zero
/// where they overlap. Found by steps to and fro that shrink.
fn least_common(a: &At, b: &At, random: &mut Random) -> f64 {
    let worth = |p: &Vec3| a.distance(p).max(b.distance(p));
    let (_, p) = [0; 4]
        .map(|_| descended(a, b, a.1.position + random.vector(0.03), 60))
        .map(|p| (worth(&p), p))
        .into_iter()
        .min_by(|x, y| x.0.total_cmp(&y.0))
        .expect("four starts");
    let (mut best, mut p, mut width, mut failed) = (worth(&p), p, 2e-3, 0);
    while width > 1e-6 {
        let q = p + random.vector(width);
        let value = worth(&q);
        if value < best {
            (best, p, failed) = (value, q, 0);
        } else {
            failed += 1;
        }
        if failed == 40 {
            (width, failed) = (0.7 * width, 0);
        }
    }
    best
}

fn contacts(a: &At, b: &At) -> Vec<Contact> {
    let mut scene = Scene::new();
    scene.rigid(Motion::Dynamic, a.0.clone(), a.1);
    scene.rigid(Motion::Prescribed, b.0.clone(), b.1);
    scene.find(1e-3)
}

fn turned(random: &mut Random) -> Quat {
    Quat::from_scaled_axis(random.vector(3.0))
}

/// Moves A until it is about `gap` from B.
fn brought_near<'a>(a: &'a Shape, b: &At, gap: f64, random: &mut Random) -> Option<(At<'a>, f64)> {
    let direction = random.vector(1.0).normalize();
    let mut at = At(a, Pose::new(0.09 * direction, turned(random)));
    for _ in 0..12 {
        let (d, n) = apart(&at, b, random);
        if (d - gap).abs() < 0.1 * gap {
            return Some((at, d));
        }
        at.1.position -= (d - gap) * n;
    }
    None
}

#[test]
fn gaps_are_the_distances_of_the_surfaces() {
    let mut random = Random::new(40);
    let shapes = shapes();
    for a in &shapes {
        for b in &shapes {
            let mut tested = 0;
            for i in 0..4 {
                let gap = [2e-5, 1e-4, 3e-4, 6e-4][i % 4];
                let b = At(b, Pose::new(Vec3::zeros(), turned(&mut random)));
                let Some((a, d)) = brought_near(a, &b, gap, &mut random) else { continue };
                tested += 1;
                let found = contacts(&a, &b);
                let least = found.iter().map(|c| c.gap).fold(f64::INFINITY, f64::min);
                let off = (least - d).abs();
                assert!(off < ALLOWED, "{}\n{}\n{least:e} for {d:e}", name(a.0), name(b.0));
                check(&a, &b, &found);
            }
            assert!(tested >= 2, "{} {}: {tested}", name(a), name(b));
        }
    }
}

/// Shapes that overlap are as deep in each other as their points of contact say.
#[test]
fn overlaps_are_the_depths_of_the_points() {
    let mut random = Random::new(41);
    let shapes = shapes();
    let mut told = 0;
    for a in &shapes {
        for b in &shapes {
            for depth in [2e-5, 1e-4, 5e-4] {
                let b = At(b, Pose::new(Vec3::zeros(), turned(&mut random)));
                let Some((mut a, d)) = brought_near(a, &b, 2e-5, &mut random) else { continue };
                let (_, n) = apart(&a, &b, &mut random);
                a.1.position -= (d + depth) * n;
                let found = contacts(&a, &b);
                let least = found.iter().map(|c| c.gap).fold(f64::INFINITY, f64::min);
                // No less than the ball that fits into the overlap; half of it, where the ball's
                // way out is not the shortest.
                let common = -2.0 * least_common(&a, &b, &mut random);
                // A rim or an edge deeper in a mesh than a hundredth of its shape is led out, and
                // not at once.
                let part = if depth > 5e-5 { 0.05 } else { 0.5 };
                let told_at_least = part * common - ALLOWED;
                // Another way out can be shorter than back along the normal, which is known to a
                // few degrees; and of edges that cross, some are told that are a fifth deeper.
                assert!(
                    least > -1.5 * depth - ALLOWED
                        && (least < -told_at_least.max(0.0) || common < 0.1 * depth),
                    "{}\n{}\n{least:e} for {depth:e}, {common:e}",
                    name(a.0),
                    name(b.0)
                );
                told += u32::from(least < 0.0);
                check(&a, &b, &found);
            }
        }
    }
    assert!(told > 240, "{told} of 300 overlap");
}

/// On a plane the height of the lowest point is known from the shape's own distances.
#[test]
fn heights_over_a_plane_are_exact() {
    let mut random = Random::new(42);
    for shape in &shapes() {
        for _ in 0..20 {
            let pose = Pose::new(Vec3::zeros(), turned(&mut random));
            let up = pose.inverse_vector(&Vec3::y());
            // From far below, the distance is the height of the lowest point to first order in
            // 1/far.
            let far = 1e4;
            let low = far - shape.distance(&(-far * up)).value;
            let gap = 3e-4;
            let a = At(shape, Pose { position: Vec3::y() * (low + gap), ..pose });
            let found = contacts(&a, &At(&Shape::HalfSpace, Pose::identity()));
            let least = found.iter().map(|c| c.gap).fold(f64::INFINITY, f64::min);
            assert!((least - gap).abs() < 1e-6, "{shape:?}: {least:e}");
            for c in &found {
                let on_a = c.position_W + 0.5 * c.gap * c.normal_W;
                assert!(a.distance(&on_a).abs() < 1e-9 && (on_a.y - c.gap).abs() < 1e-12);
            }
        }
    }
}

/// The two points of each contact (of a pair that is not fast) lie on the surfaces, and each is as
/// far from the other body as the contact says.
fn check(a: &At, b: &At, found: &[Contact]) {
    for c in found {
        let half = 0.5 * c.gap * c.normal_W;
        let (on_a, on_b) = (c.position_W + half, c.position_W - half);
        // Of round on sharp in each other the way out is known better than the place on them.
        let slack = if c.gap < 0.0 { ALLOWED - 0.15 * c.gap } else { ALLOWED.max(0.02 * c.gap) };
        let errors = [
            a.distance(&on_a),
            b.distance(&on_b),
            // Of an overlap the gap is that along the normal: a corner that has sunk in has nearer
            // ways out. And of a point of one surface, the nearest of the other may have a nearer
            // one in turn.
            match [b.distance(&on_a) - c.gap, a.distance(&on_b) - c.gap] {
                _ if c.gap < 0.0 => 0.0,
                [x, y] if x.abs() < y.abs() => x,
                [_, y] => y,
            },
        ];
        assert!(
            errors.iter().all(|e| e.abs() < slack),
            "{}\n{}\ngap {:e}, off by {errors:?} at {:?}",
            name(a.0),
            name(b.0),
            c.gap,
            c.position_W
        );
    }
}

/// A box stands on a mesh whose vertices lie exactly below its edges: nothing holds it from the
/// side.
#[test]
fn vertices_under_the_edges_of_a_box_hold_it_from_below_only() {
    let mut random = Random::new(31);
    let support = mesh_cube(0.015, 5);
    for half in [Vec3::new(0.009, 0.003, 0.004), Vec3::new(0.003, 0.003, 0.009)] {
        for _ in 0..200 {
            let shift = random.vector(1e-9) + Vec3::y() * (0.018 - 4e-9);
            let pose = Pose::new(shift, Quat::from_scaled_axis(random.vector(1e-8)));
            let found =
                contacts(&At(&Shape::Cuboid { half }, pose), &At(&support, Pose::identity()));
            assert!(found.len() >= 4);
            for c in found {
                assert!(c.normal_W.y > 0.999, "{half}: normal {}", c.normal_W);
            }
        }
    }
}
