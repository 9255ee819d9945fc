//! Goal: fast bodies that spin are announced if they meet in the step, and only then. Method:
//! capsules thrown at other shapes from random places; the least distance on their way is sampled
//! in time and along the axis with the signed distance alone.

use crate::contact::pair_tests::{mesh_ball, mesh_cube};
use crate::contact::tests::{Scene, boxed};
use crate::contact::{Contact, RigidPlace, Shape};
use crate::math::{Pose, Quat, Vec3};
use crate::model::Motion;
use crate::random::Random;

const RADIUS: f64 = 0.003;
const HALF_LENGTH: f64 = 0.012;
const STEP: f64 = 5e-3;
/// The contact margin of the scenes.
const MARGIN: f64 = 1e-3;

fn after(place: &RigidPlace, time: f64) -> Pose {
    let turn = Quat::from_scaled_axis(time * place.angular_velocity_W);
    Pose::new(place.pose_WB.position + time * place.velocity_W, turn * place.pose_WB.rotation)
}

/// The least distance of the capsule from the other shape during the step.
fn clearance(scene: &Scene, other: &Shape) -> f64 {
    let at = |time: f64| {
        let [a, b] = [0, 1].map(|i| after(&scene.places[i], time));
        let on_axis = |k: i32| a.point(&(Vec3::y() * (HALF_LENGTH * (f64::from(k) / 20.0 - 1.0))));
        let distance = |k: i32| other.distance(&b.inverse_point(&on_axis(k))).value - RADIUS;
        (0..=40).map(distance).fold(f64::INFINITY, f64::min)
    };
    (0..=200).map(|k| at(STEP * f64::from(k) / 200.0)).fold(f64::INFINITY, f64::min)
}

/// By how much a contact is violated when nothing changes the velocities \[m\].
fn closed_by(scene: &Scene, c: &Contact) -> f64 {
    let at = |place: &RigidPlace| {
        let arm = c.position_W - place.pose_WB.position;
        place.velocity_W + place.angular_velocity_W.cross(&arm)
    };
    -c.gap - STEP * c.normal_W.dot(&(at(&scene.places[0]) - at(&scene.places[1])))
}

#[test]
fn spinning_bodies_are_announced_if_they_meet_and_only_then() {
    let mut random = Random::new(77);
    let capsule = Shape::Capsule { radius: RADIUS, half_length: HALF_LENGTH };
    let others = [
        capsule.clone(),
        boxed(0.008),
        Shape::Cuboid { half: Vec3::new(0.03, 0.001, 0.02) },
        Shape::Cylinder { radius: 0.01, half_length: 0.004 },
    ];
    let (mut met, mut passed) = (0, 0);
    for i in 0..2000 {
        let other = &others[i % others.len()];
        let mut scene = Scene::new();
        for shape in [&capsule, other] {
            let pose = Pose::new(random.vector(0.03), Quat::from_scaled_axis(random.vector(3.0)));
            scene.rigid(Motion::Dynamic, shape.clone(), pose);
        }
        for place in &mut scene.places {
            // Up to 15 mm and 0.5 rad in the step.
            place.velocity_W = random.vector(3.0);
            place.angular_velocity_W = random.vector(100.0);
        }
        let mut still = Scene::new();
        still.places.clone_from(&scene.places);
        still
            .places
            .iter_mut()
            .for_each(|p| (p.velocity_W, p.angular_velocity_W) = Default::default());
        if clearance(&still, other) < MARGIN {
            continue; // They touch already.
        }
        let clearance = clearance(&scene, other);
        let contacts = scene.find(STEP);
        // Between the samples ways are less than 0.15 mm, and places on the axis 0.6 mm apart.
        if clearance > MARGIN {
            passed += 1;
            assert!(contacts.is_empty(), "{other:?} passes at {clearance}: {contacts:#?}");
        } else if clearance < -MARGIN {
            met += 1;
            let held = contacts.iter().map(|c| closed_by(&scene, c)).fold(f64::MIN, f64::max);
            assert!(held > 0.0, "{other:?} {clearance}, {held}: {contacts:#?}");
        }
    }
    assert!(met > 50 && passed > 500, "{met} meet, {passed} pass");
}

