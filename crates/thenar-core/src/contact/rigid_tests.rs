//! Contacts between rigid shapes, worked out by hand or against brute force.

use crate::contact::grid::tests::grid_of;
use crate::contact::tests::{Scene, boxed, cube};
use crate::contact::{Contact, MeshShape, Shape};
use crate::math::{Pose, Quat, Vec3};
use crate::model::Motion;
use crate::random::Random;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::sync::Arc;

/// Contacts of `a` (moving at `velocity_W`) against a fixed `b`; normals point to `a`.
fn between(a: (&Shape, Pose), b: (&Shape, Pose), velocity_W: Vec3, h: f64) -> Vec<Contact> {
    let mut scene = Scene::new();
    scene.rigid(Motion::Dynamic, a.0.clone(), a.1);
    scene.rigid(Motion::Prescribed, b.0.clone(), b.1);
    scene.places[0].velocity_W = velocity_W;
    scene.find(h)
}

fn at_rest(a: (&Shape, Pose), b: (&Shape, Pose)) -> Vec<Contact> {
    between(a, b, Vec3::zeros(), 1e-3)
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z)
}

/// A cube of half edge `half` as a mesh with a grid of exact distances.
fn mesh_cube(half: f64) -> Shape {
    let (points, triangles) = cube(2.0 * half, 4);
    // Grid planes coincide with the faces, so that the trilinear field is exact near them.
    let grid = grid_of(&boxed(half), 2.0 * half, 33);
    Shape::Mesh(Arc::new(MeshShape::new(points, triangles, grid)))
}

/// Asserts `count` contacts, all with this gap \[m\] and this normal, world.
fn check(contacts: &[Contact], count: usize, gap: f64, normal: Vec3, tolerance: f64) {
    assert_eq!(contacts.len(), count, "{contacts:#?}");
    for c in contacts {
        assert!((c.gap - gap).abs() < tolerance, "gap {} for {gap}", c.gap);
        assert!((c.normal_W - normal).norm() < 1e-6 + tolerance, "normal {}", c.normal_W);
    }
}

#[test]
fn equal_boxes_stacked_exactly_touch_at_four_corners() {
    for gap in [-1e-4, 0.0, 5e-4] {
        let upper = at(10.0, 0.2 + gap, -10.0);
        let contacts = at_rest((&boxed(0.1), upper), (&boxed(0.1), at(10.0, 0.0, -10.0)));
        check(&contacts, 4, gap, Vec3::y(), 1e-14);
        let mut corners: Vec<_> = contacts
            .iter()
            .map(|c| (c.position_W - upper.position).map(|x| (x * 1e6).round()))
            .collect();
        corners.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.z.total_cmp(&b.z)));
        let expected = [(-1e5, -1e5), (-1e5, 1e5), (1e5, -1e5), (1e5, 1e5)];
        assert!(corners.iter().zip(expected).all(|(c, e)| (c.x, c.z) == e), "{corners:?}");
        let middle = 0.1 + 0.5 * gap;
        assert!(contacts.iter().all(|c| (c.position_W.y - middle).abs() < 1e-14));
    }
}

/// Whatever tiny turns and shifts round-off brings, the manifold stays the same four points.
#[test]
fn stacked_boxes_are_steady_under_round_off() {
    let mut random = Random::new(21);
    let keys = |contacts: &[Contact]| contacts.iter().map(|c| c.key).collect::<Vec<_>>();
    let first = keys(&at_rest((&boxed(0.1), at(0.0, 0.2, 0.0)), (&boxed(0.1), at(0.0, 0.0, 0.0))));
    for _ in 0..100 {
        let turn = Quat::from_scaled_axis(random.vector(1e-13));
        let upper = Pose::new(Vec3::new(0.0, 0.2, 0.0) + random.vector(1e-13), turn);
        let contacts = at_rest((&boxed(0.1), upper), (&boxed(0.1), Pose::identity()));
        check(&contacts, 4, 0.0, Vec3::y(), 1e-12);
        assert_eq!(keys(&contacts), first);
    }
}

