//! Some bodies of a world taken out of it: the same bones, joints and flesh in the same state, with
//! nothing to touch.

use crate::math::Vec3;
use crate::model::{BodyId, PoseOffsets, RigidDesc, SoftDesc, WorldDesc};
use crate::world::{Input, ModelError, State, StepReport, World};
use std::ops::Range;

/// A hand taken out of its world. It has the state that it had there, and goes its own way from
/// then on.
#[derive(Clone, Debug)]
pub struct SubWorld {
    world: World,
    /// Bones of the hand among the rigid bodies of the whole world.
    bones: Range<usize>,
    /// Joints of the hand among the whole world's joints.
    joints: Vec<usize>,
    /// Nodes of the hand among the whole world's nodes, body after body.
    nodes: Vec<Range<usize>>,
    /// Places in the whole world's state of what the hand's flesh remembers, body after body.
    faded: Vec<Range<usize>>,
}

impl World {
    /// The hand of these bones alone: its bones, the joints among them, and the flesh that hangs on
    /// them. Nothing touches it, not even itself. Allocates.
    ///
    /// # Errors
    /// The bones are no world: some of what their description refers to is elsewhere.
    pub fn sub_world(&self, bones: Range<u32>) -> Result<SubWorld, ModelError> {
        let (desc, bones, joints, softs) = self.sub_description(bones);
        let model = &self.model;
        let nodes = softs.iter().map(|&s| model.soft_nodes[s].clone()).collect();
        let tets = softs.iter().map(|&s| model.soft_tets[s].clone());
        let faded = tets.map(|tets| model.flesh.memory.span(tets)).collect();
        let mut sub_world = SubWorld { world: World::new(desc)?, bones, joints, nodes, faded };
        sub_world.resume(&self.state);
        Ok(sub_world)
    }

    /// The description of the hand of these bones alone; which rigid bodies, joints and soft bodies
    /// it has.
    #[allow(clippy::type_complexity)] // what `sub_world` takes apart, and nothing else
    fn sub_description(
        &self,
        bones: Range<u32>,
    ) -> (WorldDesc, Range<usize>, Vec<usize>, Vec<usize>) {
        let end = (bones.end as usize).min(self.desc.rigids.len());
        let bones = (bones.start as usize).min(end)..end;
        let first = bones.start as u32;
        let within = |b: u32| bones.contains(&(b as usize));
        let whole = &self.desc;
        let joints: Vec<usize> = (0..whole.joints.len())
            .filter(|&j| {
                let joint = &whole.joints[j];
                within(joint.child) && joint.parent.is_none_or(within)
            })
            .collect();
        let softs: Vec<usize> =
            (0..whole.softs.len()).filter(|&s| hangs_on(&whole.softs[s], &within)).collect();
        let new_soft = |s: u32| softs.iter().position(|&own| own == s as usize).map(|s| s as u32);
        let desc = WorldDesc {
            gravity: whole.gravity,
            time_step: self.time_step,
            solver: whole.solver,
            rigids: whole.rigids[bones.clone()]
                .iter()
                .map(|bone| RigidDesc { shape: None, ..bone.clone() })
                .collect(),
            joints: joints
                .iter()
                .map(|&j| {
                    let mut joint = whole.joints[j].clone();
                    joint.child -= first;
                    joint.parent = joint.parent.map(|parent| parent - first);
                    joint
                })
                .collect(),
            softs: softs.iter().map(|&s| bound_anew(&whole.softs[s], first)).collect(),
            drives: whole.drives[bones.clone()].to_vec(),
            patches: (whole.patches.iter())
                .filter_map(|p| new_soft(p.soft).map(|soft| (soft, p.clone())))
                .map(|(soft, patches)| crate::model::ElementPatches { soft, ..patches })
                .collect(),
            skins: (whole.skins.iter())
                .filter_map(|skin| new_soft(skin.soft).map(|soft| (soft, skin.clone())))
                .map(|(soft, skin)| crate::model::Skin { soft, ..skin })
                .collect(),
            pose_offsets: (whole.pose_offsets.iter())
                .filter_map(|offsets| {
                    let joint = joints.iter().position(|&j| j == offsets.joint as usize)?;
                    let soft = new_soft(offsets.soft)?;
                    Some(PoseOffsets { soft, joint: joint as u32, ..offsets.clone() })
                })
                .collect(),
            ..WorldDesc::default()
        };
        (desc, bones, joints, softs)
    }

    /// True when one of these bones, or the flesh on them, bore force of contact in the last step.
    pub fn is_touched(&self, bones: Range<u32>) -> bool {
        let of_hand = |body: &BodyId| match body {
            BodyId::Rigid(b) => bones.contains(b),
            BodyId::Soft(s) => hangs_on(&self.desc.softs[*s as usize], &|b| bones.contains(&b)),
        };
        let bearing = |force: &Vec3| *force != Vec3::zeros();
        (self.contacts().iter()).any(|c| bearing(&c.force_W) && c.bodies.iter().any(of_hand))
    }
}

/// True when flesh hangs on some of these bones.
fn hangs_on(soft: &SoftDesc, within: &impl Fn(u32) -> bool) -> bool {
    let binding = soft.coupling.as_ref().and_then(|coupling| coupling.bindings.first());
    binding.is_some_and(|binding| within(binding.bones[0]))
}

