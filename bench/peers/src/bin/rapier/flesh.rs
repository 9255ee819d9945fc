//! The flesh as one FEM soft body, and three ways of tying it to bones.

use super::{f, pose, vector};
use rapier3d::prelude::*;
use std::f64::consts::TAU;
use thenar_peers::Job;
use thenar_peers::job::Tie;

/// Distance of a bone's anchors from its centre \[m\]: far enough that three springs to them act
/// like one isotropic spring, near enough for single precision.
const ANCHOR_DISTANCE: f64 = 0.5;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ties {
    /// Springs inside the FEM system, to pinned particles that move with kinematic bones.
    Springs,
    /// The same springs, to anchors that `SoftBody::attach_particle` holds on free bones: two-way.
    Anchored,
    /// Motors of joints between a bone and a cluster of one particle: springs, two-way.
    Motors,
    /// `SoftBody::attach_particle`: two-way, without compliance.
    Glue,
}

impl Ties {
    pub fn of(job: &Job) -> Result<Self, String> {
        match job.word("ties", if job.kinematic { "springs" } else { "glue" }) {
            "springs" if job.kinematic => Ok(Self::Springs),
            "anchored" => Ok(Self::Anchored),
            "motors" => Ok(Self::Motors),
            "glue" => Ok(Self::Glue),
            other => Err(format!("ties {other} cannot be had here")),
        }
    }
}

pub fn insert(
    world: &mut PhysicsWorld,
    job: &Job,
    bones: &[RigidBodyHandle],
    ties: Ties,
) -> SoftBodyHandle {
    let mut positions: Vec<Vector> = job.nodes.iter().map(vector).collect();
    let mut masses: Vec<Real> = job.node_masses.iter().map(|m| f(*m)).collect();
    let mut pinned = job.fixed.clone();
    let (mut edges, mut softness) = (Vec::new(), Vec::new());
    let first = positions.len() as u32;
    if matches!(ties, Ties::Springs | Ties::Anchored) {
        let far = f(job.number("anchor_distance", ANCHOR_DISTANCE));
        for bone in &job.bones {
            positions.extend(anchors(&pose(&bone.pose), far));
        }
        masses.resize(positions.len(), f(job.number("anchor_mass", 1e-6)));
        if ties == Ties::Springs {
            pinned.extend(first..positions.len() as u32);
        }
        for tie in &job.ties {
            for axis in 0..3 {
                softness.push((edges.len() as u32, spring(job, tie, ties)));
                edges.push([tie.node, first + 3 * tie.bone + axis]);
            }
        }
    }
    let skin = f(job.number("skin", 2e-4));
    let mut builder = SoftBodyBuilder::new(positions)
        .cells(job.tets.clone())
        .surface(job.boundary.clone())
        .masses(masses)
        .pinned_particles(pinned)
        .edges(edges)
        .cell_model(SoftBodyCellModel::Corotational)
        .solver(SoftBodySolver::Fem)
        .material(material(job))
        .linear_damping(f(job.mass_damping))
        .additional_pgs_iterations(job.number("soft_pgs", 3.0) as usize)
        .particle_radius(f(job.number("radius", 2e-3)))
        .can_sleep(false);
    builder.edge_softness = softness;
    builder = match job.table {
        Some(table) => {
            let collider = ColliderBuilder::ball(skin).friction(f(table.friction));
            builder.surface_collider(collider.contact_skin(skin))
        }
        None => builder.no_surface_collider(),
    };
    let handle = world.insert_soft_body(builder);
    match ties {
        Ties::Springs => {}
        Ties::Anchored => {
            let body = &mut world.soft_bodies[handle];
            for anchor in 0..3 * bones.len() {
                body.attach_particle(first as usize + anchor, bones[anchor / 3], &world.bodies);
            }
        }
        Ties::Motors => tie_by_motors(world, job, bones, handle),
        Ties::Glue => {
            let body = &mut world.soft_bodies[handle];
            for tie in &job.ties {
                body.attach_particle(tie.node as usize, bones[tie.bone as usize], &world.bodies);
            }
        }
    }
    for (node, force) in job.node_forces.iter().enumerate() {
        if force.iter().any(|x| *x != 0.0) {
            world.soft_bodies[handle].add_particle_force(node, vector(force), true);
        }
    }
    handle
}

/// Damping is given as a ratio, per element: chosen so that its mean is the wanted Rayleigh time.
fn material(job: &Job) -> SoftBodyMaterial {
    SoftBodyMaterial {
        young_modulus: f(job.young),
        poisson_ratio: f(job.poisson),
        elastic_damping_ratio: f(job.number("damping_ratio", damping_ratio(job))),
        ..SoftBodyMaterial::default()
    }
}

