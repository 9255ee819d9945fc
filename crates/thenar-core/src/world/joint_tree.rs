//! Bodies placed along the joints that tie them, so that no joint opens however far a step turns.
//!
//! Outwards along each tree a body takes its place from the one before it: the anchor points meet,
//! and the joint has turned about its own axes alone, by its rates over the step. Joints left over
//! because they close loops are closed afterwards (`kinematic_advance`).

use crate::math::{Pose, Quat, Vec3};
use crate::skeleton::turn_joint;
use crate::solver::tree::spanning;
use crate::world::model::Model;
use std::ops::Range;

/// A joint and the body that hangs on it.
#[derive(Clone, Copy, Debug)]
struct TreeJoint {
    joint: usize,
    outward: usize,
    /// The body that hangs on the joint is its parent.
    reversed: bool,
}

/// Bodies that joints or flesh tie to each other and to nothing fixed.
#[derive(Clone, Debug)]
pub struct FloatingGroup {
    /// Rigid bodies.
    pub bodies: Vec<usize>,
    /// Nodes of the flesh around them.
    pub nodes: Vec<Range<usize>>,
}

/// Bodies that hang on one joint with what is fixed.
#[derive(Clone, Debug)]
pub struct Subtree {
    /// This joint.
    pub joint: usize,
    /// Rigid bodies.
    pub bodies: Vec<usize>,
}

/// All joints in the order in which they place bodies.
#[derive(Clone, Debug, Default)]
pub struct JointTree {
    hung: Vec<TreeJoint>,
    /// Joints that close loops.
    pub cuts: Vec<usize>,
    /// Bodies that keep their momentum.
    pub floating: Vec<FloatingGroup>,
    /// Bodies that keep their swing: trees of rigid bodies without loops.
    pub hanging: Vec<Subtree>,
}

impl JointTree {
    /// Plans for the joints and the flesh of a model.
    pub fn new(model: &Model) -> Self {
        let moves: Vec<bool> = model.rigids.iter().map(|r| r.moves).collect();
        // Joints without rows tie nothing.
        let real: Vec<usize> =
            (0..model.joints.len()).filter(|&j| model.joints[j].kind.rows() > 0).collect();
        let ends: Vec<_> =
            real.iter().map(|&j| (model.joints[j].parent, model.joints[j].child)).collect();
        let spanned = spanning(&moves, &ends);
        let hung = spanned.links.iter().filter_map(|link| {
            let joint = real[link.joint?];
            Some(TreeJoint { joint, outward: link.bone, reversed: link.reversed })
        });
        let mut tree = Self {
            hung: hung.collect(),
            cuts: spanned.cuts.iter().map(|&j| real[j]).collect(),
            floating: Vec::new(),
            hanging: Vec::new(),
        };
        tree.floating = find_floating(model, &real);
        tree.hanging = tree.find_hanging(model);
        tree
    }

    /// Trees that hang on one joint with the world, but for those with flesh or loops.
    fn find_hanging(&self, model: &Model) -> Vec<Subtree> {
        let mut root_of: Vec<Option<usize>> = vec![None; model.rigids.len()];
        for hung in &self.hung {
            let joint = &model.joints[hung.joint];
            root_of[hung.outward] = match joint.parent {
                None => Some(hung.joint),
                Some(p) if hung.reversed => {
                    root_of[joint.child as usize].filter(|_| p != joint.child)
                }
                Some(p) => root_of[p as usize],
            };
        }
        let in_loops = self.cuts.iter().flat_map(|&j| {
            let joint = &model.joints[j];
            [Some(joint.child), joint.parent].into_iter().flatten()
        });
        let fleshy = model.coupling.bound.iter().flat_map(|bound| bound.bones);
        let left_out: Vec<Option<usize>> =
            in_loops.chain(fleshy).map(|b| root_of[b as usize]).collect();
        let mut roots: Vec<usize> = root_of.iter().flatten().copied().collect();
        roots.sort_unstable();
        roots.dedup();
        roots.retain(|root| !left_out.contains(&Some(*root)));
        let of = |joint: usize| {
            let bodies = (0..root_of.len()).filter(|&b| root_of[b] == Some(joint)).collect();
            Subtree { joint, bodies }
        };
        roots.into_iter().map(of).collect()
    }

