//! The 6-DoF viscoelastic spring between a bone and the pose it should follow (Sec. 5).

use crate::math::{Pose, Vec3, rotation_vector};
use crate::model::Drive;
use crate::world::Target;

/// Elastic force and torque on the body at this pose \[N, N m\], world:
/// `k (x_t - x)` and `k_r log(R_t Rᵀ)`.
pub fn drive_force(drive: &Drive, target: &Target, pose_WB: &Pose) -> [Vec3; 2] {
    let offset = target.pose_WB.position - pose_WB.position;
    let turn = rotation_vector(&(target.pose_WB.rotation * pose_WB.rotation.inverse()));
    [offset * drive.stiffness, turn * drive.angular_stiffness]
}

/// Returns the terms that a step adds to the diagonal of the system (linear, angular) and to its
/// right-hand side. The target is that of the end of the step: with `x₁ = x₀ + h v₁`,
/// `h F₁ = h k (x_t - x₀) + h c v_t - (h² k + h c) v₁`.
pub fn linearise_drive(
    drive: &Drive,
    target: &Target,
    pose_WB: &Pose,
    h: f64,
) -> ([f64; 2], [Vec3; 2]) {
    let [force, torque] = drive_force(drive, target, pose_WB);
    let diagonal = [
        h * h * drive.stiffness + h * drive.damping,
        h * h * drive.angular_stiffness + h * drive.angular_damping,
    ];
    let rhs = [
        (force + target.velocity_W * drive.damping) * h,
        (torque + target.angular_velocity_W * drive.angular_damping) * h,
    ];
    (diagonal, rhs)
}

/// Energy stored in the spring \[J\].
pub fn drive_energy(drive: &Drive, target: &Target, pose_WB: &Pose) -> f64 {
    let offset = target.pose_WB.position - pose_WB.position;
    let angle = target.pose_WB.rotation.angle_to(&pose_WB.rotation);
    0.5 * (drive.stiffness * offset.norm_squared() + drive.angular_stiffness * angle * angle)
}
