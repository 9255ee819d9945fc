//! Goal: a chain that the monolithic solver would take seconds a step for is refused with the way
//! out, and nothing else is. Method: chains, rings and chains held in the middle, of as many
//! freedoms as are taken and one more body, against freedoms counted by hand.

use crate::common::body;
use thenar_core::model::{Axis, JointDesc, JointKind, Motion, SolverKind, WorldDesc};
use thenar_core::{Pose, Vec3, World};

/// Freedoms that are taken at most.
const MOST: u32 = 1000;

fn joint(parent: u32, child: u32, kind: JointKind) -> JointDesc {
    JointDesc {
        name: format!("joint {child}"),
        kind,
        parent: Some(parent),
        child,
        pose_PJ: Pose::identity(),
        pose_CK: Pose::identity(),
        axes: [Axis::default(); 2],
        limit_stiffness: 0.0,
        limit_damping: 0.0,
    }
}

/// Bodies in a chain, and with `ring` a joint from the first to the last.
fn chain(bodies: u32, kind: JointKind, ring: bool) -> WorldDesc {
    let mut desc = WorldDesc::default();
    for i in 0..bodies {
        desc.add_rigid(body(&format!("link {i}"), 0.1, [1e-4; 3], Vec3::zeros()));
    }
    desc.joints = (1..bodies).map(|child| joint(child - 1, child, kind)).collect();
    if ring {
        desc.joints.push(joint(0, bodies - 1, kind));
    }
    desc
}

#[test]
fn long_chains_are_refused_by_the_monolithic_solver_alone() {
    // Six freedoms of the first body, then three of a ball joint and one of a hinge; what closes a
    // ring fixes some of them, but takes no less time.
    for (kind, own) in [(JointKind::Ball, 3), (JointKind::Hinge, 1)] {
        let most = (MOST - 6) / own + 1;
        assert!(World::new(chain(most, kind, false)).is_ok());
        for ring in [false, true] {
            let mut long = chain(most + 1, kind, ring);
            let told = World::new(long.clone()).unwrap_err().to_string();
            assert!(told.contains("link 0"), "{told}");
            assert!(told.contains(&format!("{} freedoms", 6 + own * most)), "{told}");
            assert!(told.contains("two-step"), "{told}");
            long.solver.kind = SolverKind::TwoStep;
            assert!(World::new(long).is_ok());
        }
    }
}

#[test]
fn what_does_not_hang_together_is_not_summed() {
    assert!(World::new(chain(400, JointKind::Free, false)).is_ok());
    let mut held = chain(500, JointKind::Ball, false);
    held.rigids[250].motion = Motion::Prescribed;
    assert!(World::new(held).is_ok());
}
