//! Other parameters for a world that runs.

use crate::contact::Shape;
use crate::model::{Coupling, JointDesc, RigidDesc, SoftDesc, WorldDesc};
use crate::world::check::normalize_rotations;
use crate::world::friction::patches_max;
use crate::world::{Model, ModelError, World};
use std::sync::Arc;

impl World {
    /// Goes on with the parameters of another description of the same bodies: gravity, time step,
    /// solver, masses and inertias, materials, damping, friction, pair rules, drives, joint springs
    /// and limits, coupling springs, and offsets by pose, as many as there are, may differ. The
    /// state stays, with all that contact remembers. Gravity acts through the next
    /// [`Input`](crate::world::Input). Allocates.
    ///
    /// # Errors
    /// The description is wrong, or bodies, shapes, meshes, bindings or joints differ. The world
    /// is as it was then.
    pub fn retune(&mut self, mut desc: WorldDesc) -> Result<(), ModelError> {
        normalize_rotations(&mut desc);
        same_bodies(&self.desc, &desc)?;
        let model = Model::new(&desc)?;
        let old = std::mem::replace(&mut self.model, model);
        self.keep_memory(&old);
        let pairs = |desc: &WorldDesc| -> Vec<_> {
            desc.friction_tables.iter().map(|table| table.bodies).collect()
        };
        if pairs(&self.desc) != pairs(&desc) || self.desc.parts != desc.parts {
            self.state.patch_loads.clear();
            self.scratch.before.patch_loads.clear();
            self.state.patch_loads.reserve(patches_max(&self.model));
            self.scratch.before.patch_loads.reserve(patches_max(&self.model));
        }
        self.detector.retune(&desc);
        self.state.scale_impulses(desc.time_step / self.time_step);
        self.time_step = desc.time_step;
        self.desc = desc;
        self.retuned += 1;
        self.prepare_solver();
        Ok(())
    }

    /// Returns the number of times that parameters were replaced: whoever keeps a part of the world
    /// compares it.
    pub fn retuned(&self) -> u64 {
        self.retuned
    }

    /// Tissue stays as far relaxed as it was; what has no memory any more forgets.
    fn keep_memory(&mut self, old: &Model) {
        let (flesh, was) = (&self.model.flesh, &old.flesh);
        let stiffer = |t: usize| flesh.rest[t].mu / was.rest[t].mu;
        self.state.faded = flesh.memory.carry_over(&was.memory, &self.state.faded, stiffer);
    }
}

fn changed(thing: &str, what: &'static str) -> ModelError {
    ModelError::Changed { thing: thing.into(), what }
}

/// Refuses what has not the same unknowns, pattern and geometry.
fn same_bodies(old: &WorldDesc, new: &WorldDesc) -> Result<(), ModelError> {
    let world = |same: bool, what| if same { Ok(()) } else { Err(changed("world", what)) };
    world(old.rigids.len() == new.rigids.len(), "the number of rigid bodies")?;
    world(old.joints.len() == new.joints.len(), "the number of joints")?;
    world(old.softs.len() == new.softs.len(), "the number of soft bodies")?;
    old.rigids.iter().zip(&new.rigids).try_for_each(|(old, new)| same_rigid(old, new))?;
    old.joints.iter().zip(&new.joints).try_for_each(|(old, new)| same_joint(old, new))?;
    old.softs.iter().zip(&new.softs).try_for_each(|(old, new)| same_soft(old, new))?;
    let room = |desc: &WorldDesc| -> Vec<_> {
        let offsets = desc.pose_offsets.iter();
        offsets
            .map(|given| (given.soft, given.joint, given.nodes.len(), given.poses.len()))
            .collect()
    };
    world(room(old) == room(new), "how many nodes and poses have offsets")?;
    world(old.patches == new.patches, "which tetrahedra are patches")
}

fn same_rigid(old: &RigidDesc, new: &RigidDesc) -> Result<(), ModelError> {
    let same = |same: bool, what| if same { Ok(()) } else { Err(changed(&old.name, what)) };
    same(old.name == new.name, "a body's name")?;
    same(old.motion == new.motion, "whether it moves by forces")?;
    same(old.pose_WB == new.pose_WB, "its start pose")?;
    let shapes = match (&old.shape, &new.shape) {
        (Some(Shape::Mesh(a)), Some(Shape::Mesh(b))) => Arc::ptr_eq(a, b) || a == b,
        (a, b) => a == b,
    };
    same(shapes && old.pose_BS == new.pose_BS, "its shape")
}

fn same_joint(old: &JointDesc, new: &JointDesc) -> Result<(), ModelError> {
    let same = |same: bool, what| if same { Ok(()) } else { Err(changed(&old.name, what)) };
    same(old.kind == new.kind, "its kind")?;
    same((old.parent, old.child) == (new.parent, new.child), "the bodies it joins")?;
    same((old.pose_PJ, old.pose_CK) == (new.pose_PJ, new.pose_CK), "its frames")
}

fn same_soft(old: &SoftDesc, new: &SoftDesc) -> Result<(), ModelError> {
    let same = |same: bool, what| if same { Ok(()) } else { Err(changed(&old.name, what)) };
    same(old.name == new.name, "a body's name")?;
    same(old.pose_WM == new.pose_WM, "its start pose")?;
    let (a, b) = (&old.flesh, &new.flesh);
    same(a.nodes == b.nodes && a.tets == b.tets, "its mesh")?;
    same(a.fixed == b.fixed, "its held nodes")?;
    same(a.collision == b.collision, "its surface")?;
    match (&old.coupling, &new.coupling) {
        (None, None) => Ok(()),
        (Some(a), Some(b)) => {
            let bound = |coupling: &Coupling| {
                coupling.springs.stiffness().map(|k| k > 0.0).collect::<Vec<_>>()
            };
            let bonds = bound(a) == bound(b);
            same(bonds && a.bindings == b.bindings, "which nodes are bound to bones")
        }
        _ => Err(changed(&old.name, "whether it is bound to bones")),
    }
}
