//! Resistance of a hand's joints to being turned, bent flesh included, and the springs that make up
//! what flesh leaves.
//!
//! The stiffness of a joint's axis is what a torque about it alone meets while all other joints
//! give way, as they do when a person's knuckle is measured. With the flesh's matrix F (`bend`) and
//! the springs s it is `1 / (F + diag s)⁻¹ᵢᵢ`; what of it is not the spring is called the flesh's
//! part. Springs are raised or lowered, none below zero, until all are as wanted.
//!
//! | joint | wanted, of a hand of 190 mm | source |
//! |---|---|---|
//! | knuckles, flexion | 0.039 N m/rad, 0.02 to 0.06 | four healthy people, 0.033 to 0.047 (PMC7775510, table 2) |
//! | middle joints of fingers | 0.029, 0.014 to 0.043 | 89 adults, 0.05 N cm/° on average (Dionysian et al. 2005); the band is half as much to either side, ours |
//! | last joints of fingers | 0.020 | none found: the middle joint's, by the cube of the fingers' breadths there, 15 and 17 mm (recalled) |
//! | thumb's last joint and knuckle | 0.030, 0.039 | none found: as the joints of fingers of that breadth |
//! | sideways at knuckles, thumb's carpal joint | 0.08, 0.06 | none found: a finger of 1.2e-4 kg m² that swings sideways at 4 Hz (recalled) |
//!
//! All are proportional to the cube of the hand's length, as flesh of one modulus is.

use super::bend::{AxisOf, Bender};
use crate::RigError;
use nalgebra::DMatrix;
use thenar_core::Vec3;
use thenar_core::model::{Bone, Digit, HandModel, JointDesc, JointKind};

/// Length for which figures are given \[m\].
const LENGTH: f64 = 0.19;
/// Turns of joints for measuring, to both sides: flexion as far as 10 N mm turn a knuckle, and
/// sideways a third \[rad\].
const TURNS: [f64; 2] = [0.26, 0.09];
/// Damping ratio of a joint with all beyond it: by itself it would go past its rest by 5 % of the
/// way. Relaxed fingers hardly swing (recalled); those of the hand for touch, whose flesh is damped
/// too, do not.
const DAMPING_RATIO: f64 = 0.7;
/// Rounds in which springs find their values; each leaves less than half of what is amiss.
const ROUNDS: usize = 60;
/// Springs are given to this part of themselves, so that they do not depend on a processor's last
/// bits.
const DIGITS: i32 = 3;

/// Resistance of one axis of a joint to being turned. Stiffness in N m/rad.
#[derive(Clone, Debug, serde::Serialize)]
pub struct JointStiffness {
    /// Name of the joint.
    pub joint: String,
    /// "flexion" or "abduction".
    pub axis: &'static str,
    /// Range \[°\].
    pub range_deg: Option<[f64; 2]>,
    /// Stiffness that a torque about this axis meets, all other joints giving way.
    pub total: f64,
    /// Part of the total that the bent flesh gives.
    pub flesh: f64,
    /// Stiffness that the flesh would give if all other joints were held.
    pub flesh_held: f64,
    /// Stiffness of the spring \[N m/rad\].
    pub spring: f64,
    /// Damper \[N m s/rad\].
    pub damping: f64,
    /// Wanted total stiffness.
    pub wanted: f64,
    /// Range of people's joints, where that was measured.
    pub band: Option<[f64; 2]>,
}

impl JointStiffness {
    /// True if the total is as people's joints; none where nobody has measured them.
    pub fn met(&self) -> Option<bool> {
        self.band.map(|[low, high]| (low..=high).contains(&self.total))
    }
}

/// Wanted stiffness, and the band of people's where it was measured \[N m/rad\], for a hand of 190
/// mm.
fn wanted(digit: Digit, place: usize, flexion: bool) -> (f64, Option<[f64; 2]>) {
    match (digit, place, flexion) {
        (Digit::Thumb, 0, _) => (0.06, None),
        (_, 0, false) => (0.08, None),
        (Digit::Thumb, 1, _) => (0.039, None),
        (Digit::Thumb, _, _) => (0.030, None),
        (_, 0, true) => (0.039, Some([0.02, 0.06])),
        (_, 1, _) => (0.0286, Some([0.0143, 0.0430])),
        (_, _, _) => (0.020, None),
    }
}

