//! The nodes of a figure's flesh that stand for bone, by the rule of hands (`hand::in_bone`), of
//! solids of any shape.

use super::plan::{Plan, PlanSolid};
use super::solid;
use crate::RigError;
use crate::hand::in_bone::{held, shares};
use crate::lattice::Lattice;
use thenar_core::Vec3;
use thenar_core::model::{Bone, BoneNode};
use thenar_core::shape::Shape;

/// The nodes in bone, ascending.
///
/// # Errors
/// When a bone's solid has no volume.
pub fn bone_nodes(
    lattice: &Lattice,
    plan: &Plan,
    bones: &[Bone],
) -> Result<Vec<BoneNode>, RigError> {
    let points: Vec<Vec<usize>> =
        plan.bones.iter().map(|bone| inside(lattice, &bone.solids)).collect();
    let volumes = plan.bones.iter().map(|bone| Ok(solid::mass(&bone.solids, 1.0)?.0));
    let volumes = volumes.collect::<Result<Vec<f64>, RigError>>()?;
    Ok(held(&shares(lattice, &points, &volumes), bones))
}

/// Inside points of the lattice that lie in the solids; where these lie between all of them, the
/// one nearest.
fn inside(lattice: &Lattice, solids: &[PlanSolid]) -> Vec<usize> {
    let distance = |p: &Vec3| {
        let to = |s: &PlanSolid| s.shape.distance(&s.pose_MS.inverse_point(p)).value;
        solids.iter().map(to).fold(f64::INFINITY, f64::min)
    };
    let mut points = Vec::new();
    let mut nearest = (f64::INFINITY, 0);
    for i in 0..lattice.sample_count() {
        let distance = distance(&lattice.sample_position(i));
        if distance <= 0.0 {
            points.push(i);
        } else if distance < nearest.0 {
            nearest = (distance, i);
        }
    }
    if points.is_empty() && lattice.sample_count() > 0 {
        points.push(nearest.1);
    }
    points
}

/// Half the least width of a shape \[m\].
pub fn radius(shape: &Shape) -> f64 {
    match shape {
        Shape::Sphere { radius } | Shape::Capsule { radius, .. } => *radius,
        Shape::Cuboid { half } | Shape::Ellipsoid { half } => half.min(),
        Shape::Cylinder { radius, half_length } => radius.min(*half_length),
        Shape::Cone { radius, height } => radius.min(0.5 * height),
        Shape::Mesh(mesh) => {
            let low = mesh.points.iter().copied().reduce(|a, b| a.inf(&b));
            let high = mesh.points.iter().copied().reduce(|a, b| a.sup(&b));
            low.zip(high).map_or(0.0, |(low, high)| 0.5 * (high - low).min())
        }
        Shape::HalfSpace | Shape::Compound(_) => 0.0,
    }
}
