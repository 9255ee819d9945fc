//! Energy, momentum and the forces that drives and flesh put on bones.

use crate::coupling::{KernelValue, SkinTarget, skin_target};
use crate::math::{Quat, Vec3};
use crate::model::JointKind;
use crate::skeleton::{AxisState, axis_states, drive_energy, drive_force, spring_energy};
use crate::world::assemble::{joint_frames, relaxed_at};
use crate::world::{Energy, Input, World, limits};

impl World {
    /// Energies of the present state; weight and drives are those of `input`.
    pub fn energy(&self, input: &Input) -> Energy {
        let (model, state) = (&self.model, &self.state);
        let row0 = 2 * model.rigids.len();
        let mut energy = Energy::default();
        for (b, body) in model.rigids.iter().enumerate().filter(|(_, body)| body.moves) {
            let pose = &state.poses_WB[b];
            let spin = pose.inverse_vector(&state.v[2 * b + 1]);
            energy.kinetic += 0.5
                * (body.mass * state.v[2 * b].norm_squared() + spin.dot(&(body.inertia * spin)));
            energy.gravity -= body.mass * input.gravity.dot(&pose.position);
            if let (Some(drive), Some(target)) = (&self.desc.drives[b], input.target(b)) {
                energy.drive += drive_energy(drive, target, pose);
            }
        }
        for (n, mass) in model.flesh.mass.iter().enumerate() {
            energy.kinetic += 0.5 * mass * state.v[row0 + n].norm_squared();
            energy.gravity -= mass * input.gravity.dot(&state.x[n]);
        }
        let limits = limits::kind(&self.desc.solver);
        for (j, joint) in model.joints.iter().enumerate() {
            let frames = joint_frames(model, state, j);
            let target = input.joint_target(j);
            if joint.kind == JointKind::Ball {
                let relaxed = target.map_or(Quat::identity(), |target| target.rotation_JK);
                let angle = frames.pose_WK.rotation.angle_to(&(frames.pose_WJ.rotation * relaxed));
                let spring = relaxed_at(&joint.axes[0], target.as_ref(), 0);
                energy.joint += 0.5 * spring.stiffness * angle * angle;
            }
            for (k, axis) in axis_states(joint.kind, &frames).iter().enumerate() {
                let spring = relaxed_at(&joint.axes[k], target.as_ref(), k);
                let stored = |a: AxisState| spring_energy(&spring, joint, limits, a.angle);
                energy.joint += axis.map_or(0.0, stored);
            }
        }
        energy.elastic = model.flesh.tally(&state.x, &state.faded).energy;
        energy.coupling = model.coupling.energy(&state.poses_WB, &state.x);
        energy
    }

    /// Total linear momentum \[kg m/s\] and angular momentum about the world's origin
    /// \[kg m²/s\] of all that moves.
    pub fn momentum(&self) -> [Vec3; 2] {
        let (model, state) = (&self.model, &self.state);
        let row0 = 2 * model.rigids.len();
        let (mut linear, mut angular) = (Vec3::zeros(), Vec3::zeros());
        for (b, body) in model.rigids.iter().enumerate().filter(|(_, body)| body.moves) {
            let pose = &state.poses_WB[b];
            let p = state.v[2 * b] * body.mass;
            let spin = body.inertia * pose.inverse_vector(&state.v[2 * b + 1]);
            linear += p;
            angular += pose.position.cross(&p) + pose.vector(&spin);
        }
        for (n, mass) in model.flesh.mass.iter().enumerate() {
            let p = state.v[row0 + n] * *mass;
            linear += p;
            angular += state.x[n].cross(&p);
        }
        [linear, angular]
    }

    /// Force \[N\] and torque \[N m\] that the drive of rigid body `i` puts on it at this state.
    pub fn drive_wrench(&self, i: u32, input: &Input) -> [Vec3; 2] {
        let b = i as usize;
        let (Some(drive), Some(target)) = (&self.desc.drives[b], input.target(b)) else {
            return [Vec3::zeros(); 2];
        };
        let [force, torque] = drive_force(drive, target, &self.state.poses_WB[b]);
        let [v, omega] = self.rigid_velocity(i);
        [
            force + (target.velocity_W - v) * drive.damping,
            torque + (target.angular_velocity_W - omega) * drive.angular_damping,
        ]
    }

    /// Force \[N\] and torque about its centre of mass \[N m\] that flesh puts on rigid body `i`
    /// through the coupling springs (Eq. 8), dampers included.
    pub fn coupling_wrench(&self, i: u32) -> [Vec3; 2] {
        let mut wrench = [Vec3::zeros(); 2];
        let shares = self.shares();
        for (k, bound) in self.model.coupling.bound.iter().enumerate() {
            for j in (0..bound.bone_count()).filter(|&j| bound.bones[j] == i) {
                let (target, force) = self.spring_force(k, &shares);
                wrench[0] -= force * bound.weights[j];
                wrench[1] -= target.turning.torque(j, &force);
            }
        }
        wrench
    }

    /// Gives `load` the force \[N\] and the torque about the bone's centre of mass \[N m\] of each
    /// coupling spring on each bone that carries its node, as [`World::coupling_wrench`] sums them.
    /// `shares` is room for those of offsets by pose.
    pub(crate) fn for_each_bone_load(
        &self,
        shares: &mut Vec<KernelValue>,
        mut load: impl FnMut(u32, Vec3, Vec3),
    ) {
        self.model.coupling.offsets.pose(&self.state.poses_WB, shares);
        for (k, bound) in self.model.coupling.bound.iter().enumerate() {
            let (target, force) = self.spring_force(k, shares);
            for j in 0..bound.bone_count() {
                let torque = -target.turning.torque(j, &force);
                load(bound.bones[j], force * -bound.weights[j], torque);
            }
        }
    }

    /// Force of the coupling springs on the nodes of a deformable body (Eq. 7), dampers included:
    /// node index and force \[N\], world.
    pub fn coupling_forces(&self, soft: u32) -> impl Iterator<Item = (u32, Vec3)> + '_ {
        let (range, shares) = (self.node_range(soft), self.shares());
        self.model.coupling.bound.iter().enumerate().filter_map(move |(k, bound)| {
            let node = bound.node as usize;
            range
                .contains(&node)
                .then(|| ((node - range.start) as u32, self.spring_force(k, &shares).1))
        })
    }

    /// Shares of offsets by pose at this state.
    fn shares(&self) -> Vec<KernelValue> {
        self.model.coupling.shares(&self.state.poses_WB)
    }

    /// Target of bound node `k` and the force of its spring and damper on the node.
    fn spring_force(&self, k: usize, shares: &[KernelValue]) -> (SkinTarget, Vec3) {
        let (model, state) = (&self.model, &self.state);
        let bound = &model.coupling.bound[k];
        let target = skin_target(bound, &state.poses_WB, &model.coupling.offsets.with(shares));
        let mut rate = state.v[2 * model.rigids.len() + bound.node as usize];
        for j in 0..bound.bone_count() {
            let bone = bound.bones[j] as usize;
            rate -= state.v[2 * bone] * bound.weights[j]
                + target.turning.velocity(j, &state.v[2 * bone + 1]);
        }
        let stretch = state.x[bound.node as usize] - target.position_W;
        let force = stretch * -model.coupling.stiffness[k] - rate * model.coupling.damping[k];
        (target, force)
    }
}
