//! Rigid bodies, joints, energies, momentum.

use crate::math::Vec3;
use thenar_core::World;
use thenar_core::model::BodyId;
use thenar_core::world::{Input, StepReport};

pub fn pose(world: &World, i: u32, out: &mut Vec<f64>) {
    let pose = world.rigid_pose(i);
    let q = pose.rotation.coords; // x, y, z, w
    out.extend(pose.position.iter().chain(q.iter()));
}

pub fn joint(world: &World, j: u32, axes: usize, out: &mut Vec<f64>) {
    let (angles, rates) = (world.joint_angles(j), world.joint_rates(j));
    (0..axes).for_each(|k| out.extend([angles[k], rates[k]]));
    let (gap, misalignment) = world.joint_error(j);
    out.extend([gap, misalignment]);
    out.extend(&world.joint_limit_torques(j)[..axes]);
}

pub fn energy(world: &World, input: &Input, out: &mut Vec<f64>) {
    let e = world.energy(input);
    out.extend([e.kinetic, e.gravity, e.elastic, e.coupling, e.joint, e.drive, e.total()]);
}

pub fn step(report: &StepReport, out: &mut Vec<f64>) {
    let r = report;
    out.extend([f64::from(r.cg_iterations), r.cg_residual]);
    out.extend([f64::from(r.contact_sweeps), r.contact_residual]);
    out.extend([r.contacts, r.contacts_active, r.inverted_tets].map(f64::from));
    out.push(f64::from(u8::from(r.non_finite)));
    out.extend([r.penetration_max, r.joint_gap_max, r.joint_misalignment_max]);
}

/// Calls `f` with mass, place, velocity and spin (angular momentum about the own centre) of each
/// part of a body.
fn for_each_part(world: &World, body: BodyId, mut f: impl FnMut(f64, Vec3, Vec3, Vec3)) {
    match body {
        BodyId::Rigid(i) => {
            let desc = &world.desc().rigids[i as usize];
            let pose = world.rigid_pose(i);
            let [v, w] = world.rigid_velocity(i);
            let spin = pose.vector(&(desc.inertia * pose.inverse_vector(&w)));
            f(desc.mass, pose.position, v, spin);
        }
        BodyId::Soft(s) => {
            let nodes = world.nodes(s).iter().zip(world.node_velocities(s));
            for (mass, (x, v)) in world.node_masses(s).iter().zip(nodes) {
                f(*mass, *x, *v, Vec3::zeros());
            }
        }
    }
}

pub fn body_energy(world: &World, body: BodyId, gravity: Vec3, out: &mut Vec<f64>) {
    let (mut kinetic, mut weight) = (0.0, 0.0);
    for_each_part(world, body, |mass, x, v, _| {
        kinetic += 0.5 * mass * v.norm_squared();
        weight -= mass * gravity.dot(&x);
    });
    if let BodyId::Rigid(i) = body {
        let desc = &world.desc().rigids[i as usize];
        let w = world.rigid_pose(i).inverse_vector(&world.rigid_velocity(i)[1]);
        kinetic += 0.5 * w.dot(&(desc.inertia * w));
    }
    out.extend([kinetic, weight]);
}

/// Linear and angular momentum about a point, or about the centre of mass.
pub fn momentum(world: &World, bodies: &[BodyId], about: Option<Vec3>, out: &mut Vec<f64>) {
    let (mut total, mut moment, mut linear) = (0.0, Vec3::zeros(), Vec3::zeros());
    let mut about_origin = Vec3::zeros();
    for body in bodies {
        for_each_part(world, *body, |mass, x, v, spin| {
            total += mass;
            moment += x * mass;
            linear += v * mass;
            about_origin += x.cross(&(v * mass)) + spin;
        });
    }
    let about = about.unwrap_or(moment / total);
    let angular = about_origin - about.cross(&linear);
    out.extend(linear.iter().chain(angular.iter()));
}
