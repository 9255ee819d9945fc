//! Stance of a hand: wrist and joint angles.

use crate::Articulation;
use serde::{Deserialize, Serialize};
use thenar_core::world::Target;
use thenar_core::{Pose, Quat, Vec3};

/// Wrist and joint angles with their velocities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KinematicState {
    /// Wrist, world \[m\], and its velocity \[m/s\].
    pub position: [Vec3; 2],
    /// Wrist's axes, and its angular velocity, world \[rad/s\].
    pub rotation: (Quat, Vec3),
    /// Joint angles \[rad\].
    pub angles: Vec<[f64; 2]>,
    /// Rates of the joint angles \[rad/s\].
    pub rates: Vec<[f64; 2]>,
}

impl KinematicState {
    /// The hand at rest.
    pub fn at_rest(articulation: &Articulation) -> Self {
        let wrist = articulation.wrist_at_rest(&Pose::identity());
        Self {
            position: [wrist.position, Vec3::zeros()],
            rotation: (wrist.rotation, Vec3::zeros()),
            angles: articulation.rest_angles.clone(),
            rates: vec![[0.0; 2]; articulation.rest_angles.len()],
        }
    }

    /// Reads bone targets; the joints' rates are what took them there within `h` \[s\], or zero.
    pub fn read(
        &mut self,
        articulation: &Articulation,
        targets: &[Option<Target>],
        h: Option<f64>,
        poses: &mut [Pose],
        angles: &mut [[f64; 2]],
    ) {
        for (pose, target) in poses.iter_mut().zip(targets) {
            let Some(target) = target else { return };
            *pose = target.pose_WB;
        }
        let Some(Some(root)) = targets.first() else { return };
        let wrist = root.pose_WB * articulation.pose_BT;
        let arm = wrist.position - root.pose_WB.position;
        let spin = root.angular_velocity_W;
        self.position = [wrist.position, root.velocity_W + spin.cross(&arm)];
        self.rotation = (wrist.rotation, spin);
        articulation.tree.angles(poses, angles);
        for j in 0..angles.len() {
            for k in 0..2 {
                let change = angles[j][k] - self.angles[j][k];
                self.rates[j][k] = h.map_or(0.0, |h| change / h);
                self.angles[j][k] = angles[j][k];
            }
        }
    }

    /// Copies without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        (self.position, self.rotation) = (other.position, other.rotation);
        self.angles.copy_from_slice(&other.angles);
        self.rates.copy_from_slice(&other.rates);
    }
}