/// Returns the resistance of all axes of a hand's joints, with the springs that they have.
///
/// # Errors
/// The hand makes no world, or the work would be too much.
pub fn joint_stiffness(hand: &HandModel) -> Result<Vec<JointStiffness>, RigError> {
    let measured = FleshResistance::new(hand)?;
    Ok(measured.rows(hand))
}

/// Gives the joints of a hand the springs that make up what its flesh leaves of what is wanted, and
/// dampers; keeps what the flesh resists.
///
/// # Errors
/// As [`joint_stiffness`].
pub(super) fn fill_up(hand: &mut HandModel) -> Result<Vec<JointStiffness>, RigError> {
    let measured = FleshResistance::new(hand)?;
    let wanted: Vec<f64> = measured.axes.iter().map(|&axis| goal(hand, axis).0).collect();
    for (&(j, k), spring) in measured.axes.iter().zip(fitted(&measured.flesh, &wanted)) {
        hand.joints[j].axes[k].stiffness = rounded(spring);
    }
    for (&(j, k), total) in measured.axes.iter().zip(measured.totals(hand)) {
        let critical = 2.0 * (total * inertia_beyond(hand, (j, k))).sqrt();
        hand.joints[j].axes[k].damping = rounded(DAMPING_RATIO * critical);
    }
    hand.bending = measured.flesh.iter().map(|f| f.signum() * rounded(f.abs())).collect();
    Ok(measured.rows(hand))
}

/// Resistance of a hand's flesh when its joints are turned.
struct FleshResistance {
    axes: Vec<AxisOf>,
    /// Stiffness of the flesh \[N m/rad\], symmetric.
    flesh: DMatrix<f64>,
}

impl FleshResistance {
    fn new(hand: &HandModel) -> Result<Self, RigError> {
        let axes = Bender::axes(hand);
        let turn = |axis: &AxisOf| TURNS[usize::from(!is_flexion(hand, *axis))];
        let turns: Vec<f64> = axes.iter().map(turn).collect();
        let secant = Bender::new(hand)?.stiffness(&turns)?;
        Ok(Self { axes, flesh: (&secant + secant.transpose()) * 0.5 })
    }

    fn totals(&self, hand: &HandModel) -> Vec<f64> {
        let springs = self.axes.iter().map(|&(j, k)| hand.joints[j].axes[k].stiffness);
        totals(&self.flesh, &springs.collect::<Vec<_>>())
    }

    fn rows(&self, hand: &HandModel) -> Vec<JointStiffness> {
        let rows = self.axes.iter().zip(self.totals(hand)).enumerate();
        rows.map(|(i, (&(j, k), total))| {
            let (joint, axis) = (&hand.joints[j], &hand.joints[j].axes[k]);
            let (wanted, band) = goal(hand, (j, k));
            JointStiffness {
                joint: joint.name.clone(),
                axis: if is_flexion(hand, (j, k)) { "flexion" } else { "abduction" },
                range_deg: axis.limit.map(|limit| [limit.min, limit.max].map(f64::to_degrees)),
                total,
                flesh: total - axis.stiffness,
                flesh_held: self.flesh[(i, i)],
                spring: axis.stiffness,
                damping: axis.damping,
                wanted,
                band,
            }
        })
        .collect()
    }
}

/// Wanted stiffness of an axis and people's band \[N m/rad\], at the hand's length.
fn goal(hand: &HandModel, axis: AxisOf) -> (f64, Option<[f64; 2]>) {
    let scale = (hand.length / LENGTH).powi(3);
    let digit = hand.bones[hand.joints[axis.0].child as usize].digit;
    let (wanted, band) = wanted(digit, place(hand, axis.0), is_flexion(hand, axis));
    (wanted * scale, band.map(|band| band.map(|k| k * scale)))
}

/// Stiffness that a torque about each axis alone meets, with springs beside the flesh.
fn totals(flesh: &DMatrix<f64>, springs: &[f64]) -> Vec<f64> {
    let mut whole = flesh.clone();
    for (i, spring) in springs.iter().enumerate() {
        whole[(i, i)] += spring;
    }
    match whole.try_inverse() {
        Some(compliance) => (0..springs.len()).map(|i| 1.0 / compliance[(i, i)]).collect(),
        // Joints that nothing holds.
        None => vec![0.0; springs.len()],
    }
}

/// Springs with which each axis is as stiff as wanted; none where flesh alone is stiffer.
fn fitted(flesh: &DMatrix<f64>, wanted: &[f64]) -> Vec<f64> {
    let mut springs = wanted.to_vec();
    for _ in 0..ROUNDS {
        let totals = totals(flesh, &springs);
        for ((spring, total), wanted) in springs.iter_mut().zip(&totals).zip(wanted) {
            *spring = (*spring + wanted - total).max(0.0);
        }
    }
    springs
}