/// Rapier takes an element's Rayleigh time as `2 ratio / omega`, omega its mean natural frequency.
/// That of a regular tetrahedron of edge a is estimated by its wave speed over its size.
fn damping_ratio(job: &Job) -> f64 {
    let (young, poisson) = (job.young, job.poisson);
    let mu = young / (2.0 * (1.0 + poisson));
    let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let stiffness = [2.0 * mu + lambda, 4.0 * mu];
    let mut mean = 0.0;
    for tet in &job.tets {
        let x = tet.map(|i| nalgebra::Vector3::from(job.nodes[i as usize]));
        let rest = nalgebra::Matrix3::from_columns(&[x[1] - x[0], x[2] - x[0], x[3] - x[0]]);
        let volume = rest.determinant().abs() / 6.0;
        let inverse = rest.try_inverse().unwrap_or_default();
        // Gradients of the shape functions, and the strain rows' inverse masses.
        let mut gradients = [nalgebra::Vector3::zeros(); 4];
        for k in 0..3 {
            gradients[k + 1] = inverse.row(k).transpose();
            gradients[0] -= gradients[k + 1];
        }
        let inverse_mass = |row: usize| -> f64 {
            let weight = |k: usize| 1.0 / job.node_masses[tet[k] as usize];
            let square = |k: usize| match row {
                0..3 => gradients[k][row].powi(2),
                _ => {
                    let (a, b) = [(0, 1), (0, 2), (1, 2)][row - 3];
                    0.25 * (gradients[k][a].powi(2) + gradients[k][b].powi(2))
                }
            };
            (0..4).map(|k| weight(k) * square(k)).sum()
        };
        let omegas = (0..6).map(|r| (stiffness[r / 3] * volume * inverse_mass(r)).sqrt());
        mean += omegas.sum::<f64>() / 6.0 / job.tets.len() as f64;
    }
    0.5 * job.stiffness_damping * mean
}

/// A spring's frequency and damping ratio, which Rapier counts by its ends' masses.
fn spring(job: &Job, tie: &Tie, ties: Ties) -> SpringCoefficients<Real> {
    let anchor = if ties == Ties::Springs { 0.0 } else { 1.0 / job.number("anchor_mass", 1e-6) };
    let inverse_mass = 1.0 / job.node_masses[tie.node as usize] + anchor;
    let omega = (tie.stiffness * inverse_mass).sqrt();
    SpringCoefficients::new(f(omega / TAU), f(0.5 * job.tie_damping_time * omega))
}

fn anchors(bone: &Pose, far: Real) -> [Vector; 3] {
    [Vector::X, Vector::Y, Vector::Z].map(|axis| *bone * (axis * far))
}

/// Takes the anchors to where the bones are to be after step `i`.
pub fn lead_anchors(body: &mut SoftBody, job: &Job, i: usize) {
    let first = job.nodes.len();
    let far = f(job.number("anchor_distance", ANCHOR_DISTANCE));
    for (k, row) in job.targets[i].iter().enumerate() {
        for (axis, place) in anchors(&pose(row), far).into_iter().enumerate() {
            body.set_particle_kinematic_target(first + 3 * k + axis, place);
        }
    }
}

fn tie_by_motors(
    world: &mut PhysicsWorld,
    job: &Job,
    bones: &[RigidBodyHandle],
    handle: SoftBodyHandle,
) {
    for tie in &job.ties {
        let Some(cluster) = world.add_soft_body_cluster(handle, &[tie.node]) else { continue };
        let Some(proxy) = world.soft_bodies[handle].cluster_proxy(cluster) else { continue };
        let bone = bones[tie.bone as usize];
        let place = vector(&job.nodes[tie.node as usize]);
        let local = world.bodies[bone].position().inverse_transform_point(place);
        let damping = job.tie_damping_time * tie.stiffness;
        let mut joint = GenericJointBuilder::new(JointAxesMask::empty()).local_anchor1(local);
        for axis in [JointAxis::LinX, JointAxis::LinY, JointAxis::LinZ] {
            joint = joint.motor_model(axis, MotorModel::ForceBased).motor_position(
                axis,
                0.0,
                f(tie.stiffness),
                f(damping),
            );
        }
        let joint: GenericJoint = joint.into();
        world.insert_impulse_joint(bone, proxy, joint);
    }
}
