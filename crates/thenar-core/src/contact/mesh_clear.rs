//! Balls and lines of balls that stay clear of a mesh, as bones within their flesh do.

use crate::contact::mesh_pair::Pair;
use crate::contact::{MeshShape, Shape};
use crate::math::Vec3;
use std::cell::Cell;

/// Most places of a line of balls at which its clearance is looked for.
const PROBES_MAX: usize = 16;

/// True when a ball, or a line of balls, stays farther from a mesh than anything of it could touch
/// in this step: seen from some places along the line, as a distance changes by no more than the
/// way.
pub(super) fn is_clear(pair: &Pair, mesh: &MeshShape) -> bool {
    let (radius, half) = match pair.a.shape {
        Shape::Sphere { radius } => (*radius, 0.0),
        Shape::Capsule { radius, half_length } => (*radius, *half_length),
        _ => return false,
    };
    let touching = radius + pair.reach.margin + pair.travel;
    // From here all of the line is clear.
    let all = touching + 2.0 * half;
    let guess = Cell::new(u32::MAX);
    let clearance = |y: f64| {
        let p = pair.b.shape_point(&pair.a.world_point(&(Vec3::y() * y)));
        mesh.distance_within_near(&p, all, &guess).map_or(f64::INFINITY, |d| d.value - touching)
    };
    // From the middle to either end.
    let middle = clearance(0.0);
    middle > 0.0
        && [-1.0, 1.0].into_iter().all(|side| {
            let mut cleared = middle;
            for _ in 0..PROBES_MAX {
                if cleared > half {
                    return true;
                }
                let further = clearance(side * cleared);
                if further <= 0.0 {
                    return false;
                }
                cleared += further;
            }
            false
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::RigidPlace;
    use crate::contact::grid::tests::grid_of;
    use crate::contact::rigid_body::RigidBody;
    use crate::contact::rigid_pair::{Reach, RigidSide};
    use crate::contact::sweep::MovingPiece;
    use crate::contact::tests::{boxed, cube};
    use crate::math::{Mat3, Pose, Quat};
    use crate::model::{Motion, RigidDesc};
    use crate::random::Random;
    use std::sync::Arc;

    fn body(shape: Shape) -> RigidBody {
        let desc = RigidDesc {
            name: String::new(),
            motion: Motion::Dynamic,
            mass: 0.1,
            inertia: Mat3::identity(),
            pose_WB: Pose::identity(),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
            shape: Some(shape),
            pose_BS: Pose::identity(),
            friction: 0.5,
        };
        RigidBody::new(&desc, f64::INFINITY).expect("it has a shape")
    }

    /// Capsules and balls about a cube: none is clear of which some ball comes within the margin,
    /// and most of those that stay twice as far are.
    #[test]
    fn what_is_clear_is_farther_than_the_margin() {
        let (points, triangles) = cube(0.04, 3);
        let mesh = MeshShape::new(points, triangles, grid_of(&boxed(0.02), 0.03, 13));
        let cubic = body(Shape::Mesh(Arc::new(mesh.clone())));
        let reach = Reach { h: 0.0, margin: 1e-3 };
        let mut random = Random::new(9);
        let (mut clear, mut far) = (0, 0);
        for i in 0..3000 {
            let (radius, half_length) = (0.004, if i % 3 == 0 { 0.0 } else { 0.015 });
            let shape = match half_length > 0.0 {
                true => Shape::Capsule { radius, half_length },
                false => Shape::Sphere { radius },
            };
            let capsule = body(shape);
            let turn = Quat::from_scaled_axis(random.vector(3.0));
            let place = |pose_WB| RigidPlace {
                pose_WB,
                velocity_W: Vec3::zeros(),
                angular_velocity_W: Vec3::zeros(),
            };
            let pose = Pose::new(random.vector(0.05), turn);
            let placed = [(&capsule, pose), (&cubic, Pose::identity())]
                .map(|(body, pose)| body.place(&place(pose), 0.0));
            let mover = |body, k: usize| MovingPiece {
                side: RigidSide { body, placed: &placed[k] },
                piece: &body.pieces[0],
            };
            let (a, b) = (mover(&capsule, 0), mover(&cubic, 1));
            let is_clear = is_clear(&Pair::new(&a, &b, reach), &mesh);
            let gaps = (-20..=20).map(|k| {
                let p = pose.point(&(Vec3::y() * half_length * f64::from(k) / 20.0));
                mesh.distance(&p).value - radius
            });
            let least = gaps.fold(f64::INFINITY, f64::min);
            assert!(!is_clear || least > reach.margin, "{least} m");
            if least > 2.0 * reach.margin {
                (far, clear) = (far + 1, clear + u32::from(is_clear));
            }
        }
        assert!(far > 1000 && 10 * clear > 9 * far, "{clear} of {far}");
    }
}
