//! The torques with which flesh resists the turn of one joint of a hand.
//!
//! Bones are held where one joint's angle puts them, all others at rest; the flesh finds its
//! equilibrium under the springs to the bones (Eq. 7 to 9), and what these springs put on the bones
//! beyond each joint is summed about its axes.

use super::passive::beyond;
use crate::RigError;
use crate::work::Stage;
use nalgebra::DMatrix;
use thenar_core::kinematics::Tree;
use thenar_core::model::{
    CouplingKind, ElementPatches, HandModel, HandPlacement, JointKind, Motion, Skinning, WorldDesc,
    patches,
};
use thenar_core::world::{Input, State};
use thenar_core::{Pose, Vec3, World};

/// Length of the steps by which flesh comes to rest \[s\]: a hundred periods of a finger's slowest
/// vibration, so that inertia is a ten-thousandth of what elasticity is.
const STEP: f64 = 1.0;
/// Steps. Each is one of Newton's; most torques in the shipped hands change by less than 1 % after
/// the second.
const STEPS: usize = 3;
/// Length of the steps to a shape that is looked at itself \[s\]: inertia holds Newton's method on
/// its way. Without it, in steps of 1 s, a knuckle bent by 86° goes round in circles; in steps of
/// 0.01 to 0.1 s all joints take up to 80, about.
pub(super) const SHAPE_STEP: f64 = 0.03;
/// Most steps to a shape.
const SHAPE_STEPS: usize = 300;
/// A shape is at rest when no node moves by more than this part of the hand's length in a step, 2
/// µm of a hand of 190 mm.
const SETTLED: f64 = 1e-5;
/// Comparisons of a point with a triangle that take as long as a step of one tetrahedron, about.
const TET_STEP: usize = 80;

/// A hand whose joints are turned one at a time.
pub(super) struct Bender<'a> {
    hand: &'a HandModel,
    tree: Tree,
    angles: Vec<[f64; 2]>,
    world: World,
    input: Input,
    rest: State,
}

/// An axis of a joint: the joint's number and which of its axes.
pub(super) type AxisOf = (usize, usize);

impl<'a> Bender<'a> {
    /// Cost of a shape for each tetrahedron, about, as a `Stage` counts: most joints take 20 steps.
    pub const SHAPE_WORK: usize = 20 * TET_STEP;

    /// A hand by itself, without weight, held by its usual springs.
    pub fn new(hand: &'a HandModel) -> Result<Self, RigError> {
        Self::held(hand, hand.coupling, STEP)
    }

    /// A hand by itself, without weight, held by the usual springs of such a coupling, in steps of
    /// such a length \[s\].
    pub fn held(hand: &'a HandModel, coupling: CouplingKind, step: f64) -> Result<Self, RigError> {
        let tree = Tree::of_hand(hand).map_err(|e| RigError::invalid(e.to_string()))?;
        let poses: Vec<Pose> = hand.bones.iter().map(|bone| bone.pose_MB).collect();
        let mut angles = vec![[0.0; 2]; hand.joints.len()];
        tree.angles(&poses, &mut angles);
        let mut desc =
            WorldDesc { gravity: Vec3::zeros(), time_step: step, ..WorldDesc::default() };
        desc.solver.velocity_tolerance = 1e-7;
        let placement = HandPlacement {
            name: "hand".into(),
            pose_WM: Pose::identity(),
            coupling,
            coupling_stiffness: hand.usual_coupling_stiffness(coupling),
            coupling_damping_time: 0.0,
            skinning: Skinning::Linear,
            root_drive: None,
            bone_drive: None,
            solid_bones: false,
            nails: false,
        };
        desc.add_hand(hand, &placement);
        desc.joints.clear();
        desc.self_contact.clear();
        desc.rigids.iter_mut().for_each(|bone| bone.motion = Motion::Prescribed);
        let flesh = &mut desc.softs[0].flesh;
        (flesh.mass_damping, flesh.stiffness_damping) = (0.0, 0.0);
        if coupling == CouplingKind::Bone {
            let of_tet = patches(&flesh.nodes, &flesh.tets, &flesh.materials, &flesh.relaxation);
            desc.patches.push(ElementPatches { soft: 0, of_tet });
        }
        let world = World::new(desc).map_err(|e| RigError::invalid(e.to_string()))?;
        let (input, rest) = (world.input(), world.state().clone());
        Ok(Self { hand, tree, angles, world, input, rest })
    }

    /// All axes of a hand's joints.
    pub fn axes(hand: &HandModel) -> Vec<AxisOf> {
        hand.axes().collect()
    }

