//! Goal: all forms of the contact read-out hold the forces of the contact points, and mean what
//! they say. Method: pressed, pulled and stacked bodies, against sums, statics and closed formulas.

use crate::common::{FLESH, bar, body, finger};
use thenar_core::model::{BodyId, BodyParts, Drive, Motion, SoftDesc, SolverKind, WorldDesc};
use thenar_core::readout::{ContactReadout, SlipState};
use thenar_core::shape::Shape;
use thenar_core::world::{Input, Target};
use thenar_core::{Pose, Vec3, World};

fn add_ground(desc: &mut WorldDesc) -> BodyId {
    let mut plane = body("ground", 1.0, [1.0; 3], Vec3::zeros());
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    BodyId::Rigid(desc.add_rigid(plane))
}

fn soft(name: &str, size: Vec3, cells: [usize; 3], at: Vec3) -> SoftDesc {
    let mut flesh = bar(size, cells, FLESH);
    flesh.stiffness_damping = 5e-3;
    SoftDesc {
        name: name.into(),
        flesh,
        pose_WM: Pose::translation(at.x, at.y, at.z),
        velocity_W: Vec3::zeros(),
        coupling: None,
    }
}

fn run(world: &mut World, input: &Input, steps: usize) -> ContactReadout {
    for _ in 0..steps {
        assert!(!world.step(input, &mut ()).non_finite);
    }
    let mut readout = ContactReadout::new(world);
    readout.read(world);
    readout
}

/// Sums of each body's points, straight from the world: force, and sum of normal forces.
fn sums(world: &World, id: BodyId) -> (Vec3, f64) {
    let mut sums = (Vec3::zeros(), 0.0);
    for c in world.contacts() {
        for (body, sign) in c.bodies.iter().zip([1.0, -1.0]).filter(|(body, _)| **body == id) {
            let _ = body;
            sums.0 += c.force_W * sign;
            sums.1 += c.force_W.dot(&c.normal_W);
        }
    }
    sums
}

/// Whatever touches: sums over vertices, parts and pairs are those over points to round-off, and
/// pressure integrates back to the normal force.
fn check_sums(world: &World, readout: &mut ContactReadout) {
    for s in 0..world.desc().softs.len() as u32 {
        let id = BodyId::Soft(s);
        let (force, normal) = sums(world, id);
        let vertices = readout.vertices(s);
        assert_eq!(vertices.len(), world.collision_vertices(s).len());
        let by_vertices: Vec3 = vertices.iter().map(|v| v.force_W).sum();
        let by_parts: Vec3 = readout.parts(s).iter().map(|p| p.contact.force_W).sum();
        let pressed: f64 = vertices.iter().map(|v| v.pressure * v.area).sum();
        let peak = vertices.iter().map(|v| v.pressure).fold(0.0, f64::max);
        assert!((by_vertices - force).norm() < 1e-10 && (by_parts - force).norm() < 1e-10);
        assert!((pressed - normal).abs() < 1e-10 * (1.0 + normal), "{pressed} of {normal} N");
        let part_peak = readout.parts(s).iter().map(|p| p.contact.pressure_max);
        assert_eq!(part_peak.fold(0.0, f64::max), peak);

        let whole = readout.body(world, id);
        assert!((whole.force_W - force).norm() < 1e-10 && (whole.normal - normal).abs() < 1e-10);
        assert!((whole.pressure_max - peak).abs() <= 1e-9 * peak);
        let rigids = (0..world.desc().rigids.len() as u32).map(BodyId::Rigid);
        let others: Vec<BodyId> =
            rigids.chain((0..world.desc().softs.len() as u32).map(BodyId::Soft)).collect();
        let by_pairs: Vec3 =
            others.iter().map(|other| readout.pair(world, [id, *other]).force_W).sum();
        assert!((by_pairs - force).norm() < 1e-10);
        for other in others {
            let (on, back) = (readout.pair(world, [id, other]), readout.pair(world, [other, id]));
            assert!((on.force_W + back.force_W).norm() < 1e-10);
            assert!((on.centre_W - back.centre_W).norm() < 1e-12);
            let about = Vec3::new(0.1, -0.2, 0.3);
            let net = on.torque_about(&about) + back.torque_about(&about);
            assert!(net.norm() < 1e-10, "{net}");
        }
    }
}

