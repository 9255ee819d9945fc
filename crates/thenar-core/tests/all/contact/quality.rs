//! Goal: contact as firm and as faithful as theory asks. Method: a soft pad on a driven bone is
//! pressed, twisted, hit and made to hold things, with the monolithic solver; penetration is
//! measured over all of its surface, not at contact points.

use crate::common::{FLESH, bar, body};
use thenar_core::model::{
    Binding, BodyId, Coupling, Drive, Material, Motion, Skinning, SoftDesc, SolverKind, Springs,
    WorldDesc,
};
use thenar_core::shape::Shape;
use thenar_core::world::{Input, Target};
use thenar_core::{Pose, Quat, Vec3, World};

/// A pad of 16×10×16 mm: its upper part holds on to a bone above it.
struct Pad {
    bone: u32,
    soft: u32,
}

const DRIVE: Drive =
    Drive { stiffness: 4e4, damping: 40.0, angular_stiffness: 20.0, angular_damping: 0.02 };

fn empty(h: f64) -> WorldDesc {
    let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
    desc.solver.kind = SolverKind::Monolithic;
    desc.solver.contact_sweeps_max = 2000;
    desc
}

/// A pad whose lower face is centred at the origin of `pose` and looks along its -y.
fn add_pad(desc: &mut WorldDesc, pose: Pose, cells: [usize; 3], young: f64) -> Pad {
    let size = Vec3::new(0.016, 0.010, 0.016);
    let mut bone = body("bone", 0.02, [2e-6; 3], pose.point(&(Vec3::y() * 0.008)));
    bone.name = format!("bone {}", desc.rigids.len());
    bone.pose_WB.rotation = pose.rotation;
    let bone = desc.add_rigid(bone);
    desc.drives[bone as usize] = Some(DRIVE);
    let mut flesh = bar(size, cells, Material { young, ..FLESH });
    flesh.stiffness_damping = 2e-3;
    flesh.mass_damping = 1.0;
    flesh.friction = 0.6;
    let shift = Vec3::new(0.5 * size.x, 0.0, 0.5 * size.z);
    flesh.nodes.iter_mut().for_each(|x| *x -= shift);
    let volume = size.x * size.y * size.z / flesh.nodes.len() as f64;
    // Firm at the bone, and as in the hands everywhere else.
    let held = |x: &Vec3| volume * if x.y > 0.0065 { 1e11 } else { 2e9 };
    let coupling = Coupling {
        bindings: vec![Binding { bones: [bone; 2], weights: [1.0, 0.0] }; flesh.nodes.len()],
        springs: Springs::PerNode(flesh.nodes.iter().map(held).collect()),
        damping_time: 1e-3,
        skinning: Skinning::Linear,
    };
    let name = format!("pad {}", desc.softs.len());
    let soft = desc.add_soft(SoftDesc {
        name,
        flesh,
        pose_WM: pose,
        velocity_W: Vec3::zeros(),
        coupling: Some(coupling),
    });
    Pad { bone, soft }
}

fn add_box(desc: &mut WorldDesc, motion: Motion, half: Vec3, mass: f64, pose: Pose) -> u32 {
    let inertia = |a: f64, b: f64| mass * (a * a + b * b) / 3.0;
    let inertia = [inertia(half.y, half.z), inertia(half.x, half.z), inertia(half.x, half.y)];
    let mut rigid = body(&format!("box {}", desc.rigids.len()), mass, inertia, pose.position);
    rigid.pose_WB = pose;
    rigid.motion = motion;
    rigid.shape = Some(Shape::Cuboid { half });
    rigid.friction = 0.6;
    desc.add_rigid(rigid)
}

fn target(pose_WB: Pose) -> Option<Target> {
    Some(Target { pose_WB, velocity_W: Vec3::zeros(), angular_velocity_W: Vec3::zeros() })
}

fn force_on(world: &World, id: BodyId) -> Vec3 {
    let of = |c: &thenar_core::world::ContactPoint| match c.bodies {
        [a, _] if a == id => c.force_W,
        [_, b] if b == id => -c.force_W,
        _ => Vec3::zeros(),
    };
    world.contacts().iter().map(of).sum()
}

