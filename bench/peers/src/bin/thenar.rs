//! Runs a job in Thenar. Setting `solver`: `monolithic` or `two-step`.

use cpu_time::ThreadTime;
use std::process::ExitCode;
use thenar_core::shape::Shape;
use thenar_core::model::{
    Axis, Binding, BodyId, Coupling, Drive, EmbeddedSurface, FixedNode, Flesh, JointDesc,
    JointKind, Law, Material, Motion, RigidDesc, Skinning, SoftDesc, SolverKind, Springs,
    SurfaceVertex, WorldDesc,
};
use thenar_core::world::{Input, Target};
use thenar_core::{Mat3, Pose, Quat, Vec3, World};
use thenar_peers::job::{self, Kind, PoseRow};
use thenar_peers::outcome::Frame;
use thenar_peers::{Job, Outcome, drive};

fn main() -> ExitCode {
    drive(run)
}

fn run(job: &Job) -> Result<Outcome, String> {
    let mut world = World::new(describe(job)?).map_err(|e| e.to_string())?;
    let mut input = world.input();
    for (force, given) in input.node_forces.iter_mut().zip(&job.node_forces) {
        *force = Vec3::from(*given);
    }
    let mut done = Outcome { engine: "thenar".into(), ..Outcome::default() };
    let mass: f64 = job.node_masses.iter().sum();
    for i in 0..job.steps {
        lead(job, i, &mut input);
        let start = ThreadTime::now();
        let report = world.step(&input, &mut ());
        done.step_ms.push(start.elapsed().as_secs_f64() * 1e3);
        if report.non_finite {
            done.failure = Some(format!("diverged at step {}", i + 1));
        } else if report.fell_back && job.word("solver", "monolithic") == "monolithic" {
            done.failure = Some(format!("the monolithic solver gave up at step {}", i + 1));
        }
        let on_hand: Vec3 =
            world.contacts().iter().map(|c| toward_flesh(c.bodies, c.force_W)).sum();
        done.table_force.push((-on_hand).into());
        done.contacts.push(report.contacts_active);
        if job.recorded(i) {
            done.frames.push(frame(job, &world, i + 1));
        }
        let (speeds, masses) = (world.node_velocities(0), &job.node_masses);
        let kinetic = speeds.iter().zip(masses).map(|(v, m)| 0.5 * m * v.norm_squared()).sum();
        if done.watch(i, kinetic, mass) || done.failure.is_some() {
            break;
        }
    }
    Ok(done)
}

fn toward_flesh(bodies: [BodyId; 2], force_on_first: Vec3) -> Vec3 {
    if matches!(bodies[0], BodyId::Soft(_)) { force_on_first } else { -force_on_first }
}