#[test]
fn shifted_and_turned_boxes_touch_over_their_common_area() {
    let on = |pose: Pose| at_rest((&boxed(0.1), pose), (&boxed(0.1), Pose::identity()));
    let shifted = on(at(0.15, 0.2, 0.05));
    check(&shifted, 4, 0.0, Vec3::y(), 1e-14);
    for c in &shifted {
        let (x, z) = (c.position_W.x, c.position_W.z);
        assert!([0.05, 0.1].iter().any(|e| (x - e).abs() < 1e-12), "x {x}");
        assert!([-0.05, 0.1].iter().any(|e| (z - e).abs() < 1e-12), "z {z}");
    }
    // Turned by 45° the common area is a regular octagon, with corners at ±0.1, ±0.1 tan 22.5°.
    let turned =
        on(Pose::new(Vec3::new(0.0, 0.2, 0.0), Quat::from_axis_angle(&Vec3::y_axis(), FRAC_PI_4)));
    check(&turned, 8, 0.0, Vec3::y(), 1e-12);
    for c in &turned {
        let mut sides = [c.position_W.x.abs(), c.position_W.z.abs()];
        sides.sort_by(f64::total_cmp);
        assert!((sides[1] - 0.1).abs() < 1e-9);
        assert!((sides[0] - 0.1 * (FRAC_PI_4 / 2.0).tan()).abs() < 1e-9);
    }
    assert!(on(at(0.21, 0.2, 0.0)).is_empty(), "beside, not above");
}

#[test]
fn crossed_edges_touch_at_one_point() {
    // Lower edge along z at the top, upper edge along x at the bottom.
    let lower = Quat::from_axis_angle(&Vec3::z_axis(), FRAC_PI_4);
    let upper = Quat::from_axis_angle(&Vec3::x_axis(), FRAC_PI_4);
    let reach = 0.1 * 2.0_f64.sqrt();
    for gap in [-2e-4, 3e-4] {
        let contacts = at_rest(
            (&boxed(0.1), Pose::new(Vec3::new(0.02, 2.0 * reach + gap, -0.03), upper)),
            (&boxed(0.1), Pose::new(Vec3::zeros(), lower)),
        );
        check(&contacts, 1, gap, Vec3::y(), 1e-12);
        let expected = Vec3::new(0.0, reach + 0.5 * gap, -0.03);
        assert!((contacts[0].position_W - expected).norm() < 1e-12);
    }
}

#[test]
fn a_corner_stands_on_a_face() {
    let down = Quat::rotation_between(&Vec3::repeat(1.0), &-Vec3::y()).expect("not opposite");
    let height = 0.01 * 3.0_f64.sqrt();
    for gap in [-3e-4, 4e-4] {
        let pose = Pose::new(Vec3::new(0.03, 0.1 + height + gap, 0.02), down);
        let contacts = at_rest((&boxed(0.01), pose), (&boxed(0.1), Pose::identity()));
        let deepest = contacts.iter().min_by(|a, b| a.gap.total_cmp(&b.gap)).expect("touches");
        assert!((deepest.gap - gap).abs() < 1e-12 && deepest.normal_W == Vec3::y());
        let expected = Vec3::new(0.03, 0.1 + 0.5 * gap, 0.02);
        assert!((deepest.position_W - expected).norm() < 1e-12);
    }
}

/// The depth along the normal is the least over all directions (sampled), within the handicap
/// of edges; moving the upper box out by it separates the two.
#[test]
fn overlapping_boxes_part_along_the_shortest_way() {
    let mut random = Random::new(8);
    let mut overlapping = 0;
    let directions: Vec<Vec3> = (0..4000).map(|_| random.vector(1.0).normalize()).collect();
    for _ in 0..200 {
        let half = Vec3::new(0.06, 0.1, 0.08);
        let shape = Shape::Cuboid { half };
        let pose = |random: &mut Random, reach: f64| {
            Pose::new(random.vector(reach), Quat::from_scaled_axis(random.vector(2.0)))
        };
        let (a, b) = (pose(&mut random, 0.12), pose(&mut random, 0.05));
        let overlap = |a: &Pose, n: &Vec3| {
            let extent = |p: &Pose| half.dot(&p.inverse_vector(n).abs());
            extent(a) + extent(&b) - (a.position - b.position).dot(n)
        };
        let least =
            |a: &Pose| directions.iter().map(|n| overlap(a, n)).fold(f64::INFINITY, f64::min);
        let contacts = at_rest((&shape, a), (&shape, b));
        let depth = least(&a);
        // Between the sampled directions the overlap may be less by some millimetres.
        if depth < 1e-2 {
            continue;
        }
        overlapping += 1;
        assert!(!contacts.is_empty(), "overlap {depth} without contact");
        let n = contacts[0].normal_W;
        assert!(contacts.iter().all(|c| c.normal_W == n));
        let along = overlap(&a, &n);
        assert!(along < depth + 0.011 * 0.06, "{along} along the normal, {depth} at best");
        let deepest = contacts.iter().map(|c| -c.gap).fold(0.0, f64::max);
        assert!(deepest <= along + 1e-12 && deepest > 0.0);
    }
    assert!(overlapping > 50, "{overlapping}");
}