/// A soft block under an even load on top: pressure below is force over area, everywhere.
#[test]
fn an_even_load_gives_an_even_pressure() {
    for kind in [SolverKind::Monolithic, SolverKind::TwoStep] {
        let mut desc = WorldDesc { gravity: Vec3::zeros(), ..WorldDesc::default() };
        desc.solver.kind = kind;
        let ground = add_ground(&mut desc);
        desc.pairs.push(thenar_core::model::PairRule {
            bodies: [ground, BodyId::Soft(0)],
            friction: Some(0.0),
        });
        let size = Vec3::new(0.02, 0.01, 0.03);
        desc.add_soft(soft("block", size, [4, 2, 6], Vec3::zeros()));
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        // Consistent forces of an even traction of 1 kPa.
        let (tx, tz) = (size.x / 4.0, size.z / 6.0);
        let flesh = world.desc().softs[0].flesh.clone();
        for t in &flesh.collision.triangles {
            let corner = |k: usize| {
                let v = &flesh.collision.vertices[t[k] as usize];
                let n = v.weights.iter().position(|w| *w == 1.0).unwrap();
                flesh.tets[v.tet as usize][n] as usize
            };
            let corners = [corner(0), corner(1), corner(2)];
            if corners.iter().all(|n| flesh.nodes[*n].y > 0.0099) {
                for n in corners {
                    input.node_forces[n].y -= 1e3 * 0.5 * tx * tz / 3.0;
                }
            }
        }
        let mut readout = run(&mut world, &input, 400);
        check_sums(&world, &mut readout);
        let load = 1e3 * size.x * size.z;
        let patch = readout.pair(&world, [BodyId::Soft(0), ground]);
        assert!((patch.normal / load - 1.0).abs() < 1e-3, "{kind:?}: {} N", patch.normal);
        // The block has grown wider by Poisson's effect: a little less pressure on more area.
        let wider = patch.area / (size.x * size.z);
        assert!(wider > 1.005 && wider < 1.03, "{wider}");
        let mut middle = world.nodes(0).iter().sum::<Vec3>() / world.nodes(0).len() as f64;
        middle.y = 0.0;
        assert!(
            (patch.centre_W - middle).norm() < 1e-4 && (patch.normal_W - Vec3::y()).norm() < 1e-6
        );
        let below: Vec<_> = readout.vertices(0).iter().filter(|v| v.normal > 0.0).collect();
        assert_eq!(below.len(), 5 * 7);
        for v in below {
            let even = v.pressure * wider / 1e3;
            assert!((even - 1.0).abs() < 0.02, "{kind:?}: {even} kPa");
            assert_eq!(v.state, SlipState::Slip, "nothing holds without friction");
        }
    }
}

/// Centre of pressure and torque by the law of the lever; states by Coulomb's.
#[test]
fn a_block_pulled_aside_sticks_then_slips() {
    let mut desc = WorldDesc { gravity: Vec3::zeros(), ..WorldDesc::default() };
    desc.solver.kind = SolverKind::Monolithic;
    let ground = add_ground(&mut desc);
    let mut cube = body("cube", 0.1, [1e-4; 3], Vec3::y() * 0.02);
    cube.shape = Some(Shape::Cuboid { half: Vec3::repeat(0.02) });
    let cube = BodyId::Rigid(desc.add_rigid(cube));
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    // 5 N down at 4 mm beside the middle, and a pull along z at the foot, below and above 0.5 × 5
    // N.
    for (pull, state) in [(2.0, SlipState::Stick), (3.0, SlipState::Slip)] {
        let force = Vec3::new(0.0, -5.0, pull);
        let arm = Vec3::new(0.004, -0.02, 0.0);
        input.wrenches[1] = [force, arm.cross(&force)];
        let mut readout = run(&mut world, &input, 20);
        let patch = readout.pair(&world, [cube, ground]);
        assert_eq!(patch.state, state);
        assert!((patch.normal - 5.0).abs() < 1e-2, "{patch:?}");
        let friction = if pull < 2.5 { -pull } else { -2.5 };
        assert!((patch.shear_W - Vec3::z() * friction).norm() < 1e-2, "{patch:?}");
        let from = world.rigid_pose(1).position;
        assert!((patch.centre_W.x - from.x - 0.004).abs() < 1e-4, "{patch:?}");
        if pull < 2.5 {
            let balance = patch.torque_about(&from) + input.wrenches[1][1];
            assert!(balance.norm() < 1e-4, "at rest torques balance: {balance}");
            assert_eq!(patch.slipping, 0.0);
        } else {
            assert!(patch.slipping > 0.99 && patch.slip_W.z > 1e-3, "{patch:?}");
        }
        assert_eq!((patch.area, patch.pressure_max), (0.0, 0.0), "between rigid bodies");
    }
}

