//! Parts of one surface that are no neighbours touch, and only they: forks whose arms are pressed
//! together, laid on each other, or lie side by side from the start, and blocks that slide on
//! slabs. Lengths are in edges; what must touch follows from the way between parts along the
//! surface or through the body.

use super::tests::{Scene, cube, moved};
use super::{Contact, Detector, SeenSides, Shape, Site};
use crate::math::{Pose, Quat, Vec3};
use crate::model::{Binding, Coupling, JointDesc, JointKind, Motion, Skinning, Springs};
use std::collections::BTreeMap;

/// Length of an edge \[m\], of the squares that are halved.
const EDGE: f64 = 5e-3;
/// Between arms that are brought together \[m\].
const GAP: f64 = 2e-4;
/// Length of the arms \[edges\], from the bottom of the slit between them.
const ARM: i32 = 12;

/// The outside of a body of cubes, in edges.
fn outside(is_filled: impl Fn([i32; 3]) -> bool, size: [i32; 3]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut points, mut known, mut triangles) = (Vec::new(), BTreeMap::new(), Vec::new());
    let cells = (-1..=size[0])
        .flat_map(|x| (-1..=size[1]).flat_map(move |y| (-1..=size[2]).map(move |z| [x, y, z])));
    for cell in cells.filter(|cell| is_filled(*cell)) {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut beside = cell;
                beside[axis] += 2 * side - 1;
                if is_filled(beside) {
                    continue;
                }
                let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
                    let mut at = cell;
                    at[axis] += side;
                    at[(axis + 1) % 3] += u;
                    at[(axis + 2) % 3] += v;
                    *known.entry(at).or_insert_with(|| {
                        points.push(Vec3::from_fn(|k, _| f64::from(at[k])));
                        points.len() as u32 - 1
                    })
                });
                let [a, b, c, d] = corners;
                let square = if side == 1 { [a, b, c, d] } else { [a, d, c, b] };
                triangles
                    .extend([[square[0], square[1], square[2]], [square[0], square[2], square[3]]]);
            }
        }
    }
    (points, triangles)
}

/// Two arms of two by two edges along x, z up to 2 and from 3, on a foot below x = 0. The slit
/// between them is `slit` edges wide.
fn fork(slit: f64) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let is_filled = |[x, y, z]: [i32; 3]| {
        let within = (0..ARM + 2).contains(&x) && (0..2).contains(&y) && (0..5).contains(&z);
        within && (x < 2 || z != 2)
    };
    let (mut points, triangles) = outside(is_filled, [ARM + 2, 2, 5]);
    for p in &mut points {
        p.x -= 2.0;
        p.z += if p.z > 2.5 { slit - 1.0 } else { 0.0 };
    }
    (points, triangles)
}

/// The vertices of the fork that touch something of it when it is deformed, by where they were at
/// rest.
fn touching(slit: f64, deformed: impl Fn(&Vec3) -> Vec3) -> Vec<Vec3> {
    let (rest, triangles) = fork(slit);
    let mut scene = Scene::new();
    let soft = scene.soft((rest.iter().map(|p| p * EDGE).collect(), triangles));
    scene.desc.self_contact.push(soft);
    scene.surfaces[0].0 = rest.iter().map(|p| deformed(p) * EDGE).collect();
    let mut found = Vec::new();
    for c in scene.find(1e-3) {
        let (Site::Soft(p), Site::Soft(_)) = (&c.a, &c.b) else { panic!("soft on soft") };
        if p.vertices[0] == p.vertices[1] {
            assert!((c.gap - GAP).abs() < 0.01 * EDGE, "a gap of {} m", c.gap);
            found.push(rest[p.vertices[0] as usize]);
        }
    }
    found
}

/// The lattice points at which `is_wanted` are all among those that touch.
fn all_touch(found: &[Vec3], slit: f64, is_wanted: impl Fn(&Vec3) -> bool) {
    let (rest, _) = fork(slit);
    let wanted: Vec<Vec3> = rest.into_iter().filter(is_wanted).collect();
    assert!(wanted.len() >= 5);
    for p in wanted {
        let touches = found.iter().any(|q| (q - p).norm() < 1e-9);
        assert!(touches, "{:?} touches nothing", p.as_slice());
    }
}

/// The slit is closed by pressing the arms together. Two vertices that face each other at a
/// distance d from its bottom are `2 d + 1` edges from each other along the surface: from d = 2 on
/// that is more than anything that is near, and less than four times as much up to d = 4.
#[test]
fn a_slit_that_closes_touches_down_to_its_bottom() {
    let closed = |p: &Vec3| {
        let by = if p.z > 2.5 && p.x > 1.5 { 1.0 - GAP / EDGE } else { 0.0 };
        p - Vec3::z() * by
    };
    let found = touching(1.0, closed);
    let is_inner = |p: &Vec3| (2.0..=3.0).contains(&p.z);
    all_touch(&found, 1.0, |p| is_inner(p) && p.x > 1.5);
    // Around the foot parts stay as they are.
    assert!(found.iter().all(|p| p.x > 0.5 && is_inner(p)), "{found:?}");
}

