//! Solids of bones that come with a skin and no geometry: as wide as bones are in limbs.
//!
//! A long bone is a capsule from its joint to each child's. One whose part of the skin is flat or stout, such as a foot, a
//! palm, a pelvis or a head, is a box within that part.

use super::build::begin;
use super::in_solid::radius;
use super::plan::{Plan, PlanSkin, PlanSolid};
use super::solid;
use crate::RigError;
use crate::mesh::Bvh;
use nalgebra::{Matrix3, Rotation3};
use thenar::shape::Shape;
use thenar::{Pose, Quat, Vec3};

/// Half the width of a bone over the distance from its middle to the skin: between that of a phalanx (0.45) and of a
/// metacarpal (0.36).
const BONE_WIDTH: f64 = 0.4;
/// A part of the skin is long when it is more than twice as long as wide and less than one and a half times as wide as
/// thick, as thighs, forearms and phalanges are.
const LONG: [f64; 2] = [2.0, 1.5];
/// A box that is not deep enough under the skin is made smaller by this factor, so many times at most: to a tenth.
const SHRINK: f64 = 0.95;
const SHRINKS_MAX: u32 = 45;
/// Vertices belong to the bone that has most of their weight.
const OWN: f64 = 0.5;

/// Gives solids to bones without.
///
/// # Errors
/// When a bone has no extent and lies on the skin.
pub fn give_solids(plan: &mut Plan, ends: &[[Vec3; 2]], surface: &Bvh) -> Result<(), RigError> {
    for b in 0..plan.bones.len() {
        if !plan.bones[b].solids.is_empty() {
            continue;
        }
        let boxed = plan.skin.as_ref().and_then(|skin| stout(skin, b as u32));
        let boxed = boxed.map(|(solid, deep)| sunk(solid, deep, surface));
        let solids = boxed.map_or_else(|| long(plan, b, ends[b], surface), |solid| vec![solid]);
        if solids.iter().map(|s| radius(&s.shape)).any(|r| r.is_nan() || r <= 0.0) {
            return Err(RigError::invalid(format!(
                "bone \"{}\" has no extent, and lies on the skin: leave its joint out of the rig",
                plan.bones[b].name
            )));
        }
        plan.bones[b].solids = solids;
    }
    Ok(())
}

/// Capsules from a bone's joint to each child's, or to its end.
fn long(plan: &Plan, b: usize, [from, end]: [Vec3; 2], surface: &Bvh) -> Vec<PlanSolid> {
    let children = plan.bones.iter().filter(|bone| bone.parent == Some(b as u32)).map(begin);
    let mut to: Vec<Vec3> = children.filter(|to| (to - from).norm() > 0.0).collect();
    if to.is_empty() {
        to.push(end);
    }
    to.iter().map(|to| within(&from, to, BONE_WIDTH * depth(surface, &from, to))).collect()
}

/// A capsule that begins and ends with its caps at these points.
fn within(from: &Vec3, to: &Vec3, radius: f64) -> PlanSolid {
    let along = to - from;
    let length = along.norm();
    let inset = along * (radius / length.max(f64::MIN_POSITIVE)).min(0.4);
    solid::capsule(&(from + inset), &(to - inset), radius)
}

/// Mean distance to the surface along the middle of the line from `a` to `b` \[m\].
fn depth(surface: &Bvh, a: &Vec3, b: &Vec3) -> f64 {
    let places = [0.2, 0.35, 0.5, 0.65, 0.8];
    let sum: f64 = places.iter().map(|t| surface.closest(&a.lerp(b, *t)).distance).sum();
    sum / places.len() as f64
}

/// Shrinks a box until all of its corners are at least half as deep under the skin as they should be \[m\]: skin is no
/// box. A box that lies outside altogether ends as small as it may be.
fn sunk(mut solid: PlanSolid, deep: f64, surface: &Bvh) -> PlanSolid {
    for _ in 0..SHRINKS_MAX {
        let Shape::Cuboid { half } = &mut solid.shape else { return solid };
        let corner =
            |c: u32| Vec3::from([0, 1, 2].map(|k| if c >> k & 1 == 0 { -1.0 } else { 1.0 }));
        let mut corners = (0..8).map(|c| solid.pose_MS.point(&corner(c).component_mul(half)));
        if corners.all(|p| surface.signed_distance(&p) < -0.5 * deep) {
            return solid;
        }
        *half *= SHRINK;
    }
    solid
}