    /// Rotation `R_JK` of each joint after a step: `poses_WB` are those before it, `spin` gives the
    /// angular velocity of a body over the step \[rad/s\], world.
    pub fn turn(
        &self,
        model: &Model,
        poses_WB: &[Pose],
        spin: impl Fn(usize) -> Vec3,
        h: f64,
        rotations_JK: &mut [Quat],
    ) {
        for hung in &self.hung {
            let joint = &model.joints[hung.joint];
            let child = joint.child as usize;
            let parent = joint.parent.map(|p| p as usize);
            let R_WP = parent.map_or(Quat::identity(), |p| poses_WB[p].rotation);
            let R_WJ = R_WP * joint.pose_PJ.rotation;
            let R_WK = poses_WB[child].rotation * joint.pose_CK.rotation;
            let relative = spin(child) - parent.map_or(Vec3::zeros(), &spin);
            let spin_J = R_WJ.inverse_transform_vector(&relative);
            rotations_JK[hung.joint] = turn_joint(joint.kind, &(R_WJ.inverse() * R_WK), &spin_J, h);
        }
    }

    /// Places every body that hangs on a joint, from the poses of those that do not.
    pub fn place(&self, model: &Model, rotations_JK: &[Quat], poses_WB: &mut [Pose]) {
        for hung in &self.hung {
            let joint = &model.joints[hung.joint];
            let pose_JK = Pose::new(Vec3::zeros(), rotations_JK[hung.joint]);
            let pose_PC = joint.pose_PJ * pose_JK * joint.pose_CK.inverse();
            let mut pose = if hung.reversed {
                poses_WB[joint.child as usize] * pose_PC.inverse()
            } else {
                joint.parent.map_or(pose_PC, |p| poses_WB[p as usize] * pose_PC)
            };
            pose.rotation = Quat::new_normalize(pose.rotation.into_inner());
            poses_WB[hung.outward] = pose;
        }
    }
}

/// Bodies with joints or flesh that nothing fixed holds.
fn find_floating(model: &Model, real: &[usize]) -> Vec<FloatingGroup> {
    let bodies = model.rigids.len();
    // The last entry stands for all that is fixed.
    let fixed = bodies;
    let mut leader: Vec<usize> = (0..=bodies).collect();
    let place = |b: Option<u32>| match b {
        Some(b) if model.rigids[b as usize].moves => b as usize,
        _ => fixed,
    };
    let mut ties: Vec<(usize, usize)> = Vec::new();
    for &j in real {
        ties.push((place(model.joints[j].parent), place(Some(model.joints[j].child))));
    }
    let mut bone_of_soft: Vec<Option<usize>> = vec![None; model.soft_nodes.len()];
    for bound in &model.coupling.bound {
        let node = bound.node as usize;
        let Some(soft) = model.soft_nodes.iter().position(|nodes| nodes.contains(&node)) else {
            continue;
        };
        for &bone in &bound.bones[..bound.bone_count()] {
            let bone = place(Some(bone));
            ties.push((*bone_of_soft[soft].get_or_insert(bone), bone));
        }
        if model.is_held[node] {
            ties.extend(bone_of_soft[soft].map(|bone| (bone, fixed)));
        }
    }
    for &(a, b) in &ties {
        let (a, b) = (find(&leader, a), find(&leader, b));
        leader[a.min(b)] = a.max(b);
    }

    let tied = |b: usize| ties.iter().any(|&(p, q)| p == b || q == b);
    (0..bodies)
        .filter(|&b| find(&leader, b) == b && tied(b))
        .map(|head| FloatingGroup {
            bodies: (0..bodies).filter(|&b| find(&leader, b) == head).collect(),
            nodes: (0..bone_of_soft.len())
                .filter(|&s| bone_of_soft[s].is_some_and(|b| find(&leader, b) == head))
                .map(|s| model.soft_nodes[s].clone())
                .collect(),
        })
        .collect()
}

fn find(leader: &[usize], mut b: usize) -> usize {
    while leader[b] != b {
        b = leader[b];
    }
    b
}
