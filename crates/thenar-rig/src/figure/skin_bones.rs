//! Solids of bones that come with a skin and no geometry: as wide as bones are in limbs.
//!
//! A long bone is a capsule from its joint to each child's. One whose part of the skin is flat or
//! stout, such as a foot, a palm, a pelvis or a head, is a box within that part.

use super::build::begin;
use super::in_solid::radius;
use super::plan::{Plan, PlanSkin, PlanSolid};
use super::solid;
use crate::RigError;
use crate::mesh::Bvh;
use crate::object::length_in_words;
use crate::size::place_in_words;
use nalgebra::{Matrix3, Rotation3};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat, Vec3};
use thenar_input::quoted;

/// Half the width of a bone over the distance from its middle to the skin: between that of a
/// phalanx (0.45) and of a metacarpal (0.36).
const BONE_WIDTH: f64 = 0.4;
/// A part of the skin is long when it is more than twice as long as wide and less than one and a
/// half times as wide as thick, as thighs, forearms and phalanges are.
const LONG: [f64; 2] = [2.0, 1.5];
/// Number of steps in which a box grows to its bounds.
const GROWTH: f64 = 20.0;
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
        let [from, end] = ends[b];
        // Skin that is thin beside the flesh around the bone says nothing of the bone's width: a
        // loop of vertices.
        let boxed =
            boxed.filter(|inside| 2.0 * inside.deep > BONE_WIDTH * depth(surface, &from, &end));
        let boxed = boxed.and_then(|inside| inside.grown(surface));
        let solids = boxed.map_or_else(|| long(plan, b, ends[b], surface), |solid| vec![solid]);
        if solids.iter().map(|s| radius(&s.shape)).any(|r| r.is_nan() || r <= 0.0) {
            return Err(bare(&plan.bones[b].name, &from, &end, surface));
        }
        plan.bones[b].solids = solids;
    }
    Ok(())
}

/// A bone that no skin surrounds, and what helps.
fn bare(name: &str, from: &Vec3, to: &Vec3, surface: &Bvh) -> RigError {
    RigError::invalid(format!(
        "bone {} has no geometry and lies on or outside the skin, from {} to {} m, in the mean by {}: name the meshes that \
         are around it (`--mesh`), close the skin there, or take the weights of its joint away",
        quoted(name),
        place_in_words(from),
        place_in_words(to),
        length_in_words((-depth(surface, from, to)).max(0.0)),
    ))
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

/// Mean depth under the surface along the middle of the line from `a` to `b` \[m\]; negative
/// outside.
fn depth(surface: &Bvh, a: &Vec3, b: &Vec3) -> f64 {
    let places = [0.2, 0.35, 0.5, 0.65, 0.8];
    let sum: f64 = places.iter().map(|t| -surface.signed_distance(&a.lerp(b, *t))).sum();
    sum / places.len() as f64
}

/// A box in its frame S, from its lowest to its highest corner.
#[derive(Clone, Copy, Debug)]
struct Inside {
    pose_MS: Pose,
    /// Lowest and highest corner that it may have.
    bounds: [Vec3; 2],
    /// Distance under the skin \[m\].
    deep: f64,
}

impl Inside {
    /// The box grown from its middle, face after face, as far as its corners are at least half as
    /// deep under the skin as they should be: skin is no box. None where its middle is not.
    fn grown(&self, surface: &Bvh) -> Option<PlanSolid> {
        let [low, high] = self.bounds;
        let middle = 0.5 * (low + high);
        let fits = |ends: &[Vec3; 2]| {
            let corner = |c: usize| Vec3::from([0, 1, 2].map(|k| ends[c >> k & 1][k]));
            let deep =
                |p: &Vec3| surface.signed_distance(&self.pose_MS.point(p)) < -0.5 * self.deep;
            (0..8).map(corner).all(|p| deep(&p))
        };
        let mut ends = [middle + (low - middle) / GROWTH, middle + (high - middle) / GROWTH];
        if !fits(&ends) {
            return None;
        }
        let mut grows = true;
        while std::mem::take(&mut grows) {
            for face in 0..6 {
                let (side, k) = (face % 2, face / 2);
                let mut wider = ends;
                wider[side][k] += (self.bounds[side][k] - middle[k]) / GROWTH;
                let within = (wider[side][k] - middle[k]).abs()
                    <= (self.bounds[side][k] - middle[k]).abs() * (1.0 + 1e-9);
                if within && wider != ends && fits(&wider) {
                    (ends, grows) = (wider, true);
                }
            }
        }
        let half = 0.5 * (ends[1] - ends[0]);
        let centre = self.pose_MS.point(&(0.5 * (ends[0] + ends[1])));
        let pose_MS = Pose::new(centre, self.pose_MS.rotation);
        (half.min() > 0.0).then_some(PlanSolid { shape: Shape::Cuboid { half }, pose_MS })
    }
}

/// A box along the main axes of the skin that a bone moves, as far under it all round as a bone is;
/// none where that skin is long, or too little to tell.
fn stout(skin: &PlanSkin, bone: u32) -> Option<Inside> {
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
    let inset = Vec3::repeat(deep);
    let pose_MS = Pose::new(mean, Quat::from_rotation_matrix(&turn));
    Some(Inside { pose_MS, bounds: [low + inset, high - inset], deep })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// A part of skin that is a box, of which one bone has all.
    fn skin(half: Vec3) -> PlanSkin {
        let mesh = shapes::cuboid(&half);
        let influences = vec![[(0, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)]; mesh.positions.len()];
        PlanSkin { mesh, influences, joined: false }
    }

    #[test]
    fn a_foot_has_a_box_and_a_thigh_has_none() {
        let half = Vec3::new(0.13, 0.03, 0.055);
        let foot = stout(&skin(half), 0).unwrap();
        assert!((foot.deep - 0.018).abs() < 1e-12, "{foot:?}");
        let solid = foot.grown(&Bvh::new(&shapes::cuboid(&half))).unwrap();
        let Shape::Cuboid { half } = solid.shape else { panic!("{:?}", solid.shape) };
        // As far under the skin all round as 0.6 of half the thickness.
        let mut sorted: [f64; 3] = half.into();
        sorted.sort_by(f64::total_cmp);
        for (got, wanted) in sorted.into_iter().zip([0.012, 0.037, 0.112]) {
            assert!((got - wanted).abs() < 1e-6, "{half:?}");
        }
        assert!(stout(&skin(Vec3::new(0.07, 0.22, 0.075)), 0).is_none());
        assert!(stout(&skin(Vec3::repeat(0.1)), 1).is_none(), "no skin of its own");
        assert!(stout(&skin(Vec3::new(0.08, 0.11, 0.095)), 0).is_some(), "a head");
    }

    /// In a ball a box grows until its corners are deep enough: for half-edges a, √3 a ≤ R - d/2,
    /// in steps of a twentieth.
    #[test]
    fn a_box_is_as_deep_as_it_should_be() {
        let ball = shapes::sphere(0.1, 12);
        let bounds = [Vec3::repeat(-0.08), Vec3::repeat(0.08)];
        let inside = Inside { pose_MS: Pose::identity(), bounds, deep: 0.04 };
        let Shape::Cuboid { half } = inside.grown(&Bvh::new(&ball)).unwrap().shape else {
            panic!()
        };
        let most = 0.08 / 3.0_f64.sqrt();
        assert!(half.norm() <= 0.08 && half.min() > most - 0.004, "{half:?}");
        let outside = Inside { pose_MS: Pose::translation(0.2, 0.0, 0.0), ..inside };
        assert!(outside.grown(&Bvh::new(&ball)).is_none());
    }
}