#[test]
fn spheres_touch_everything_at_one_point() {
    let sphere = Shape::Sphere { radius: 0.02 };
    let gap = 4e-4;
    let lying = Quat::from_axis_angle(&Vec3::z_axis(), FRAC_PI_2);
    let capsule = Shape::Capsule { radius: 0.03, half_length: 0.05 };
    let mesh = mesh_cube(0.05);
    let others = [
        (Shape::HalfSpace, Pose::identity(), 0.0, 1e-14),
        (boxed(0.05), Pose::identity(), 0.05, 1e-14),
        (sphere.clone(), Pose::identity(), 0.02, 1e-14),
        (capsule, Pose::new(Vec3::zeros(), lying), 0.03, 1e-14),
        (mesh, Pose::identity(), 0.05, 1e-7),
    ];
    for (other, pose, top, tolerance) in others {
        let place = at(0.01, top + 0.02 + gap, 0.0);
        let round_below = matches!(other, Shape::Sphere { .. });
        let place = if round_below { at(0.0, top + 0.02 + gap, 0.0) } else { place };
        let contacts = at_rest((&sphere, place), (&other, pose));
        let deepest = contacts.iter().min_by(|a, b| a.gap.total_cmp(&b.gap)).expect("near");
        check(&[*deepest], 1, gap, Vec3::y(), tolerance);
        assert!((deepest.position_W.y - (top + 0.5 * gap)).abs() < 1e-7);
        if !matches!(other, Shape::Mesh(_)) {
            assert_eq!(contacts.len(), 1, "{other:?}");
        }
    }
}

#[test]
fn a_lying_capsule_rests_on_two_points() {
    let lying = Quat::from_axis_angle(&Vec3::z_axis(), FRAC_PI_2);
    let capsule = Shape::Capsule { radius: 0.01, half_length: 0.06 };
    let gap = -2e-4;
    let on = |shape: &Shape, top: f64| {
        at_rest(
            (&capsule, Pose::new(Vec3::new(0.0, top + 0.01 + gap, 0.0), lying)),
            (shape, Pose::identity()),
        )
    };
    let ends = |contacts: &[Contact]| {
        let x = contacts.iter().map(|c| c.position_W.x);
        (x.clone().fold(f64::INFINITY, f64::min), x.fold(f64::NEG_INFINITY, f64::max))
    };
    let plane = on(&Shape::HalfSpace, 0.0);
    check(&plane, 2, gap, Vec3::y(), 1e-14);
    assert!((ends(&plane).0 + 0.06).abs() < 1e-12 && (ends(&plane).1 - 0.06).abs() < 1e-12);
    // On a box shorter than itself it rests on the rim of the box.
    let short = on(&boxed(0.04), 0.04);
    check(&short, short.len(), gap, Vec3::y(), 1e-9);
    assert!((ends(&short).0 + 0.04).abs() < 1e-9 && (ends(&short).1 - 0.04).abs() < 1e-9);
    // On an equal parallel capsule, at both ends; across one, at the crossing.
    let parallel = at_rest(
        (&capsule, Pose::new(Vec3::new(0.03, 0.02 + gap, 0.0), lying)),
        (&capsule, Pose::new(Vec3::zeros(), lying)),
    );
    check(&parallel, parallel.len(), gap, Vec3::y(), 1e-12);
    assert!((ends(&parallel).0 + 0.03).abs() < 1e-12 && (ends(&parallel).1 - 0.06).abs() < 1e-12);
    let across = Quat::from_axis_angle(&Vec3::x_axis(), FRAC_PI_2);
    let crossed = at_rest(
        (&capsule, Pose::new(Vec3::new(0.03, 0.02 + gap, 0.0), lying)),
        (&capsule, Pose::new(Vec3::new(0.02, 0.0, 0.0), across)),
    );
    check(&crossed, 1, gap, Vec3::y(), 1e-9);
    assert!((crossed[0].position_W - Vec3::new(0.02, 0.01 + 0.5 * gap, 0.0)).norm() < 1e-7);
}

