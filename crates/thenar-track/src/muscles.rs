//! Torques that hold a hand's joints at the angles of its targets.
//!
//! Flesh and springs resist bending, and drives that are soft enough to be felt leave a bent finger
//! some millimetres short of its target. A person's muscles carry that; so do torques about the
//! joints here, which balance flesh and springs at the angles of the targets:
//!
//! ```text
//! τ = F (q - q_rest) + s (q - q_spring)
//! ```
//!
//! with F the stiffness of the flesh, measured when the hand was built, and s that of the joints'
//! springs. They follow from the targets alone, so that they neither damp nor drive anything by
//! themselves, and end where the joints' ranges end.

use crate::{Articulation, FitError};
use thenar_core::Pose;
use thenar_core::model::HandModel;
use thenar_core::world::Target;

/// Torques about the joints of one hand.
#[derive(Clone, Debug)]
pub struct Muscles {
    articulation: Articulation,
    /// Joint of each axis, and which of its axes it is.
    axes: Vec<(usize, usize)>,
    /// Stiffness of the flesh against turns of all axes \[N m/rad\], row by row; empty where
    /// nothing is known of it.
    flesh: Vec<f64>,
    /// Stiffness \[N m/rad\] and rest angle \[rad\] of the spring of each axis.
    springs: Vec<[f64; 2]>,
    poses: Vec<Pose>,
    angles: Vec<[f64; 2]>,
    /// Way of each axis from rest \[rad\].
    turned: Vec<f64>,
}

impl Muscles {
    /// The muscles of `hand`; those of a skeleton, which has no flesh, hold its springs alone.
    ///
    /// # Errors
    /// Its bones are no tree.
    pub fn new(hand: &HandModel, flesh: bool) -> Result<Self, FitError> {
        let articulation = Articulation::new(hand)?;
        let axes: Vec<(usize, usize)> = hand.axes().collect();
        let spring = |&(j, k): &(usize, usize)| {
            let axis = &hand.joints[j].axes[k];
            [axis.stiffness, axis.rest_angle]
        };
        Ok(Self {
            springs: axes.iter().map(spring).collect(),
            flesh: if flesh { hand.bending.clone() } else { Vec::new() },
            poses: vec![Pose::identity(); hand.bones.len()],
            angles: articulation.rest_angles.clone(),
            turned: vec![0.0; axes.len()],
            articulation,
            axes,
        })
    }

    /// Adds the torques \[N m\] that hold the hand at its targets to those of its joints, with
    /// flesh that is `stiffer` than the model's by a factor; nothing where a bone has no target.
    pub fn hold(&mut self, targets: &[Option<Target>], stiffer: f64, torques: &mut [[f64; 2]]) {
        for (pose, target) in self.poses.iter_mut().zip(targets) {
            match target {
                Some(target) if target.pose_WB.is_finite() => *pose = target.pose_WB,
                _ => return,
            }
        }
        let Self { articulation, angles, .. } = self;
        articulation.tree.angles(&self.poses, angles);
        for (turned, &(j, k)) in self.turned.iter_mut().zip(&self.axes) {
            angles[j] = articulation.tree.clamp(j, angles[j]);
            *turned = angles[j][k] - articulation.rest_angles[j][k];
        }
        for (a, &(j, k)) in self.axes.iter().enumerate() {
            let row = self.flesh.chunks_exact(self.axes.len()).nth(a).unwrap_or(&[]);
            let flesh: f64 = row.iter().zip(&self.turned).map(|(f, turned)| f * turned).sum();
            let [stiffness, rest] = self.springs[a];
            torques[j][k] += stiffer * flesh + stiffness * (self.angles[j][k] - rest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Muscles;
    use crate::{Articulation, fixture};
    use thenar_core::model::HandModel;
    use thenar_core::random::Random;
    use thenar_core::world::Target;
    use thenar_core::{Pose, Vec3};

    fn targets_at(hand: &HandModel, angles: &[[f64; 2]]) -> Vec<Option<Target>> {
        let mut poses = vec![Pose::identity(); hand.bones.len()];
        let articulation = Articulation::new(hand).unwrap();
        articulation.tree.forward(&Pose::translation(0.1, 0.2, 0.3), angles, &mut poses);
        let still = Vec3::zeros();
        let target = |pose_WB| Target { pose_WB, velocity_W: still, angular_velocity_W: still };
        poses.into_iter().map(|pose| Some(target(pose))).collect()
    }

    /// Torques follow from the flesh's matrix and the springs; an angle beyond its range counts as
    /// its end.
    #[test]
    fn torques_balance_flesh_and_springs() {
        let mut hand = fixture::hand(false);
        let mut random = Random::new(11);
        let axes: Vec<(usize, usize)> = hand.axes().collect();
        let n = axes.len();
        assert_eq!(n, 20);
        hand.bending = (0..n * n).map(|_| random.symmetric()).collect();
        for &(j, k) in &axes {
            let axis = &mut hand.joints[j].axes[k];
            (axis.stiffness, axis.rest_angle) = (1.0 + random.symmetric(), 0.1);
        }
        let rest = Articulation::new(&hand).unwrap().rest_angles;
        let mut angles = rest.clone();
        angles.as_flattened_mut().iter_mut().for_each(|angle| *angle -= 0.1);
        // Straight fingers bend back by 5° at most; what is beyond does not count.
        angles[1][0] = 0.5;
        let mut counted = angles.clone();
        counted[1][0] = 5f64.to_radians();
        let mut expected = vec![[0.0; 2]; hand.joints.len()];
        for (a, &(j, k)) in axes.iter().enumerate() {
            let spring = &hand.joints[j].axes[k];
            expected[j][k] = 3.0 + spring.stiffness * (counted[j][k] - 0.1);
            for (b, &(i, l)) in axes.iter().enumerate() {
                expected[j][k] += 2.0 * hand.bending[a * n + b] * (counted[i][l] - rest[i][l]);
            }
        }
        let mut torques = vec![[3.0; 2]; hand.joints.len()];
        let mut muscles = Muscles::new(&hand, true).unwrap();
        muscles.hold(&targets_at(&hand, &angles), 2.0, &mut torques);
        for &(j, k) in &axes {
            let (found, expected) = (torques[j][k], expected[j][k]);
            assert!((found - expected).abs() < 1e-9, "{j} {k}: {found} for {expected}");
        }
    }

    /// A bone without a target, or with one that is no place, lets the whole hand be.
    #[test]
    fn a_hand_without_targets_has_no_torques() {
        let mut hand = fixture::hand(false);
        hand.joints.iter_mut().for_each(|joint| joint.axes[0].stiffness = 1.0);
        let rest = Articulation::new(&hand).unwrap().rest_angles;
        let bent: Vec<[f64; 2]> = rest.iter().map(|angles| angles.map(|a| a - 0.2)).collect();
        let mut muscles = Muscles::new(&hand, true).unwrap();
        for break_one in [0, 1] {
            let mut targets = targets_at(&hand, &bent);
            match break_one {
                0 => targets[7] = None,
                _ => targets[7].as_mut().unwrap().pose_WB.position.x = f64::NAN,
            }
            let mut torques = vec![[0.0; 2]; hand.joints.len()];
            muscles.hold(&targets, 1.0, &mut torques);
            assert_eq!(torques, vec![[0.0; 2]; hand.joints.len()]);
            muscles.hold(&targets_at(&hand, &bent), 1.0, &mut torques);
            assert!(torques[1][0] < -0.1, "{torques:?}");
        }
    }
}
