//! A hand's skeleton as a motion sees it: wrist and joint angles in, bone targets out.

use crate::FitError;
use thenar_core::kinematics::Tree;
use thenar_core::model::HandModel;
use thenar_core::world::Target;
use thenar_core::{Pose, Vec3};

/// Turns the wrist's pose and the joint angles into targets of all bones. The wrist is the frame
/// of the root bone's tracked joint (WebXR: -z towards the fingers, +y out of the back).
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Articulation {
    /// The joints.
    pub tree: Tree,
    /// Wrist frame T in the root bone.
    pub pose_BT: Pose,
    /// Root bone in the model frame, at rest.
    pub pose_MB: Pose,
    /// Angles at rest \[rad\].
    pub rest_angles: Vec<[f64; 2]>,
    poses: Vec<Pose>,
    velocities: Vec<[Vec3; 2]>,
}

impl Articulation {
    /// The skeleton of `hand`.
    pub fn new(hand: &HandModel) -> Result<Self, FitError> {
        let name = || hand.name.clone();
        let Some(root) = hand.bones.first() else {
            return Err(FitError::NoBones { hand: name() });
        };
        let tree = Tree::of_hand(hand).map_err(|cause| FitError::Tree { hand: name(), cause })?;
        let poses: Vec<_> = hand.bones.iter().map(|bone| bone.pose_MB).collect();
        let mut rest_angles = vec![[0.0; 2]; tree.joints()];
        tree.angles(&poses, &mut rest_angles);
        let velocities = vec![[Vec3::zeros(); 2]; tree.bones()];
        let (pose_BT, pose_MB) = (root.pose_BT, root.pose_MB);
        Ok(Self { tree, pose_BT, pose_MB, rest_angles, poses, velocities })
    }

    /// The wrist of a hand at rest whose model frame is at `pose_WM`.
    pub fn wrist_at_rest(&self, pose_WM: &Pose) -> Pose {
        *pose_WM * self.pose_MB * self.pose_BT
    }

    /// Returns the pose of the model frame that puts the wrist of a hand at rest at `pose_WT`.
    pub fn placement(&self, pose_WT: &Pose) -> Pose {
        *pose_WT * self.pose_BT.inverse() * self.pose_MB.inverse()
    }

    /// Writes the targets of all bones for the wrist's pose and velocity (linear \[m/s\], angular
    /// \[rad/s\], world), the joint angles \[rad\] and their rates \[rad/s\]. Should a number not
    /// be finite, `out` keeps what it held.
    pub fn targets(
        &mut self,
        pose_WT: &Pose,
        velocity_T: [Vec3; 2],
        angles: &[[f64; 2]],
        rates: &[[f64; 2]],
        out: &mut [Option<Target>],
    ) {
        let root = *pose_WT * self.pose_BT.inverse();
        let [velocity, angular] = velocity_T;
        let to_root = root.position - pose_WT.position;
        let velocity_root = [velocity + angular.cross(&to_root), angular];
        self.tree.forward(&root, angles, &mut self.poses);
        self.tree.velocities(&self.poses, velocity_root, angles, rates, &mut self.velocities);
        for ((pose_WB, velocity), out) in self.poses.iter().zip(&self.velocities).zip(out) {
            let [velocity_W, angular_velocity_W] = *velocity;
            let finite = velocity.iter().flat_map(|v| v.iter()).all(|x| x.is_finite());
            if finite && pose_WB.is_finite() {
                *out = Some(Target { pose_WB: *pose_WB, velocity_W, angular_velocity_W });
            }
        }
    }
}
