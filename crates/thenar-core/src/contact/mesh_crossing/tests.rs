//! Plates of twelve triangles, of 60 x 90 mm and across it: no vertex lies over the other's faces.

use crate::contact::grid::tests::grid_of;
use crate::contact::tests::{Scene, cube};
use crate::contact::{Contact, MeshShape, Shape};
use crate::math::{Pose, Quat, Vec3};
use crate::model::Motion;
use std::sync::Arc;

fn plate(half: Vec3) -> Shape {
    let (points, triangles) = cube(2.0, 1);
    let points = points.iter().map(|p| p.component_mul(&half)).collect();
    let grid = grid_of(&Shape::Cuboid { half }, 0.06, 17);
    Shape::Mesh(Arc::new(MeshShape::new(points, triangles, grid)))
}

/// Contacts of plates as thick as this, the upper turned about z and lifted so that its lower side
/// has the edge of the one below, at x = -30 mm, so deep in it, and of that edge's height.
fn contacts(thickness: f64, tilt: f64, depth: f64) -> Vec<Contact> {
    let mut scene = Scene::new();
    let half = 0.5 * thickness;
    scene.rigid(Motion::Prescribed, plate(Vec3::new(0.03, half, 0.045)), Pose::identity());
    let turn = Quat::from_scaled_axis(Vec3::z() * tilt);
    let edge = Vec3::new(-0.03, half, 0.0);
    let center = edge + turn * Vec3::new(0.03, half - depth, 0.0);
    scene.rigid(Motion::Dynamic, plate(Vec3::new(0.045, half, 0.03)), Pose::new(center, turn));
    scene.find(1e-3)
}

/// Overlaps beyond the margin of 1 mm are found along edges that lie level, whose boxes are apart,
/// and where the normal is that of a face: as deep as they are, along the normal of the upper
/// plate.
#[test]
fn deep_crossings_of_level_edges_lead_out() {
    for thickness in [3e-3, 6e-3, 0.012] {
        for tilt in [0.0, 0.1, 0.36, 0.6] {
            for depth in [0.1, 0.25, 0.4].map(|part| part * thickness) {
                let found = contacts(thickness, tilt, depth);
                let name = format!("{thickness} m, {tilt} rad, {depth} m deep");
                let up = Quat::from_scaled_axis(Vec3::z() * tilt) * Vec3::y();
                let deepest = found.iter().map(|c| c.gap).fold(f64::INFINITY, f64::min);
                assert!((deepest + depth).abs() < 1e-5, "{name}: {deepest}");
                let deep = found.iter().filter(|c| c.gap < -0.5 * depth);
                let places: Vec<f64> = deep
                    .map(|c| {
                        let along = c.normal_W.dot(&up).abs();
                        assert!(along > 1.0 - 1e-6, "{name}: along {}", c.normal_W);
                        c.position_W.z
                    })
                    .collect();
                // At both sides of the upper plate.
                for side in [-0.03, 0.03] {
                    assert!(places.iter().any(|z| (z - side).abs() < 1e-4), "{name}: {places:?}");
                }
            }
        }
    }
}

/// Plates that lie on each other, to a ten-thousandth of a millimetre: their far sides, as deep as
/// both are thick, are none, however thin.
#[test]
fn edges_of_far_sides_do_not_meet() {
    for thickness in [2e-4, 4e-4, 8e-4, 3e-3, 6e-3] {
        for depth in [-1e-7, -1e-12, 0.0, 1e-12, 1e-7] {
            let found = contacts(thickness, 0.0, depth);
            assert!(found.len() >= 4, "{thickness} m, {depth} m: {} contacts", found.len());
            for c in &found {
                assert!((c.gap + depth).abs() < 1e-9, "{thickness} m, {depth} m: {}", c.gap);
            }
        }
    }
}
