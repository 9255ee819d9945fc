//! The constant part of a world: topology, rest shapes, materials, sparsity.

use crate::coupling::{BoundNode, CouplingEntries, CouplingModel, PairAtRest, Pivot};
use crate::flesh::{FleshModel, RestTet};
use crate::math::{Mat3, Vec3};
use crate::model::{
    BodyId, FrictionTable, JointDesc, Motion, PoseOffsets, Relaxation, Skin, Skinning, SoftDesc,
    WorldDesc,
};
use crate::solver::BlockMatrix;
use crate::world::joint_tree::JointTree;
use crate::world::{ModelError, check::check};
use std::ops::Range;

/// A rigid body's constants.
#[derive(Clone, Debug)]
pub struct RigidModel {
    /// False when its velocity is prescribed.
    pub moves: bool,
    /// Mass \[kg\].
    pub mass: f64,
    /// Inertia in B \[kg m²\].
    pub inertia: Mat3,
    /// Inverse of the inertia, in B \[1/(kg m²)\].
    pub inverse_inertia: Mat3,
}

/// Places of a joint's spring blocks in the system matrix (angular rows of child and parent).
#[derive(Clone, Copy, Debug)]
pub struct JointEntries {
    /// (child, child).
    pub child: u32,
    /// (parent, parent), (child, parent), (parent, child).
    pub with_parent: Option<[u32; 3]>,
}

/// An embedded collision vertex with its nodes numbered through all bodies.
#[derive(Clone, Copy, Debug)]
pub struct Embedded {
    /// Nodes of the tetrahedron.
    pub nodes: [u32; 4],
    /// Barycentric weights.
    pub weights: [f64; 4],
}

/// Everything constant.
#[derive(Clone, Debug)]
pub struct Model {
    /// Rigid bodies.
    pub rigids: Vec<RigidModel>,
    /// Joints of the world.
    pub joints: Vec<JointDesc>,
    /// Order in which the joints place bodies.
    pub tree: JointTree,
    /// Places of the joints' blocks in the system matrix.
    pub joint_entries: Vec<JointEntries>,
    /// Flesh of all deformable bodies.
    pub flesh: FleshModel,
    /// Coupling of all deformable bodies.
    pub coupling: CouplingModel,
    /// Nodes of each deformable body.
    pub soft_nodes: Vec<Range<usize>>,
    /// Elements of each deformable body.
    pub soft_tets: Vec<Range<usize>>,
    /// Collision vertices of each deformable body.
    pub soft_vertices: Vec<Range<usize>>,
    /// Collision vertices of all bodies.
    pub vertices: Vec<Embedded>,
    /// Part of each collision vertex, of each deformable body that has parts.
    pub parts: Vec<Vec<u8>>,
    /// The deformable body that each rigid body is a bone of, and the part of it that it is in.
    pub flesh_of_bone: Vec<Option<(u32, u8)>>,
    /// Pairs whose friction depends on load.
    pub friction: Vec<FrictionTable>,
    /// Held nodes (numbered through) and axes.
    pub held: Vec<(u32, [bool; 3])>,
    /// True for nodes with a held axis.
    pub is_held: Vec<bool>,
    /// Velocity components given from outside, per block row: prescribed bodies, held axes.
    pub known: Vec<[bool; 3]>,
    /// The zero matrix with the system's pattern.
    pub pattern: BlockMatrix,
}

impl Model {
    /// Compiles a description.
    pub fn new(desc: &WorldDesc) -> Result<Self, ModelError> {
        check(desc)?;
        let rigids: Vec<RigidModel> = desc
            .rigids
            .iter()
            .map(|r| RigidModel {
                moves: r.motion == Motion::Dynamic,
                mass: r.mass,
                inertia: r.inertia,
                inverse_inertia: r.inertia.try_inverse().unwrap_or_else(Mat3::identity),
            })
            .collect();
        let mut model = Self {
            rigids,
            joints: desc.joints.clone(),
            tree: JointTree::default(),
            joint_entries: Vec::new(),
            flesh: FleshModel::default(),
            coupling: CouplingModel::default(),
            soft_nodes: Vec::new(),
            soft_tets: Vec::new(),
            soft_vertices: Vec::new(),
            vertices: Vec::new(),
            parts: vec![Vec::new(); desc.softs.len()],
            flesh_of_bone: (0..desc.rigids.len() as u32).map(|b| desc.flesh_of_bone(b)).collect(),
            friction: desc.friction_tables.clone(),
            held: Vec::new(),
            is_held: Vec::new(),
            known: Vec::new(),
            pattern: BlockMatrix::with_pattern(0, []),
        };
        for soft in &desc.softs {
            model.add_soft(soft, desc)?;
        }
        for offsets in &desc.pose_offsets {
            model.add_pose_offsets(offsets, desc)?;
        }
        for parts in &desc.parts {
            model.parts[parts.soft as usize].clone_from(&parts.vertices);
        }
        model.is_held = vec![false; model.flesh.mass.len()];
        model.known = model.rigids.iter().flat_map(|r| [[!r.moves; 3]; 2]).collect();
        model.known.resize(model.rows(), [false; 3]);
        let row0 = 2 * model.rigids.len();
        for (node, axes) in &model.held {
            model.is_held[*node as usize] = true;
            for axis in 0..3 {
                model.known[row0 + *node as usize][axis] |= axes[axis];
            }
        }
        model.tree = JointTree::new(&model);
        model.lay_out();
        model.flesh.arrange();
        Ok(model)
    }

