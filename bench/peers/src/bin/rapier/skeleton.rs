//! Bones, the joints between them, and what leads the palm.

use super::{f, pose};
use rapier3d::prelude::*;
use thenar_peers::Job;
use thenar_peers::job::{Joint, Kind};

pub fn insert_bones(world: &mut PhysicsWorld, job: &Job) -> Vec<RigidBodyHandle> {
    let mut bones = Vec::new();
    for bone in &job.bones {
        let builder = if job.kinematic {
            RigidBodyBuilder::kinematic_position_based()
        } else {
            let rows = bone.inertia.map(|row| row.map(f));
            let inertia = Matrix::from_cols_array_2d(&rows); // symmetric: rows are columns
            let mass = MassProperties::with_inertia_matrix(Vector::ZERO, f(bone.mass), inertia);
            RigidBodyBuilder::dynamic().additional_mass_properties(mass)
        };
        bones.push(world.insert_body(builder.pose(pose(&bone.pose)).can_sleep(false)));
    }
    for joint in &job.joints {
        let (parent, child) = (bones[joint.parent as usize], bones[joint.child as usize]);
        world.insert_impulse_joint(parent, child, describe(job, joint));
    }
    bones
}

/// Both frames are the child's, so that all angles are zero, and all springs relaxed, at rest.
fn describe(job: &Job, joint: &Joint) -> GenericJoint {
    let in_child = pose(&joint.pose_in_child);
    let parent = pose(&job.bones[joint.parent as usize].pose);
    let child = pose(&job.bones[joint.child as usize].pose);
    let in_parent = parent.inverse() * child * in_child;
    let lines = JointAxesMask::LIN_X | JointAxesMask::LIN_Y | JointAxesMask::LIN_Z;
    let (locked, free): (JointAxesMask, &[JointAxis]) = match joint.kind {
        Kind::Hinge => (JointAxesMask::ANG_Y | JointAxesMask::ANG_Z, &[JointAxis::AngX]),
        Kind::Universal => (JointAxesMask::ANG_Z, &[JointAxis::AngY, JointAxis::AngX]),
    };
    let mut built =
        GenericJointBuilder::new(lines | locked).local_frame1(in_parent).local_frame2(in_child);
    for (axis, given) in free.iter().zip(&joint.axes) {
        built = built.motor_model(*axis, MotorModel::ForceBased).motor_position(
            *axis,
            0.0,
            f(given.stiffness),
            f(given.damping),
        );
    }
    built.into()
}

/// A kinematic body at the tracked pose, tied to the palm by six motors.
pub fn insert_drive(
    world: &mut PhysicsWorld,
    job: &Job,
    bones: &[RigidBodyHandle],
) -> Option<RigidBodyHandle> {
    let (drive, palm) = (job.drive.as_ref()?, *bones.first()?);
    let at = pose(&job.bones[0].pose);
    let leader = world.insert_body(RigidBodyBuilder::kinematic_position_based().pose(at));
    let mut joint = GenericJointBuilder::new(JointAxesMask::empty());
    for axis in [JointAxis::LinX, JointAxis::LinY, JointAxis::LinZ] {
        joint = joint.motor_model(axis, MotorModel::ForceBased).motor_position(
            axis,
            0.0,
            f(drive.stiffness),
            f(drive.damping),
        );
    }
    for axis in [JointAxis::AngX, JointAxis::AngY, JointAxis::AngZ] {
        joint = joint.motor_model(axis, MotorModel::ForceBased).motor_position(
            axis,
            0.0,
            f(drive.angular_stiffness),
            f(drive.angular_damping),
        );
    }
    let joint: GenericJoint = joint.into();
    world.insert_impulse_joint(leader, palm, joint);
    Some(leader)
}