#[test]
fn meshes_rest_like_the_shape_they_are() {
    let mesh = mesh_cube(0.05);
    let gap = 2e-4;
    for (other, pose, top) in [
        (Shape::HalfSpace, Pose::identity(), 0.0),
        (boxed(0.1), Pose::identity(), 0.1),
        (mesh_cube(0.1), Pose::identity(), 0.1),
    ] {
        let contacts = at_rest((&mesh, at(0.01, top + 0.05 + gap, 0.0)), (&other, pose));
        check(&contacts, 12, gap, Vec3::y(), 1e-6);
        let bounds = |k: usize| {
            let x = contacts.iter().map(|c| c.position_W[k]);
            (x.clone().fold(f64::INFINITY, f64::min), x.fold(f64::NEG_INFINITY, f64::max))
        };
        assert!((bounds(0).0 + 0.04).abs() < 1e-6 && (bounds(0).1 - 0.06).abs() < 1e-6);
        assert!((bounds(2).0 + 0.05).abs() < 1e-6 && (bounds(2).1 - 0.05).abs() < 1e-6);
    }
}

/// Flat faces a few nanometres over level triangles are held upright wherever their edges cross
/// those of triangles: places are found to less than that.
#[test]
fn what_stands_on_triangles_is_held_upright() {
    let half = 0.03;
    let plate = mesh_cube(half);
    let things = [
        (boxed(0.005), 0.005),
        (Shape::Cylinder { radius: 0.006, half_length: 0.01 }, 0.01),
        (Shape::Cone { radius: 0.014, height: 0.02 }, 0.005),
    ];
    let mut random = Random::new(8);
    for i in 0..200 {
        let gap = 1e-9 * 10.0_f64.powf(3.0 * random.unit());
        let turn = if i % 2 == 0 { 0.0 } else { random.unit() };
        for (shape, below) in &things {
            let place = random.vector(1.0) * 0.015;
            let place = if i % 4 == 0 { Vec3::zeros() } else { Vec3::new(place.x, 0.0, place.z) };
            let pose = Pose::new(
                place + Vec3::y() * (half + below + gap),
                Quat::from_scaled_axis(Vec3::y() * turn),
            );
            let contacts = at_rest((shape, pose), (&plate, Pose::identity()));
            // What lies beside, farther off, holds nothing yet.
            let near: Vec<_> = contacts.iter().filter(|c| c.gap < 2e-6).collect();
            assert!(near.len() >= 3, "{i}, {shape:?}: {contacts:#?}");
            for c in near {
                let lean = (c.normal_W - Vec3::y()).norm();
                assert!(lean < 2e-4, "{i}, {shape:?} at {gap}: a normal leans by {lean}");
                assert!((c.gap - gap).abs() < 1e-10, "{i}, {shape:?}: {} of {gap} m", c.gap);
            }
        }
    }
}

