//! Goal: a conforming mesh of well-shaped tetrahedra over a tree of four sizes. Method: places all
//! over it find all tetrahedra; what volumes, faces and angles must be is known from geometry.

use super::*;
use crate::lattice::tet;
use std::collections::BTreeMap;

/// Cubes of 1 m over 3 m, halved three times around one place and twice around another.
fn graded() -> Graded {
    let mut tree = Octree::new([Vec3::zeros(), Vec3::repeat(3.0)], 1.0, 3).unwrap();
    tree.refine(&Vec3::new(1.3, 1.1, 0.7), 1.0 / 8.0);
    tree.refine(&Vec3::new(2.4, 1.9, 2.2), 1.0 / 4.0);
    tree.balance();
    Graded { tree }
}

/// Tetrahedra found at points spread over the box (a Kronecker sequence of irrational steps).
fn found(graded: &Graded, points: usize) -> BTreeMap<TetKey, Vec<Vec3>> {
    let mut tets: BTreeMap<TetKey, Vec<Vec3>> = BTreeMap::new();
    let steps = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2];
    for i in 0..points {
        let p = Vec3::from(steps.map(|s| (s * i as f64).fract() * 3.0));
        tets.entry(graded.locate(&p)).or_default().push(p);
    }
    tets
}

fn places(graded: &Graded, key: TetKey) -> tet::Corners {
    graded.corners(key).map(|p| graded.place(p))
}

#[test]
fn every_point_lies_in_the_tetrahedron_found_for_it() {
    let graded = graded();
    for (key, points) in found(&graded, 50_000) {
        let corners = places(&graded, key);
        for p in points {
            let weights = tet::barycentric(&corners, &p);
            assert!(weights.iter().all(|&w| w > -1e-12), "{p:?}: {weights:?}");
        }
    }
}

#[test]
fn all_four_kinds_are_there_with_their_volumes_and_angles() {
    let graded = graded();
    let mut seen = [[f64::INFINITY, f64::NEG_INFINITY]; 4];
    for key in found(&graded, 50_000).into_keys() {
        let corners = places(&graded, key);
        assert!((tet::volume(&corners) / graded.volume(key) - 1.0).abs() < 1e-12);
        let [low, high] = tet::dihedral_range(&corners).map(f64::to_degrees);
        let kind = KINDS.iter().position(|k| *k == Parts::of(key).kind).unwrap();
        seen[kind] = [seen[kind][0].min(low), seen[kind][1].max(high)];
    }
    // Exact for these shapes.
    let expected = [[60.0, 90.0], [45.0, 90.0], [45.0, 90.0], [45.0, 120.0]];
    for (seen, expected) in seen.iter().zip(expected) {
        assert!((seen[0] - expected[0]).abs() < 1e-9, "{seen:?} {expected:?}");
        assert!((seen[1] - expected[1]).abs() < 1e-9, "{seen:?} {expected:?}");
    }
}

/// All tetrahedra together fill space without overlap or hanging node: a face within the box is
/// that of exactly two, and theirs is its volume.
#[test]
fn the_mesh_conforms() {
    let graded = graded();
    let tets: Vec<TetKey> = found(&graded, 400_000).into_keys().collect();
    let mut faces: BTreeMap<[Point; 3], usize> = BTreeMap::new();
    for corners in tets.iter().map(|&key| graded.corners(key)) {
        for k in 0..4 {
            let mut face = [corners[(k + 1) % 4], corners[(k + 2) % 4], corners[(k + 3) % 4]];
            face.sort_unstable();
            *faces.entry(face).or_insert(0) += 1;
        }
    }
    // Tetrahedra at the border of the box reach beyond it; those within are all found.
    let border = |p: &Point| {
        let x = graded.place(*p);
        x.min() <= 1e-9 || x.max() >= 3.0 - 1e-9
    };
    let within = faces.iter().filter(|(face, _)| !face.iter().any(border));
    let counts: Vec<usize> = within.map(|(_, n)| *n).collect();
    assert!(counts.len() > 2000 && counts.iter().all(|n| *n == 2), "{}", counts.len());
}

/// With one size alone it is the body-centred cubic lattice.
#[test]
fn a_tree_that_is_not_split_is_the_uniform_lattice() {
    let tree = Octree::new([Vec3::zeros(), Vec3::repeat(3.0)], 1.0, 0).unwrap();
    let graded = Graded { tree };
    for (key, points) in found(&graded, 2000) {
        let mut own = places(&graded, key);
        let shift = Vec3::repeat(1.0);
        let mut expected =
            super::super::bcc::corners(super::super::bcc::locate(&(points[0] + shift)))
                .map(|c| super::super::bcc::place(c) - shift);
        let order = |a: &Vec3, b: &Vec3| {
            a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
        };
        own.sort_by(order);
        expected.sort_by(order);
        assert!(own.iter().zip(&expected).all(|(a, b)| (a - b).norm() < 1e-12));
    }
}
