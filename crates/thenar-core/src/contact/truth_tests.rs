//! Contacts are where surfaces meet: the gap of each is the distance from its point to the other
//! surface, found here without the code that made it.

use super::pair_tests::{mesh_ball, mesh_cube};
use super::tests::{Scene, boxed, cube, moved};
use super::triangle::closest_on_triangle;
use super::*;
use crate::math::{Pose, Quat, Vec3};
use crate::model::Motion;
use crate::random::Random;
use std::sync::Arc;

/// The bound of the gap's error: 1 % of the mean edge where squares of 5 mm are halved.
pub(super) const WITHIN: f64 = 5e-5 * (2.0 + std::f64::consts::SQRT_2) / 3.0;

/// Distance from `p` to a triangle mesh by going through all triangles; unsigned.
pub(super) fn to_mesh(p: &Vec3, points: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let of = |t: &[u32; 3]| {
        closest_on_triangle(p, &t.map(|v| points[v as usize])).distance_squared.sqrt()
    };
    triangles.iter().map(of).fold(f64::INFINITY, f64::min)
}

/// Signed distance to a shape from its geometry: to the middle of a ball, a line of balls, the
/// nearest of many points on the faces of a box, the outline of what is turned about an axis, the
/// triangles of a convex mesh.
fn to_shape(p_S: &Vec3, shape: &Shape) -> f64 {
    match shape {
        Shape::Sphere { radius } => p_S.norm() - radius,
        Shape::Capsule { radius, half_length } => {
            let at = |k: u32| Vec3::y() * (half_length * (f64::from(k) / 200.0 - 1.0));
            (0..=400).map(|k| (p_S - at(k)).norm()).fold(f64::INFINITY, f64::min) - radius
        }
        Shape::Cuboid { half } => {
            let mut least = f64::INFINITY;
            for axis in 0..3 {
                for side in [-1.0, 1.0] {
                    let mut foot = p_S.sup(&-half).inf(half);
                    foot[axis] = side * half[axis];
                    least = least.min((p_S - foot).norm());
                }
            }
            let inside = (0..3).all(|k| p_S[k].abs() < half[k]);
            if inside { -least } else { least }
        }
        Shape::Cylinder { radius, half_length } => {
            let (away, beyond) = (p_S.xz().norm() - radius, p_S.y.abs() - half_length);
            let outside = away.max(0.0).hypot(beyond.max(0.0));
            if outside > 0.0 { outside } else { away.max(beyond) }
        }
        Shape::Cone { radius, height } => {
            let low = -0.25 * height;
            let [rim, apex] = [[*radius, low], [0.0, low + height]];
            let q = [p_S.xz().norm(), p_S.y];
            let away = to_segment(q, [0.0, low], rim).min(to_segment(q, rim, apex));
            let is_inside = q[1] > low && q[0] < radius * (apex[1] - q[1]) / height;
            if is_inside { -away } else { away }
        }
        Shape::Ellipsoid { half } => to_ellipsoid(p_S, half),
        Shape::HalfSpace => p_S.y,
        Shape::Compound(parts) => {
            let to_part =
                |part: &PlacedShape| to_shape(&part.pose_SP.inverse_point(p_S), &part.shape);
            parts.iter().map(to_part).fold(f64::INFINITY, f64::min)
        }
        Shape::Mesh(mesh) => {
            let is_behind = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|v| mesh.points[v as usize]);
                (b - a).cross(&(c - a)).dot(&(p_S - a)) < 0.0
            };
            let away = to_mesh(p_S, &mesh.points, &mesh.triangles);
            if mesh.triangles.iter().all(is_behind) { -away } else { away }
        }
    }
}

fn to_segment(q: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (u, w) = ([b[0] - a[0], b[1] - a[1]], [q[0] - a[0], q[1] - a[1]]);
    let along = ((u[0] * w[0] + u[1] * w[1]) / (u[0] * u[0] + u[1] * u[1])).clamp(0.0, 1.0);
    (w[0] - along * u[0]).hypot(w[1] - along * u[1])
}