fn frame(job: &Job, world: &World, step: usize) -> Frame {
    let row = |pose: Pose| {
        let (p, q) = (pose.position, pose.rotation.coords);
        [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
    };
    Frame {
        step,
        nodes: world.nodes(0).iter().map(|&x| x.into()).collect(),
        bones: (0..job.bones.len()).map(|b| row(world.rigid_pose(b as u32))).collect(),
    }
}

/// Leads the kinematic bones, or the palm's drive, to where they are to be after step `i`.
fn lead(job: &Job, i: usize, input: &mut Input) {
    if job.targets.is_empty() {
        return;
    }
    for k in 0..job.targets[i].len() {
        let (after, before) = job.targets(i, k);
        let (after, before) = (pose(&after), pose(&before));
        let velocity_W = (after.position - before.position) / job.time_step;
        let turned = after.rotation * before.rotation.inverse();
        let angular_velocity_W = turned.scaled_axis() / job.time_step;
        if job.kinematic {
            input.prescribed[k] = [velocity_W, angular_velocity_W];
        } else {
            input.targets[k] = Some(Target { pose_WB: after, velocity_W, angular_velocity_W });
        }
    }
}

fn describe(job: &Job) -> Result<WorldDesc, String> {
    let mut desc = WorldDesc {
        gravity: Vec3::from(job.gravity),
        time_step: job.time_step,
        ..WorldDesc::default()
    };
    desc.solver.kind = match job.word("solver", "monolithic") {
        "monolithic" => SolverKind::Monolithic,
        "two-step" => SolverKind::TwoStep,
        other => return Err(format!("solver {other} is unknown")),
    };
    desc.solver.velocity_tolerance =
        job.number("velocity_tolerance", desc.solver.velocity_tolerance);
    for (i, bone) in job.bones.iter().enumerate() {
        desc.add_rigid(rigid(format!("bone {i}"), job, bone));
    }
    if let (Some(drive), false) = (&job.drive, job.bones.is_empty()) {
        desc.drives[0] = Some(Drive {
            stiffness: drive.stiffness,
            damping: drive.damping,
            angular_stiffness: drive.angular_stiffness,
            angular_damping: drive.angular_damping,
        });
    }
    desc.joints = job.joints.iter().map(joint).collect();
    desc.add_soft(soft(job));
    if let Some(table) = &job.table {
        desc.add_rigid(RigidDesc {
            name: "table".into(),
            motion: Motion::Prescribed,
            mass: 1.0,
            inertia: Mat3::identity(),
            pose_WB: Pose::translation(0.0, table.height, 0.0),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
            shape: Some(Shape::HalfSpace),
            pose_BS: Pose::identity(),
            friction: table.friction,
        });
    }
    Ok(desc)
}

fn rigid(name: String, job: &Job, bone: &job::Bone) -> RigidDesc {
    RigidDesc {
        name,
        motion: if job.kinematic { Motion::Prescribed } else { Motion::Dynamic },
        mass: bone.mass,
        inertia: Mat3::from_fn(|r, c| bone.inertia[r][c]),
        pose_WB: pose(&bone.pose),
        velocity_W: Vec3::zeros(),
        angular_velocity_W: Vec3::zeros(),
        shape: None,
        pose_BS: Pose::identity(),
        friction: 0.0,
    }
}

fn joint(joint: &job::Joint) -> JointDesc {
    let mut axes = [Axis::default(); 2];
    for (axis, given) in axes.iter_mut().zip(&joint.axes) {
        *axis = Axis {
            limit: None,
            stiffness: given.stiffness,
            rest_angle: given.rest_angle,
            damping: given.damping,
        };
    }
    JointDesc {
        name: format!("joint of {}", joint.child),
        kind: match joint.kind {
            Kind::Hinge => JointKind::Hinge,
            Kind::Universal => JointKind::Universal,
        },
        parent: Some(joint.parent),
        child: joint.child,
        pose_PJ: pose(&joint.pose_in_parent),
        pose_CK: pose(&joint.pose_in_child),
        axes,
        limit_stiffness: 0.0,
        limit_damping: 0.0,
    }
}

fn soft(job: &Job) -> SoftDesc {
    let material = Material {
        law: Law::Corotational,
        young: job.young,
        poisson: job.poisson,
        density: job.density,
    };
    let mut bindings = vec![Binding { bones: [0, 0], weights: [1.0, 0.0] }; job.nodes.len()];
    let mut stiffness = vec![0.0; job.nodes.len()];
    for tie in &job.ties {
        bindings[tie.node as usize].bones = [tie.bone; 2];
        stiffness[tie.node as usize] = tie.stiffness;
    }
    let coupling = Coupling {
        bindings,
        springs: Springs::PerNode(stiffness),
        damping_time: job.tie_damping_time,
        skinning: Skinning::Linear,
    };
    SoftDesc {
        name: "flesh".into(),
        flesh: Flesh {
            nodes: job.nodes.iter().map(|&x| Vec3::from(x)).collect(),
            tets: job.tets.clone(),
            materials: vec![material; job.tets.len()],
            relaxation: Vec::new(),
            mass_damping: job.mass_damping,
            stiffness_damping: job.stiffness_damping,
            fixed: job.fixed.iter().map(|&node| FixedNode { node, axes: [true; 3] }).collect(),
            collision: if job.table.is_some() { surface(job) } else { EmbeddedSurface::default() },
            friction: job.table.map_or(0.0, |table| table.friction),
        },
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
        coupling: (!job.bones.is_empty()).then_some(coupling),
    }
}

/// The boundary of the lattice itself, as an embedded surface.
fn surface(job: &Job) -> EmbeddedSurface {
    let mut numbers = vec![u32::MAX; job.nodes.len()];
    let mut vertices = Vec::new();
    let mut number = |node: u32| {
        let slot = &mut numbers[node as usize];
        if *slot == u32::MAX {
            *slot = vertices.len() as u32;
            vertices.push(at_node(job, node));
        }
        *slot
    };
    let triangles = job.boundary.iter().map(|face| face.map(&mut number)).collect();
    EmbeddedSurface { vertices, triangles }
}

fn at_node(job: &Job, node: u32) -> SurfaceVertex {
    let holds = |tet: &[u32; 4]| tet.iter().position(|&n| n == node);
    let found = job.tets.iter().enumerate().find_map(|(t, tet)| Some((t, holds(tet)?)));
    let (tet, corner) = found.expect("a boundary node belongs to a tetrahedron");
    let mut weights = [0.0; 4];
    weights[corner] = 1.0;
    SurfaceVertex { tet: tet as u32, weights }
}

fn pose(row: &PoseRow) -> Pose {
    let [x, y, z, qx, qy, qz, qw] = *row;
    let rotation = Quat::from_quaternion(nalgebra::Quaternion::new(qw, qx, qy, qz));
    Pose::new(Vec3::new(x, y, z), rotation)
}