/// One arm is laid on the other. At rest its lower side is two edges and more from the upper side
/// of the other, and lies behind that: through the body, and farther than a part is thick that
/// cannot touch itself.
#[test]
fn an_arm_laid_on_the_other_touches_it() {
    let laid = |p: &Vec3| {
        // First up, and then over the other.
        let [up, over] = [1.0, 4.0].map(|from| ((p.x - from) / 3.0).clamp(0.0, 1.0));
        let on = Vec3::new(0.0, up * (2.0 + GAP / EDGE), over * 3.0);
        if p.z < 2.5 { p + on } else { *p }
    };
    let found = touching(1.0, laid);
    let is_on = |p: &Vec3| p.x > 6.5 && p.x < f64::from(ARM) - 0.5;
    // Within the other's rims: there what is nearest is no face.
    all_touch(&found, 1.0, |p| is_on(p) && p.z < 1.5 && p.z > 0.5 && p.y < 0.5);
    all_touch(&found, 1.0, |p| is_on(p) && p.z > 3.5 && p.z < 4.5 && p.y > 1.5);
}

/// Slabs of two bodies in one surface, each the length of four bones. No contact of a block begins
/// on the slab's half whose bone is joined to its own; one that slides there from the other half
/// goes on, as deep as it is, until the two part, in either direction, at steps of a tenth of an
/// edge up to a whole one.
#[test]
fn a_contact_that_slides_on_to_a_joined_bone_s_flesh_goes_on() {
    let (slab, block) = (cube(0.08, 8), cube(0.01, 1));
    for (turn, step) in [(0.0, 0.1), (0.4, 0.3), (2.0, 0.5), (-1.0, 1.0)] {
        let (mut scene, [own, joined, other]) = (Scene::new(), [0, 1, 2]);
        let first = slab.0.len();
        let points = [&slab.0[..], &block.0].concat();
        let shifted = block.1.iter().map(|t| t.map(|v| v + first as u32));
        let mut rest = points.clone();
        moved(&mut rest[first..], Vec3::z() * 0.2);
        scene.soft((rest, slab.1.iter().copied().chain(shifted).collect()));
        scene.desc.self_contact.push(0);
        let bone = |i: usize| match points[i].x < -1e-9 {
            _ if i >= first => own,
            true => other,
            false => joined,
        };
        scene.desc.softs[0].coupling = Some(Coupling {
            bindings: (0..points.len())
                .map(|i| Binding { bones: [bone(i); 2], weights: [1.0, 0.0] })
                .collect(),
            springs: Springs::PerNode(vec![0.0; points.len()]),
            damping_time: 0.0,
            skinning: Skinning::Linear,
        });
        scene.desc.joints.push(joint_between(own, joined));
        for k in 0..3 {
            let far = Pose::translation(10.0 + f64::from(k), 0.0, 0.0);
            scene.rigid(Motion::Prescribed, Shape::Sphere { radius: 0.1 }, far);
        }
        let (mut detector, mut sides) = (Detector::new(&scene.desc), SeenSides::default());
        let turn = Quat::from_axis_angle(&Vec3::y_axis(), turn);
        let mut gaps_at = |x: f64, depth: f64, sides: &mut SeenSides| -> Vec<f64> {
            scene.surfaces[0].0.copy_from_slice(&points);
            for p in &mut scene.surfaces[0].0[first..] {
                *p = turn * *p + Vec3::new(x, 0.045 - depth, 0.003);
            }
            let mut out = Vec::new();
            scene.find_next(&mut detector, sides, 1e-3, &mut out);
            // Vertices of the block alone: its edges cross some of the slab, too.
            let is_corner = |c: &&Contact| {
                matches!(&c.a, Site::Soft(p) if p.vertices[0] == p.vertices[1]
                    && p.vertices[0] as usize >= first)
            };
            out.iter().filter(is_corner).map(|c| c.gap).collect()
        };
        let depth = 1e-4;
        let pressed = |gaps: &[f64], x: f64| {
            assert_eq!(gaps.len(), 4, "turn {turn}, step {step}: {gaps:?} at {x} m");
            assert!(gaps.iter().all(|gap| (gap + depth).abs() < 1e-9), "{gaps:?} at {x} m");
        };
        let mut x = -0.025;
        while x < 0.025 {
            pressed(&gaps_at(x, depth, &mut sides), x);
            x += step * 0.01;
        }
        while x > 0.0 {
            x -= step * 0.01;
            pressed(&gaps_at(x, depth, &mut sides), x);
        }
        // There it parts, and comes back.
        pressed(&gaps_at(0.02, depth, &mut sides), 0.02);
        assert_eq!(gaps_at(0.02, -2e-3, &mut sides), []);
        assert_eq!(gaps_at(0.02, depth, &mut sides), []);
    }
}

fn joint_between(parent: u32, child: u32) -> JointDesc {
    JointDesc {
        name: String::new(),
        kind: JointKind::Ball,
        parent: Some(parent),
        child,
        pose_PJ: Pose::identity(),
        pose_CK: Pose::identity(),
        axes: Default::default(),
        limit_stiffness: 0.0,
        limit_damping: 0.0,
    }
}

