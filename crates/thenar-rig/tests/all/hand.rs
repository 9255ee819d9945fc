//! Goal: the shipped hands become models that a simulator can trust. Method: known figures of the
//! mesh, conservation laws, and properties that skinning and topology must have.

use std::collections::BTreeSet;
use std::sync::OnceLock;
use thenar_core::kinematics::Tree;
use thenar_core::model::{Digit, HandModel, JointKind, Side};
use thenar_core::random::Random;
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat, Vec3};
use thenar_rig::hand::{
    HandOptions, HandReport, Size, asset, build_hand, build_hand_with_report, default_hand,
    uniform_hand,
};
use thenar_rig::lattice::tet;

const COUNTS: [usize; 4] = [600, 2000, 5000, 17_000];

/// Both hands at all counts, built once.
fn all() -> &'static [(HandModel, HandReport)] {
    static ALL: OnceLock<Vec<(HandModel, HandReport)>> = OnceLock::new();
    ALL.get_or_init(|| {
        let sides = [Side::Right, Side::Left];
        let cases = sides.iter().flat_map(|&side| COUNTS.map(|tets| (side, tets)));
        cases
            .map(|(side, tets)| {
                let options = HandOptions { side: Some(side), tets, ..HandOptions::paper() };
                build_hand_with_report(asset(side), &options).unwrap()
            })
            .collect()
    })
}

fn right() -> &'static HandModel {
    &all()[0].0
}

fn corners(hand: &HandModel, t: usize) -> [Vec3; 4] {
    hand.flesh.tets[t].map(|n| hand.flesh.nodes[n as usize])
}

/// Numbers from -1 to 1.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut random = Random::new(seed);
    move || random.symmetric()
}

#[test]
fn the_skin_is_the_known_mesh() {
    for (_, report) in all() {
        let skin = &report.skin;
        assert_eq!((skin.vertices, skin.triangles, skin.components), (1159, 2314, 1));
        assert!(skin.closed() && skin.manifold() && skin.oriented());
        // 343.2 ml, and a hand of 190 mm without the wrist stub.
        assert!((report.skin_volume - 343.2e-6).abs() < 0.3e-6, "{}", report.skin_volume);
        assert!((report.length - 0.190).abs() < 0.003, "{}", report.length);
        // A smooth body through the vertices of a convex-ish polyhedron holds a little more.
        assert!((1.0..1.05).contains(&(report.volume / report.skin_volume)));
    }
}

#[test]
fn counts_are_met() {
    for (i, (hand, report)) in all().iter().enumerate() {
        let wanted = COUNTS[i % 4] as f64;
        assert!((hand.flesh.tets.len() as f64 / wanted - 1.0).abs() < 0.15, "{}", report.tets);
        assert!((1300..=1441).contains(&report.collision_triangles));
        assert!(report.render_triangles >= 23_600);
    }
}

#[test]
fn sixteen_bones_hang_on_fifteen_joints() {
    for (hand, _) in all() {
        assert_eq!((hand.bones.len(), hand.joints.len()), (16, 15));
        let universal = hand.joints.iter().filter(|j| j.kind == JointKind::Universal).count();
        let hinge = hand.joints.iter().filter(|j| j.kind == JointKind::Hinge).count();
        assert_eq!((universal, hinge), (5, 10));
        for (i, joint) in hand.joints.iter().enumerate() {
            assert_eq!(joint.child as usize, i + 1);
            assert_eq!(joint.parent, hand.bones[i + 1].parent);
        }
        for name in ["palm", "thumb-metacarpal", "index-proximal", "little-distal"] {
            assert!(hand.bones.iter().any(|b| b.name == name), "{name}");
        }
    }
}

