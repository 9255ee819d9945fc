//! A rigid body inside a deformable one: the way out.
//!
//! A body that starts inside the flesh, or was driven there, touches its surface nowhere. Balls
//! inside the body tell: while the centre of one is inside the surface, it is led out where the
//! surface is nearest, however deep that is. In contact no centre is inside: the surface lies
//! around the body.
//!
//! Flesh that is crushed has folds and places turned inside out. Of those the normal says the wrong
//! side, so that a centre is inside only if the surface also winds around it.

use crate::contact::collector::{Collector, feature_key};
use crate::contact::features::capsule_axis;
use crate::contact::soft_rigid::{KEY_INSIDE, SoftRigid};
use crate::contact::triangle::{Closest, closest_on_triangle};
use crate::contact::{Contact, Shape, Site, SurfacePoint};
use crate::math::Vec3;

/// A ball inside a shape, in its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct InnerBall {
    pub center: Vec3,
    /// Radius \[m\].
    pub radius: f64,
}

/// Adds balls inside a shape that is no compound, in its frame: of a capsule both ends and the
/// middle, of a mesh that about the deepest point of its grid, of others the middle.
pub(crate) fn inner_balls(shape: &Shape, mut add: impl FnMut(InnerBall)) {
    let mut about = |center: Vec3| {
        let radius = -shape.distance(&center).value;
        if radius > 0.0 {
            add(InnerBall { center, radius });
        }
    };
    match shape {
        Shape::HalfSpace | Shape::Compound(_) => {}
        Shape::Capsule { half_length, .. } => {
            let [a, b] = capsule_axis(*half_length);
            [a, 0.5 * (a + b), b].into_iter().for_each(about);
        }
        Shape::Mesh(mesh) => about(mesh.grid.deepest()),
        _ => about(Vec3::zeros()),
    }
}

impl SoftRigid<'_> {
    /// Contacts that lead the body out of the surface, whose tree is up to date; `false` when it is
    /// not inside.
    pub(super) fn lead_out(&self, out: &mut Collector) -> bool {
        let mut is_inside = false;
        for (i, inner) in (0..).zip(&self.body.sharp.inner) {
            let center_W = self.placed.world_point(&inner.center);
            let Some((t, closest)) = self.surface_nearest(&center_W) else { continue };
            let x = self.state.positions;
            let outward = self.surface.pseudonormal(t, closest.feature, x);
            let way = closest.point - center_W;
            if outward.dot(&way) <= 0.0 || !self.surface.winds_around(&center_W, x) {
                continue;
            }
            let Some(direction) = way.try_normalize(0.0) else { continue };
            is_inside = true;
            let vertices = self.surface.triangles[t as usize];
            let weights = closest.weights;
            out.push(Contact {
                key: feature_key([KEY_INSIDE, self.soft, self.rigid, i]),
                a: Site::Soft(SurfacePoint { soft: self.soft, vertices, weights }),
                b: Site::Rigid {
                    body: self.rigid,
                    offset_W: closest.point - self.placed.center_of_mass,
                },
                position_W: closest.point,
                normal_W: -direction,
                gap: -way.norm() - inner.radius,
                friction: self.friction,
            });
        }
        is_inside
    }

    /// The place of the surface nearest to a point.
    fn surface_nearest(&self, p_W: &Vec3) -> Option<(u32, Closest)> {
        let mut best: Option<(u32, Closest)> = None;
        self.surface.tree.nearest(0, p_W, f64::INFINITY, |t| {
            let found = closest_on_triangle(p_W, &self.surface.corners(t, self.state.positions));
            // Of equally near triangles the lowest index.
            let squared = found.distance_squared;
            if best.is_none_or(|(u, b)| (squared, t) < (b.distance_squared, u)) {
                best = Some((t, found));
            }
            squared
        });
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::tests::{Scene, boxed, cube};
    use crate::math::{Pose, Quat};
    use crate::model::Motion;

    /// A side wall turned inside out, as crushed flesh has them, sees what is in front of it as
    /// behind it.
    #[test]
    fn what_is_before_a_wall_turned_inside_out_is_not_inside() {
        for n in [2, 4] {
            for x in [0.024, 0.026, 0.03] {
                let mut scene = Scene::new();
                let at = Vec3::new(x, 1e-3, 0.006);
                let ball = Shape::Sphere { radius: 0.002 };
                scene.rigid(Motion::Dynamic, ball, Pose::new(at, Quat::identity()));
                scene.soft(cube(0.04, n));
                let points = &mut scene.surfaces[0].0;
                for p in points.iter_mut().filter(|p| p.x > 0.0199) {
                    // A corner sticks out so far that the ball is within the surface's box.
                    let is_corner = p.y < -0.0199 && p.z < -0.0199;
                    (p.x, p.y) = (if is_corner { 0.04 } else { p.x }, -0.5 * p.y);
                }
                let contacts = scene.find(1e-3);
                assert!(contacts.is_empty(), "{n} cells, at {x} m: {contacts:?}");
            }
        }
    }

    /// Bodies wholly inside a soft cube of 40 mm, at several depths and meshes, leave by its
    /// nearest face: the deepest contact points out of it and is as deep as the body's middle, and
    /// its inner radius.
    #[test]
    fn what_is_inside_leaves_by_the_nearest_face() {
        let shapes = [
            (Shape::Sphere { radius: 0.004 }, 0.004),
            (Shape::Capsule { radius: 0.003, half_length: 0.0 }, 0.003),
            (boxed(0.003), 0.003),
            (Shape::Cylinder { radius: 0.004, half_length: 0.003 }, 0.003),
            (Shape::Ellipsoid { half: Vec3::new(0.002, 0.004, 0.005) }, 0.002),
        ];
        for n in [1, 3, 9] {
            for depth in [0.0061, 0.009, 0.015] {
                for (shape, radius) in &shapes {
                    let mut scene = Scene::new();
                    let place = Vec3::new(0.001, 0.02 - depth, -0.0012);
                    let turn = Quat::from_axis_angle(&Vec3::y_axis(), 0.3);
                    scene.rigid(Motion::Dynamic, shape.clone(), Pose::new(place, turn));
                    scene.soft(cube(0.04, n));
                    let contacts = scene.find(1e-3);
                    let deepest = contacts.iter().min_by(|a, b| a.gap.total_cmp(&b.gap));
                    let c =
                        deepest.unwrap_or_else(|| panic!("{shape:?} at {depth} touches nothing"));
                    assert!((c.gap + depth + radius).abs() < 1e-9, "{shape:?}: {}", c.gap);
                    assert!((c.normal_W + Vec3::y()).norm() < 1e-9, "{shape:?}: {}", c.normal_W);
                }
            }
        }
    }
}
