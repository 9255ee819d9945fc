//! Goal: a hand of graded mesh is fine where it touches and coarse elsewhere, in hands of all
//! sizes, and its skin is no coarser than its flesh. Method: edges of elements and triangles are
//! measured where the rig says that pads and palm are; shapes have the angles that geometry gives
//! them.

use std::sync::OnceLock;
use thenar_core::Vec3;
use thenar_core::model::{Digit, HandModel, Side};
use thenar_rig::HandReport;
use thenar_rig::hand::{HandOptions, Size, asset, build_hand, build_hand_with_report, graded_tets};

fn build(side: Side, detail: f64, length: f64) -> (HandModel, HandReport) {
    let detail = Some(detail);
    let options = HandOptions { detail, size: Size::Length(length), ..HandOptions::paper() };
    build_hand_with_report(asset(side), &options).unwrap()
}

/// The right hand of 190 mm at detail 1.
fn usual() -> &'static (HandModel, HandReport) {
    static USUAL: OnceLock<(HandModel, HandReport)> = OnceLock::new();
    USUAL.get_or_init(|| build(Side::Right, 1.0, 0.19))
}

/// Mean edge of a tetrahedron \[m\].
fn edge(hand: &HandModel, tet: usize) -> f64 {
    let x = hand.flesh.tets[tet].map(|n| hand.flesh.nodes[n as usize]);
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    pairs.iter().map(|&(a, b)| (x[a] - x[b]).norm()).sum::<f64>() / 6.0
}

fn place(hand: &HandModel, vertex: usize) -> Vec3 {
    let v = &hand.flesh.collision.vertices[vertex];
    let nodes = hand.flesh.tets[v.tet as usize].iter().zip(v.weights);
    nodes.map(|(n, w)| hand.flesh.nodes[*n as usize] * w).sum()
}

/// Whether a place lies at the pad of the index: on the palm's side of the last third of its last
/// bone.
fn at_pad(hand: &HandModel, x: &Vec3) -> bool {
    let bone = hand.bones.iter().find(|b| b.name == "index-distal").unwrap();
    let [a, b] = bone.ends_B;
    let p = bone.pose_MB.inverse_point(x);
    let along = (p - a).dot(&(b - a)) / (b - a).norm_squared();
    (0.6..1.0).contains(&along) && p.y < a.y && (p - b).norm() < 0.1 * hand.length
}

/// Collision triangles with their mean edge, and the mean edge of the elements under them \[m\].
fn triangles<'a>(
    hand: &'a HandModel,
    wanted: impl Fn(&Vec3, Digit) -> bool + 'a,
) -> impl Iterator<Item = [f64; 2]> + 'a {
    hand.flesh.collision.triangles.iter().filter_map(move |t| {
        let x = t.map(|v| place(hand, v as usize));
        let under = t.map(|v| edge(hand, hand.flesh.collision.vertices[v as usize].tet as usize));
        let middle = (x[0] + x[1] + x[2]) / 3.0;
        let sides = (0..3).map(|k| (x[k] - x[(k + 1) % 3]).norm()).sum::<f64>() / 3.0;
        wanted(&middle, hand.collision_digits[t[0] as usize])
            .then_some([sides, under.iter().sum::<f64>() / 3.0])
    })
}

fn mean(of: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    let all: Vec<[f64; 2]> = of.collect();
    assert!(all.len() > 20, "{} triangles", all.len());
    [0, 1].map(|k| all.iter().map(|x| x[k]).sum::<f64>() / all.len() as f64)
}

/// A body-centred cubic tetrahedron's mean edge is 0.911 of its cube's; transitions are mixed in.
#[test]
fn pads_are_fine_and_palms_are_coarse() {
    let (hand, _) = usual();
    let cube = 0.19 / 48.0;
    let [skin, flesh] = mean(triangles(hand, |x, _| at_pad(hand, x)));
    assert!((0.8 * cube..1.2 * cube).contains(&flesh) && skin < flesh, "{skin} m on {flesh} m");
    let [skin, flesh] = mean(triangles(hand, |_, digit| digit == Digit::Palm));
    assert!((2.0 * cube..4.0 * cube).contains(&flesh) && skin < flesh, "{skin} m on {flesh} m");
}