#[test]
fn the_rest_pose_is_where_the_springs_rest() {
    for (hand, _) in all() {
        let tree = Tree::of_hand(hand).unwrap();
        let rest: Vec<Pose> = hand.bones.iter().map(|b| b.pose_MB).collect();
        let mut angles = vec![[0.0; 2]; hand.joints.len()];
        tree.angles(&rest, &mut angles);
        for (joint, q) in hand.joints.iter().zip(&angles) {
            for (axis, q) in joint.axes.iter().zip(q).take(joint.kind.angles()) {
                assert!((axis.rest_angle - q).abs() < 1e-9, "{}", joint.name);
                let limit = axis.limit.unwrap();
                assert!(limit.min < *q && *q < limit.max, "{}", joint.name);
            }
        }
        // The joints hold exactly at these angles.
        let mut back = rest.clone();
        tree.forward(&rest[0], &angles, &mut back);
        for (a, b) in back.iter().zip(&rest) {
            assert!((a.position - b.position).norm() < 1e-12);
            assert!(a.rotation.angle_to(&b.rotation) < 1e-9);
        }
    }
}

/// The pose of all bones when one joint's angle is `more` than at rest.
fn bent(hand: &HandModel, joint: &str, axis: usize, more: f64) -> Vec<Pose> {
    let tree = Tree::of_hand(hand).unwrap();
    let rest: Vec<Pose> = hand.bones.iter().map(|b| b.pose_MB).collect();
    let mut angles = vec![[0.0; 2]; hand.joints.len()];
    tree.angles(&rest, &mut angles);
    let j = hand.joints.iter().position(|j| j.name == joint).unwrap();
    angles[j][axis] += more;
    let mut out = rest.clone();
    tree.forward(&rest[0], &angles, &mut out);
    out
}

#[test]
fn positive_flexion_closes_and_positive_abduction_is_radial_on_both_hands() {
    for (hand, _) in all() {
        let thumbward = if hand.side == Some(Side::Right) { -1.0 } else { 1.0 };
        for digit in Digit::FINGERS.iter().skip(1) {
            let tip = hand.bones.iter().position(|b| b.name == format!("{}-distal", digit.name()));
            let bone = &hand.bones[tip.unwrap()];
            let place = |poses: &[Pose]| poses[tip.unwrap()].point(&bone.ends_B[1]);
            let rest: Vec<Pose> = hand.bones.iter().map(|b| b.pose_MB).collect();
            for joint in ["mcp", "pip", "dip"] {
                let axis = usize::from(joint == "mcp");
                let poses = bent(hand, &format!("{}-{joint}", digit.name()), axis, 0.3);
                // The palm faces -y in the wrist's frame.
                let moved = place(&poses) - place(&rest);
                assert!(moved.y < -0.7 * moved.norm(), "{} {joint} {moved:?}", digit.name());
            }
            let poses = bent(hand, &format!("{}-mcp", digit.name()), 0, 0.3);
            let moved = place(&poses) - place(&rest);
            assert!(moved.x * thumbward > 0.7 * moved.norm(), "{} {moved:?}", digit.name());
        }
    }
}

#[test]
fn bones_are_as_long_as_anatomy_says_but_for_one() {
    // G1: ±2 standard deviations of one uniform scale. The rig's thumb joint lies 12 mm distal of
    // the anatomical one, so its metacarpal is too short; no scale mends that.
    for (_, report) in all() {
        assert!((report.anatomy_scale - 1.0).abs() < 0.1);
        for bone in &report.bone_lengths {
            let misses = bone.deviation_sd.abs() > 2.0;
            assert_eq!(misses, bone.bone == "thumb-metacarpal", "{bone:?}");
        }
    }
}

#[test]
fn bones_weigh_what_bones_weigh() {
    for (hand, report) in all() {
        for bone in &hand.bones {
            // Between the moments of a thin rod and of a thick cylinder of that length.
            let length = (bone.ends_B[1] - bone.ends_B[0]).norm();
            let moments = bone.inertia.symmetric_eigenvalues();
            assert!(moments.max() < bone.mass * length * length / 8.0, "{}", bone.name);
            assert!(moments.min() > 0.2 * bone.mass * bone.radius * bone.radius, "{}", bone.name);
            assert!(moments.max() < moments.sum() - moments.max() + 1e-15, "{}", bone.name);
        }
        // A fresh adult hand's skeleton: 60 to 110 g.
        assert!((0.060..0.110).contains(&report.bone_mass), "{}", report.bone_mass);
    }
}

