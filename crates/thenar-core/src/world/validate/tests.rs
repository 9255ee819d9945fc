use super::*;
use crate::contact::{self, Contact, HeldPlace, Shape, Site};
use crate::math::Mat3;
use crate::model::{
    AngleLimit, Axis, Cone, EmbeddedSurface, FixedNode, Flesh, FrictionTable, JointDesc, JointKind,
    Law, Material, Motion, Relaxation, RigidDesc, SoftDesc, SolverKind, SurfaceVertex, WorldDesc,
};
use std::f64::consts::FRAC_PI_2;

const FLOOR: usize = 0;
const CUBE: usize = 1;
const ARM: usize = 2;
const HELD: usize = 0;

fn body(name: &str, motion: Motion, x: f64, y: f64, shape: Option<Shape>) -> RigidDesc {
    RigidDesc {
        name: name.into(),
        motion,
        mass: 0.1,
        inertia: Mat3::from_diagonal_element(1e-5),
        pose_WB: Pose::translation(x, y, 0.0),
        velocity_W: Vec3::zeros(),
        angular_velocity_W: Vec3::zeros(),
        shape,
        pose_BS: Pose::identity(),
        friction: 0.5,
    }
}

/// One tetrahedron with memory, a corner of which keeps its place along x.
fn flesh() -> Flesh {
    let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
    let corner = |k: usize| {
        let mut weights = [0.0; 4];
        weights[k] = 1.0;
        SurfaceVertex { tet: 0, weights }
    };
    Flesh {
        nodes: corners.map(|x| x * 0.02).into(),
        tets: vec![[0, 1, 2, 3]],
        materials: vec![Material {
            law: Law::Corotational,
            young: 5e4,
            poisson: 0.4,
            density: 1000.0,
        }],
        relaxation: vec![Relaxation::new(&[[0.3, 0.1]]).unwrap()],
        mass_damping: 0.0,
        stiffness_damping: 0.0,
        fixed: vec![FixedNode { node: HELD as u32, axes: [true, false, false] }],
        collision: EmbeddedSurface {
            vertices: (0..4).map(corner).collect(),
            triangles: vec![[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]],
        },
        friction: 0.5,
    }
}

