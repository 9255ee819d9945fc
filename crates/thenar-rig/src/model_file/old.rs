//! Bodies of files before version 3: their flesh has no memory, and their hands are held uniformly.

use crate::object::SoftModel;
use serde::Deserialize;
use thenar_core::Vec3;
use thenar_core::model::{
    Binding, Bone, BoneSolid, CouplingKind, Digit, EmbeddedSurface, FixedNode, Flesh, HandModel,
    JointDesc, Material, Side,
};

#[derive(Deserialize)]
struct OldFlesh {
    nodes: Vec<Vec3>,
    tets: Vec<[u32; 4]>,
    materials: Vec<Material>,
    mass_damping: f64,
    stiffness_damping: f64,
    fixed: Vec<FixedNode>,
    collision: EmbeddedSurface,
    friction: f64,
}

/// A hand of version 1 or 2.
#[derive(Deserialize)]
pub(super) struct OldHand {
    name: String,
    side: Option<Side>,
    bones: Vec<Bone>,
    joints: Vec<JointDesc>,
    flesh: OldFlesh,
    bindings: Vec<Binding>,
    node_volumes: Vec<f64>,
    render: EmbeddedSurface,
    collision_digits: Vec<Digit>,
    length: f64,
    solids: Vec<BoneSolid>,
}

/// A deformable body of version 1 or 2.
#[derive(Deserialize)]
pub(super) struct OldSoft {
    name: String,
    flesh: OldFlesh,
    render: EmbeddedSurface,
}

impl From<OldFlesh> for Flesh {
    fn from(old: OldFlesh) -> Self {
        Self {
            nodes: old.nodes,
            tets: old.tets,
            materials: old.materials,
            relaxation: Vec::new(),
            mass_damping: old.mass_damping,
            stiffness_damping: old.stiffness_damping,
            fixed: old.fixed,
            collision: old.collision,
            friction: old.friction,
        }
    }
}

impl From<OldHand> for HandModel {
    fn from(old: OldHand) -> Self {
        Self {
            name: old.name,
            side: old.side,
            bones: old.bones,
            joints: old.joints,
            flesh: old.flesh.into(),
            bindings: old.bindings,
            node_volumes: old.node_volumes,
            render: old.render,
            collision_digits: old.collision_digits,
            length: old.length,
            solids: old.solids,
            coupling: CouplingKind::Uniform,
            bone_nodes: Vec::new(),
            regions: Vec::new(),
            nail_nodes: Vec::new(),
            bending: Vec::new(),
        }
    }
}

impl From<OldSoft> for SoftModel {
    fn from(old: OldSoft) -> Self {
        Self { name: old.name, flesh: old.flesh.into(), render: old.render }
    }
}