/// Arms that lie a tenth of an edge from each other at rest do not overlap: they touch where they
/// come nearer.
#[test]
fn arms_that_lie_side_by_side_touch() {
    let slit = 0.1;
    let nearer = |p: &Vec3| {
        let by = if p.z > 2.05 && p.x > 1.5 { slit - GAP / EDGE } else { 0.0 };
        p - Vec3::z() * by
    };
    let found = touching(slit, nearer);
    all_touch(&found, slit, |p| p.z > 1.5 && p.z < 2.5 && p.x > 3.5);
}

/// A wedge lies across the rim of a slab's flesh that it may touch: beyond it the slab belongs to a
/// bone that is joined to the wedge's.
struct OnRim {
    /// Slope of the slab beyond the rim.
    fold: f64,
    /// Bones of the wedge, of the slab beyond the rim, and before it.
    bones: [u32; 3],
    /// The slab's triangles come in reverse order.
    reversed: bool,
    /// Corner that each triangle begins with.
    first_corner: usize,
}

/// Place right of which the slab's squares have corners of the joined bone \[m\].
const RIM: f64 = -0.01;
/// By so much the wedge's edge lies below the rim \[m\], and so steeply it goes down to the right.
const BELOW: f64 = 1e-4;
const DOWN: f64 = 0.1;

impl OnRim {
    /// The contacts that press.
    fn pressed(&self) -> Vec<Contact> {
        let [own, joined, other] = self.bones;
        let (slab, block) = (cube(0.08, 8), cube(0.01, 1));
        let of_slab = slab.0.iter().map(|p| (*p, if p.x < -1e-9 { other } else { joined }));
        let points: Vec<(Vec3, u32)> = of_slab.chain(block.0.iter().map(|p| (*p, own))).collect();
        let mut triangles = slab.1;
        if self.reversed {
            triangles.reverse();
        }
        triangles.extend(block.1.iter().map(|t| t.map(|v| v + slab.0.len() as u32)));
        triangles.iter_mut().for_each(|t| t.rotate_left(self.first_corner));
        let apart =
            points.iter().map(|(p, bone)| if *bone == own { p + Vec3::z() * 0.2 } else { *p });
        let mut scene = Scene::new();
        scene.soft((apart.collect(), triangles));
        scene.desc.self_contact.push(0);
        let bound = |(_, bone): &(Vec3, u32)| Binding { bones: [*bone; 2], weights: [1.0, 0.0] };
        scene.desc.softs[0].coupling = Some(Coupling {
            bindings: points.iter().map(bound).collect(),
            springs: Springs::PerNode(vec![0.0; points.len()]),
            damping_time: 0.0,
            skinning: Skinning::Linear,
        });
        scene.desc.joints.push(joint_between(own, joined));
        for k in 0..3 {
            let far = Pose::translation(10.0 + f64::from(k), 0.0, 0.0);
            scene.rigid(Motion::Prescribed, Shape::Sphere { radius: 0.1 }, far);
        }
        let tilt = Quat::from_axis_angle(&Vec3::z_axis(), -DOWN.atan());
        let on_edge = Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_4);
        let lowest = -0.005 * 2.0_f64.sqrt();
        for (x, (p, bone)) in scene.surfaces[0].0.iter_mut().zip(&points) {
            *x = if *bone == own {
                let along = Vec3::x() * 4.0 * p.x;
                let round = on_edge * Vec3::new(0.0, p.y, p.z) - Vec3::y() * lowest;
                tilt * (along + round) + Vec3::new(RIM, 0.04 - BELOW, 0.003)
            } else {
                p + Vec3::y() * self.fold * (p.x - RIM).max(0.0)
            };
        }
        scene.find(1e-3).into_iter().filter(|c| c.gap < 0.0).collect()
    }
}

/// The wedge's edge is held where it crosses the rim, however the flesh beyond is folded, whichever
/// of the triangles come first, and of whichever corner they are named by.
#[test]
fn a_rim_holds_an_edge_however_the_flesh_beyond_is_folded() {
    for fold in [-0.5, -0.2, 0.0, 0.05, 0.2, 0.5, 1.0] {
        for bones in [[0, 1, 2], [2, 1, 0], [1, 0, 2], [1, 2, 0]] {
            for (reversed, first_corner) in [(false, 0), (true, 0), (false, 1), (true, 2)] {
                let case = format!("fold {fold}, {bones:?}, {reversed}, {first_corner}");
                let pressed = OnRim { fold, bones, reversed, first_corner }.pressed();
                let [contact] = &pressed[..] else { panic!("{case}: {pressed:?}") };
                // Square to both edges, along which the wedge goes down and the rim is level.
                let expected = BELOW / (1.0 + DOWN * DOWN).sqrt();
                assert!((contact.gap + expected).abs() < 1e-9, "{case}: {} m", contact.gap);
                let place = contact.position_W;
                assert!((place.x - RIM).abs() < 1e-4, "{case}: {}", place.x);
            }
        }
    }
}
