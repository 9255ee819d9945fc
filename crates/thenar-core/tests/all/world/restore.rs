//! Goal: a state is all that the next steps need. Method: a soft cube is pressed through the middle
//! of a thin plate, where only the side it came from tells which way is out; a second world that is
//! put into the kept state must go on with the same bits, one that lacks the sides must not.

use crate::common::{FLESH, bar, body};
use thenar_core::model::{Motion, SoftDesc, SolverKind, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::world::State;
use thenar_core::{Pose, Vec3, World};

/// A soft cube whose lowest layer is held 1.2 mm deep in a plate 2 mm thick.
fn world(kind: SolverKind) -> World {
    let mut desc = WorldDesc { time_step: 2e-3, ..WorldDesc::default() };
    desc.solver.kind = kind;
    let mut plate = body("plate", 1.0, [1.0; 3], Vec3::y() * -0.0005);
    plate.motion = Motion::Prescribed;
    plate.shape = Some(Shape::Cuboid { half: Vec3::new(0.1, 0.001, 0.1) });
    desc.add_rigid(plate);
    desc.add_soft(SoftDesc {
        name: "cube".into(),
        flesh: bar(Vec3::repeat(0.02), [2, 2, 2], FLESH),
        pose_WM: Pose::translation(0.0, 0.001, 0.0),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    World::new(desc).unwrap()
}

/// The state after some steps on the plate, then with the cube moved down into it.
fn sunk(kind: SolverKind) -> State {
    let mut world = world(kind);
    let input = world.input();
    for _ in 0..50 {
        world.step(&input, &mut ());
    }
    let mut state = world.state().clone();
    state.x.iter_mut().for_each(|x| x.y -= 0.0012);
    state
}

fn hashes(world: &mut World) -> Vec<u64> {
    let input = world.input();
    (0..20)
        .map(|_| {
            world.step(&input, &mut ());
            world.state_hash()
        })
        .collect()
}

#[test]
fn a_restored_state_goes_on_with_the_same_bits() {
    for kind in [SolverKind::Monolithic, SolverKind::TwoStep] {
        let state = sunk(kind);
        let mut one = world(kind);
        assert!(one.restore(&state));
        let first = hashes(&mut one);
        let low = one.nodes(0).iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
        assert!(low > 0.0, "{kind:?}: it goes back to the side it came from, not to {low}");

        // In a world that did something else meanwhile, and again in the same one.
        let mut other = world(kind);
        let input = other.input();
        for _ in 0..7 {
            other.step(&input, &mut ());
        }
        assert!(other.restore(&state));
        assert_eq!(hashes(&mut other), first, "{kind:?}");
        assert!(one.restore(&state));
        assert_eq!(hashes(&mut one), first, "{kind:?}");

        // Without its sides it is another state, and it falls out below.
        let mut blind = state.clone();
        blind.sides.clear();
        assert_ne!(blind.hash(), state.hash());
        assert!(other.restore(&blind));
        assert_ne!(hashes(&mut other), first, "{kind:?}");
    }
}

#[test]
fn a_foreign_state_is_refused() {
    let mut world = world(SolverKind::Monolithic);
    let before = world.state_hash();
    let mut foreign = world.state().clone();
    foreign.x.pop();
    assert!(!world.restore(&foreign));
    let mut broken = world.state().clone();
    broken.x[0].x = f64::NAN;
    assert!(!world.restore(&broken));
    assert_eq!(world.state_hash(), before);
}