    /// Stiffness of the flesh \[N m/rad\], secant: entry (a, b) is by how much the torque about
    /// axis a differs between turns of axis b alone to both sides of rest, over the way between
    /// them. `turns` \[rad\], one for each axis.
    ///
    /// # Errors
    /// The work would be too much, or is to end.
    pub fn stiffness(&mut self, turns: &[f64]) -> Result<DMatrix<f64>, RigError> {
        let axes = Self::axes(self.hand);
        let work = (2 * TET_STEP * STEPS * self.hand.flesh.tets.len() * axes.len()) as f64;
        let stage = Stage::new("turning the joints", axes.len(), work, "ask for fewer tetrahedra")?;
        let mut matrix = DMatrix::zeros(axes.len(), axes.len());
        for (b, (&axis, &turn)) in axes.iter().zip(turns).enumerate() {
            let [there, back] = [self.torques(axis, turn)?, self.torques(axis, -turn)?];
            for (a, (there, back)) in there.iter().zip(&back).enumerate() {
                matrix[(a, b)] = (back - there) / (2.0 * turn);
            }
            stage.at(b + 1)?;
        }
        Ok(matrix)
    }

    /// Torque of the flesh about every axis \[N m\] with one of them turned by `turn` \[rad\] from
    /// rest.
    fn torques(&mut self, axis: AxisOf, turn: f64) -> Result<Vec<f64>, RigError> {
        let poses = self.turn(axis, turn)?;
        for _ in 0..STEPS {
            self.world.step(&self.input, &mut ());
        }
        let hand = self.hand;
        let wrenches: Vec<[Vec3; 2]> =
            (0..hand.bones.len()).map(|b| self.world.coupling_wrench(b as u32)).collect();
        let torques: Vec<f64> =
            Self::axes(hand).iter().map(|&axis| torque(hand, &poses, &wrenches, axis)).collect();
        if torques.iter().any(|torque| !torque.is_finite()) {
            return Err(no_rest());
        }
        Ok(torques)
    }

    /// Puts the bones where one axis is turned by `turn` \[rad\] from rest, and the flesh where
    /// skinning has it; gives the bones' poses.
    fn turn(&mut self, (j, k): AxisOf, turn: f64) -> Result<Vec<Pose>, RigError> {
        let hand = self.hand;
        let mut angles = self.angles.clone();
        angles[j][k] += turn;
        let mut poses: Vec<Pose> = hand.bones.iter().map(|bone| bone.pose_MB).collect();
        let root = poses[0];
        self.tree.forward(&root, &angles, &mut poses);
        let moves = moves(hand, &poses);
        let mut state = self.rest.clone();
        // Skinning is the first guess.
        for (x, binding) in state.x.iter_mut().zip(&hand.bindings) {
            let by = |k: usize| moves[binding.bones[k] as usize].point(x) * binding.weights[k];
            *x = by(0) + by(1);
        }
        state.poses_WB.copy_from_slice(&poses);
        if self.world.restore(&state) { Ok(poses) } else { Err(no_rest()) }
    }

    /// Returns the poses of bones and the places of nodes with one axis turned by `turn` \[rad\]
    /// from rest, in the model frame \[m\].
    ///
    /// # Errors
    /// The flesh finds no rest.
    pub fn shape(&mut self, axis: AxisOf, turn: f64) -> Result<(Vec<Pose>, &[Vec3]), RigError> {
        let poses = self.turn(axis, turn)?;
        for _ in 0..SHAPE_STEPS {
            let before = self.world.nodes(0).to_vec();
            self.world.step(&self.input, &mut ());
            let moved = self.world.nodes(0).iter().zip(&before).map(|(x, y)| (x - y).norm());
            if moved.fold(0.0, f64::max) <= SETTLED * self.hand.length {
                return Ok((poses, self.world.nodes(0)));
            }
        }
        Err(no_rest())
    }

    /// Angle of an axis at rest \[rad\].
    pub fn angle_at_rest(&self, (j, k): AxisOf) -> f64 {
        self.angles[j][k]
    }
}

/// Movement of each bone from rest, in the model frame.
pub(super) fn moves(hand: &HandModel, poses: &[Pose]) -> Vec<Pose> {
    let moved = poses.iter().zip(&hand.bones);
    moved.map(|(pose, bone)| *pose * bone.pose_MB.inverse()).collect()
}

fn no_rest() -> RigError {
    RigError::invalid("the flesh finds no rest where a joint is turned")
}

/// Torque about an axis \[N m\] of wrenches on all bones beyond its joint.
fn torque(hand: &HandModel, poses: &[Pose], wrenches: &[[Vec3; 2]], (j, k): AxisOf) -> f64 {
    let joint = &hand.joints[j];
    let pose_WJ = poses[joint.parent.unwrap_or(0) as usize] * joint.pose_PJ;
    let pose_WK = poses[joint.child as usize] * joint.pose_CK;
    // A universal joint turns about y of J, then x of K; a hinge about x of both.
    let axis = match (joint.kind, k) {
        (JointKind::Universal, 0) => pose_WJ.vector(&Vec3::y()),
        _ => pose_WK.vector(&Vec3::x()),
    };
    let carried = beyond(&hand.bones, joint.child);
    let loads = poses.iter().zip(wrenches).zip(&carried).filter(|(_, carried)| **carried);
    let sum: Vec3 = loads
        .map(|((pose, [force, torque]), _)| {
            torque + (pose.position - pose_WJ.position).cross(force)
        })
        .sum();
    axis.dot(&sum)
}