/// Shapes of every kind but compounds.
fn bodies() -> [Shape; 9] {
    [
        Shape::Sphere { radius: 0.008 },
        Shape::Capsule { radius: RADIUS, half_length: HALF_LENGTH },
        boxed(0.008),
        Shape::Cuboid { half: Vec3::new(0.03, 0.001, 0.02) },
        Shape::Cylinder { radius: 0.01, half_length: 0.004 },
        Shape::Cone { radius: 0.008, height: 0.012 },
        Shape::Ellipsoid { half: Vec3::new(0.004, 0.009, 0.006) },
        mesh_cube(0.009, 2),
        mesh_ball(0.009, 4),
    ]
}

/// Returns a lower bound of the depth at which two shapes overlap \[m\]: the deepest of many places
/// in both; negative where none is in both.
fn overlap(shapes: [&Shape; 2], poses: [Pose; 2], random: &mut Random) -> f64 {
    let depth = |p: Vec3| {
        let of = |i: usize| -shapes[i].distance(&poses[i].inverse_point(&p)).value;
        of(0).min(of(1))
    };
    let middle = 0.5 * (poses[0].position + poses[1].position);
    let mut best = (depth(middle), middle);
    // Places everywhere, then ever nearer to the best.
    for k in 0..600 {
        let p = best.1 + random.vector(0.02 * 0.99_f64.powi(k));
        let found = depth(p);
        if found > best.0 {
            best = (found, p);
        }
    }
    best.0
}

/// However they lie in each other: corner in face, through and through, or wholly inside.
#[test]
fn overlaps_are_told_by_a_contact() {
    let shapes = bodies();
    let mut random = Random::new(5);
    let mut overlapping = 0;
    for i in 0..4050 {
        let pair = [i % 9, i / 9 % 9];
        let mut scene = Scene::new();
        for k in pair {
            let pose = Pose::new(random.vector(0.015), Quat::from_scaled_axis(random.vector(3.0)));
            scene.rigid(Motion::Dynamic, shapes[k].clone(), pose);
        }
        let poses = [0, 1].map(|i| scene.places[i].pose_WB);
        if overlap(pair.map(|k| &shapes[k]), poses, &mut random) > 2e-4 {
            overlapping += 1;
            let told = scene.find(STEP).iter().any(|c| c.gap < 0.0);
            assert!(told, "{pair:?} at {poses:?} overlap unseen");
        }
    }
    assert!(overlapping > 1500, "{overlapping}");
}

/// Bodies that are apart and fly past or at each other without spin: none of their contacts says
/// that they overlap.
#[test]
fn bodies_apart_are_never_told_to_overlap() {
    let shapes = bodies();
    let mut random = Random::new(5);
    let mut announced = 0;
    for i in 0..8100 {
        let pair = [i % 9, i / 9 % 9];
        let mut scene = Scene::new();
        for k in pair {
            let pose = Pose::new(random.vector(0.03), Quat::from_scaled_axis(random.vector(3.0)));
            scene.rigid(Motion::Dynamic, shapes[k].clone(), pose);
        }
        // What is in contact where it is need not move to be.
        if scene.find(STEP).is_empty() {
            scene.places.iter_mut().for_each(|place| place.velocity_W = random.vector(3.0));
            let contacts = scene.find(STEP);
            announced += usize::from(!contacts.is_empty());
            let poses = [0, 1].map(|i| scene.places[i].pose_WB);
            let told = contacts.iter().map(|c| c.gap).fold(f64::INFINITY, f64::min);
            assert!(told > 0.0, "{pair:?} at {poses:?}: {told} m");
        }
    }
    assert!(announced > 300, "{announced}");
}