/// A box along the main axes of the skin that a bone moves, as far under it all round as a bone is, and how far that is
/// \[m\]; none where that skin is long, or too little to tell.
fn stout(skin: &PlanSkin, bone: u32) -> Option<(PlanSolid, f64)> {
    let own = skin.mesh.positions.iter().zip(&skin.influences).filter(|(_, four)| {
        four.iter().filter(|(b, _)| *b == bone).map(|(_, w)| w).sum::<f64>() > OWN
    });
    let points: Vec<Vec3> = own.map(|(p, _)| *p).collect();
    if points.len() < 4 {
        return None;
    }
    let mean = points.iter().sum::<Vec3>() / points.len() as f64;
    let spread: Matrix3<f64> = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
    let axes = spread.symmetric_eigen().eigenvectors;
    let (x, y) = (axes.column(0).into_owned(), axes.column(1).into_owned());
    let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]));
    let local = points.iter().map(|p| turn.inverse() * (p - mean));
    let (low, high) = local
        .fold((Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)), |(low, high), p| {
            (low.inf(&p), high.sup(&p))
        });
    let half = 0.5 * (high - low);
    let mut sorted: [f64; 3] = half.into();
    sorted.sort_by(f64::total_cmp);
    let [thickness, width, length] = sorted;
    if length > LONG[0] * width && width < LONG[1] * thickness {
        return None;
    }
    let deep = (1.0 - BONE_WIDTH) * thickness;
    let half = half - Vec3::repeat(deep);
    let centre = mean + turn * (0.5 * (low + high));
    let pose_MS = Pose::new(centre, Quat::from_rotation_matrix(&turn));
    (half.min() > 0.0).then_some((PlanSolid { shape: Shape::Cuboid { half }, pose_MS }, deep))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// A part of skin that is a box, of which one bone has all.
    fn skin(half: Vec3) -> PlanSkin {
        let mesh = shapes::cuboid(&half);
        let influences = vec![[(0, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)]; mesh.positions.len()];
        PlanSkin { mesh, influences }
    }

    #[test]
    fn a_foot_has_a_box_and_a_thigh_has_none() {
        let (foot, deep) = stout(&skin(Vec3::new(0.13, 0.03, 0.055)), 0).unwrap();
        assert!((deep - 0.018).abs() < 1e-12, "{deep}");
        let Shape::Cuboid { half } = foot.shape else { panic!("{:?}", foot.shape) };
        // As far under the skin all round as 0.6 of half the thickness.
        let mut sorted: [f64; 3] = half.into();
        sorted.sort_by(f64::total_cmp);
        for (got, wanted) in sorted.into_iter().zip([0.012, 0.037, 0.112]) {
            assert!((got - wanted).abs() < 1e-9, "{half:?}");
        }
        assert!(stout(&skin(Vec3::new(0.07, 0.22, 0.075)), 0).is_none());
        assert!(stout(&skin(Vec3::repeat(0.1)), 1).is_none(), "no skin of its own");
        assert!(stout(&skin(Vec3::new(0.08, 0.11, 0.095)), 0).is_some(), "a head");
    }

    /// In a ball a box is shrunk until its corners are deep enough: for half-edges a, √3 a ≤ R - d/2.
    #[test]
    fn a_box_is_as_deep_as_it_should_be() {
        let ball = shapes::sphere(0.1, 12);
        let half = Vec3::repeat(0.08);
        let at = PlanSolid { shape: Shape::Cuboid { half }, pose_MS: Pose::identity() };
        let shrunk = sunk(at, 0.04, &Bvh::new(&ball));
        let Shape::Cuboid { half } = shrunk.shape else { panic!() };
        let most = 0.08 / 3.0_f64.sqrt();
        assert!(half.x < most && half.x > 0.9 * most, "{half:?}");
    }
}