    /// Block rows of the system.
    pub fn rows(&self) -> usize {
        2 * self.rigids.len() + self.flesh.mass.len()
    }

    /// Part of a deformable body that a vertex of its collision surface belongs to.
    pub fn part_of(&self, soft: u32, vertex: u32) -> u32 {
        self.parts[soft as usize].get(vertex as usize).map_or(0, |part| u32::from(*part))
    }

    /// True when what touches `found` touches `asked`: that body, or a bone inside it.
    pub fn is_in(&self, found: BodyId, asked: BodyId) -> bool {
        match (found, asked) {
            (BodyId::Rigid(bone), BodyId::Soft(soft)) => {
                self.flesh_of_bone[bone as usize].is_some_and(|flesh| flesh.0 == soft)
            }
            _ => found == asked,
        }
    }

    /// True when there is flesh, and springs bind every node of it to bones.
    pub fn all_is_bound(&self) -> bool {
        !self.flesh.mass.is_empty() && self.coupling.bound.len() == self.flesh.mass.len()
    }

    fn add_soft(&mut self, soft: &SoftDesc, desc: &WorldDesc) -> Result<(), ModelError> {
        let flesh = &soft.flesh;
        let node0 = self.flesh.mass.len();
        let tet0 = self.flesh.tets.len();
        self.flesh.mass.resize(node0 + flesh.nodes.len(), 0.0);
        self.flesh.mass_damping.resize(node0 + flesh.nodes.len(), flesh.mass_damping);
        for (t, (tet, material)) in flesh.tets.iter().zip(&flesh.materials).enumerate() {
            let rest = RestTet::new(&tet.map(|n| flesh.nodes[n as usize]), material)
                .ok_or(ModelError::Tet { thing: soft.name.clone(), tet: t })?;
            for n in tet {
                self.flesh.mass[node0 + *n as usize] += 0.25 * rest.volume * material.density;
            }
            self.flesh.tets.push(tet.map(|n| node0 as u32 + n));
            self.flesh.rest.push(rest);
            let elastic = flesh.relaxation.get(t).is_none_or(Relaxation::is_none);
            self.flesh.stiffness_damping.push(if elastic { flesh.stiffness_damping } else { 0.0 });
        }
        if let Some(node) = self.flesh.mass[node0..].iter().position(|&m| m <= 0.0) {
            return Err(ModelError::LooseNode { thing: soft.name.clone(), node });
        }
        self.soft_nodes.push(node0..self.flesh.mass.len());
        self.soft_tets.push(tet0..self.flesh.tets.len());
        let shared = self.add_patches(soft, desc);
        self.flesh.memory.add(tet0, &shared.unwrap_or_else(|| flesh.relaxation.clone()));
        let of_body = |skin: &&Skin| skin.soft as usize == self.soft_tets.len() - 1;
        if let Some(skin) = desc.skins.iter().find(of_body) {
            self.flesh.add_skin(tet0, &skin.sheets, &skin.facets);
        }

        let vertex0 = self.vertices.len();
        self.vertices.extend(flesh.collision.vertices.iter().map(|v| Embedded {
            nodes: self.flesh.tets[tet0 + v.tet as usize],
            weights: v.weights,
        }));
        self.soft_vertices.push(vertex0..self.vertices.len());
        self.held.extend(flesh.fixed.iter().map(|f| (node0 as u32 + f.node, f.axes)));
        self.add_coupling(soft, desc, node0)
    }

