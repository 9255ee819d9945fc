//! Zero-length springs and dampers between flesh nodes and their skinning targets (Eq. 7, 8),
//! and what they add to the coupled system (Eq. 9): the diagonal of A_f, the blocks A_sf and
//! A_fs, and A_s for each bone and each pair of bones that share a node.
//!
//! The springs have no net force and no net torque. The dampers have no net force; their net
//! torque is the product of damping force and stretch, since they act on the bone at the target.

use crate::coupling::{BoundNode, KernelValue, OffsetModel, PosedOffsets, skin_target};
use crate::math::{Mat3, Mat6, Pose, Vec3};
use crate::model::FleshInStep1;
use crate::solver::BlockMatrix;

/// All bound nodes, and those of the same bodies that are not.
#[derive(Clone, Debug, Default)]
pub struct CouplingModel {
    /// Bound nodes and what carries them.
    pub bound: Vec<BoundNode>,
    /// Nodes that no spring binds, and what carries them.
    pub unbound: Vec<BoundNode>,
    /// Spring of each bound node \[N/m\].
    pub stiffness: Vec<f64>,
    /// Damper of each \[N s/m\].
    pub damping: Vec<f64>,
    /// Joint between the two bones of each, and whether its child is the first of them.
    pub joints: Vec<Option<(u32, bool)>>,
    /// Offsets of targets by the pose of joints.
    pub offsets: OffsetModel,
    /// Places of the blocks of each in the system matrix.
    pub entries: Vec<CouplingEntries>,
}

/// Places in the system matrix: `[bone][linear, angular]`.
#[derive(Clone, Copy, Debug)]
pub struct CouplingEntries {
    /// (node, node).
    pub node: u32,
    /// (node, bone part).
    pub node_bone: [[u32; 2]; 2],
    /// (bone part, node).
    pub bone_node: [[u32; 2]; 2],
    /// (bone part, bone part).
    pub bone_bone: [[[[u32; 2]; 2]; 2]; 2],
}

/// The bones' own system in step 1: `S Δ = b_s - S v_s + pull`.
#[derive(Clone, Debug)]
pub struct BoneSystem {
    /// S of each rigid body with itself.
    pub diagonal: Vec<Mat6>,
    /// S between the two bodies of each joint: rows of the child, columns of the parent.
    pub edge: Vec<Mat6>,
    /// `-S_sf v_f`: linear and angular impulse by which the flesh's velocity pulls each body.
    pub pull: Vec<[Vec3; 2]>,
}

impl BoneSystem {
    /// Room for this many bodies and joints.
    pub fn new(rigids: usize, joints: usize) -> Self {
        Self {
            diagonal: vec![Mat6::zeros(); rigids],
            edge: vec![Mat6::zeros(); joints],
            pull: vec![[Vec3::zeros(); 2]; rigids],
        }
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        self.diagonal.fill(Mat6::zeros());
        self.edge.fill(Mat6::zeros());
        self.pull.fill([Vec3::zeros(); 2]);
    }
}

/// Mass of the flesh for step 1: decides how much of a node's spring the bone feels there.
#[derive(Clone, Copy, Debug)]
pub struct EffectiveMass<'a> {
    /// The assumption.
    pub flesh: FleshInStep1,
    /// Nodal mass with its damping, `m (1 + α Δt)` \[kg\]; infinite for held nodes.
    pub mass: &'a [f64],
}

impl EffectiveMass<'_> {
    /// The part of the implicit spring `s = Δt² k + Δt c` that a bone feels in step 1.
    ///
    /// A frozen node resists with all of s. A node that yields by its own inertia, its other forces
    /// in balance, follows the bone by `v_f = (m v_f,0 + s J v_s) / (m + s)`, so that the bone
    /// feels s and the node's mass in series, `s m / (m + s)`.
    #[inline]
    fn felt(&self, node: u32, s: f64) -> f64 {
        let m = self.mass[node as usize];
        match self.flesh {
            FleshInStep1::Lumped if m.is_finite() => s * m / (m + s),
            _ => s,
        }
    }
}

impl CouplingModel {
    /// All nodes that bones carry, with a spring or without.
    pub fn carried(&self) -> impl Iterator<Item = &BoundNode> {
        self.bound.iter().chain(&self.unbound)
    }

