//! Contacts are where surfaces meet: the gap of each is the distance from its point to the other
//! surface, found here without the code that made it.

use super::tests::{Scene, boxed, cube, moved};
use super::triangle::closest_on_triangle;
use super::triangle::tests::Random;
use super::*;
use crate::math::{Pose, Quat, Vec3};
use crate::model::Motion;

/// The bound of the gap's error: 1 % of an edge of 5 mm.
const WITHIN: f64 = 5e-5;

/// Distance from `p` to a triangle mesh by going through all triangles; unsigned.
fn to_mesh(p: &Vec3, points: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let of = |t: &[u32; 3]| {
        closest_on_triangle(p, &t.map(|v| points[v as usize])).distance_squared.sqrt()
    };
    triangles.iter().map(of).fold(f64::INFINITY, f64::min)
}

/// Signed distance to a shape from its geometry: to the middle of a ball, a line of balls, or the
/// nearest of many points on the faces of a box.
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
        _ => unreachable!("not tried here"),
    }
}

fn turn(random: &mut Random) -> Quat {
    Quat::from_scaled_axis(random.vector(2.0))
}

/// Shapes of 1.5 to 60 mm at random places on and in a soft cube: every contact is true.
#[test]
fn gaps_of_soft_surfaces_with_shapes_are_their_distances() {
    let mut random = Random::new(5);
    let shapes = [
        Shape::Sphere { radius: 0.06 },
        Shape::Sphere { radius: 0.0015 },
        Shape::Capsule { radius: 0.004, half_length: 0.03 },
        boxed(0.01),
        Shape::Cuboid { half: Vec3::new(0.002, 0.015, 0.04) },
        Shape::Cylinder { radius: 0.012, half_length: 0.02 },
    ];
    let mut seen = [0; 6];
    for (shape, seen) in shapes.iter().zip(&mut seen) {
        for _ in 0..120 {
            let (points, triangles) = cube(0.04, 8);
            let rotation = turn(&mut random);
            // Deepest 0.1 mm to shallowest 0.9 mm over some face.
            let along = random.vector(1.0).normalize();
            let reach = |p: &Vec3| points.iter().map(|q| p.dot(q)).fold(f64::MIN, f64::max);
            let mut away = reach(&along);
            let pose = |away: f64| Pose::new(along * away + Vec3::repeat(0.001), rotation);
            let clearance = |away: f64| {
                let nearest = |p: &Vec3| to_shape(&pose(away).inverse_point(p), shape);
                points.iter().map(nearest).fold(f64::INFINITY, f64::min)
            };
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
                let other = if soft < 1e-9 { rigid } else { soft.copysign(c.gap) };
                assert!((other - c.gap).abs() < WITHIN, "{shape:?}: gap {} at {other}", c.gap);
                *seen += 1;
            }
        }
    }
    assert!(seen.iter().all(|n| *n > 30), "too few contacts: {seen:?}");
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
                    // A vertex may be beside a wall of the box, or nearer to it than below its face.
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