    /// Evaluates the body added last by patches, if it has some; then, what each tetrahedron
    /// remembers: the first of a patch for all.
    fn add_patches(&mut self, body: &SoftDesc, desc: &WorldDesc) -> Option<Vec<Relaxation>> {
        let soft = self.soft_tets.len() - 1;
        let tets = self.soft_tets[soft].clone();
        let patches = desc.patches.iter().find(|p| p.soft as usize == soft)?;
        let mut relaxations = body.flesh.relaxation.clone();
        let mut members: Vec<(u32, usize)> = patches.of_tet.iter().copied().zip(0..).collect();
        members.sort_unstable();
        for patch in members.chunk_by(|a, b| a.0 == b.0) {
            let of = |&(_, t): &(u32, usize)| {
                (self.flesh.tets[tets.start + t], &self.flesh.rest[tets.start + t])
            };
            let elements: Vec<_> = patch.iter().map(of).collect();
            let first = patch[0].1;
            let relaxation = relaxations.get(first).copied().unwrap_or_default();
            let damping = self.flesh.stiffness_damping[tets.start + first];
            self.flesh.patches.push(tets.start + first, &elements, &relaxation, damping);
            for (_, other) in &patch[1..] {
                relaxations.get_mut(*other).into_iter().for_each(|r| *r = Relaxation::NONE);
            }
        }
        self.flesh.patched.push(tets);
        Some(relaxations)
    }

    fn add_coupling(
        &mut self,
        soft: &SoftDesc,
        desc: &WorldDesc,
        node0: usize,
    ) -> Result<(), ModelError> {
        let Some(coupling) = &soft.coupling else { return Ok(()) };
        let hangs = coupling.springs.stiffness().any(|stiffness| stiffness > 0.0);
        let springs = coupling.bindings.iter().zip(coupling.springs.stiffness());
        for (node, (binding, stiffness)) in springs.enumerate() {
            let (mut bones, mut weights) = (binding.bones, binding.weights);
            if weights[0] == 0.0 {
                bones.swap(0, 1);
                weights.swap(0, 1);
            }
            if bones[0] == bones[1] {
                weights = [1.0, 0.0];
            }
            let x_W = soft.pose_WM.point(&soft.flesh.nodes[node]);
            let offsets = bones.map(|b| desc.rigids[b as usize].pose_WB.inverse_point(&x_W));
            let node_W = (node0 + node) as u32;
            let joint = if weights[1] == 0.0 { None } else { joint_between(&desc.joints, bones) };
            let pivot = joint.filter(|_| coupling.skinning == Skinning::Joint).map(|(j, first)| {
                let (joint, poses) =
                    (&desc.joints[j as usize], bones.map(|b| &desc.rigids[b as usize].pose_WB));
                let (child, parent) = (joint.pose_CK.position, joint.pose_PJ.position);
                let anchors_B = if first { [child, parent] } else { [parent, child] };
                Pivot::new(poses, anchors_B, weights, &x_W)
            });
            let bound = BoundNode { node: node_W, bones, weights, offsets, pivot, posed: None };
            if stiffness == 0.0 {
                // Flesh that has no spring at all is tied to nothing, and goes its own way.
                if hangs {
                    self.coupling.unbound.push(bound);
                }
                continue;
            }
            let prescribed = bones.iter().all(|&b| !self.rigids[b as usize].moves);
            let needs_joint = coupling.skinning == Skinning::Joint || !prescribed;
            if weights[1] != 0.0 && joint.is_none() && needs_joint {
                return Err(ModelError::NotAdjacent { thing: soft.name.clone(), node, bones });
            }
            self.coupling.bound.push(bound);
            self.coupling.stiffness.push(stiffness);
            self.coupling.damping.push(stiffness * coupling.damping_time);
            self.coupling.joints.push(joint);
        }
        Ok(())
    }

    /// Gives nodes the offsets that follow the pose of a joint, which must be that of their two
    /// bones.
    fn add_pose_offsets(
        &mut self,
        given: &PoseOffsets,
        desc: &WorldDesc,
    ) -> Result<(), ModelError> {
        let joint = &desc.joints[given.joint as usize];
        let thing = &desc.softs[given.soft as usize].name;
        let (node0, bodies) =
            (self.soft_nodes[given.soft as usize].start, [Some(joint.child), joint.parent]);
        let CouplingModel { bound, unbound, offsets, .. } = &mut self.coupling;
        let mut carried: Vec<&mut BoundNode> = bound.iter_mut().chain(unbound).collect();
        carried.sort_unstable_by_key(|bound| bound.node);
        let place = |node: &u32| {
            let found =
                carried.binary_search_by_key(&(node0 as u32 + node), |bound| bound.node).ok()?;
            let bones = carried[found].bones.map(Some);
            let both = carried[found].bone_count() == 2 && bodies.iter().all(|b| bones.contains(b));
            both.then_some((found, bones[0] == bodies[0]))
        };
        let places: Result<Vec<(usize, bool)>, u32> =
            given.nodes.iter().map(|node| place(node).ok_or(*node)).collect();
        let (places, child_first): (Vec<_>, Vec<_>) = places
            .map_err(|node| ModelError::NotPosed {
                thing: thing.clone(),
                node: node as usize,
                joint: joint.name.clone(),
            })?
            .into_iter()
            .unzip();
        // Without a parent it has no node.
        let Some(parent) = joint.parent else { return Ok(()) };
        let bodies = [joint.child, parent];
        let pair = PairAtRest {
            bodies,
            rotations_WB: bodies.map(|b| desc.rigids[b as usize].pose_WB.rotation),
            model_WM: desc.softs[given.soft as usize].pose_WM.rotation,
        };
        let posed = offsets.push(given, &pair, &child_first).ok_or_else(|| {
            ModelError::SamePoses { thing: thing.clone(), joint: joint.name.clone() }
        })?;
        for (place, posed) in places.into_iter().zip(posed) {
            carried[place].posed = Some(posed);
        }
        Ok(())
    }

