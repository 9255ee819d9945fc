//! Pose and velocity of a rigid bone.

use crate::math::{Pose, Quat, Vec3};
use crate::world::{Target, World};

/// Pose and velocity of a bone frame B (at its centre of mass) in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RigidState {
    /// Pose of the bone frame B in the world.
    pub pose_WB: Pose,
    /// Velocity of the origin, world \[m/s\].
    pub velocity_W: Vec3,
    /// Angular velocity, world \[rad/s\].
    pub angular_velocity_W: Vec3,
}

impl RigidState {
    /// At this pose, not moving.
    pub fn at_rest(pose_WB: Pose) -> Self {
        Self { pose_WB, velocity_W: Vec3::zeros(), angular_velocity_W: Vec3::zeros() }
    }

    /// A rigid body of a world, as it is.
    pub fn of(world: &World, body: u32) -> Self {
        let [velocity_W, angular_velocity_W] = world.rigid_velocity(body);
        Self { pose_WB: world.rigid_pose(body), velocity_W, angular_velocity_W }
    }

    /// True when every number is finite.
    pub fn is_finite(&self) -> bool {
        let rates = self.velocity_W.iter().chain(self.angular_velocity_W.iter());
        self.pose_WB.is_finite() && rates.copied().all(f64::is_finite)
    }

    /// The pose after `time` \[s\] at constant velocity.
    pub fn pose_after(&self, time: f64) -> Pose {
        let turn = Quat::from_scaled_axis(self.angular_velocity_W * time);
        Pose::new(self.pose_WB.position + self.velocity_W * time, turn * self.pose_WB.rotation)
    }

    /// Returns the state as the target of a bone's drive in the simulation.
    pub fn target(&self) -> Target {
        Target {
            pose_WB: self.pose_WB,
            velocity_W: self.velocity_W,
            angular_velocity_W: self.angular_velocity_W,
        }
    }
}

impl From<Target> for RigidState {
    fn from(target: Target) -> Self {
        let Target { pose_WB, velocity_W, angular_velocity_W } = target;
        Self { pose_WB, velocity_W, angular_velocity_W }
    }
}
