//! The bones that each node of a figure's flesh follows: two that are joined, at most.

use super::plan::{Plan, PlanSkin};
use crate::mesh::Bvh;
use crate::weights::pair;
use std::collections::BTreeMap;
use thenar_core::Vec3;
use thenar_core::model::Binding;

/// Bindings of nodes, and what of the file's weights they could not keep.
pub struct Bound {
    /// One binding per node.
    pub bindings: Vec<Binding>,
    /// Mean part of a node's weights on bones other than its two.
    pub lost: f64,
}

/// Binds nodes at these places of M.
pub fn bind(plan: &Plan, nodes: &[Vec3], thickness: f64) -> Bound {
    match &plan.skin {
        Some(skin) => by_skin(plan, skin, nodes),
        None => {
            let bindings = nodes.iter().map(|p| by_distance(plan, p, thickness)).collect();
            Bound { bindings, lost: 0.0 }
        }
    }
}

/// By the weights of the skin's nearest point.
fn by_skin(plan: &Plan, skin: &PlanSkin, nodes: &[Vec3]) -> Bound {
    let surface = Bvh::new(&skin.mesh);
    let mut lost = 0.0;
    let bindings = nodes.iter().map(|p| {
        let at = surface.closest(p);
        let mut weights: BTreeMap<u32, f64> = BTreeMap::new();
        for (v, part) in skin.mesh.triangles[at.triangle as usize].iter().zip(at.weights) {
            for (bone, weight) in skin.influences[*v as usize] {
                *weights.entry(bone).or_insert(0.0) += part * weight;
            }
        }
        let (binding, kept) = best_pair(plan, &weights);
        lost += 1.0 - kept;
        binding
    });
    let bindings: Vec<Binding> = bindings.collect();
    let lost = lost / bindings.len().max(1) as f64;
    Bound { bindings, lost }
}

/// The bone with its parent that have most, and how much that is; of equals the first.
fn best_pair(plan: &Plan, weights: &BTreeMap<u32, f64>) -> (Binding, f64) {
    let share = |b: u32| weights.get(&b).copied().unwrap_or(0.0);
    // A bone alone counts as a pair with whichever neighbour has nothing.
    let pairs = (0..plan.bones.len() as u32).map(|b| {
        let parent = plan.bones[b as usize].parent;
        (parent.unwrap_or(b), b, share(b) + parent.map_or(0.0, share))
    });
    let most = pairs.reduce(|best, next| if next.2 > best.2 { next } else { best });
    match most {
        Some((parent, bone, kept)) if kept > 0.0 => {
            let own = if parent == bone { 1.0 } else { share(bone) / kept };
            (pair(parent, bone, own), kept)
        }
        _ => (pair(0, 0, 0.0), 0.0),
    }
}

/// By the distance to the bones' solids: halfway between two joined bones a node follows both
/// alike, and the other's share fades where it is farther by twice the thickness of the flesh.
fn by_distance(plan: &Plan, p: &Vec3, thickness: f64) -> Binding {
    let distances: Vec<f64> = plan
        .bones
        .iter()
        .map(|bone| {
            let to =
                |s: &super::plan::PlanSolid| s.shape.distance(&s.pose_MS.inverse_point(p)).value;
            bone.solids.iter().map(to).fold(f64::INFINITY, f64::min)
        })
        .collect();
    let nearest =
        (0..distances.len()).reduce(|a, b| if distances[b] < distances[a] { b } else { a });
    let Some(nearest) = nearest.filter(|&b| distances[b].is_finite()) else {
        return pair(0, 0, 0.0);
    };
    let joined = |b: &usize| {
        let parent = |b: usize| plan.bones[b].parent.map(|p| p as usize);
        parent(*b) == Some(nearest) || parent(nearest) == Some(*b)
    };
    let second = (0..distances.len())
        .filter(joined)
        .reduce(|a, b| if distances[b] < distances[a] { b } else { a });
    let Some(second) = second else { return pair(nearest as u32, nearest as u32, 0.0) };
    let farther = (distances[second] - distances[nearest]) / (2.0 * thickness);
    let share = 0.5 * (1.0 - farther).max(0.0);
    pair(nearest as u32, second as u32, share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::plan::{PlanBone, PlanJoint, PlanSolid};
    use thenar_core::Pose;
    use thenar_core::model::{Axis, JointKind};
    use thenar_core::shape::Shape;

    /// Three balls in a row along x, 0.1 m apart; the last two hang on the one before.
    fn row() -> Plan {
        let bone = |i: u32| {
            let pose_ML = Pose::translation(0.1 * f64::from(i), 0.0, 0.0);
            let joint = PlanJoint {
                name: format!("joint {i}"),
                kind: JointKind::Ball,
                pose_MJ: pose_ML,
                axes: [Axis::default(); 2],
            };
            PlanBone {
                name: format!("bone {i}"),
                parent: i.checked_sub(1),
                pose_ML,
                joint: (i > 0).then_some(joint),
                mass: None,
                solids: vec![PlanSolid { shape: Shape::Sphere { radius: 0.03 }, pose_MS: pose_ML }],
            }
        };
        Plan {
            name: String::new(),
            bones: (0..3).map(bone).collect(),
            skin: None,
            mimics: vec![],
            notes: vec![],
        }
    }

    #[test]
    fn halfway_between_two_bones_both_count_alike() {
        let at = |x: f64| by_distance(&row(), &(Vec3::x() * x), 0.02);
        let shares = |x: f64| {
            let binding = at(x);
            [0, 1, 2].map(|b| {
                (0..2).filter(|&k| binding.bones[k] == b).map(|k| binding.weights[k]).sum::<f64>()
            })
        };
        assert_eq!(shares(-0.1), [1.0, 0.0, 0.0]);
        for (x, wanted) in
            [(0.05, [0.5, 0.5, 0.0]), (0.15, [0.0, 0.5, 0.5]), (0.1, [0.0, 1.0, 0.0])]
        {
            let got = shares(x);
            assert!((0..3).all(|b| (got[b] - wanted[b]).abs() < 1e-9), "{x}: {got:?}");
        }
        // 10 mm off the middle the distances differ by 20 mm of 40: a quarter is left.
        let got = shares(0.04);
        assert!((got[1] - 0.25).abs() < 1e-9, "{got:?}");
    }

    /// Weights on bones that are not joined cannot be kept: the best pair is, and the rest is
    /// reported.
    #[test]
    fn the_best_pair_of_joined_bones_is_kept() {
        let weights = BTreeMap::from([(0, 0.5), (1, 0.2), (2, 0.3)]);
        let (binding, kept) = best_pair(&row(), &weights);
        assert_eq!(binding.bones, [0, 1]);
        assert!((kept - 0.7).abs() < 1e-12 && (binding.weights[1] - 0.2 / 0.7).abs() < 1e-12);
        let alone = best_pair(&row(), &BTreeMap::from([(2, 1.0)])).0;
        assert_eq!((alone.bones, alone.weights), ([2, 2], [1.0, 0.0]));
    }
}
