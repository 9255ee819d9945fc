//! A soft object of a simulation.

use thenar_core::{Vec3, World};

/// A soft object as it is after the last step.
#[derive(Clone, Copy, Debug)]
pub struct SoftRef<'a> {
    pub(crate) world: &'a World,
    pub(crate) soft: u32,
}

impl<'a> SoftRef<'a> {
    /// Name in the scene.
    pub fn name(&self) -> &'a str {
        &self.world.desc().softs[self.soft as usize].name
    }

    /// Mass \[kg\].
    pub fn mass(&self) -> f64 {
        self.world.node_masses(self.soft).iter().sum()
    }

    /// Centre of mass, world \[m\].
    pub fn centre(&self) -> Vec3 {
        let nodes = self.nodes().iter().zip(self.world.node_masses(self.soft));
        nodes.map(|(x, m)| x * *m).sum::<Vec3>() / self.mass()
    }

    /// Nodes, world \[m\].
    pub fn nodes(&self) -> &'a [Vec3] {
        self.world.nodes(self.soft)
    }

    /// Velocities of the nodes, world \[m/s\].
    pub fn node_velocities(&self) -> &'a [Vec3] {
        self.world.node_velocities(self.soft)
    }

    /// Vertices of the surface that touches, world \[m\].
    pub fn vertices(&self) -> &'a [Vec3] {
        self.world.collision_vertices(self.soft)
    }

    /// Triangles of that surface, by vertex, counter-clockwise from outside.
    pub fn triangles(&self) -> &'a [[u32; 3]] {
        &self.world.desc().softs[self.soft as usize].flesh.collision.triangles
    }
}

/// A soft object that is put elsewhere.
#[derive(Debug)]
pub struct SoftMut<'a> {
    pub(crate) world: &'a mut World,
    pub(crate) soft: u32,
}

impl SoftMut<'_> {
    /// Puts its nodes there, world \[m\]; velocities stay. Ignored where the number of nodes is
    /// another, or a number is not finite.
    pub fn place(&mut self, nodes: &[Vec3]) {
        self.world.set_nodes(self.soft, nodes);
    }
}