/// Deepest place of a soft surface in a rigid body \[m\]: over points all over its triangles, 66 on
/// each.
fn deepest(world: &World, soft: u32, rigid: u32) -> f64 {
    let shape = world.desc().rigids[rigid as usize].shape.as_ref().unwrap();
    let pose = world.rigid_pose(rigid);
    let x = world.collision_vertices(soft);
    let mut deepest = 0.0_f64;
    for t in &world.desc().softs[soft as usize].flesh.collision.triangles {
        let [a, b, c] = t.map(|v| pose.inverse_point(&x[v as usize]));
        for (i, j) in (0..=10).flat_map(|i| (0..=10 - i).map(move |j| (i, j))) {
            let p = a + (b - a) * (f64::from(i) / 10.0) + (c - a) * (f64::from(j) / 10.0);
            deepest = deepest.max(-shape.distance(&p).value);
        }
    }
    deepest
}

fn run(world: &mut World, input: &Input, seconds: f64, mut each: impl FnMut(&World)) {
    for step in 0..(seconds / world.time_step()).round() as usize {
        let report = world.step(input, &mut ());
        assert!(!report.non_finite && report.contacts_dropped == 0, "step {step}: {report:?}");
        each(world);
    }
}

/// 20 N on a pad over a flat table, level and turned.
#[test]
fn twenty_newtons_press_no_surface_point_in_by_more_than_a_fifth_of_a_millimetre() {
    let half = Vec3::new(0.05, 0.01, 0.05);
    for angle in [0.0, 0.4] {
        for h in [1e-3, 1e-2] {
            let mut desc = empty(h);
            let turn = Quat::from_axis_angle(&Vec3::y_axis(), angle);
            let place = Pose::new(Vec3::y() * -0.01, turn);
            let table = add_box(&mut desc, Motion::Prescribed, half, 1.0, place);
            let pad = add_pad(&mut desc, Pose::translation(0.0, 0.0005, 0.0), [4, 3, 4], 3e5);
            // The bone is pushed down by a force, and kept level by its drive.
            desc.drives[pad.bone as usize] = Some(Drive { stiffness: 0.1, damping: 20.0, ..DRIVE });
            let start = desc.rigids[pad.bone as usize].pose_WB;
            let mut world = World::new(desc).unwrap();
            let mut input = world.input();
            input.targets[pad.bone as usize] = target(start);
            let mut worst = 0.0_f64;
            for k in 0..20 {
                input.wrenches[pad.bone as usize][0].y = -f64::from(k + 1);
                run(&mut world, &input, 0.02, |_| {});
                worst = worst.max(deepest(&world, pad.soft, table));
            }
            run(&mut world, &input, 0.3, |_| {});
            worst = worst.max(deepest(&world, pad.soft, table));
            let force = force_on(&world, BodyId::Rigid(table)).y;
            assert!(force < -19.0, "h {h}: {force} N on the table");
            assert!(worst < 2e-4, "h {h}: {:.3} mm deep", worst * 1e3);
        }
    }
}

/// A plate 2 mm thick comes at a pad, and a pad at the plate, with 5 m/s. The bone weighs 3 g, as
/// in a finger: what the flesh can stop before it is crushed.
#[test]
fn a_thin_plate_and_a_pad_at_five_metres_a_second_do_not_pass_through_each_other() {
    let half = Vec3::new(0.04, 0.001, 0.04);
    let check = |world: &World, pad: &Pad, plate: u32, case: &str| {
        let pose = world.rigid_pose(plate);
        let above = pose.inverse_point(&world.rigid_pose(pad.bone).position).y;
        let flesh = world.collision_vertices(pad.soft).iter().map(|x| pose.inverse_point(x).y);
        let low = flesh.fold(f64::INFINITY, f64::min);
        assert!(low > 0.0, "{case}: flesh {low} m above the plate's middle");
        assert!(above > 0.001, "{case}: the bone is {above} m above the plate's middle");
    };
    for h in [1e-3, 5e-3, 1.0 / 60.0] {
        for offset in [0.0, 0.003, 0.007, 0.02] {
            let mut desc = empty(h);
            let pad = add_pad(&mut desc, Pose::identity(), [3, 3, 3], 1e6);
            desc.rigids[pad.bone as usize].mass = 0.003;
            desc.drives[pad.bone as usize] =
                Some(Drive { stiffness: 400.0, damping: 2.0, ..DRIVE });
            let at = Pose::translation(0.002, -0.005 - offset, 0.001);
            let plate = add_box(&mut desc, Motion::Prescribed, half, 1.0, at);
            let start = desc.rigids[pad.bone as usize].pose_WB;
            let mut world = World::new(desc).unwrap();
            let mut input = world.input();
            input.targets[pad.bone as usize] = target(start);
            input.prescribed[plate as usize][0] = Vec3::y() * 5.0;
            let case = format!("plate at pad, h {h}, from {offset}");
            run(&mut world, &input, 0.05, |world| check(world, &pad, plate, &case));

            let mut desc = empty(h);
            let pad =
                add_pad(&mut desc, Pose::translation(0.0, 0.005 + offset, 0.0), [3, 3, 3], 1e6);
            desc.drives[pad.bone as usize] = None;
            desc.rigids[pad.bone as usize].mass = 0.003;
            desc.rigids[pad.bone as usize].velocity_W = Vec3::y() * -5.0;
            desc.softs[pad.soft as usize].velocity_W = Vec3::y() * -5.0;
            let plate = add_box(&mut desc, Motion::Prescribed, half, 1.0, Pose::identity());
            let mut world = World::new(desc).unwrap();
            let input = world.input();
            let case = format!("pad at plate, h {h}, from {offset}");
            run(&mut world, &input, 0.05, |world| check(world, &pad, plate, &case));
        }
    }
}

