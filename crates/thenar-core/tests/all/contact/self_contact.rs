//! Goal: parts of one soft body touch each other. Method: the arms of a soft tuning fork are
//! pressed together; the fork floats freely, so that contact must leave its momentum alone.

use crate::common::{FLESH, bar, boundary};
use std::collections::BTreeMap;
use thenar_core::model::{BodyId, PairRule, SoftDesc, SolverKind, WorldDesc};
use thenar_core::world::Input;
use thenar_core::{Pose, Vec3, World};

const SLIT: f64 = 0.003;

/// A fork along x: two arms of 40×8×10 mm over each other, `SLIT` apart, on a foot of 10 mm.
fn fork(kind: SolverKind, h: f64, touches: bool) -> World {
    let mut flesh = bar(Vec3::new(0.05, 0.019, 0.01), [10, 5, 2], FLESH);
    // Five layers: two of each arm, and the slit, which is narrower.
    let levels = [0.0, 0.004, 0.008, 0.008 + SLIT, 0.012 + SLIT, 0.016 + SLIT];
    for x in &mut flesh.nodes {
        x.y = levels[(x.y / 0.019 * 5.0).round() as usize];
    }
    let slit = |x: Vec3| x.x > 0.01 && x.y > 0.0081 && x.y < 0.0079 + SLIT;
    let center = |t: &[u32; 4]| t.iter().map(|&n| flesh.nodes[n as usize]).sum::<Vec3>() / 4.0;
    let kept: Vec<[u32; 4]> = flesh.tets.iter().copied().filter(|t| !slit(center(t))).collect();
    let mut new: BTreeMap<u32, u32> = kept.iter().flatten().map(|&n| (n, 0)).collect();
    new.values_mut().zip(0..).for_each(|(n, i)| *n = i);
    flesh.nodes = new.keys().map(|&n| flesh.nodes[n as usize]).collect();
    flesh.tets = kept.iter().map(|t| t.map(|n| new[&n])).collect();
    flesh.materials.truncate(flesh.tets.len());
    flesh.collision = boundary(&flesh.tets);
    flesh.stiffness_damping = 5e-3;
    let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
    desc.solver.kind = kind;
    let soft = desc.add_soft(SoftDesc {
        name: "fork".into(),
        flesh,
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    if touches {
        desc.self_contact.push(soft);
    }
    World::new(desc).unwrap()
}

/// Pushes the arms' ends together with `force` \[N\] each.
fn press(world: &World, force: f64) -> Input {
    let mut input = world.input();
    let start = &world.desc().softs[0].flesh.nodes;
    let pushed = |x: &Vec3, top: bool| x.x > 0.0349 && (x.y > 0.01) == top;
    for top in [true, false] {
        let count = start.iter().filter(|x| pushed(x, top)).count() as f64;
        let way = if top { -1.0 } else { 1.0 };
        for (f, x) in input.node_forces.iter_mut().zip(start) {
            if pushed(x, top) {
                f.y = way * force / count;
            }
        }
    }
    input
}

/// Deepest place of one arm in the other \[m\]: over points 1 mm apart on the inner faces, which
/// face each other along y.
fn overlap(world: &World) -> f64 {
    let flesh = &world.desc().softs[0].flesh;
    let x = world.nodes(0);
    let inner = |level: f64| {
        let is = move |n: &u32| (flesh.nodes[*n as usize].y - level).abs() < 1e-9;
        let faces = flesh.collision.triangles.iter().map(|t| {
            t.map(|v| {
                let vertex = flesh.collision.vertices[v as usize];
                let k = vertex.weights.iter().position(|w| *w == 1.0).unwrap();
                flesh.tets[vertex.tet as usize][k]
            })
        });
        let beyond = move |t: &[u32; 3]| t.iter().all(|n| flesh.nodes[*n as usize].x > 0.0099);
        faces.filter(move |t| t.iter().all(is) && beyond(t)).collect::<Vec<_>>()
    };
    let corners = |t: &[u32; 3]| t.map(|n| x[n as usize]);
    let mut deepest = 0.0_f64;
    for low in inner(0.008).iter().map(corners) {
        for (i, j) in (0..=5).flat_map(|i| (0..=5 - i).map(move |j| (i, j))) {
            let (s, t) = (f64::from(i) / 5.0, f64::from(j) / 5.0);
            let p = low[0] + s * (low[1] - low[0]) + t * (low[2] - low[0]);
            for high in inner(0.008 + SLIT).iter().map(corners) {
                let (u, v, w) = (high[1] - high[0], high[2] - high[0], p - high[0]);
                let area = u.x * v.z - u.z * v.x;
                let (a, b) = ((w.x * v.z - w.z * v.x) / area, (u.x * w.z - u.z * w.x) / area);
                if a >= 0.0 && b >= 0.0 && a + b <= 1.0 {
                    deepest = deepest.max(p.y - (high[0] + a * u + b * v).y);
                }
            }
        }
    }
    deepest
}

fn momentum(world: &World) -> [Vec3; 2] {
    let (m, x, v) = (world.node_masses(0), world.nodes(0), world.node_velocities(0));
    let of = |f: &dyn Fn(usize) -> Vec3| (0..m.len()).map(|i| m[i] * f(i)).sum::<Vec3>();
    [of(&|i| v[i]), of(&|i| x[i].cross(&v[i]))]
}

#[test]
fn the_arms_of_a_fork_press_on_each_other() {
    for (kind, h) in [(SolverKind::Monolithic, 1e-3), (SolverKind::Monolithic, 5e-3)] {
        let mut world = fork(kind, h, true);
        let input = press(&world, 0.03);
        let mut deepest = 0.0_f64;
        for _ in 0..(0.1 / h) as usize {
            let report = world.step(&input, &mut ());
            assert!(!report.fell_back && !report.non_finite && report.inverted_tets == 0);
            deepest = deepest.max(overlap(&world));
        }
        assert!(deepest < 3e-4, "h {h}: an arm came {deepest} m into the other");
        let pressing: f64 = world.contacts().iter().map(|c| c.force_W.norm()).sum();
        assert!(pressing > 0.01, "h {h}: they press with {pressing} N only");
        let [p, l] = momentum(&world);
        // To the solver's 1e-5 m/s. The pushes are opposite, but their lines of action part by what
        // the arms shear.
        assert!(p.norm() < 1e-7 && l.norm() < 1e-5, "h {h}: momentum {p} and {l}");

        // Without it they go through each other.
        let mut ghost = fork(kind, h, false);
        for _ in 0..(0.1 / h) as usize {
            ghost.step(&input, &mut ());
        }
        assert!(overlap(&ghost) > 1e-3 && ghost.contacts().is_empty());
    }
}

#[test]
fn a_rule_for_the_pair_of_a_body_with_itself_sets_friction_or_removes_contact() {
    let mut world = fork(SolverKind::Monolithic, 5e-3, true);
    let input = press(&world, 0.03);
    let own = [BodyId::Soft(0); 2];
    let friction = |world: &mut World, friction| {
        let mut desc = world.desc().clone();
        desc.pairs = vec![PairRule { bodies: own, friction }];
        world.retune(desc).unwrap();
    };
    friction(&mut world, Some(0.3));
    for _ in 0..20 {
        world.step(&input, &mut ());
        for c in world.contacts() {
            assert_eq!(c.bodies, own);
            let normal = c.force_W.dot(&c.normal_W);
            let tangential = (c.force_W - c.normal_W * normal).norm();
            assert!(tangential <= 0.3 * normal * (1.0 + 1e-9) + 1e-12, "{c:?}");
        }
    }
    assert!(!world.contacts().is_empty());
    friction(&mut world, None);
    world.step(&input, &mut ());
    assert!(world.contacts().is_empty());
}

/// At rest and in any pose that only moves it, a body does not touch itself.
#[test]
fn neighbors_do_not_touch() {
    let mut world = fork(SolverKind::Monolithic, 5e-3, true);
    let input = world.input();
    for _ in 0..5 {
        let report = world.step(&input, &mut ());
        assert_eq!(report.contacts, 0);
    }
}