/// At 5 m/s and 60 Hz each shape meets a 2 mm plate before it crosses, and flies past one that is
/// beside its way.
#[test]
fn fast_rigid_bodies_are_announced() {
    let plate = Shape::Cuboid { half: Vec3::new(0.2, 0.001, 0.2) };
    let lying = Quat::from_axis_angle(&Vec3::z_axis(), FRAC_PI_2);
    let shapes = [
        (Shape::Sphere { radius: 0.01 }, Quat::identity()),
        (Shape::Capsule { radius: 0.01, half_length: 0.02 }, lying),
        (boxed(0.01), Quat::identity()),
        (mesh_cube(0.01), Quat::identity()),
    ];
    let fall = Vec3::new(1.0, -5.0, 0.5);
    for (shape, rotation) in shapes {
        for i in 0..16 {
            let height = 0.002 + 0.005 * f64::from(i);
            let pose = Pose::new(Vec3::new(0.0, 0.011 + height, 0.0), rotation);
            let contacts = between((&shape, pose), (&plate, Pose::identity()), fall, 1.0 / 60.0);
            let deepest = contacts.iter().map(|c| c.gap).fold(f64::INFINITY, f64::min);
            assert!((deepest - height).abs() < 1e-6, "at {height}: {deepest}");
            assert!(contacts.iter().all(|c| (c.normal_W - Vec3::y()).norm() < 1e-6));
        }
        let pose = Pose::new(Vec3::new(0.25, 0.05, 0.0), rotation);
        assert!(between((&shape, pose), (&plate, Pose::identity()), fall, 1.0 / 60.0).is_empty());
    }
}

/// A capsule thrown at a plate, standing as it likes: both its ends are announced, each with its
/// height over the plate, at a lever through the middle of its ball; an end left out would turn
/// through the plate.
#[test]
fn both_ends_of_a_thrown_capsule_are_announced() {
    let mut random = Random::new(31);
    let (radius, half_length) = (0.003, 0.006);
    let capsule = Shape::Capsule { radius, half_length };
    let plate = Shape::Cuboid { half: Vec3::new(0.2, 0.001, 0.2) };
    for (h, way) in [(1.0 / 60.0, 0.03), (5e-3, 0.005)] {
        for _ in 0..200 {
            let turn = Quat::from_scaled_axis(random.vector(3.0));
            let place = Vec3::new(0.0, 0.001 + radius + half_length + way * random.unit(), 0.0);
            let pose = Pose::new(place, turn);
            let fall = Vec3::new(0.3, -5.0, 0.1);
            let contacts = between((&capsule, pose), (&plate, Pose::identity()), fall, h);
            let ends = [-half_length, half_length].map(|y| pose.point(&(Vec3::y() * y)));
            for end in ends {
                let gap = end.y - radius - 0.001;
                let told = contacts.iter().any(|c| {
                    let aside = c.position_W - end;
                    (c.gap - gap).abs() < 1e-9
                        && aside.x.hypot(aside.z) < 1e-6
                        && (c.normal_W - Vec3::y()).norm() < 1e-9
                });
                let near_now = gap < 1e-4;
                assert!(told || near_now, "h {h}, gap {gap}: {contacts:#?}");
            }
        }
    }
}

/// Swapping which body is listed first changes only the direction.
#[test]
fn swapping_the_bodies_turns_the_normal() {
    let shapes = [
        (boxed(0.02), 0.02),
        (Shape::Sphere { radius: 0.02 }, 0.02),
        (Shape::Capsule { radius: 0.015, half_length: 0.01 }, 0.025),
        (mesh_cube(0.02), 0.02),
    ];
    let tilt = Quat::from_euler_angles(0.1, 0.2, 0.05);
    for (upper, bottom) in &shapes {
        for (lower, top) in &shapes {
            let height = bottom + top - 2e-4;
            let find = |swap: bool| {
                let mut scene = Scene::new();
                let upper = (upper.clone(), Pose::new(Vec3::new(0.003, height, 0.002), tilt));
                let lower = (lower.clone(), Pose::identity());
                let [a, b] = if swap { [lower, upper] } else { [upper, lower] };
                scene.rigid(Motion::Dynamic, a.0, a.1);
                scene.rigid(Motion::Dynamic, b.0, b.1);
                scene.find(1e-3)
            };
            let (one, other) = (find(false), find(true));
            let deepest = |c: &[Contact]| c.iter().map(|c| c.gap).fold(f64::INFINITY, f64::min);
            assert!((deepest(&one) - deepest(&other)).abs() < 1e-9, "{upper:?} {lower:?}");
            assert!(one.iter().all(|c| c.normal_W.y > 0.0), "{one:#?}");
            assert!(other.iter().all(|c| c.normal_W.y < 0.0));
        }
    }
}
