//! Start states other than rest.

use crate::contact::SeenSides;
use crate::math::{Pose, Vec3, to_turn};
use crate::world::state::{is_sound_pose, is_sound_position, is_sound_velocity};
use crate::world::{State, World};

impl World {
    /// Back to time 0 and to what the description starts with; contacts are forgotten. States set
    /// since by [`World::set_rigid_state`] and [`World::set_nodes`] are lost.
    pub fn restart(&mut self) {
        let contacts_max = self.detector.capacity();
        self.state = State::new(&self.desc, &self.model);
        self.state.impulses.reserve(contacts_max);
        self.state.sides = SeenSides::with_capacity(self.detector.sides_max());
        self.readout.forget_contacts();
        self.embed();
    }

    /// Goes back (or on) to a state of this world, kept by cloning [`World::state`]: with the same
    /// inputs it steps from there with the same bits. Returns false, and stays as it is, when the
    /// state is of a world with other bodies, has a number that is not finite, a rotation of no
    /// length, or a patch that is pulled.
    pub fn restore(&mut self, state: &State) -> bool {
        if !self.fits(state) {
            return false;
        }
        self.state.copy_from(state);
        self.state.normalize(&self.model);
        self.readout.forget_contacts();
        self.embed();
        true
    }

    /// True when [`World::restore`] takes this state.
    pub fn fits(&self, state: &State) -> bool {
        let own = &self.state;
        let same = own.poses_WB.len() == state.poses_WB.len()
            && own.x.len() == state.x.len()
            && own.v.len() == state.v.len()
            && own.contact_change.len() == state.contact_change.len()
            && own.limit_impulses.len() == state.limit_impulses.len()
            && own.faded.len() == state.faded.len();
        same && state.is_finite()
            && state.poses_WB.iter().all(|pose| to_turn(&pose.rotation).is_some())
            && state.patch_loads.iter().all(|(_, load)| *load >= 0.0)
    }

    /// Sets the time \[s\]; nothing moves. Ignored when it is not finite.
    pub fn set_time(&mut self, time: f64) {
        if time.is_finite() {
            self.state.time = time;
        }
    }

    /// Places a rigid body, with linear \[m/s\] and angular \[rad/s\] velocity. Ignored when a
    /// number is not finite or beyond 1e9, or the rotation has no length. The flesh around a bone
    /// stays where it is.
    ///
    /// # Panics
    /// When there is no rigid body `i`.
    pub fn set_rigid_state(&mut self, i: u32, pose_WB: Pose, velocity_W: [Vec3; 2]) {
        let Some(rotation) = to_turn(&pose_WB.rotation) else { return };
        if velocity_W.iter().all(is_sound_velocity) && is_sound_pose(&pose_WB) {
            let i = i as usize;
            self.state.poses_WB[i] = Pose { rotation, ..pose_WB };
            self.state.v[2 * i..2 * i + 2].copy_from_slice(&velocity_W);
            self.state.sides.clear();
        }
    }

    /// Places the nodes of a deformable body \[m\]; their velocities stay. Ignored when the number
    /// of positions is not that of its nodes or one is not finite or beyond 1e9. Held nodes are
    /// held where they are put.
    pub fn set_nodes(&mut self, soft: u32, positions_W: &[Vec3]) {
        let range = self.node_range(soft);
        if !positions_W.iter().all(is_sound_position) || positions_W.len() != range.len() {
            return;
        }
        self.state.x[range].copy_from_slice(positions_W);
        self.state.sides.clear();
        self.embed();
    }
}