/// A plate of 2 mm against small things, each thrown at the other.
#[test]
fn thin_plates_and_small_things_do_not_pass_through_each_other() {
    let small = [
        Shape::Sphere { radius: 0.004 },
        Shape::Capsule { radius: 0.003, half_length: 0.006 },
        Shape::Cuboid { half: Vec3::new(0.004, 0.002, 0.006) },
    ];
    for h in [1e-3, 5e-3, 1.0 / 60.0] {
        for shape in &small {
            for plate_comes in [false, true] {
                for k in 0..6 {
                    let mut desc = empty(h);
                    desc.gravity = Vec3::zeros();
                    let half = Vec3::new(0.05, 0.001, 0.05);
                    let mass = if plate_comes { 0.1 } else { 1e3 };
                    let plate = add_box(&mut desc, Motion::Dynamic, half, mass, Pose::identity());
                    let at = Vec3::new(0.004, 0.02 + 0.009 * f64::from(k), -0.003);
                    let mut thing = body("thing", 0.01, [2e-7; 3], at);
                    thing.pose_WB.rotation =
                        Quat::from_euler_angles(0.4 * f64::from(k), 0.2, 0.3 * f64::from(k));
                    thing.shape = Some(shape.clone());
                    let thing = desc.add_rigid(thing);
                    let mover = if plate_comes { plate } else { thing };
                    let way = if plate_comes { 5.0 } else { -5.0 };
                    desc.rigids[mover as usize].velocity_W = Vec3::y() * way;
                    let mut world = World::new(desc).unwrap();
                    let input = world.input();
                    run(&mut world, &input, 0.1, |world| {
                        let at = world.rigid_pose(thing).position;
                        let above = world.rigid_pose(plate).inverse_point(&at).y;
                        assert!(above > 0.0015, "{shape:?}, h {h}, {plate_comes}, {k}: {above} m");
                    });
                }
            }
        }
    }
}

/// 200 g held for 10 s by friction between two pads of 5 N each: it needs 1.64 N.
#[test]
fn a_block_held_between_two_pads_does_not_creep() {
    let mut desc = empty(1e-2);
    let half = Vec3::new(0.02, 0.015, 0.015);
    let block = add_box(&mut desc, Motion::Dynamic, half, 0.2, Pose::identity());
    let quarter = std::f64::consts::FRAC_PI_2;
    let mut pads = Vec::new();
    for side in [-1.0, 1.0] {
        let turn = Quat::from_axis_angle(&Vec3::z_axis(), -side * quarter);
        let at = Pose::new(Vec3::x() * (side * 0.0201), turn);
        pads.push(add_pad(&mut desc, at, [3, 2, 3], 5e4));
    }
    for pad in &pads {
        desc.drives[pad.bone as usize] = Some(Drive { stiffness: 2000.0, ..DRIVE });
    }
    let poses: Vec<Pose> = pads.iter().map(|p| desc.rigids[p.bone as usize].pose_WB).collect();
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    for ((pad, pose), side) in pads.iter().zip(&poses).zip([-1.0, 1.0]) {
        let inward = Pose::new(pose.position - Vec3::x() * (side * 0.005), pose.rotation);
        input.targets[pad.bone as usize] = target(inward);
    }
    run(&mut world, &input, 2.0, |_| {});
    let place = |world: &World| {
        let held = world.rigid_pose(block).position;
        held - pads.iter().map(|p| world.rigid_pose(p.bone).position).sum::<Vec3>() / 2.0
    };
    let before = place(&world);
    run(&mut world, &input, 10.0, |_| {});
    let force = force_on(&world, BodyId::Soft(pads[0].soft)).x.abs();
    assert!(force > 2.0, "gripped with {force} N");
    let crept = (place(&world) - before).norm();
    assert!(crept < 1e-4, "crept {crept} m in 10 s");
    let carried = force_on(&world, BodyId::Rigid(block)).y;
    assert!((carried / (0.2 * 9.81) - 1.0).abs() < 0.01, "{carried} N carry it");
}