/// A cube and flesh that lie on a floor, and an arm that its weight holds at the limit of its
/// hinge.
fn resting(kind: SolverKind, cone: Cone) -> World {
    let mut desc = WorldDesc { time_step: 2e-3, ..WorldDesc::default() };
    (desc.solver.kind, desc.solver.cone) = (kind, cone);
    desc.add_rigid(body("floor", Motion::Prescribed, 0.0, 0.0, Some(Shape::HalfSpace)));
    let cube = Shape::Cuboid { half: Vec3::repeat(0.01) };
    desc.add_rigid(body("cube", Motion::Dynamic, 0.2, 0.01, Some(cube)));
    desc.add_rigid(body("arm", Motion::Dynamic, 0.55, 0.2, None));
    // A hinge turns about x of its frame.
    let about_z = Quat::from_axis_angle(&Vec3::y_axis(), -FRAC_PI_2);
    let limit = Some(AngleLimit { min: -0.05, max: 0.05 });
    desc.joints.push(JointDesc {
        name: "hinge".into(),
        kind: JointKind::Hinge,
        parent: None,
        child: ARM as u32,
        pose_PJ: Pose::new(Vec3::new(0.5, 0.2, 0.0), about_z),
        pose_CK: Pose::new(Vec3::x() * -0.05, about_z),
        axes: [Axis { limit, ..Axis::default() }, Axis::default()],
        limit_stiffness: 10.0,
        limit_damping: 0.01,
    });
    desc.add_soft(SoftDesc {
        name: "flesh".into(),
        flesh: flesh(),
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    desc.friction_tables.push(FrictionTable {
        bodies: [BodyId::Rigid(FLOOR as u32), BodyId::Soft(0)],
        points: vec![[0.0, 0.8], [20.0, 0.4]],
    });
    let mut world = World::new(desc).unwrap();
    assert_eq!(world.validate(), Ok(()), "before the first step");
    let input = world.input();
    (0..150).for_each(|_| {
        world.step(&input, &mut ());
    });
    world
}

/// Rotations in single precision, and others of any length but none, are brought to length one
/// wherever a description has them: what touches then has unit normals, and the world steps as with
/// the true ones.
#[test]
fn rotations_of_another_length_are_brought_to_one() {
    let turn = Quat::from_axis_angle(&Vec3::y_axis(), 0.3);
    let of_length = |length: f64| Quat::new_unchecked(turn.into_inner() * length);
    let world = |length: f64| {
        let at = |y: f64| Pose::new(Vec3::new(0.0, y, 0.0), of_length(length));
        let mut desc = WorldDesc { time_step: 2e-3, ..WorldDesc::default() };
        let mut floor = body("floor", Motion::Prescribed, 0.0, 0.0, Some(Shape::HalfSpace));
        floor.pose_BS = at(0.0);
        desc.add_rigid(floor);
        let part = contact::PlacedShape {
            shape: Shape::Cuboid { half: Vec3::repeat(0.01) },
            pose_SP: at(0.0),
        };
        let compound = Shape::Compound(std::sync::Arc::new(vec![part]));
        let mut cube = body("cube", Motion::Dynamic, 0.2, 0.01, Some(compound));
        (cube.pose_BS, cube.pose_WB) = (at(0.0), at(0.01));
        desc.add_rigid(cube);
        desc.add_rigid(body("arm", Motion::Dynamic, 0.55, 0.2, None));
        desc.joints.push(JointDesc {
            name: "hinge".into(),
            kind: JointKind::Hinge,
            parent: None,
            child: ARM as u32,
            pose_PJ: Pose::new(Vec3::new(0.5, 0.2, 0.0), of_length(length)),
            pose_CK: Pose::new(Vec3::x() * -0.05, of_length(length)),
            axes: [Axis::default(); 2],
            limit_stiffness: 0.0,
            limit_damping: 0.0,
        });
        World::new(desc)
    };
    let states = [1.0, 1.0 + 1e-7, 2.0, 1e-3].map(|length| {
        let mut world = world(length).unwrap();
        let input = world.input();
        (0..50).for_each(|_| _ = world.step(&input, &mut ()));
        assert!(world.contacts().iter().any(|c| c.force_W.y != 0.0), "{length}");
        world.rigid_pose(CUBE as u32)
    });
    for pose in &states[1..] {
        assert!((pose.position - states[0].position).norm() < 1e-9, "{pose:?}");
        assert!(pose.rotation.angle_to(&states[0].rotation) < 1e-7, "{pose:?}");
    }
    assert!(world(0.0).is_err());
}

#[test]
fn a_world_at_rest_is_valid_by_every_solver_and_after_every_change() {
    for kind in [SolverKind::Monolithic, SolverKind::TwoStep, SolverKind::DenseReference] {
        for cone in [Cone::Circular, Cone::Linearised] {
            let mut world = resting(kind, cone);
            let case = format!("{kind:?}, {cone:?}");
            assert_eq!(world.validate_step(), Ok(()), "{case}");
            let touches = |soft: bool| {
                let of = |c: &&ContactPoint| c.touches_skin() == soft && c.force_W.y != 0.0;
                world.contacts().iter().filter(of).count()
            };
            assert!(touches(true) > 0 && touches(false) > 0, "{case}");
            assert!(!world.state.patch_loads.is_empty(), "{case}");
            let pose_WB = Pose::translation(0.2, 0.05, 0.0);
            let kept = world.state().clone();
            for h in [1e-3, 10.0, 1e-300, 10.0, 2e-3] {
                world.set_time_step(h);
                assert_eq!(world.validate(), Ok(()), "{case}, {h} s");
            }
            world.set_rigid_state(CUBE as u32, pose_WB, [Vec3::x(), Vec3::z()]);
            assert_eq!(world.validate(), Ok(()), "{case}, placed");
            world.set_nodes(0, &[Vec3::x(), Vec3::y(), Vec3::z(), Vec3::zeros()]);
            assert_eq!(world.validate(), Ok(()), "{case}, nodes placed");
            assert!(world.restore(&kept));
            assert_eq!(world.validate(), Ok(()), "{case}, restored");
            world.restart();
            assert_eq!(world.validate(), Ok(()), "{case}, restarted");
        }
    }
}

/// Impulses that a step ten billion times as long would give are forgotten where no number holds
/// them.
#[test]
fn what_another_time_step_makes_infinite_is_forgotten() {
    let mut world = resting(SolverKind::Monolithic, Cone::Circular);
    world.state.impulses[0].1 = Vec3::new(1e-3, 1e300, 0.0);
    world.set_time_step(2e-12);
    world.state.impulses[0].1.y = 1e300;
    world.set_time_step(2.0);
    assert_eq!(world.validate(), Ok(()));
    let [x, y, _] = world.state.impulses[0].1.into();
    assert!((x - 1.0).abs() < 1e-12 && y == 0.0, "{x} {y}");
}

/// States that no step leaves behind, read from a file say, are refused or put in order.
#[test]
fn restored_states_are_valid_or_refused() {
    let mut world = resting(SolverKind::Monolithic, Cone::Circular);
    let good = world.state().clone();
    let doubled = Quat::new_unchecked(good.poses_WB[CUBE].rotation.into_inner() * 2.0);
    let refused: [fn(&mut State); 3] = [
        |state| state.v[5].x = f64::NAN,
        |state| state.patch_loads[0].1 = -1.0,
        |state| state.x.truncate(3),
    ];
    for spoil in refused {
        let mut bad = good.clone();
        spoil(&mut bad);
        assert!(!world.restore(&bad));
    }
    let place = good.poses_WB[CUBE].position;
    for none in [0.0, f64::NAN, f64::INFINITY] {
        let rotation = Quat::new_unchecked(doubled.into_inner() * none);
        let mut bad = good.clone();
        bad.poses_WB[CUBE].rotation = rotation;
        assert!(!world.restore(&bad));
        world.set_rigid_state(CUBE as u32, Pose::new(place, rotation), [Vec3::zeros(); 2]);
        assert_eq!(world.state().hash(), good.hash());
    }
    // A rotation of another length turns as far.
    let mut long = good.clone();
    long.poses_WB[CUBE].rotation = doubled;
    assert!(world.restore(&long));
    assert_eq!(world.validate(), Ok(()));
    assert!(world.rigid_pose(CUBE as u32).rotation.angle_to(&doubled) < 1e-7);
    world.set_rigid_state(CUBE as u32, Pose::new(place, doubled), [Vec3::zeros(); 2]);
    assert_eq!(world.validate(), Ok(()));

    let mut tidied = good.clone();
    tidied.impulses.reverse();
    tidied.v[6 + HELD].x = 0.3;
    assert!(world.restore(&tidied));
    assert_eq!(world.validate(), Ok(()));
    assert_eq!(world.state().hash(), good.hash());
}

/// Words that are expected, and what is broken by hand.
type Broken = (&'static str, fn(&mut World));

fn assert_each_is_found(broken: &[Broken]) {
    let world = resting(SolverKind::Monolithic, Cone::Circular);
    assert_eq!(world.validate(), Ok(()));
    for (said, spoil) in broken {
        let mut bad = world.clone();
        spoil(&mut bad);
        let found = bad.validate().map_err(|invalid| invalid.to_string());
        let start = found.as_ref().err().is_some_and(|text| text.starts_with(said));
        assert!(start, "{found:?} of: {said}");
    }
}

const OF_STATES: &[Broken] = &[
    ("world 0: time step must be", |w| w.time_step = 0.0),
    ("world 0: time [s] must be finite, got inf", |w| w.state.time = f64::INFINITY),
    ("poses of rigid bodies: 2 entries, expected 3", |w| w.state.poses_WB.truncate(2)),
    ("positions of nodes: 3 entries, expected 4", |w| w.state.x.truncate(3)),
    ("velocities: 9 entries, expected 10", |w| w.state.v.truncate(9)),
    ("velocities by contact: 11 entries, expected 10", |w| {
        w.state.contact_change.push(Vec3::zeros());
    }),
    ("impulses of joint limits: 0 entries, expected 1", |w| w.state.limit_impulses.clear()),
    ("faded stresses: 0 entries, expected 1", |w| w.state.faded.clear()),
    ("rigid body 1: position [m] must be finite and within 1e9, got NaN", |w| {
        w.state.poses_WB[CUBE].position.y = f64::NAN;
    }),
    ("rigid body 2: length of the rotation must be 1, got 2", |w| {
        w.state.poses_WB[ARM].rotation = Quat::new_unchecked(Quat::identity().into_inner() * 2.0);
    }),
    ("node 2: position [m] must be finite and within 1e9, got 2000000000", |w| {
        w.state.x[2].z = -2e9;
    }),
    ("block row 3: velocity [m/s, rad/s] must be", |w| w.state.v[3].x = f64::INFINITY),
    ("block row 4: velocity by contact [m/s] must be finite, got NaN", |w| {
        w.state.contact_change[4].y = f64::NAN;
    }),
    ("remembered contact 0: impulse [N s] must be finite", |w| {
        w.state.impulses[0].1.z = f64::INFINITY;
    }),
    ("joint 0: impulse of limits [N m s] must be finite", |w| {
        w.state.limit_impulses[0][1] = f64::NAN;
    }),
    ("patch 0: load [N] must be finite and not negative, got -1", |w| {
        w.state.patch_loads[0].1 = -1.0;
    }),
    ("element with memory 0: faded stress must be finite", |w| {
        w.state.faded[0][3] = f64::NAN;
    }),
    ("held place 0: weights must be finite", |w| {
        let held = HeldPlace::new([0; 4], [f64::NAN, 0.5, 0.5]);
        w.state.sides = w.state.sides.clone().with_places(vec![held]);
    }),
    ("held node 0: speed along held axes [m/s] must be 0, got 0.1", |w| {
        w.state.v[6 + HELD].x = 0.1;
    }),
    ("impulses of contacts: not in order", |w| w.state.impulses.reverse()),
    ("loads of patches: not in order", |w| {
        let (key, load) = w.state.patch_loads[0];
        w.state.patch_loads.insert(0, (key.map(|k| k + 1), load));
    }),
];

#[test]
fn what_is_wrong_with_a_state_is_named() {
    assert_each_is_found(OF_STATES);
}

/// The first contact of the cube.
fn of_cube(world: &mut World) -> &mut ContactPoint {
    let of = |c: &&mut ContactPoint| c.bodies.contains(&BodyId::Rigid(CUBE as u32));
    world.readout.contacts.iter_mut().filter(of).find(|c| c.force_W.y != 0.0).unwrap()
}

/// The first contact of the flesh, put before all others.
fn of_flesh(world: &mut World) -> &mut ContactPoint {
    let contacts = &mut world.readout.contacts;
    let first = contacts.iter().position(ContactPoint::touches_skin).unwrap();
    contacts.swap(0, first);
    &mut contacts[0]
}

const OF_CONTACTS: &[Broken] = &[
    ("sites of contacts:", |w| {
        w.readout.sites.pop();
    }),
    ("rows of contacts and limits:", |w| {
        w.readout.rows.rows.pop();
    }),
    ("contact 0: position [m] must be finite", |w| of_flesh(w).position_W.x = f64::NAN),
    ("contact 0: length of the normal must be 1, got 1.0001", |w| {
        of_flesh(w).normal_W *= 1.0001;
    }),
    ("contact 0: gap [m] must be finite", |w| of_flesh(w).gap = f64::NEG_INFINITY),
    ("contact 0: slip [m/s] must be finite", |w| of_flesh(w).slip_W.y = f64::NAN),
    ("contact 0: force [N] must be finite", |w| of_flesh(w).force_W.y = f64::NAN),
    ("contact 0: area [m²] must be finite and not negative, got -1", |w| {
        of_flesh(w).area = -1.0;
    }),
    ("contact 0: friction coefficient must be", |w| of_flesh(w).friction = -0.5),
    ("contact 0: normal force [N] must be not negative", |w| {
        let contact = of_flesh(w);
        contact.force_W = contact.normal_W * -1.0;
    }),
    ("contact 0: deformable body must be one of the world's, got 7", |w| {
        let soft = |body: &&mut BodyId| matches!(body, BodyId::Soft(_));
        *of_flesh(w).bodies.iter_mut().find(soft).unwrap() = BodyId::Soft(7);
    }),
    ("contact 0: vertex must be one of its body's surface, got 4", |w| {
        *of_flesh(w).vertices.iter_mut().flatten().next().unwrap() = 4;
    }),
    ("contact 0: vertex must be none on a rigid body", |w| of_flesh(w).vertices = [Some(0); 2]),
    ("contact 0: body without a vertex must be rigid", |w| of_flesh(w).vertices = [None; 2]),
    ("contact 0: force on B must be opposite", |w| {
        let [held, _] = &mut w.readout.rows.rows[0].rigids;
        held.as_mut().unwrap().2 *= 1.001;
    }),
    ("limit 0: joint must be one of the world's, got 5", |w| w.readout.limits[0].joint = 5),
    ("limit 1: impulse away from its bound [N s] must be", |w| {
        w.readout.rows.rows.last_mut().unwrap().lambda.x = -1e-9;
    }),
];

#[test]
fn what_is_wrong_with_contacts_and_limits_is_named() {
    assert_each_is_found(OF_CONTACTS);
    // Whatever its number.
    let mut world = resting(SolverKind::Monolithic, Cone::Circular);
    let contact = of_cube(&mut world);
    contact.force_W.x += 0.6 * contact.force_W.y.abs();
    let said = world.validate().unwrap_err().to_string();
    assert!(said.contains("tangential force [N] must be within the cone of friction"), "{said}");
    let mut world = resting(SolverKind::Monolithic, Cone::Circular);
    of_cube(&mut world).bodies = [BodyId::Rigid(CUBE as u32); 2];
    let said = world.validate().unwrap_err().to_string();
    assert!(said.ends_with("other body must be another one, got 1"), "{said}");
    let mut world = resting(SolverKind::Monolithic, Cone::Circular);
    of_cube(&mut world).bodies = [BodyId::Rigid(FLOOR as u32), BodyId::Rigid(3)];
    let said = world.validate().unwrap_err().to_string();
    assert!(said.ends_with("rigid body must be one of the world's, got 3"), "{said}");
}

/// Friction in the corner of the disc is allowed there, and beyond the square that is inscribed in
/// it.
#[test]
fn the_square_is_asked_of_steps_with_the_linearised_cone() {
    let mut world = resting(SolverKind::Monolithic, Cone::Linearised);
    assert_eq!(world.validate_step(), Ok(()));
    let flesh = |contact: &Contact| matches!(contact.a, Site::Soft(_));
    let i = world.readout.sites.iter().position(flesh).unwrap();
    let row = &mut world.readout.rows.rows[i];
    row.lambda.y = row.friction * row.lambda.x * 0.9;
    assert!(row.lambda.x > 0.0);
    let said = world.validate_step().unwrap_err().to_string();
    assert!(said.contains("within the square inscribed in Coulomb's disc"), "{said}");
    world.desc.solver.cone = Cone::Circular;
    assert_eq!(world.validate_step(), Ok(()));
}

#[test]
fn led_bodies_and_held_nodes_are_where_they_were_put() {
    let mut desc = resting(SolverKind::Monolithic, Cone::Circular).desc.clone();
    desc.rigids[FLOOR].shape = None;
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    input.prescribed[FLOOR] = [Vec3::new(0.3, -0.2, 0.1), Vec3::new(2.0, 1.0, -3.0)];
    let part = StepPart { h: world.time_step(), left: 0.0, reach: 0.0 };
    let done = StepReport::default();
    world.step(&input, &mut ());
    assert_eq!(world.validate_led(part, &input, &done), Ok(()));
    let broken: [Broken; 4] = [
        ("led body 0: velocity must be as prescribed", |w| w.state.v[0].x += 1e-12),
        ("led body 0: way from where it was led [m] must be none", |w| {
            w.state.poses_WB[FLOOR].position.z += 1e-12;
        }),
        ("led body 0: turn from where it was led must be none", |w| {
            let turn = Quat::from_scaled_axis(Vec3::x() * 1e-8);
            w.state.poses_WB[FLOOR].rotation = turn * w.state.poses_WB[FLOOR].rotation;
        }),
        ("held node 0: way along held axes [m] must be none", |w| w.state.x[HELD].x += 1e-15),
    ];
    for (said, spoil) in broken {
        let mut bad = world.clone();
        spoil(&mut bad);
        let found = bad.validate_led(part, &input, &done).unwrap_err().to_string();
        assert!(found.starts_with(said), "{found}");
    }
}
