//! Parts of a scene that are compared.

use crate::session::Session;
use thenar_core::{Pose, Vec3, World};

/// A body that is neither bone nor the flesh of bones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Object {
    /// Index of a rigid body.
    Rigid(u32),
    /// Index of a deformable body.
    Soft(u32),
}

/// Bones, objects and hands of a scene.
#[derive(Clone, Debug, Default)]
pub struct Bodies {
    /// Rigid bodies that move and are part of a hand, of a joint, or carry flesh.
    pub bones: Vec<u32>,
    /// Names of the bones.
    pub bone_names: Vec<String>,
    /// All else that moves.
    pub objects: Vec<Object>,
    /// Names of the objects.
    pub object_names: Vec<String>,
    /// Rigid bodies pulled by a drive.
    pub driven: Vec<u32>,
    /// Hands with flesh, by index.
    pub hands: Vec<usize>,
    /// Names of the hands.
    pub hand_names: Vec<String>,
}

impl Bodies {
    /// Bodies of a session's scene.
    pub fn of(session: &Session) -> Self {
        let (world, model) = (session.world(), session.world().model());
        let desc = world.desc();
        let mut is_bone = vec![false; desc.rigids.len()];
        for hand in session.hands() {
            is_bone[crate::session::bones(hand)].fill(true);
        }
        for joint in &desc.joints {
            is_bone[joint.child as usize] = true;
            joint.parent.into_iter().for_each(|p| is_bone[p as usize] = true);
        }
        let mut is_flesh = vec![false; desc.softs.len()];
        for bound in &model.coupling.bound {
            bound.bones[..bound.bone_count()].iter().for_each(|&b| is_bone[b as usize] = true);
            let soft = model.soft_nodes.iter().position(|n| n.contains(&(bound.node as usize)));
            soft.into_iter().for_each(|s| is_flesh[s] = true);
        }
        let moving = |b: &u32| model.rigids[*b as usize].moves;
        let rigids = || (0..desc.rigids.len() as u32).filter(moving);
        let bones: Vec<u32> = rigids().filter(|&b| is_bone[b as usize]).collect();
        let loose = rigids().filter(|&b| !is_bone[b as usize]).map(Object::Rigid);
        let soft = (0..desc.softs.len() as u32).filter(|&s| !is_flesh[s as usize]);
        let objects: Vec<Object> = loose.chain(soft.map(Object::Soft)).collect();
        let name = |object: &Object| match *object {
            Object::Rigid(i) => desc.rigids[i as usize].name.clone(),
            Object::Soft(i) => desc.softs[i as usize].name.clone(),
        };
        let with_flesh = |(_, hand): &(usize, &crate::build::BuiltHand)| hand.flesh().is_some();
        let hands = session.hands().iter().enumerate().filter(with_flesh);
        let (hands, hand_names) = hands.map(|(i, hand)| (i, hand.name.clone())).unzip();
        Self {
            bone_names: bones.iter().map(|&b| desc.rigids[b as usize].name.clone()).collect(),
            object_names: objects.iter().map(name).collect(),
            driven: rigids().filter(|&b| desc.drives[b as usize].is_some()).collect(),
            bones,
            objects,
            hands,
            hand_names,
        }
    }
}

impl Object {
    /// Distance \[m\] and angle \[rad\] between its poses in two worlds. A deformable body is
    /// where its centre of mass is; it has no angle.
    pub fn apart(&self, a: &World, b: &World) -> [f64; 2] {
        match *self {
            Self::Rigid(i) => poses_apart(&a.rigid_pose(i), &b.rigid_pose(i)),
            Self::Soft(i) => [(centre(a, i) - centre(b, i)).norm(), 0.0],
        }
    }
}

/// Distance \[m\] and angle \[rad\] between two poses.
pub fn poses_apart(a: &Pose, b: &Pose) -> [f64; 2] {
    [(a.position - b.position).norm(), a.rotation.angle_to(&b.rotation)]
}

/// Centre of mass of a deformable body \[m\].
fn centre(world: &World, soft: u32) -> Vec3 {
    let masses = world.node_masses(soft);
    let moment: Vec3 = world.nodes(soft).iter().zip(masses).map(|(x, m)| x * *m).sum();
    moment / masses.iter().sum::<f64>()
}
