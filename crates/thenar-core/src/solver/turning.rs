//! Motion of a carried node's target as its bones turn.

use crate::math::{Mat3, Vec3, skew};

/// The angular part of `∂f/∂q` of a target: `∂f = Σ_j ω_j × l_j + T (ω_0 − ω_1)`.
///
/// Where places are blended (`Skinning::Linear`) there are levers alone. Where rotations are
/// blended (`Skinning::Joint`) the target turns with neither bone, and T is what bones that turn
/// apart add, as they do where their pose shifts the target (`PoseOffsets`).
#[derive(Clone, Copy, Debug)]
pub struct Turning {
    /// The lever l of each bone, weighted, world \[m\].
    pub levers: [Vec3; 2],
    /// T, where there is one.
    pub apart: Option<RelativeTerm>,
}

/// T: what bones that turn apart add.
#[derive(Clone, Copy, Debug)]
pub enum RelativeTerm {
    /// Matrix T of blended rotations, `κ rᵀ − (κ·r) 1` \[m\].
    Blended {
        /// κ, along the axis by which the bones are turned to each other, world.
        axis: Vec3,
        /// r, from the joint to the target, world \[m\].
        arm: Vec3,
    },
    /// Matrix T of a target that the bones' pose shifts: any \[m\].
    Posed(Mat3),
}

impl Turning {
    /// No lever at all.
    pub const NONE: Self = Self { levers: [Vec3::new(0.0, 0.0, 0.0); 2], apart: None };

    /// Velocity of the target \[m/s\] when bone `j` turns at `omega` \[rad/s\].
    #[inline(always)]
    pub fn velocity(&self, j: usize, omega: &Vec3) -> Vec3 {
        let turned = omega.cross(&self.levers[j]);
        match &self.apart {
            None => turned,
            Some(apart) => turned + apart.velocity(omega) * SIGNS[j],
        }
    }

    /// Torque on bone `j` about its origin \[N m\] of a force on the target \[N\]: the transpose of
    /// [`Turning::velocity`].
    #[inline(always)]
    pub fn torque(&self, j: usize, force: &Vec3) -> Vec3 {
        let torque = self.levers[j].cross(force);
        match &self.apart {
            None => torque,
            Some(apart) => torque + apart.torque(force) * SIGNS[j],
        }
    }

    /// The matrix of [`Turning::velocity`] \[m\].
    pub fn matrix(&self, j: usize) -> Mat3 {
        let turned = -skew(&self.levers[j]);
        match &self.apart {
            None => turned,
            Some(apart) => turned + apart.matrix() * SIGNS[j],
        }
    }
}

/// T acts on `ω_0 − ω_1`.
const SIGNS: [f64; 2] = [1.0, -1.0];

impl RelativeTerm {
    /// `T ω`: velocity of the target \[m/s\] when the first bone turns by ω against the second
    /// \[rad/s\].
    #[inline(always)]
    pub fn velocity(&self, omega: &Vec3) -> Vec3 {
        match self {
            Self::Blended { axis, arm } => axis * arm.dot(omega) - omega * axis.dot(arm),
            Self::Posed(matrix) => matrix * omega,
        }
    }

    /// `Tᵀ f`: torque on the first bone, and against it on the second \[N m\], of a force on the
    /// target \[N\].
    #[inline(always)]
    pub fn torque(&self, force: &Vec3) -> Vec3 {
        match self {
            Self::Blended { axis, arm } => arm * axis.dot(force) - force * axis.dot(arm),
            Self::Posed(matrix) => matrix.tr_mul(force),
        }
    }

    /// T \[m\].
    pub fn matrix(&self) -> Mat3 {
        match self {
            Self::Blended { axis, arm } => {
                axis * arm.transpose() - Mat3::from_diagonal_element(axis.dot(arm))
            }
            Self::Posed(matrix) => *matrix,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn velocity_torque_and_matrix_are_one_map() {
        let mut random = Random::new(5);
        for k in 0..100 {
            let apart = match k % 2 {
                0 => RelativeTerm::Blended { axis: random.vector(1.0), arm: random.vector(0.1) },
                _ => RelativeTerm::Posed(Mat3::from_fn(|_, _| random.range(-0.1, 0.1))),
            };
            let levers = [random.vector(0.1), random.vector(0.1)];
            let turning = Turning { levers, apart: (k % 3 > 0).then_some(apart) };
            let (omega, force) = (random.vector(3.0), random.vector(3.0));
            for j in 0..2 {
                let velocity = turning.velocity(j, &omega);
                assert!((velocity - turning.matrix(j) * omega).norm() < 1e-15);
                let power = velocity.dot(&force) - turning.torque(j, &force).dot(&omega);
                assert!(power.abs() < 1e-14, "{power}");
            }
        }
    }
}