/// By search among the points of an ellipsoid, ever nearer to the best: from the direction of p and
/// from the poles on its side, as deep inside more than one place is nearer than all around it.
fn to_ellipsoid(p: &Vec3, half: &Vec3) -> f64 {
    let away = |s: &Vec3| (p - half.component_mul(&s.normalize())).norm();
    let search = |mut best: Vec3| {
        let mut width = 0.5;
        while width > 1e-6 {
            let (a, b) = Quat::rotation_between(&Vec3::y(), &best)
                .map_or((Vec3::x(), Vec3::z()), |q| (q * Vec3::x(), q * Vec3::z()));
            let around = (0..64).map(|k| (f64::from(k % 8) - 3.5, f64::from(k / 8) - 3.5));
            let tried = around.map(|(i, j)| best + (a * i + b * j) * (width / 3.5));
            let nearest = tried.min_by(|s, t| away(s).total_cmp(&away(t))).expect("64 directions");
            match away(&nearest) < away(&best) {
                true => best = nearest.normalize(),
                false => width *= 0.5,
            }
        }
        away(&best)
    };
    let poles = [Vec3::x(), Vec3::y(), Vec3::z()].map(|pole| pole * pole.dot(p).signum());
    let starts = [p.component_div(half).normalize()].into_iter().chain(poles);
    let least = starts.map(search).fold(f64::INFINITY, f64::min);
    if p.component_div(half).norm() < 1.0 { -least } else { least }
}

/// A rod with a ball and a box at its ends.
fn dumbbell() -> Shape {
    let part = |shape, pose_SP| PlacedShape { shape, pose_SP };
    let lying = Quat::from_scaled_axis(Vec3::z() * std::f64::consts::FRAC_PI_2);
    let rod = Shape::Cylinder { radius: 0.004, half_length: 0.015 };
    Shape::Compound(Arc::new(vec![
        part(rod, Pose::new(Vec3::zeros(), lying)),
        part(Shape::Sphere { radius: 0.01 }, Pose::translation(0.015, 0.0, 0.0)),
        part(boxed(0.007), Pose::translation(-0.017, 0.0, 0.0)),
    ]))
}

pub(super) fn turn(random: &mut Random) -> Quat {
    Quat::from_scaled_axis(random.vector(2.0))
}

/// Shapes at random places on and in a soft cube: every contact is true.
fn contacts_are_true(seed: u64, shapes: &[Shape]) {
    let mut random = Random::new(seed);
    for shape in shapes {
        let mut seen = 0;
        for _ in 0..120 {
            let (points, triangles) = cube(0.04, 8);
            let rotation = turn(&mut random);
            // Deepest 0.6 mm to shallowest 0.4 mm over some face.
            let along = random.vector(1.0).normalize();
            let reach = |p: &Vec3| points.iter().map(|q| p.dot(q)).fold(f64::MIN, f64::max);
            let pose = |away: f64| {
                // A half-space looks at the cube.
                let facing = Quat::rotation_between(&Vec3::y(), &-along);
                let rotation = match shape {
                    Shape::HalfSpace => facing.expect("not opposite"),
                    _ => rotation,
                };
                Pose::new(along * away + Vec3::repeat(0.001), rotation)
            };
            // Only the choice of places asks the shape itself.
            let clearance = |away: f64| {
                let nearest = |p: &Vec3| shape.distance(&pose(away).inverse_point(p)).value;
                points.iter().map(nearest).fold(f64::INFINITY, f64::min)
            };
            let mut away = if *shape == Shape::HalfSpace { 0.0 } else { reach(&along) };
            while clearance(away) < 0.0 {
                away += 0.0005;
            }
            away += 1e-3 * (random.unit() - 0.6);
            let mut scene = Scene::new();
            scene.rigid(Motion::Prescribed, shape.clone(), pose(away));
            scene.soft((points.clone(), triangles.clone()));
            for c in scene.find(1e-3) {
                let p = c.position_W;
                let rigid = to_shape(&pose(away).inverse_point(&p), shape);
                let soft = to_mesh(&p, &points, &triangles);
                // The point lies on one of the surfaces, its distance to the other is the gap.
                let is_inside = p.amax() < 0.02;
                let other = match soft < 1e-9 {
                    true => rigid,
                    false => {
                        if is_inside {
                            -soft
                        } else {
                            soft
                        }
                    }
                };
                assert!((other - c.gap).abs() < WITHIN, "{shape:?}: gap {} at {other}", c.gap);
                seen += 1;
            }
        }
        assert!(seen > 30, "{shape:?}: {seen} contacts");
    }
}