/// A finger pressed on a plane, with a block that leans on it: what skin feels reaches the bones.
#[test]
fn what_the_skin_feels_reaches_the_bones() {
    for kind in [SolverKind::Monolithic, SolverKind::TwoStep] {
        let mut desc = finger(1e9, 2e-3);
        desc.gravity = Vec3::zeros();
        desc.solver.kind = kind;
        desc.softs[0].flesh.stiffness_damping = 5e-3;
        let ground = add_ground(&mut desc);
        let mut block = soft("block", Vec3::repeat(0.015), [2, 2, 2], Vec3::new(0.0605, 0.0, 0.0));
        block.flesh.mass_damping = 20.0;
        desc.add_soft(block);
        let vertices = vec![1; desc.softs[0].flesh.collision.vertices.len()];
        desc.parts.push(BodyParts { soft: 0, vertices, bones: vec![(0, 1), (1, 1)] });
        let drive =
            Drive { stiffness: 400.0, damping: 8.0, angular_stiffness: 0.4, angular_damping: 0.01 };
        (desc.drives[0], desc.drives[1]) = (Some(drive), Some(drive));
        let poses = [desc.rigids[0].pose_WB, desc.rigids[1].pose_WB];
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        for b in 0..2 {
            let position = poses[b].position + Vec3::new(0.001, -0.004, 0.0);
            let pose_WB = Pose::new(position, poses[b].rotation);
            let zero = Vec3::zeros();
            input.targets[b] = Some(Target { pose_WB, velocity_W: zero, angular_velocity_W: zero });
        }
        let mut readout = run(&mut world, &input, 1500);
        check_sums(&world, &mut readout);

        let [none, finger] = readout.parts(0) else { panic!("two parts") };
        assert_eq!(none.contact.points, 0);
        let (skin, bone) = (finger.contact.force_W, finger.bone_force_W);
        assert!(skin.y > 1.0, "{kind:?}: {skin}");
        assert!((skin - bone).norm() < 2e-3 * skin.norm(), "{kind:?}: {skin} and {bone} N");
        let by_bones = world.coupling_wrench(0)[0] + world.coupling_wrench(1)[0];
        assert!((bone - by_bones).norm() < 1e-10);
        assert_eq!(finger.tip_W, world.rigid_pose(1).position);
        let torque = finger.torque_W - finger.bone_torque_W;
        assert!(torque.norm() < 2e-3 * skin.norm() * 0.03, "{kind:?}: {torque} N m");
        // The drives hold what the bones bear.
        let drives: Vec3 = (0..2).map(|b| world.drive_wrench(b, &input)[0]).sum();
        assert!((drives + bone).norm() < 2e-3 * skin.norm(), "{kind:?}: {drives} and {bone} N");
        let on_ground = readout.body(&world, ground).force_W;
        assert!(on_ground.y < -1.0);
    }
}

/// A step that is taken back leaves nothing to read, and what is open reads as zero.
#[test]
fn what_is_open_reads_as_nothing() {
    let mut desc = WorldDesc::default();
    let ground = add_ground(&mut desc);
    desc.add_soft(soft("block", Vec3::repeat(0.02), [2, 2, 2], Vec3::y() * 0.0005));
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    let mut readout = ContactReadout::new(&world);
    for _ in 0..100 {
        world.step(&input, &mut ());
        readout.read(&world);
    }
    assert!(readout.parts(0)[0].contact.normal > 0.0);
    input.gravity.y = f64::NAN;
    assert!(world.step(&input, &mut ()).non_finite);
    readout.read(&world);
    assert!(readout.vertices(0).iter().all(|v| *v == Default::default()));
    assert_eq!(readout.parts(0)[0].contact, Default::default());
    assert_eq!(readout.pair(&world, [BodyId::Soft(0), ground]), Default::default());
}
