//! Motors of joints: springs whose rest moves.

use super::Track;
use super::drivers::ease;
use crate::format::InterpolationWord;
use crate::math::{Quat, Vec3};
use thenar::World;
use thenar::model::JointKind;
use thenar::world::JointTarget;

/// What leads one joint.
#[derive(Clone, Debug)]
pub struct Motor {
    /// The joint.
    pub joint: u32,
    /// Where it is led over time.
    pub course: Course,
    /// Largest torque of the spring about each axis \[N m\]; of a ball about any.
    pub torque_max: Option<f64>,
}

/// A joint's target over time.
#[derive(Clone, Debug)]
pub enum Course {
    /// Angles \[rad\] between keys, of hinges and universal joints.
    Angles {
        /// Times \[s\], ascending, and angles; at least one.
        keys: Vec<(f64, [f64; 2])>,
        /// How to go from one to the next.
        interpolation: InterpolationWord,
    },
    /// Rotation of a ball.
    Rotation(Track),
}

impl Motor {
    /// Where the joint is led at time `t` \[s\], whatever the motor's strength.
    pub fn wanted(&self, t: f64) -> JointTarget {
        match &self.course {
            Course::Angles { keys, interpolation } => {
                let (angles, rates) = angles_at(keys, *interpolation, t);
                JointTarget { angles, rates, ..JointTarget::default() }
            }
            Course::Rotation(track) => {
                let (pose, [_, spin_J]) = track.at(t);
                JointTarget { rotation_JK: pose.rotation, spin_J, ..JointTarget::default() }
            }
        }
    }

    /// Where the joint is led at time `t` \[s\]: no farther from where it is in `world` than the spring bears with the
    /// largest torque. A motor at its limit pushes with it and damps nothing.
    pub fn target(&self, world: &World, t: f64) -> JointTarget {
        let wanted = self.wanted(t);
        let Some(torque_max) = self.torque_max else { return wanted };
        let joint = &world.desc().joints[self.joint as usize];
        match joint.kind {
            JointKind::Ball => self.weak_ball(world, wanted, torque_max / joint.axes[0].stiffness),
            _ => {
                let [now, rates] = [world.joint_angles(self.joint), world.joint_rates(self.joint)];
                let mut target = wanted;
                for k in 0..joint.kind.angles() {
                    let reach = torque_max / joint.axes[k].stiffness;
                    // Both are known but for whole turns, and an axis turns the shorter way.
                    let off = Quat::from_axis_angle(&Vec3::x_axis(), wanted.angles[k] - now[k]);
                    let ahead = off.scaled_axis().x;
                    if ahead.abs() > reach {
                        target.angles[k] = now[k] + reach.copysign(ahead);
                        target.rates[k] = rates[k];
                    }
                }
                target
            }
        }
    }

    fn weak_ball(&self, world: &World, wanted: JointTarget, reach: f64) -> JointTarget {
        let joint = &world.desc().joints[self.joint as usize];
        let frame = |body: u32| world.rigid_pose(body).rotation;
        let turn_WJ = joint.parent.map_or(Quat::identity(), frame) * joint.pose_PJ.rotation;
        let turn_WK = frame(joint.child) * joint.pose_CK.rotation;
        let now = turn_WJ.inverse() * turn_WK;
        let ahead = (wanted.rotation_JK * now.inverse()).scaled_axis();
        if ahead.norm() <= reach {
            return wanted;
        }
        let rotation_JK = Quat::from_scaled_axis(ahead * (reach / ahead.norm())) * now;
        let spin = |body: u32| world.rigid_velocity(body)[1];
        let spin_W = spin(joint.child) - joint.parent.map_or(Vec3::zeros(), spin);
        JointTarget { rotation_JK, spin_J: turn_WJ.inverse() * spin_W, ..wanted }
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