/// On a slope of 15° with a friction of 0.6, rigid and soft things stay where they are.
#[test]
fn nothing_creeps_down_a_slope() {
    let slope = 15.0_f64.to_radians();
    for soft in [false, true] {
        let mut desc = empty(1e-2);
        desc.gravity = Vec3::new(9.81 * slope.sin(), -9.81 * slope.cos(), 0.0);
        let mut plane = body("plane", 1.0, [1.0; 3], Vec3::zeros());
        plane.motion = Motion::Prescribed;
        plane.shape = Some(Shape::HalfSpace);
        plane.friction = 0.6;
        desc.add_rigid(plane);
        let half = Vec3::new(0.02, 0.01, 0.02);
        if soft {
            let mut flesh = bar(2.0 * half, [4, 2, 4], FLESH);
            flesh.stiffness_damping = 2e-3;
            flesh.friction = 0.6;
            desc.add_soft(SoftDesc {
                name: "block".into(),
                flesh,
                pose_WM: Pose::identity(),
                velocity_W: Vec3::zeros(),
                coupling: None,
            });
        } else {
            add_box(&mut desc, Motion::Dynamic, half, 0.2, Pose::translation(0.0, 0.01, 0.0));
        }
        let mut world = World::new(desc).unwrap();
        let input = world.input();
        let place = |world: &World| match soft {
            true => world.nodes(0).iter().sum::<Vec3>() / world.nodes(0).len() as f64,
            false => world.rigid_pose(1).position,
        };
        run(&mut world, &input, 1.0, |_| {});
        let before = place(&world);
        run(&mut world, &input, 10.0, |_| {});
        let crept = (place(&world) - before).norm();
        assert!(crept < 1e-4, "soft {soft}: crept {crept} m in 10 s");
    }
}

/// A pad pressed on a plate and twisted slides all over when the torque reaches the sum of
/// `μ F_i r_i` over its pressed points: friction against spinning comes from the patch alone. For a
/// square of side a under even pressure that is 0.3826 μ N a.
#[test]
fn a_twisted_pad_resists_as_its_pressure_says() {
    let mut desc = empty(2e-3);
    let half = Vec3::new(0.05, 0.01, 0.05);
    let down = Pose::translation(0.0, -0.01, 0.0);
    let plate = add_box(&mut desc, Motion::Prescribed, half, 1.0, down);
    let pad = add_pad(&mut desc, Pose::translation(0.0, 0.0002, 0.0), [4, 3, 4], 5e4);
    let start = desc.rigids[pad.bone as usize].pose_WB;
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    let lowered = start.position - Vec3::y() * 0.0010;
    input.targets[pad.bone as usize] = target(Pose::new(lowered, start.rotation));
    run(&mut world, &input, 0.3, |_| {});
    // The plate turns under it at 1 rad/s.
    input.prescribed[plate as usize][1] = Vec3::y();
    run(&mut world, &input, 1.2, |_| {});
    let centre = world.rigid_pose(plate).position;
    let (mut torque, mut bound, mut normal) = (0.0, 0.0, 0.0);
    for c in world.contacts() {
        let arm = c.position_W - centre;
        // On the pad, which is side A.
        torque += arm.cross(&c.force_W).y;
        bound += 0.6 * c.force_W.y * arm.x.hypot(arm.z);
        normal += c.force_W.y;
    }
    assert!(normal > 1.0, "pressed with {normal} N");
    assert!((torque / bound - 1.0).abs() < 0.01, "{torque} of {bound} N m");
    // Pressure is higher at the rim of a bonded block than in its middle: more than when even.
    let even = 0.3826 * 0.6 * normal * 0.016;
    assert!((0.95..1.3).contains(&(torque / even)), "{torque} N m, even {even}");
    // The bone feels it: the drive holds against the same torque.
    let drive = world.drive_wrench(pad.bone, &input)[1].y;
    assert!((drive / -torque - 1.0).abs() < 0.03, "drive {drive} N m against {torque}");
}
