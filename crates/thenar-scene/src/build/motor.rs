//! Motors of joints: springs whose rest moves, up to a torque.

use super::PoseTrack;
use super::drivers::ease;
use crate::format::InterpolationWord;
use crate::math::{Quat, Vec3};
use thenar_core::World;
use thenar_core::kinematics::stretch;
use thenar_core::model::{Axis, JointDesc, JointKind};
use thenar_core::world::{Input, JointTarget};

/// Motor that leads one joint.
#[derive(Clone, Debug)]
pub struct Motor {
    /// Index of the joint.
    pub joint: u32,
    /// Target of the joint over time.
    pub joint_track: JointTrack,
    /// Largest torque of spring and damper about each axis \[N m\]; of a ball about any.
    pub torque_max: Option<f64>,
    /// Axes that a train leads instead ([`super::Train`]).
    pub in_train: [bool; 2],
}

/// A joint's target over time.
#[derive(Clone, Debug)]
pub enum JointTrack {
    /// Angles \[rad\] between keys, of hinges and universal joints.
    Angles {
        /// Times \[s\], ascending, and angles; at least one.
        keys: Vec<(f64, [f64; 2])>,
        /// Interpolation from one key to the next.
        interpolation: InterpolationWord,
    },
    /// Rotation of a ball.
    Rotation(PoseTrack),
}

impl Motor {
    /// Returns the joint's target at time `t` \[s\], whatever the motor's strength.
    pub fn wanted(&self, t: f64) -> JointTarget {
        match &self.joint_track {
            JointTrack::Angles { keys, interpolation } => {
                let (angles, rates) = angles_at(keys, *interpolation, t);
                JointTarget { angles, rates, ..JointTarget::default() }
            }
            JointTrack::Rotation(track) => {
                let (pose, [_, spin_J]) = track.at(t);
                JointTarget { rotation_JK: pose.rotation, spin_J, ..JointTarget::default() }
            }
        }
    }

    /// Leads the joint for the step that ends at time `t` \[s\]. Where spring and damper would give
    /// more than the largest torque, by where the joint would be then if it went on as it does,
    /// they let go and that torque acts.
    pub fn lead(&self, input: &mut Input, world: &World, t: f64) {
        let j = self.joint as usize;
        let joint = &world.desc().joints[j];
        let mut target = self.wanted(t);
        if let Some(most) = self.torque_max {
            match joint.kind {
                JointKind::Ball => self.weaken_ball(&mut target, joint, world, most),
                kind => {
                    let asked = self.asked(&target, joint, world);
                    let weak = |k: &usize| asked[*k].abs() > most && !self.in_train[*k];
                    for k in (0..kind.angles()).filter(weak) {
                        target.gains[k] = 0.0;
                        input.joint_torques[j][k] += most.copysign(asked[k]);
                    }
                }
            }
        }
        input.joint_targets[j] = Some(target);
    }

    /// Torque that spring and damper of each axis would give \[N m\].
    fn asked(&self, target: &JointTarget, joint: &JointDesc, world: &World) -> [f64; 2] {
        let [now, rates] = [world.joint_angles(self.joint), world.joint_rates(self.joint)];
        [0, 1].map(|k| {
            let axis = Axis { rest_angle: target.angles[k], ..joint.axes[k] };
            let then = now[k] + world.time_step() * rates[k];
            axis.damping * (target.rates[k] - rates[k]) - axis.stiffness * stretch(&axis, then)
        })
    }

    /// A ball has no torques of its own: spring and damper are weakened until they give no more
    /// than `most`.
    fn weaken_ball(&self, target: &mut JointTarget, joint: &JointDesc, world: &World, most: f64) {
        let turn = |body: u32| world.rigid_pose(body).rotation;
        let spin = |body: u32| world.rigid_velocity(body)[1];
        let turn_WJ = joint.parent.map_or(Quat::identity(), turn) * joint.pose_PJ.rotation;
        let now_JK = turn_WJ.inverse() * turn(joint.child) * joint.pose_CK.rotation;
        let spin_W = spin(joint.child) - joint.parent.map_or(Vec3::zeros(), spin);
        let spin_J = turn_WJ.inverse() * spin_W;
        let then_JK = Quat::from_scaled_axis(spin_J * world.time_step()) * now_JK;
        let ahead = (target.rotation_JK * then_JK.inverse()).scaled_axis();
        let axis = &joint.axes[0];
        let asked = (ahead * axis.stiffness + (target.spin_J - spin_J) * axis.damping).norm();
        if asked > most {
            target.gains[0] = most / asked;
        }
    }
}

fn angles_at(
    keys: &[(f64, [f64; 2])],
    interpolation: InterpolationWord,
    t: f64,
) -> ([f64; 2], [f64; 2]) {
    let after = keys.partition_point(|(time, _)| *time <= t);
    match (after.checked_sub(1).map(|k| keys[k]), keys.get(after)) {
        (Some((t0, a)), Some(&(t1, b))) => {
            let (way, rate) = ease(interpolation, (t - t0) / (t1 - t0), t1 - t0);
            let angles = [0, 1].map(|k| a[k] + (b[k] - a[k]) * way);
            (angles, [0, 1].map(|k| (b[k] - a[k]) * rate))
        }
        (Some((_, angles)), None) => (angles, [0.0; 2]),
        (None, first) => (first.map_or([0.0; 2], |key| key.1), [0.0; 2]),
    }
}