#[test]
fn mass_and_volume_are_the_body_s() {
    for (hand, report) in all() {
        let whole = report.flesh_mass + report.bone_mass;
        assert!((whole / (1080.0 * report.volume) - 1.0).abs() < 1e-9);
        // G2: 0.0060-0.0061 of a body of 60-75 kg.
        assert!((0.34..0.46).contains(&whole), "{whole}");
        let nodes: f64 = hand.node_volumes.iter().sum();
        assert!((nodes / report.volume - 1.0).abs() < 1e-12);
    }
}

#[test]
fn elements_are_well_shaped() {
    for (hand, report) in all() {
        assert!(report.quality.dihedral_min.to_degrees() > 15.0, "{:?}", report.quality);
        assert!(report.quality.dihedral_max.to_degrees() < 155.0, "{:?}", report.quality);
        assert!(report.quality.edge_ratio_max < 3.0, "{:?}", report.quality);
        assert!((0..hand.flesh.tets.len()).all(|t| tet::volume(&corners(hand, t)) > 0.0));
    }
}

#[test]
fn surfaces_lie_in_or_beside_their_elements() {
    for (hand, report) in all() {
        assert!(report.barycentric_min > -0.3, "{}", report.barycentric_min);
        for surface in [&hand.flesh.collision, &hand.render] {
            for vertex in &surface.vertices {
                assert!((vertex.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn embedded_surfaces_enclose_the_body() {
    for (hand, report) in all() {
        for surface in [&hand.flesh.collision, &hand.render] {
            let mut positions = vec![Vec3::zeros(); surface.vertices.len()];
            surface.positions(&hand.flesh.tets, &hand.flesh.nodes, &mut positions);
            let mesh = thenar_rig::TriMesh::new(positions, surface.triangles.clone()).unwrap();
            assert!((mesh.volume() / report.volume - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn weights_are_convex_and_bind_at_most_two_adjacent_bones() {
    for (hand, _) in all() {
        for binding in &hand.bindings {
            let [a, b] = binding.bones.map(|b| b as usize);
            assert!(binding.weights.iter().all(|&w| w >= 0.0));
            assert!((binding.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let adjacent = a == b
                || hand.bones[a].parent == Some(b as u32)
                || hand.bones[b].parent == Some(a as u32);
            assert!(adjacent, "{} and {}", hand.bones[a].name, hand.bones[b].name);
        }
    }
}

#[test]
fn a_rigid_motion_of_all_bones_moves_every_target_by_it() {
    let hand = right();
    let mut next = noise(7);
    for _ in 0..100 {
        let axis = Vec3::new(next(), next(), next()) * 3.0;
        let motion = Pose::new(Vec3::new(next(), next(), next()), Quat::from_scaled_axis(axis));
        for (x, binding) in hand.flesh.nodes.iter().zip(&hand.bindings) {
            let target: Vec3 = (0..2)
                .map(|k| {
                    let rest = &hand.bones[binding.bones[k] as usize].pose_MB;
                    (motion * *rest).point(&rest.inverse_point(x)) * binding.weights[k]
                })
                .sum();
            assert!((target - motion.point(x)).norm() < 1e-12);
        }
    }
}

/// The finger whose moving bones alone carry every node of an element.
fn finger_of(hand: &HandModel, t: usize) -> Option<Digit> {
    let bones = hand.flesh.tets[t].iter().flat_map(|&n| {
        let binding = &hand.bindings[n as usize];
        (0..2).filter(|&k| binding.weights[k] > 0.0).map(|k| binding.bones[k])
    });
    let digits: BTreeSet<Digit> = bones.map(|b| hand.bones[b as usize].digit).collect();
    (digits.len() == 1).then(|| digits.first().copied()).flatten().filter(|&d| d != Digit::Palm)
}

#[test]
fn fingers_are_not_glued() {
    for (hand, _) in all() {
        // Beyond the knuckles, no two elements of different fingers share a node that stands
        // clear of the web: every node shared by two fingers belongs to an element of the palm.
        let mut fingers = vec![BTreeSet::new(); hand.flesh.nodes.len()];
        let mut palm = vec![false; hand.flesh.nodes.len()];
        for (t, nodes) in hand.flesh.tets.iter().enumerate() {
            match finger_of(hand, t) {
                Some(digit) => nodes.iter().for_each(|&n| {
                    fingers[n as usize].insert(digit);
                }),
                None => nodes.iter().for_each(|&n| palm[n as usize] = true),
            }
        }
        for n in 0..palm.len() {
            assert!(fingers[n].len() < 2 || palm[n], "node {n} glues {:?}", fingers[n]);
        }
    }
}

#[test]
fn no_element_ties_two_fingertips_together() {
    // Coarse elements of the web may reach the middle of two fingers, never their ends.
    for (hand, _) in all() {
        for (t, nodes) in hand.flesh.tets.iter().enumerate() {
            let digits: BTreeSet<Digit> = nodes
                .iter()
                .map(|&n| &hand.bindings[n as usize])
                .flat_map(|b| (0..2).filter(|&k| b.weights[k] > 0.0).map(|k| b.bones[k]))
                .filter(|&b| hand.bones[b as usize].name.ends_with("-distal"))
                .map(|b| hand.bones[b as usize].digit)
                .collect();
            assert!(digits.len() < 2, "element {t} ties {digits:?} together");
        }
    }
}

#[test]
fn a_uniform_scale_scales_everything() {
    let length = 0.17;
    let options = HandOptions { size: Size::Length(length), ..HandOptions::paper() };
    let (small, report) = build_hand_with_report(asset(Side::Right), &options).unwrap();
    let (full, full_report) = &all()[0];
    let s = length / full.length;
    assert!((small.length - length).abs() < 1e-9);
    assert!((report.volume / full_report.volume - s.powi(3)).abs() < 1e-6);
    assert!((report.bone_mass / full_report.bone_mass - s.powi(3)).abs() < 1e-6);
    for (a, b) in small.bones.iter().zip(&full.bones) {
        assert!((a.pose_MB.position - b.pose_MB.position * s).norm() < 1e-6);
    }
    for (a, b) in small.joints.iter().zip(&full.joints) {
        // Moments of weight go as length to the fourth, but torques of stress as its cube.
        assert!((a.axes[0].stiffness / b.axes[0].stiffness - s.powi(3)).abs() < 1e-6);
    }
}

#[test]
fn building_twice_gives_the_same_bits() {
    let builds: [fn() -> HandModel; 2] =
        [|| uniform_hand(Side::Left, 600).unwrap(), || default_hand(Side::Left).unwrap()];
    for build in builds {
        let (a, b) = (build(), build());
        assert_eq!(a.flesh.nodes, b.flesh.nodes);
        assert_eq!(a.bindings, b.bindings);
        assert_eq!(a.render, b.render);
    }
}

#[test]
fn a_fist_turns_few_elements_inside_out() {
    for (_, report) in all() {
        assert!(report.fist.volume_fraction < 0.004, "{:?}", report.fist);
    }
}

#[test]
fn bad_options_are_named() {
    let right = asset(Side::Right);
    let fails = |options: HandOptions, named: &str| {
        let error = build_hand(right, &options).unwrap_err().to_string();
        assert!(error.contains(named), "{error}");
    };
    let base = HandOptions::paper;
    fails(HandOptions { side: Some(Side::Left), ..base() }, "right hand");
    fails(HandOptions { size: Size::Scale(0.0), ..base() }, "hand scale");
    fails(HandOptions { size: Size::Scale(f64::NAN), ..base() }, "hand scale");
    fails(HandOptions { size: Size::Length(3.0), ..base() }, "hand length");
    fails(HandOptions { tets: 3, ..base() }, "tetrahedra");
    fails(HandOptions { detail: Some(9.0), ..base() }, "detail");
    let renamed = [("wrist".to_string(), "root".to_string())].into();
    fails(HandOptions { name_map: renamed, ..base() }, "\"root\"");
    let mut soft = base();
    soft.material.poisson = 0.5;
    fails(soft, "Poisson");
}

/// The right hand's file with one text of its JSON replaced by another of the same length.
fn altered(from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let mut bytes = asset(Side::Right).to_vec();
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
    bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
    bytes
}

#[test]
fn other_names_are_mapped() {
    let bytes = altered("\"name\":\"wrist\"", "\"name\":\"carpi\"");
    let error = build_hand(&bytes, &HandOptions::paper()).unwrap_err().to_string();
    assert!(error.contains("`wrist`"), "{error}");
    let name_map = [("wrist".to_string(), "carpi".to_string())].into();
    let options = HandOptions { name_map, ..HandOptions::paper() };
    let hand = build_hand(&bytes, &options).unwrap();
    assert_eq!(hand.flesh.nodes, right().flesh.nodes);
    // The tracked joints keep their WebXR names: that is what trackers send.
    assert_eq!(hand.bones[0].tracked_joint.as_deref(), Some("wrist"));
}

#[test]
fn a_damaged_rig_gives_an_error_or_a_sound_hand() {
    let options = HandOptions { tets: 60, render_triangles: 200, ..HandOptions::paper() };
    let mut next = noise(11);
    let mut built = 0;
    for _ in 0..60 {
        let mut bytes = asset(Side::Right).to_vec();
        // The last 1600 bytes are the joints' rest poses, before them are indices and weights.
        for _ in 0..2 {
            let back = ((next() + 1.0) * if next() < 0.0 { 800.0 } else { 40_000.0 }) as usize;
            let at = bytes.len() - 1 - back.min(80_000);
            bytes[at] ^= 1 << (((next() + 1.0) * 4.0) as u32).min(7);
        }
        if let Ok(hand) = build_hand(&bytes, &options) {
            built += 1;
            assert!(thenar_rig::Model::Hand(hand).to_bytes().is_ok());
        }
    }
    assert!(built > 0, "not one survived: the damage is too great to test anything");
}

/// Diameter of a capsule, least edge of a box \[m\]; capsules side by side are as thick as one.
fn thickness(solid: &Shape) -> f64 {
    match solid {
        Shape::Compound(parts) => thickness(&parts[0].shape),
        Shape::Capsule { radius, .. } => 2.0 * radius,
        Shape::Cuboid { half } => 2.0 * half.min(),
        other => panic!("{other:?}"),
    }
}

/// Distance of a point in the frame of capsules or a box from it \[m\]; none inside.
fn distance(solid: &Shape, p: &Vec3) -> f64 {
    match solid {
        Shape::Compound(parts) => {
            let each =
                parts.iter().map(|part| distance(&part.shape, &part.pose_SP.inverse_point(p)));
            each.fold(f64::INFINITY, f64::min)
        }
        Shape::Capsule { radius, half_length } => {
            (p - Vec3::y() * p.y.clamp(-half_length, *half_length)).norm() - radius
        }
        Shape::Cuboid { half } => p.abs().zip_map(half, |x, h| (x - h).max(0.0)).norm(),
        other => panic!("{other:?}"),
    }
}

/// The palm's box and the capsules of the fingers, measured by the skin of the built model rather
/// than by the mesh that they were made from.
#[test]
fn flesh_covers_every_bone() {
    for (hand, report) in all() {
        assert_eq!(hand.solids.len(), hand.bones.len());
        let of_tet = |t: u32| hand.flesh.tets[t as usize].map(|n| hand.flesh.nodes[n as usize]);
        let vertices = hand.flesh.collision.vertices.iter();
        let skin: Vec<Vec3> = vertices
            .map(|v| of_tet(v.tet).iter().zip(v.weights).map(|(x, w)| x * w).sum())
            .collect();
        for ((bone, solid), cover) in hand.bones.iter().zip(&hand.solids).zip(&report.bone_covers) {
            let pose_MS = bone.pose_MB * solid.pose_BS;
            let distances = skin.iter().map(|p| distance(&solid.shape, &pose_MS.inverse_point(p)));
            let least = distances.fold(f64::INFINITY, f64::min);
            assert_eq!(cover.thickness, thickness(&solid.shape));
            assert!(cover.flesh >= 0.5 * cover.thickness - 1e-12, "{cover:?}");
            // Surface points lie farther than the faces between them, and decimation moves faces.
            assert!(least > 0.9 * cover.flesh && least < cover.flesh + 3e-3, "{cover:?}: {least}");
            // Of the phalanges of a hand of 190 mm none is thinner than 3 mm or thicker than 11 mm.
            assert!((3e-3..11e-3).contains(&cover.thickness), "{cover:?}");
        }
    }
}