    /// Fixes the sparsity and remembers where everything goes.
    fn lay_out(&mut self) {
        let row0 = 2 * self.rigids.len() as u32;
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for b in 0..self.rigids.len() as u32 {
            pairs.push((2 * b, 2 * b + 1));
        }
        for joint in &self.joints {
            pairs.extend(joint.parent.map(|p| (2 * p + 1, 2 * joint.child + 1)));
        }
        for tet in &self.flesh.tets {
            for a in 0..4 {
                pairs.extend((0..a).map(|c| (row0 + tet[a], row0 + tet[c])));
            }
        }
        pairs.extend(self.flesh.patches.pairs().map(|(a, b)| (row0 + a, row0 + b)));
        for bound in &self.coupling.bound {
            for j in 0..bound.bone_count() {
                for part in 0..2 {
                    let bone = 2 * bound.bones[j] + part;
                    pairs.push((row0 + bound.node, bone));
                    for l in 0..bound.bone_count() {
                        pairs.extend((0..2).map(|q| (bone, 2 * bound.bones[l] + q)));
                    }
                }
            }
        }
        self.pattern = BlockMatrix::with_pattern(self.rows(), pairs);

        let A = &self.pattern;
        let entry = |i: u32, j: u32| A.entry(i, j);
        self.joint_entries = self
            .joints
            .iter()
            .map(|joint| {
                let c = 2 * joint.child + 1;
                JointEntries {
                    child: entry(c, c),
                    with_parent: joint.parent.map(|p| {
                        let p = 2 * p + 1;
                        [entry(p, p), entry(c, p), entry(p, c)]
                    }),
                }
            })
            .collect();
        self.flesh.entries = self
            .flesh
            .tets
            .iter()
            .map(|tet| tet.map(|a| tet.map(|c| entry(row0 + a, row0 + c))))
            .collect();
        self.flesh.patches.lay_out(|a, b| entry(row0 + a, row0 + b));
        self.coupling.entries = self
            .coupling
            .bound
            .iter()
            .map(|bound| {
                let node = row0 + bound.node;
                let carried = |j: usize| bound.bones[if j < bound.bone_count() { j } else { 0 }];
                let bone = |j: usize, part: u32| 2 * carried(j) + part;
                CouplingEntries {
                    node: entry(node, node),
                    node_bone: [0, 1].map(|j| [0, 1].map(|p| entry(node, bone(j, p)))),
                    bone_node: [0, 1].map(|j| [0, 1].map(|p| entry(bone(j, p), node))),
                    bone_bone: [0, 1].map(|j| {
                        [0, 1]
                            .map(|l| [0, 1].map(|p| [0, 1].map(|q| entry(bone(j, p), bone(l, q)))))
                    }),
                }
            })
            .collect();
    }
}

impl Embedded {
    /// Weighted sum of a nodal quantity.
    #[inline]
    pub fn of(&self, nodal: &[Vec3]) -> Vec3 {
        let of = |k: usize| nodal[self.nodes[k] as usize] * self.weights[k];
        Vec3::zeros() + of(0) + of(1) + of(2) + of(3)
    }
}

/// The joint between two bones, and whether its child is the first of them.
fn joint_between(joints: &[JointDesc], bones: [u32; 2]) -> Option<(u32, bool)> {
    joints.iter().enumerate().find_map(|(j, joint)| {
        let parent = joint.parent?;
        if [joint.child, parent] == bones {
            Some((j as u32, true))
        } else if [parent, joint.child] == bones {
            Some((j as u32, false))
        } else {
            None
        }
    })
}
