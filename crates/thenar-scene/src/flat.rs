//! Poses and targets as lists of numbers, with all their bits: how recordings keep them.

use serde::{Serialize, Serializer};
use thenar_core::world::Target;
use thenar_core::{Pose, Quat, Vec3};

/// Pose, velocity \[m/s\] and angular velocity \[rad/s\], world.
pub type FlatTarget = [f64; 13];

/// A list of targets, flattened as it is written.
#[derive(Debug)]
pub struct Flattened<'a, T>(pub &'a [T]);

impl Serialize for Flattened<'_, Target> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(self.0.iter().map(flat_target))
    }
}

impl Serialize for Flattened<'_, Option<Target>> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(self.0.iter().map(|target| target.as_ref().map(flat_target)))
    }
}

fn flat_target(target: &Target) -> FlatTarget {
    let [a, b, c, d, e, f, g] = flat_pose(&target.pose_WB);
    let (v, w) = (target.velocity_W, target.angular_velocity_W);
    [a, b, c, d, e, f, g, v.x, v.y, v.z, w.x, w.y, w.z]
}

/// The target of such numbers.
pub fn target([a, b, c, d, e, f, g, vx, vy, vz, wx, wy, wz]: &FlatTarget) -> Target {
    Target {
        pose_WB: pose(&[*a, *b, *c, *d, *e, *f, *g]),
        velocity_W: Vec3::new(*vx, *vy, *vz),
        angular_velocity_W: Vec3::new(*wx, *wy, *wz),
    }
}

/// Position, then quaternion x, y, z, w.
pub fn flat_pose(pose: &Pose) -> [f64; 7] {
    let (p, q) = (pose.position, pose.rotation.coords);
    [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
}

/// The pose of such numbers.
pub fn pose([x, y, z, i, j, k, w]: &[f64; 7]) -> Pose {
    let rotation = Quat::new_unchecked(nalgebra::Quaternion::new(*w, *i, *j, *k));
    Pose::new(Vec3::new(*x, *y, *z), rotation)
}
