//! Loads in the input of a step.

use crate::build::{ActiveLoad, LoadKind};
use thenar_core::World;
use thenar_core::math::Vec3;
use thenar_core::world::Input;

/// Fills forces and torques with those at time `t` \[s\].
pub fn fill(input: &mut Input, loads: &[ActiveLoad], world: &World, t: f64) {
    input.wrenches.fill([Vec3::zeros(); 2]);
    input.joint_torques.fill([0.0; 2]);
    input.node_forces.fill(Vec3::zeros());
    for load in loads {
        apply(input, load, world, t);
    }
}

fn apply(input: &mut Input, load: &ActiveLoad, world: &World, t: f64) {
    // Each component of each thing the load acts on has its own random series.
    let scaled = |v: &Vec3, thing: usize| {
        let stream = 3 * thing as u64;
        let factor = |k: u64| load.factor.at(t, stream + k);
        Vec3::new(v.x * factor(0), v.y * factor(1), v.z * factor(2))
    };
    match &load.kind {
        LoadKind::Force { rigid, force, point } => {
            let force = scaled(force, 0);
            let arm = world.rigid_pose(*rigid).vector(point);
            let wrench = &mut input.wrenches[*rigid as usize];
            wrench[0] += force;
            wrench[1] += arm.cross(&force);
        }
        LoadKind::Torque { rigid, torque } => {
            input.wrenches[*rigid as usize][1] += scaled(torque, 0);
        }
        LoadKind::JointTorque { joints, torque } => {
            for (n, (joint, axes)) in joints.iter().enumerate() {
                for axis in 0..*axes {
                    let factor = load.factor.at(t, (2 * n + axis) as u64);
                    input.joint_torques[*joint as usize][axis] += torque * factor;
                }
            }
        }
        LoadKind::Nodes(forces) => {
            for (n, (node, force)) in forces.iter().enumerate() {
                input.node_forces[*node as usize] += scaled(force, n);
            }
        }
        LoadKind::Pressure { faces, pressure } => {
            let size = pressure * load.factor.at(t, 0);
            let x = &world.state().x;
            for face in faces {
                let [a, b, c] = face.map(|n| x[n as usize]);
                let share = (b - a).cross(&(c - a)) * (-size / 6.0);
                face.iter().for_each(|n| input.node_forces[*n as usize] += share);
            }
        }
    }
}