    /// Shares of all offsets where the bones are: for reading; a step has room of its own for them.
    pub fn shares(&self, poses_WB: &[Pose]) -> Vec<KernelValue> {
        let mut shares = Vec::new();
        self.offsets.pose(poses_WB, &mut shares);
        shares
    }

    /// Adds the springs to `A` and `b`, and to `bones` what the bones feel of them in step 1. `x`
    /// and `v` are nodal.
    pub fn assemble(
        &self,
        poses_WB: &[Pose],
        posed: &PosedOffsets<'_>,
        x: &[Vec3],
        v: &[Vec3],
        h: f64,
        step1: &EffectiveMass<'_>,
        A: &mut BlockMatrix,
        b: &mut [Vec3],
        bones: &mut BoneSystem,
    ) {
        let row0 = 2 * poses_WB.len();
        debug_assert_eq!([b.len(), A.rows()], [row0 + x.len(); 2], "rows of b and A, unknowns");
        debug_assert_eq!(v.len(), x.len(), "velocities of nodes, nodes");
        debug_assert_eq!(self.stiffness.len(), self.bound.len(), "springs, bound nodes");
        debug_assert!(h > 0.0 && h.is_finite(), "a time step of {h} s");
        for (i, bound) in self.bound.iter().enumerate() {
            let target = skin_target(bound, poses_WB, posed);
            let s = h * h * self.stiffness[i] + h * self.damping[i];
            let felt = step1.felt(bound.node, s);
            let entries = &self.entries[i];
            let node = bound.node as usize;
            let stretch = (x[node] - target.position_W) * (h * self.stiffness[i]);
            // ∂f/∂q_j = [w I, turning]
            let jacobian: [[Mat3; 2]; 2] = std::array::from_fn(|j| {
                [Mat3::from_diagonal_element(bound.weights[j]), target.turning.matrix(j)]
            });

            A.add_scalar(entries.node, s);
            b[row0 + node] -= stretch;
            for j in 0..bound.bone_count() {
                let bone = bound.bones[j] as usize;
                b[2 * bone] += stretch * bound.weights[j];
                b[2 * bone + 1] += target.turning.torque(j, &stretch);
                let pull = v[node] * felt;
                bones.pull[bone][0] += pull * bound.weights[j];
                bones.pull[bone][1] += target.turning.torque(j, &pull);
                for part in 0..2 {
                    let block = jacobian[j][part] * -s;
                    A.add(entries.node_bone[j][part], &block);
                    A.add(entries.bone_node[j][part], &block.transpose());
                }
                for l in 0..bound.bone_count() {
                    for (p, q) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                        let block = jacobian[j][p].tr_mul(&jacobian[l][q]);
                        A.add(entries.bone_bone[j][l][p][q], &(block * s));
                        if j == l {
                            add_part(&mut bones.diagonal[bone], p, q, &(block * felt));
                        }
                    }
                }
            }
            if let Some((joint, first_is_child)) = self.joints[i] {
                let (child, parent) = if first_is_child { (0, 1) } else { (1, 0) };
                for (p, q) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let block = jacobian[child][p].tr_mul(&jacobian[parent][q]) * felt;
                    add_part(&mut bones.edge[joint as usize], p, q, &block);
                }
            }
        }
    }

    /// Energy stored in the springs \[J\].
    pub fn energy(&self, poses_WB: &[Pose], x: &[Vec3]) -> f64 {
        let shares = self.shares(poses_WB);
        let posed = self.offsets.with(&shares);
        let stretch2 = |bound: &BoundNode| {
            let target = skin_target(bound, poses_WB, &posed);
            (x[bound.node as usize] - target.position_W).norm_squared()
        };
        self.bound.iter().zip(&self.stiffness).map(|(bound, k)| 0.5 * k * stretch2(bound)).sum()
    }
}

impl BoundNode {
    /// Returns the number of bones that carry the node: 1 or 2.
    pub fn bone_count(&self) -> usize {
        if self.weights[1] == 0.0 { 1 } else { 2 }
    }
}

/// Adds a 3×3 part to a 6×6 matrix.
pub(crate) fn add_part(m: &mut Mat6, p: usize, q: usize, part: &Mat3) {
    for r in 0..3 {
        for c in 0..3 {
            m[(3 * p + r, 3 * q + c)] += part[(r, c)];
        }
    }
}
