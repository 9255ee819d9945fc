//! Goal: friction that depends on load is that of the whole patch, in both solvers. Method: blocks,
//! rigid and soft, pressed on a plane by known loads and pulled, against mu(N) N.

use crate::common::{FLESH, bar, body};
use thenar_core::model::{
    BodyId, BodyParts, FrictionTable, Material, Motion, SoftDesc, SolverKind, WorldDesc,
};
use thenar_core::readout::{ContactReadout, SlipState};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Vec3, World};

/// From 1 to 20 N the coefficient falls by 46 % (Seo et al. 2009), here by straight lines.
const SKIN: [[f64; 2]; 3] = [[1.0, 0.9], [6.0, 0.65], [20.0, 0.486]];

fn table(a: BodyId, b: BodyId) -> FrictionTable {
    FrictionTable { bodies: [a, b], points: SKIN.to_vec() }
}

fn with_ground(kind: SolverKind) -> WorldDesc {
    let mut desc = WorldDesc { time_step: 1e-3, ..WorldDesc::default() };
    desc.solver.kind = kind;
    let mut plane = body("ground", 1.0, [1.0; 3], Vec3::zeros());
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    desc.add_rigid(plane);
    desc
}

/// A cube of 40 mm that presses on the ground with `load` \[N\], pulled sideways at its foot.
fn speed_when_pulled(kind: SolverKind, load: f64, pull: f64) -> f64 {
    let mut desc = with_ground(kind);
    let mut cube = body("cube", 0.1, [1e-4; 3], Vec3::y() * 0.02);
    cube.shape = Some(Shape::Cuboid { half: Vec3::repeat(0.02) });
    desc.add_rigid(cube);
    desc.friction_tables.push(table(BodyId::Rigid(1), BodyId::Rigid(0)));
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    let down = Vec3::y() * (0.1 * 9.81 - load);
    input.wrenches[1] = [down, Vec3::zeros()];
    for step in 0..150 {
        if step == 50 {
            let pull_W = Vec3::x() * pull;
            // At the height of the ground it does not tip.
            input.wrenches[1] = [down + pull_W, (Vec3::y() * -0.02).cross(&pull_W)];
        }
        world.step(&input, &mut ());
    }
    world.rigid_velocity(1)[0].x
}

/// The pull at which a rigid block begins to slide, found by bisection.
#[test]
fn a_block_slips_at_mu_of_its_load() {
    for kind in [SolverKind::Monolithic, SolverKind::TwoStep] {
        for (load, mu) in [(0.5, 0.9), (1.0, 0.9), (3.5, 0.775), (13.0, 0.568), (30.0, 0.486)] {
            let (mut holds, mut slips) = (0.2 * load, 1.2 * load);
            for _ in 0..9 {
                let pull = 0.5 * (holds + slips);
                if speed_when_pulled(kind, load, pull) > 1e-4 { slips = pull } else { holds = pull }
            }
            let found = 0.5 * (holds + slips) / load;
            assert!((found / mu - 1.0).abs() < 0.01, "{kind:?}, {load} N: {found}, not {mu}");
        }
    }
}

