//! Start states other than rest.

use crate::math::Vec3;
use crate::world::World;

impl World {
    /// Places the nodes of a deformable body \[m\]; their velocities stay. Ignored when the number
    /// of positions is not that of its nodes or one is not finite. Held nodes are held where they
    /// are put.
    pub fn set_nodes(&mut self, soft: u32, positions_W: &[Vec3]) {
        let range = self.node_range(soft);
        let finite = positions_W.iter().flat_map(|x| x.iter()).all(|x| x.is_finite());
        if !finite || positions_W.len() != range.len() {
            return;
        }
        self.state.x[range].copy_from_slice(positions_W);
        self.embed();
    }
}