/// The flesh on bones whose numbers begin at 0.
fn bound_anew(soft: &SoftDesc, first: u32) -> SoftDesc {
    let mut soft = soft.clone();
    for binding in soft.coupling.iter_mut().flat_map(|coupling| &mut coupling.bindings) {
        binding.bones = binding.bones.map(|bone| bone.saturating_sub(first));
    }
    soft
}

impl SubWorld {
    /// Goes on from where the hand is in a state of the whole world. Allocates nothing.
    pub fn resume(&mut self, whole: &State) {
        let Self { world, bones, joints, nodes, faded } = self;
        let state = &mut world.state;
        let own = bones.len();
        state.poses_WB.copy_from_slice(&whole.poses_WB[bones.clone()]);
        state.v[..2 * own].copy_from_slice(&whole.v[2 * bones.start..2 * bones.end]);
        let (mut to, row0) = (0, 2 * whole.poses_WB.len());
        for from in nodes.iter() {
            let end = to + from.len();
            state.x[to..end].copy_from_slice(&whole.x[from.clone()]);
            let rates = &whole.v[row0 + from.start..row0 + from.end];
            state.v[2 * own + to..2 * own + end].copy_from_slice(rates);
            to = end;
        }
        for (to, from) in state.limit_impulses.iter_mut().zip(joints.iter()) {
            *to = whole.limit_impulses[*from];
        }
        let mut to = 0;
        for from in faded.iter() {
            state.faded[to..to + from.len()].copy_from_slice(&whole.faded[from.clone()]);
            to += from.len();
        }
        state.contact_change.fill(Vec3::zeros());
        state.impulses.clear();
    }

    /// Goes on from where it is with the parameters that its bodies have in the whole world now.
    /// Allocates.
    ///
    /// # Errors
    /// The whole world is another one by now.
    pub fn retune(&mut self, whole: &World) -> Result<(), ModelError> {
        let bones = self.bones.start as u32..self.bones.end as u32;
        let (desc, _, _, softs) = whole.sub_description(bones);
        self.world.retune(desc)?;
        let tets = softs.iter().map(|&s| whole.model.soft_tets[s].clone());
        self.faded = tets.map(|tets| whole.model.flesh.memory.span(tets)).collect();
        Ok(())
    }

    /// An input of its size.
    pub fn input(&self) -> Input {
        self.world.input()
    }

    /// Copies the input of the whole world that acts on the hand, but for targets and wrenches of
    /// its bones: gravity, and what acts on its joints and nodes.
    pub fn copy_input(&self, whole: &Input, to: &mut Input) {
        to.gravity = whole.gravity;
        for (to, from) in to.joint_torques.iter_mut().zip(&self.joints) {
            *to = whole.joint_torques[*from];
        }
        for (to, from) in to.joint_targets.iter_mut().zip(&self.joints) {
            *to = whole.joint_targets[*from];
        }
        let nodes = self.nodes.iter().flat_map(|nodes| &whole.node_forces[nodes.clone()]);
        to.node_forces.iter_mut().zip(nodes).for_each(|(to, force)| *to = *force);
    }

    /// One step of `h` \[s\].
    pub fn step(&mut self, h: f64, input: &Input) -> StepReport {
        self.world.set_time_step(h);
        self.world.step(input, &mut ())
    }

    /// World of the hand alone, with bones numbered from 0.
    pub fn world(&self) -> &World {
        &self.world
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Mat3, Pose};
    use crate::model::{Drive, Motion};

    /// Three bodies fall side by side; the one in the middle, taken out, falls as it did among
    /// them.
    #[test]
    fn one_body_alone_moves_as_among_others() {
        let body = |i: u32| RigidDesc {
            name: format!("body {i}"),
            motion: Motion::Dynamic,
            mass: 0.1,
            inertia: Mat3::from_diagonal_element(1e-4),
            pose_WB: Pose::translation(f64::from(i), 0.0, 0.0),
            velocity_W: Vec3::x() * f64::from(i),
            angular_velocity_W: Vec3::z(),
            shape: None,
            pose_BS: Pose::identity(),
            friction: 0.5,
        };
        let drive =
            Drive { stiffness: 9.0, damping: 0.1, angular_stiffness: 0.1, angular_damping: 0.01 };
        let mut desc = WorldDesc::default();
        for i in 0..3 {
            desc.add_rigid(body(i));
        }
        desc.drives[1] = Some(drive);
        let mut whole = World::new(desc).unwrap();
        let mut input = whole.input();
        let target =
            crate::condensed::RigidState::at_rest(Pose::translation(1.0, 0.1, 0.0)).target();
        input.targets[1] = Some(target);
        whole.step(&input, &mut ());
        let mut sub_world = whole.sub_world(1..2).unwrap();
        let mut own = sub_world.input();
        own.targets[0] = Some(target);
        for _ in 0..100 {
            whole.step(&input, &mut ());
            sub_world.step(1e-3, &own);
        }
        let (there, here) = (whole.rigid_pose(1), sub_world.world().rigid_pose(0));
        assert!((there.position - here.position).norm() < 1e-12);
        assert!(there.rotation.angle_to(&here.rotation) < 1e-9);
        assert!(!whole.is_touched(1..2));
    }
}