/// A soft block, 25 points of which touch: the coefficient is that of all its load, not of a
/// point's share.
#[test]
fn a_soft_patch_slides_with_the_coefficient_of_all_its_load() {
    for kind in [SolverKind::Monolithic, SolverKind::TwoStep] {
        for (load, mu) in [(1.0, 0.9), (3.5, 0.775), (13.0, 0.568)] {
            let mut desc = with_ground(kind);
            desc.gravity = Vec3::zeros();
            // Stiff enough that friction shears it by no more than a tenth.
            let material = Material { young: 10.0 * FLESH.young, ..FLESH };
            let mut flesh = bar(Vec3::new(0.02, 0.01, 0.02), [4, 2, 4], material);
            flesh.stiffness_damping = 5e-3;
            let (pose_WM, velocity_W) = (Pose::translation(0.0, 1e-4, 0.0), Vec3::zeros());
            let top: Vec<usize> =
                (0..flesh.nodes.len()).filter(|&n| flesh.nodes[n].y > 0.0099).collect();
            desc.add_soft(SoftDesc {
                name: "pad".into(),
                flesh,
                pose_WM,
                velocity_W,
                coupling: None,
            });
            desc.friction_tables.push(table(BodyId::Rigid(0), BodyId::Soft(0)));
            let mut world = World::new(desc).unwrap();
            let mut input = world.input();
            let mut readout = ContactReadout::new(&world);
            for step in 0..400 {
                for n in &top {
                    let pull = if step < 200 { 0.0 } else { 1.05 * mu };
                    input.node_forces[*n] = Vec3::new(pull, -1.0, 0.0) * (load / top.len() as f64);
                }
                world.step(&input, &mut ());
                if step >= 300 {
                    readout.read(&world);
                    let patch = readout.parts(0)[0].contact;
                    let ratio = patch.shear_W.norm() / patch.normal;
                    let there = thenar_core::model::FrictionTable::at(
                        &table(BodyId::Rigid(0), BodyId::Soft(0)),
                        patch.normal,
                    );
                    assert!(patch.points >= 9 && patch.state == SlipState::Slip, "{patch:?}");
                    let case = format!("{kind:?}, {load} N, step {step}");
                    assert!((ratio / there - 1.0).abs() < 0.01, "{case}: {ratio}, not {there}");
                    assert!((patch.normal / load - 1.0).abs() < 0.1, "{case}: {patch:?}");
                }
            }
        }
    }
}

/// Two parts of one body, as two fingers of a hand, each with its own load.
#[test]
fn each_part_has_the_coefficient_of_its_own_load() {
    let mut desc = with_ground(SolverKind::Monolithic);
    desc.gravity = Vec3::zeros();
    let mut flesh = bar(Vec3::new(0.06, 0.01, 0.01), [12, 2, 2], FLESH);
    flesh.stiffness_damping = 5e-3;
    let nodes = flesh.nodes.clone();
    // In this bar every surface vertex lies on the node at which its weight is 1.
    let at = |v: &thenar_core::model::SurfaceVertex| {
        let k = v.weights.iter().position(|w| *w == 1.0).unwrap();
        nodes[flesh.tets[v.tet as usize][k] as usize]
    };
    let vertices = flesh.collision.vertices.iter().map(|v| u8::from(at(v).x > 0.03)).collect();
    let (pose_WM, velocity_W) = (Pose::translation(0.0, 1e-4, 0.0), Vec3::zeros());
    desc.add_soft(SoftDesc { name: "pair".into(), flesh, pose_WM, velocity_W, coupling: None });
    desc.parts.push(BodyParts { soft: 0, vertices, bones: Vec::new() });
    desc.friction_tables.push(table(BodyId::Rigid(0), BodyId::Soft(0)));
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    for step in 0..300 {
        for (n, x) in nodes.iter().enumerate().filter(|(_, x)| x.y > 0.0099) {
            let load = if x.x > 0.03 { 0.6 } else { 0.1 };
            let pull = if step < 100 { 0.0 } else { 1.5 };
            input.node_forces[n] = Vec3::new(0.0, -1.0, pull) * load;
        }
        world.step(&input, &mut ());
    }
    let mut readout = ContactReadout::new(&world);
    readout.read(&world);
    let skin = table(BodyId::Rigid(0), BodyId::Soft(0));
    let parts = readout.parts(0);
    assert!(parts[1].contact.normal > 3.0 * parts[0].contact.normal);
    for part in parts {
        let p = part.contact;
        let (ratio, mu) = (p.shear_W.norm() / p.normal, skin.at(p.normal));
        assert!((ratio / mu - 1.0).abs() < 0.01, "{} N: {ratio}, not {mu}", p.normal);
    }
}