/// Not on the average alone: on elements of each size.
#[test]
fn skin_is_at_least_as_fine_as_the_flesh_under_it() {
    for (side, detail) in [(Side::Right, 1.0), (Side::Left, 0.5)] {
        let hand = build(side, detail, 0.19).0;
        let finest = 0.19 / 48.0 / detail;
        for size in [1.0, 2.0, 4.0] {
            let all = triangles(&hand, |_, _| true);
            let on_size =
                all.filter(|[_, flesh]| (flesh / (0.911 * finest) / size).log2().abs() < 0.4);
            let [skin, flesh] = mean(on_size);
            assert!(skin <= flesh, "{side:?}, {detail}: {skin} m on {flesh} m");
        }
    }
}

#[test]
fn shapes_keep_their_angles_and_the_body_its_volume() {
    let (hand, report) = usual();
    let [low, high] = [report.quality.dihedral_min, report.quality.dihedral_max];
    assert!(low > 44.999_f64.to_radians() && high < 120.001_f64.to_radians(), "{low} {high} rad");
    assert!((hand.node_volumes.iter().sum::<f64>() / report.volume - 1.0).abs() < 1e-9);
    assert!((1.0..1.05).contains(&(report.volume / report.skin_volume)));
    let wanted = graded_tets(1.0) as f64;
    assert!((report.tets as f64 / wanted - 1.0).abs() < 0.15, "{} of {wanted}", report.tets);
}

#[test]
fn the_same_hand_is_built_again_and_in_every_size() {
    let (hand, report) = usual();
    let again = build(Side::Right, 1.0, 0.19).0;
    assert!(again.flesh.nodes == hand.flesh.nodes && again.flesh.tets == hand.flesh.tets);
    assert!(again.flesh.collision == hand.flesh.collision);
    for length in [0.06, 0.45] {
        let (_, other) = build(Side::Right, 1.0, length);
        let ratio = other.tets as f64 / report.tets as f64;
        assert!((ratio - 1.0).abs() < 0.02, "{length} m: {} tetrahedra", other.tets);
        for cover in other.bone_covers {
            assert!(cover.bound > 0.8 * cover.volume, "{length} m: {cover:?}");
        }
    }
}

/// The pads of two fingers side by side hang together through the palm alone.
#[test]
fn no_two_fingers_share_a_node_at_their_ends() {
    let (hand, _) = usual();
    let mut owner: Vec<Option<Digit>> = vec![None; hand.flesh.nodes.len()];
    for bone in hand.bones.iter().filter(|b| b.name.ends_with("-distal")) {
        let tip = bone.pose_MB.point(&bone.ends_B[1]);
        for (v, digit) in hand.collision_digits.iter().enumerate() {
            if *digit != bone.digit || (place(hand, v) - tip).norm() > 0.06 * hand.length {
                continue;
            }
            for &n in &hand.flesh.tets[hand.flesh.collision.vertices[v].tet as usize] {
                let owner = owner[n as usize].get_or_insert(bone.digit);
                assert_eq!(*owner, bone.digit, "node {n}");
            }
        }
    }
    assert!(owner.iter().flatten().count() > 200);
}

#[test]
fn the_least_and_the_largest_detail_can_be_built() {
    for (side, detail) in [(Side::Left, 0.25), (Side::Left, 1.5)] {
        let (_, report) = build(side, detail, 0.19);
        assert!(report.tets > 300 && report.tets < graded_tets(1.6) as usize, "{}", report.tets);
    }
}

#[test]
fn a_detail_out_of_range_is_refused_by_name() {
    for detail in [0.0, 0.2, 1.6, -1.0, f64::NAN] {
        let options = HandOptions { detail: Some(detail), ..HandOptions::paper() };
        let error = build_hand(asset(Side::Right), &options).unwrap_err().to_string();
        assert!(error.contains("detail") && error.contains("0.25"), "{error}");
    }
}