/// A value to three significant digits.
fn rounded(value: f64) -> f64 {
    if value <= 0.0 {
        return 0.0;
    }
    let unit = 10f64.powi(value.log10().floor() as i32 - DIGITS + 1);
    (value / unit).round() * unit
}

/// True if an axis flexes: the only one of a hinge, the second of a universal joint.
fn is_flexion(hand: &HandModel, (j, k): AxisOf) -> bool {
    hand.joints[j].kind != JointKind::Universal || k == 1
}

/// Place of a joint in its digit, from 0 at the palm.
fn place(hand: &HandModel, j: usize) -> usize {
    let digit = |joint: &JointDesc| hand.bones[joint.child as usize].digit;
    let own = digit(&hand.joints[j]);
    hand.joints[..j].iter().filter(|joint| digit(joint) == own).count()
}

/// Moment of inertia \[kg m²\] about an axis, in the rest pose, of the bones beyond its joint and
/// of the flesh that follows them.
fn inertia_beyond(hand: &HandModel, (j, k): AxisOf) -> f64 {
    let joint = &hand.joints[j];
    let child = &hand.bones[joint.child as usize];
    let pose_MK = child.pose_MB * joint.pose_CK;
    let turns_aside = joint.kind == JointKind::Universal && k == 0;
    let along = if turns_aside { Vec3::y() } else { Vec3::x() };
    let (at, along) = (pose_MK.position, pose_MK.vector(&along));
    let about = |x: &Vec3, mass: f64| mass * along.cross(&(x - at)).norm_squared();
    let beyond = beyond(&hand.bones, joint.child);
    let bones = hand.bones.iter().zip(&beyond).filter(|(_, beyond)| **beyond).map(|(bone, _)| {
        let axis_B = bone.pose_MB.inverse_vector(&along);
        about(&bone.pose_MB.position, bone.mass) + axis_B.dot(&(bone.inertia * axis_B))
    });
    let flesh = &hand.flesh;
    let flesh_beyond = flesh.tets.iter().zip(&flesh.materials).map(|(tet, material)| {
        let mass =
            material.density * crate::lattice::tet::volume(&tet.map(|n| flesh.nodes[n as usize]));
        let node = |n: &u32| {
            let binding = &hand.bindings[*n as usize];
            let part = |k: usize| f64::from(beyond[binding.bones[k] as usize]) * binding.weights[k];
            (part(0) + part(1)) * about(&flesh.nodes[*n as usize], mass / 4.0)
        };
        tet.iter().map(node).sum::<f64>()
    });
    bones.sum::<f64>() + flesh_beyond.sum::<f64>()
}

/// The bones that a bone carries, itself among them.
pub(super) fn beyond(bones: &[Bone], first: u32) -> Vec<bool> {
    let mut beyond = vec![false; bones.len()];
    for b in 0..bones.len() {
        let carried = bones[b].parent.is_some_and(|parent| beyond[parent as usize]);
        beyond[b] = carried || b == first as usize;
    }
    beyond
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two axes that flesh ties: `1 / (F + diag s)⁻¹₀₀ = F₀₀ + s₀ - F₀₁² / (F₁₁ + s₁)`.
    #[test]
    fn springs_make_up_what_flesh_leaves() {
        let flesh = DMatrix::from_row_slice(2, 2, &[0.05, -0.02, -0.02, 0.04]);
        let springs = fitted(&flesh, &[0.06, 0.05]);
        let total = |a: usize, b: usize| {
            flesh[(a, a)] + springs[a] - flesh[(a, b)].powi(2) / (flesh[(b, b)] + springs[b])
        };
        assert!((total(0, 1) - 0.06).abs() < 1e-9 && (total(1, 0) - 0.05).abs() < 1e-9);
        // Flesh that is too stiff by itself gets no spring, and none pulls the other way.
        let springs = fitted(&flesh, &[0.03, 0.05]);
        assert_eq!(springs[0], 0.0);
        assert!(springs[1] > 0.0);
    }

    #[test]
    fn values_are_rounded_to_three_digits() {
        for (value, expected) in [(0.012_345, 0.0123), (9.996e-5, 1.0e-4), (0.0, 0.0), (-1.0, 0.0)]
        {
            assert!((rounded(value) - expected).abs() < 1e-15, "{value}");
        }
    }
}
