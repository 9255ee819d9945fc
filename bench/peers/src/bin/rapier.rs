//! Runs a job in Rapier with its FEM soft bodies.
//!
//! Settings: `ties` is how flesh holds to bone ([`flesh::Ties`]); `substeps`, `pgs` and
//! `stabilization` count the solver's passes; `linear_tolerance`, `linear_iterations` and `dense`
//! (the largest system to be factored) tune its FEM; `contact_stiffening`,
//! `contact_damping_ratio`, `radius`, `skin` and `length_unit` its contact.

#[path = "rapier/flesh.rs"]
mod flesh;
#[path = "rapier/skeleton.rs"]
mod skeleton;

use cpu_time::ThreadTime;
use flesh::Ties;
use rapier3d::prelude::*;
use std::process::ExitCode;
use thenar_peers::job::PoseRow;
use thenar_peers::outcome::Frame;
use thenar_peers::{Job, Outcome, drive};

fn main() -> ExitCode {
    drive(|job| Ok(Scene::new(job)?.run()))
}

/// A job inside a Rapier world.
struct Scene<'a> {
    job: &'a Job,
    world: PhysicsWorld,
    bones: Vec<RigidBodyHandle>,
    /// The kinematic body whose motors lead the palm.
    leader: Option<RigidBodyHandle>,
    flesh: SoftBodyHandle,
    ties: Ties,
}

impl<'a> Scene<'a> {
    fn new(job: &'a Job) -> Result<Self, String> {
        let mut world = PhysicsWorld::new();
        world.gravity = vector(&job.gravity);
        tune(&mut world.integration_parameters, job);
        let bones = skeleton::insert_bones(&mut world, job);
        let leader = skeleton::insert_drive(&mut world, job, &bones);
        if let Some(table) = job.table {
            let body =
                RigidBodyBuilder::fixed().translation(Vector::new(0.0, f(table.height), 0.0));
            // A half space, as in the other engines.
            let shape = ColliderBuilder::new(SharedShape::halfspace(Vector::Y));
            world.insert(body, shape.friction(f(table.friction)));
        }
        let ties = Ties::of(job)?;
        let flesh = flesh::insert(&mut world, job, &bones, ties);
        Ok(Self { job, world, bones, leader, flesh, ties })
    }

    fn run(mut self) -> Outcome {
        let job = self.job;
        let mut done = Outcome { engine: "rapier".into(), ..Outcome::default() };
        let mass: f64 = job.node_masses.iter().sum();
        for i in 0..job.steps {
            self.lead(i);
            let start = ThreadTime::now();
            self.world.step();
            done.step_ms.push(start.elapsed().as_secs_f64() * 1e3);
            let (force, contacts) = self.table_force();
            done.table_force.push(force);
            done.contacts.push(contacts);
            if job.recorded(i) {
                done.frames.push(self.frame(i + 1));
            }
            if !self.world.quarantine().is_empty() {
                done.failure = Some(format!("not finite at step {}", i + 1));
            }
            let kinetic = self.kinetic();
            if done.watch(i, kinetic, mass) || done.failure.is_some() {
                break;
            }
        }
        done
    }

    /// Leads the kinematic bones, or the palm's leader, to where they are to be after step `i`.
    fn lead(&mut self, i: usize) {
        let job = self.job;
        if job.targets.is_empty() {
            return;
        }
        if let Some(leader) = self.leader {
            self.world.bodies[leader].set_next_kinematic_position(pose(&job.targets[i][0]));
            self.world.bodies[self.bones[0]].wake_up(true);
            return;
        }
        for (k, bone) in self.bones.iter().enumerate() {
            self.world.bodies[*bone].set_next_kinematic_position(pose(&job.targets[i][k]));
        }
        if self.ties == Ties::Springs {
            flesh::lead_anchors(&mut self.world.soft_bodies[self.flesh], job, i);
        }
    }

    /// Normal force of the hand on the table, and the points that carry it.
    fn table_force(&self) -> ([f64; 3], u32) {
        // Tangential impulses on soft surfaces are not reported.
        let (mut force, mut contacts) = (0.0, 0);
        for pair in self.world.contact_pairs() {
            force += f64::from(pair.total_impulse_magnitude());
            contacts += pair.manifolds().iter().map(|m| m.points.len() as u32).sum::<u32>();
        }
        ([0.0, -force / self.job.time_step, 0.0], contacts)
    }

    fn frame(&self, step: usize) -> Frame {
        let body = &self.world.soft_bodies[self.flesh];
        let count = self.job.nodes.len();
        let nodes = body.particle_positions().take(count).map(|p| [p.x, p.y, p.z].map(f64::from));
        let bones = self.bones.iter().map(|bone| {
            let pose = self.world.bodies[*bone].position();
            let (p, q) = (pose.translation, pose.rotation);
            [p.x, p.y, p.z, q.x, q.y, q.z, q.w].map(f64::from)
        });
        Frame { step, nodes: nodes.collect(), bones: bones.collect() }
    }

    fn kinetic(&self) -> f64 {
        let speeds = self.world.soft_bodies[self.flesh].particle_velocities();
        let energy = speeds.zip(&self.job.node_masses);
        energy.map(|(v, m)| 0.5 * m * f64::from(v.length_squared())).sum()
    }
}

/// Tolerances for lengths of a hand, not of a room; systems are factored where they fit.
fn tune(parameters: &mut IntegrationParameters, job: &Job) {
    parameters.dt = f(job.time_step);
    parameters.length_unit = f(job.number("length_unit", 0.1));
    parameters.num_solver_iterations = job.number("substeps", 1.0) as usize;
    parameters.num_internal_pgs_iterations = job.number("pgs", 1.0) as usize;
    parameters.num_internal_stabilization_iterations = job.number("stabilization", 1.0) as usize;
    parameters.warmstart_joints = true;
    parameters.friction_model = FrictionModel::Coulomb;
    parameters.contact_clustering = false;
    parameters.soft_bodies.max_extra_substeps = job.number("extra_substeps", 4.0) as usize;
    parameters.soft_bodies.contact_stiffening = f(job.number("contact_stiffening", 4.0));
    parameters.static_contact_softness.damping_ratio = f(job.number("contact_damping_ratio", 10.0));
    let fem = &mut parameters.soft_bodies.fem;
    fem.linear_tolerance = f(job.number("linear_tolerance", 1e-5));
    fem.max_linear_iterations = job.number("linear_iterations", 200.0) as usize;
    fem.max_dense_dofs = job.number("dense", 100_000.0) as usize;
}

fn f(x: f64) -> Real {
    x as Real
}

fn vector(v: &[f64; 3]) -> Vector {
    Vector::new(f(v[0]), f(v[1]), f(v[2]))
}

fn pose(row: &PoseRow) -> Pose {
    let [x, y, z, qx, qy, qz, qw] = row.map(f);
    Pose::from_parts(Vector::new(x, y, z), Rotation::from_xyzw(qx, qy, qz, qw))
}