#[test]
fn gaps_of_soft_surfaces_with_shapes_are_their_distances() {
    contacts_are_true(
        5,
        &[
            Shape::Sphere { radius: 0.06 },
            Shape::Sphere { radius: 0.0015 },
            Shape::Capsule { radius: 0.004, half_length: 0.03 },
            boxed(0.01),
            Shape::Cuboid { half: Vec3::new(0.002, 0.015, 0.04) },
            Shape::Cylinder { radius: 0.012, half_length: 0.02 },
            Shape::HalfSpace,
        ],
    );
}

#[test]
fn gaps_of_soft_surfaces_with_tapered_shapes_are_their_distances() {
    contacts_are_true(
        11,
        &[
            Shape::Cone { radius: 0.015, height: 0.03 },
            Shape::Cone { radius: 0.03, height: 0.01 },
            Shape::Ellipsoid { half: Vec3::new(0.02, 0.012, 0.015) },
            Shape::Ellipsoid { half: Vec3::new(0.003, 0.03, 0.008) },
        ],
    );
}

#[test]
fn gaps_of_soft_surfaces_with_composed_shapes_are_their_distances() {
    contacts_are_true(
        12,
        &[dumbbell(), mesh_cube(0.012, 1), mesh_cube(0.015, 5), mesh_ball(0.015, 8)],
    );
}

/// A box that lies on a soft cube, at many places and sizes of triangles: no contact has another
/// normal than the face, none is deeper than the box (a row of them threw boxes off).
#[test]
fn a_box_on_a_level_face_has_no_sideways_contacts() {
    let mut random = Random::new(6);
    for n in [1, 2, 5, 10] {
        for half in [0.005, 0.01, 0.02] {
            for _ in 0..20 {
                let sunk = 5e-5 * random.unit();
                let mut place = random.vector(0.049 - half * 2.0_f64.sqrt());
                place.y = 0.05 + half - sunk;
                let spin = Quat::from_axis_angle(&Vec3::y_axis(), 3.0 * random.unit());
                let mut scene = Scene::new();
                scene.rigid(Motion::Dynamic, boxed(half), Pose::new(place, spin));
                let (mut points, triangles) = cube(0.1, n);
                moved(&mut points, Vec3::zeros());
                scene.soft((points, triangles));
                let contacts = scene.find(1e-3);
                let corners = contacts.iter().filter(|c| c.gap < 0.0).count();
                assert!(corners >= 4, "{corners} places hold it");
                for c in contacts {
                    assert!(c.gap > -sunk - 1e-12, "gap {} at {sunk}", c.gap);
                    // A vertex may be beside a wall of the box, or nearer to it than below its
                    // face.
                    let level = (c.normal_W + Vec3::y()).norm() < 1e-6;
                    assert!(
                        level || c.gap > 0.0 || -c.gap < sunk,
                        "normal {}, gap {}",
                        c.normal_W,
                        c.gap
                    );
                }
            }
        }
    }
}

/// Soft against soft, near and through each other's faces.
#[test]
fn gaps_between_soft_surfaces_are_their_distances() {
    let mut random = Random::new(7);
    let mut seen = 0;
    for _ in 0..150 {
        let (mut a, triangles) = cube(0.04, 6);
        let (mut b, _) = cube(0.04, 6);
        let spin = turn(&mut random);
        b.iter_mut().for_each(|p| *p = spin * *p);
        let along = random.vector(1.0).normalize();
        moved(&mut b, along * (0.035 + 0.03 * random.unit()));
        moved(&mut a, Vec3::zeros());
        let mut scene = Scene::new();
        scene.soft((a.clone(), triangles.clone()));
        scene.soft((b.clone(), triangles.clone()));
        for c in scene.find(1e-3) {
            let (Site::Soft(p), Site::Soft(q)) = (c.a, c.b) else { panic!("both are soft") };
            if p.vertices[0] != p.vertices[1] {
                continue; // Edges that cross are tried with their ridges.
            }
            let own = if p.soft == 0 { &a } else { &b };
            let other = if p.soft == 0 { &b } else { &a };
            assert_eq!(c.position_W, own[p.vertices[0] as usize]);
            let to_point = (q.interpolate(other) - c.position_W).norm();
            let nearest = to_mesh(&c.position_W, other, &triangles);
            assert!((to_point - c.gap.abs()).abs() < WITHIN, "{to_point} {}", c.gap);
            // What has got in leaves by a face that it looks at, which may not be the nearest.
            assert!(c.gap < -6e-5 || (nearest - c.gap.abs()).abs() < WITHIN, "{nearest} {}", c.gap);
            seen += 1;
        }
    }
    assert!(seen > 300, "{seen} contacts");
}
