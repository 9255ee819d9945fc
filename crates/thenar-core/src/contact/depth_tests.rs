//! Ways out of corners, tips and ridges pressed into a face of long edges, as deep as a fifth of
//! them: what has come in by up to a quarter of an edge leaves through the triangle it came
//! through.

use super::tests::{Scene, boxed, cube, moved};
use super::{Contact, Site};
use crate::math::{Pose, Quat, Vec3};
use crate::model::Motion;
use std::f64::consts::FRAC_PI_4;

/// A cube of 40 mm whose faces are two by two squares, and the mean edge of their halves.
const HALF: f64 = 0.02;
const EDGE: f64 = HALF * (2.0 + std::f64::consts::SQRT_2) / 3.0;
/// Parts of an edge.
const DEPTHS: [f64; 4] = [0.02, 0.08, 0.14, 0.2];
/// Between vertices and edges of the face.
const BESIDE: Vec3 = Vec3::new(0.004, 0.0, 0.007);

/// Returns the rotation that turns the corner of a cube down.
fn corner_down() -> Quat {
    Quat::rotation_between(&Vec3::repeat(1.0), &-Vec3::y()).expect("not opposite")
}

fn deepest(contacts: &[Contact]) -> &Contact {
    contacts.iter().min_by(|a, b| a.gap.total_cmp(&b.gap)).expect("it touches")
}

#[test]
fn a_rigid_corner_in_a_face_is_led_out() {
    for depth in DEPTHS {
        let half = 0.006;
        let height = HALF + half * 3.0_f64.sqrt() - depth * EDGE;
        let mut scene = Scene::new();
        let pose = Pose::new(BESIDE + Vec3::y() * height, corner_down());
        scene.rigid(Motion::Dynamic, boxed(half), pose);
        scene.soft(cube(2.0 * HALF, 2));
        let contacts = scene.find(1e-3);
        let c = deepest(&contacts);
        assert!((c.gap + depth * EDGE).abs() < 1e-12, "{depth}: {}", c.gap);
        assert!((c.normal_W + Vec3::y()).norm() < 1e-9, "{depth}: {}", c.normal_W);
    }
}

/// The lowest vertex of a soft cube.
#[test]
fn a_soft_tip_in_a_face_is_led_out() {
    for depth in DEPTHS {
        let mut scene = Scene::new();
        scene.soft(cube(2.0 * HALF, 2));
        let tip = scene.soft(cube(2.0 * HALF, 2));
        let height = HALF + HALF * 3.0_f64.sqrt() - depth * EDGE;
        let upper = &mut scene.surfaces[1].0;
        upper.iter_mut().for_each(|p| *p = corner_down() * *p);
        moved(upper, BESIDE + Vec3::y() * height);
        let lowest = (0..upper.len()).min_by(|&i, &j| upper[i].y.total_cmp(&upper[j].y));
        let contacts = scene.find(1e-3);
        let is_tip = |c: &&Contact| match &c.a {
            Site::Soft(p) => p.soft == tip && p.vertices == [lowest.expect("vertices") as u32; 3],
            Site::Rigid { .. } => false,
        };
        let c = contacts.iter().find(is_tip).unwrap_or_else(|| panic!("{depth}: {contacts:#?}"));
        assert!((c.gap + depth * EDGE).abs() < 1e-12, "{depth}: {}", c.gap);
        assert!((c.normal_W - Vec3::y()).norm() < 1e-9, "{depth}: {}", c.normal_W);
    }
}

/// Two ridges at right angles, between their vertices.
#[test]
fn crossed_soft_ridges_are_led_out() {
    for depth in DEPTHS {
        let mut scene = Scene::new();
        scene.soft(cube(2.0 * HALF, 2));
        scene.soft(cube(2.0 * HALF, 2));
        let up = Quat::from_axis_angle(&Vec3::z_axis(), FRAC_PI_4);
        let across = Quat::from_axis_angle(&Vec3::y_axis(), 2.0 * FRAC_PI_4) * up;
        let apart = 2.0 * HALF * std::f64::consts::SQRT_2 - depth * EDGE;
        scene.surfaces[0].0.iter_mut().for_each(|p| *p = up * *p);
        let upper = &mut scene.surfaces[1].0;
        upper.iter_mut().for_each(|p| *p = across * *p);
        // A quarter of an edge aside along either ridge.
        moved(upper, Vec3::new(0.5 * HALF, apart, 0.5 * HALF));
        let contacts = scene.find(1e-3);
        let c = deepest(&contacts);
        assert!((c.gap + depth * EDGE).abs() < 1e-12, "{depth}: {}", c.gap);
        assert!((c.normal_W.y.abs() - 1.0).abs() < 1e-9, "{depth}: {}", c.normal_W);
    }
}
