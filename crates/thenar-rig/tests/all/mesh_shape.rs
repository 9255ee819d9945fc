//! Simplification, refinement, welding, orientation, distance and winding number of meshes,
//! against what geometry says of spheres, boxes and tori.

use std::f64::consts::PI;
use thenar_core::Vec3;
use thenar_core::random::Random;
use thenar_rig::TriMesh;
use thenar_rig::mesh::{
    Bvh, Topology, decimate, decimate_within, shapes, subdivide, subdivide_to, weld,
};

/// A seeded sequence of points in the cube [-1, 1]³.
fn points(n: usize) -> Vec<Vec3> {
    let mut random = Random::new(1);
    (0..n).map(|_| random.vector(1.0)).collect()
}

fn torus(major: f64, minor: f64, n: u32, m: u32) -> TriMesh {
    let mut mesh = TriMesh::default();
    for i in 0..n {
        for j in 0..m {
            let (u, v) =
                (2.0 * PI * f64::from(i) / f64::from(n), 2.0 * PI * f64::from(j) / f64::from(m));
            let r = major + minor * v.cos();
            mesh.positions.push(Vec3::new(r * u.cos(), r * u.sin(), minor * v.sin()));
            let at = |i: u32, j: u32| i % n * m + j % m;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn assert_sound(mesh: &TriMesh, genus: i64) {
    let t = Topology::of(mesh);
    assert!(t.closed() && t.manifold() && t.oriented(), "{t:?}");
    assert_eq!((t.components, t.genus(), t.degenerate_triangles), (1, Some(genus), 0));
}

#[test]
fn decimation_keeps_volume_topology_and_shape() {
    let ball = shapes::sphere(0.03, 16);
    for target in [2000, 600, 200] {
        let coarse = decimate(&ball, target).unwrap();
        assert_sound(&coarse, 0);
        assert!(coarse.triangles.len() <= target && coarse.triangles.len() + 2 >= target);
        assert!((coarse.volume() / ball.volume() - 1.0).abs() < 1e-9);
        // An equilateral triangle of edge e sags by e²/(6 r) below its sphere; allow double.
        let edge2 = 4.0 / 3f64.sqrt() * ball.area() / target as f64;
        let sag = edge2 / (6.0 * 0.03);
        for p in &coarse.positions {
            assert!((p.norm() - 0.03).abs() < 2.0 * sag, "{} {sag}", p.norm());
        }
    }
    let ring = torus(0.1, 0.04, 64, 32);
    let coarse = decimate(&ring, 500).unwrap();
    assert_sound(&coarse, 1);
    assert!((coarse.volume() / ring.volume() - 1.0).abs() < 1e-9);
}

#[test]
fn decimation_of_a_refined_box_gives_the_box_back() {
    // Linear refinement of a box: everything but the eight corners is redundant.
    let mut fine = shapes::cuboid(&Vec3::new(0.1, 0.2, 0.3));
    for _ in 0..3 {
        fine = split_flat(&fine);
    }
    let coarse = decimate(&fine, 12).unwrap();
    assert_sound(&coarse, 0);
    assert_eq!(coarse.triangles.len(), 12);
    let hierarchy = Bvh::new(&coarse);
    for x in [-0.1, 0.1] {
        for y in [-0.2, 0.2] {
            for z in [-0.3, 0.3] {
                assert!(hierarchy.closest(&Vec3::new(x, y, z)).distance < 1e-6);
            }
        }
    }
}

/// Every triangle into four, in its plane.
fn split_flat(mesh: &TriMesh) -> TriMesh {
    let mut fine = TriMesh::default();
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
        for corners in [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]] {
            let first = fine.positions.len() as u32;
            fine.positions.extend(corners);
            fine.triangles.push([first, first + 1, first + 2]);
        }
    }
    weld(&fine, 1e-9).mesh
}

#[test]
fn refinement_passes_through_the_vertices_and_nears_the_sphere() {
    let coarse = shapes::sphere(1.0, 4);
    let fine = subdivide(&coarse, 2).unwrap();
    assert_sound(&fine.mesh, 0);
    assert_eq!(fine.mesh.triangles.len(), 16 * coarse.triangles.len());
    assert!(fine.moved_max < 1e-3, "{}", fine.moved_max);
    // The coarse mesh's faces lie more than 1 % below the sphere; the refined ones within 0.5 %.
    let lowest = |m: &TriMesh| {
        (0..m.triangles.len())
            .map(|t| (m.corners(t).iter().sum::<Vec3>() / 3.0).norm())
            .fold(1.0, f64::min)
    };
    assert!(lowest(&coarse) < 0.99);
    assert!(fine.mesh.positions.iter().all(|p| (p.norm() - 1.0).abs() < 5e-3));
    assert!((fine.mesh.volume() / (4.0 / 3.0 * PI) - 1.0).abs() < 0.01);
    assert!(fine.volume_ratio > 1.0 && fine.volume_ratio < 1.05);
    assert_eq!(subdivide_to(&coarse, 321).unwrap().mesh.triangles.len(), 1280);
    assert_eq!(subdivide_to(&coarse, 320).unwrap().mesh.triangles.len(), 320);
}

#[test]
fn an_open_square_stays_flat_and_keeps_its_rim() {
    // Refinement leaves it flat; simplification gives its two triangles back.
    let square = TriMesh::new(
        vec![Vec3::zeros(), Vec3::x(), Vec3::x() + Vec3::y(), Vec3::y()],
        vec![[0, 1, 2], [0, 2, 3]],
    )
    .unwrap();
    let fine = subdivide(&split_flat(&square), 2).unwrap().mesh;
    assert!(fine.positions.iter().all(|p| p.z.abs() < 1e-15));
    assert_eq!(Topology::of(&fine).boundary_edges, 32);
    let flat = split_flat(&split_flat(&square));
    let coarse = decimate(&flat, 2).unwrap();
    assert_eq!(coarse.triangles.len(), 2);
    assert!((coarse.area() - 1.0).abs() < 1e-9);
}

#[test]
fn welding_a_soup_gives_the_closed_mesh_back() {
    let ball = shapes::sphere(1.0, 5);
    let mut soup = TriMesh::default();
    for (t, jitter) in (0..ball.triangles.len()).zip(points(ball.triangles.len())) {
        let first = soup.positions.len() as u32;
        soup.positions.extend(ball.corners(t).map(|p| p + jitter * 1e-7));
        soup.triangles.push([first, first + 1, first + 2]);
    }
    assert_eq!(Topology::of(&soup).components, ball.triangles.len());
    let welded = weld(&soup, 1e-6);
    assert_sound(&welded.mesh, 0);
    assert_eq!(welded.mesh.positions.len(), ball.positions.len());
    assert_eq!(welded.dropped, 0);
    assert_eq!(weld(&soup, 0.0).mesh.positions.len(), soup.positions.len());
}

#[test]
fn orientation_is_repaired_and_cavities_stay() {
    let mut messy = shapes::sphere(1.0, 4);
    for t in (0..messy.triangles.len()).step_by(3) {
        messy.triangles[t].swap(0, 1);
    }
    assert!(!Topology::of(&messy).oriented());
    messy.orient().unwrap();
    assert_sound(&messy, 0);
    assert!(messy.volume() > 4.0);

    // A hollow ball, its inner wall facing inward: volume 4π/3 (1 - 0.5³) when right.
    let mut hollow = shapes::sphere(1.0, 12);
    let mut wall = shapes::sphere(0.5, 12);
    wall.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    hollow.append(&wall);
    let volume = hollow.volume();
    let result = hollow.orient().unwrap();
    assert_eq!((result.cavities, result.flipped_triangles), (1, 0));
    assert!((hollow.volume() - volume).abs() < 1e-12);
    assert!((volume / (4.0 / 3.0 * PI * 0.875) - 1.0).abs() < 0.02);

    // The same ball with everything inside out: the outer wall turns, the inner is then inward.
    hollow.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    hollow.orient().unwrap();
    assert!(hollow.volume() > 0.0);
}

#[test]
fn topology_counts_handles_holes_and_pieces() {
    assert_eq!(Topology::of(&torus(1.0, 0.3, 20, 10)).genus(), Some(1));
    let mut two = shapes::sphere(1.0, 2);
    two.append(&torus(1.0, 0.3, 20, 10));
    let t = Topology::of(&two);
    assert_eq!((t.components, t.genus()), (2, Some(1)));

    let mut open = shapes::sphere(1.0, 2);
    open.triangles.pop();
    let t = Topology::of(&open);
    assert_eq!((t.boundary_edges, t.genus()), (3, None));

    // Two tetrahedra that share one vertex: closed, not manifold.
    let corner = |s: f64| [Vec3::x() * s, Vec3::y() * s, Vec3::z() * s];
    let mut positions = vec![Vec3::zeros()];
    positions.extend(corner(1.0));
    positions.extend(corner(-1.0));
    let tetra = |a, b, c, d| [[a, c, b], [a, b, d], [b, c, d], [c, a, d]];
    let triangles = [tetra(0, 1, 2, 3), tetra(0, 4, 6, 5)].concat();
    let t = Topology::of(&TriMesh::new(positions, triangles).unwrap());
    assert!(t.closed() && t.oriented() && !t.manifold());
    assert_eq!(t.non_manifold_vertices, 1);
}

#[test]
fn nearest_point_agrees_with_brute_force() {
    let ring = torus(0.6, 0.25, 40, 20);
    let hierarchy = Bvh::new(&ring);
    for p in points(500) {
        let brute = (0..ring.triangles.len())
            .map(|t| {
                let corners = ring.corners(t);
                let (w, _) = thenar_rig::mesh::closest_on_triangle(&p, &corners);
                ((0..3).map(|k| corners[k] * w[k]).sum::<Vec3>() - p).norm()
            })
            .fold(f64::INFINITY, f64::min);
        let found = hierarchy.closest(&p);
        assert!((found.distance - brute).abs() < 1e-14);
        assert!(hierarchy.closest_within(&p, brute * 0.999).is_none());
        assert!(hierarchy.near(&p, found.distance).contains(&found.triangle));
    }
}

#[test]
fn winding_number_counts_layers_and_halves_at_a_hole() {
    let mut nested = shapes::sphere(1.0, 12);
    nested.append(&shapes::sphere(0.5, 12));
    let hierarchy = Bvh::new(&nested);
    for p in points(2000) {
        let r = p.norm();
        let expected = match r {
            r if r < 0.49 => 2.0,
            r if r > 0.51 && r < 0.97 => 1.0,
            r if r > 1.01 => 0.0,
            _ => continue,
        };
        let w = hierarchy.winding_number(&p);
        assert!((w - expected).abs() < 0.02, "{w} at radius {r}");
    }
    // The open upper half of a sphere, seen from its centre, covers half the sky; from far
    // below on the axis at height -h its rim covers (1 - h/√(1+h²))/2 of it, seen from inside.
    let mut dome = shapes::sphere(1.0, 30);
    let p = dome.positions.clone();
    dome.triangles.retain(|t| t.iter().map(|&v| p[v as usize].y).sum::<f64>() > 0.0);
    let hierarchy = Bvh::new(&dome);
    for h in [0.0, 0.5, 1.0, 3.0] {
        let expected = (1.0 - h / f64::hypot(1.0, h)) / 2.0;
        let w = hierarchy.winding_number(&Vec3::new(0.0, -h, 0.0));
        assert!((w - expected).abs() < 0.02, "{w} {expected}");
    }
}

#[test]
fn signed_distance_of_a_fine_sphere() {
    let hierarchy = Bvh::new(&shapes::sphere(0.5, 30));
    for p in points(500) {
        let d = hierarchy.signed_distance(&p);
        assert!((d - (p.norm() - 0.5)).abs() < 5e-4);
    }
}

#[test]
fn bad_meshes_are_refused_by_name() {
    let error = |positions, triangles| TriMesh::new(positions, triangles).unwrap_err().to_string();
    assert!(error(vec![Vec3::zeros()], vec![]).contains("no triangles"));
    assert!(error(vec![Vec3::zeros()], vec![[0, 0, 7]]).contains("vertex 7"));
    let nan = Vec3::new(0.0, f64::NAN, 0.0);
    assert!(error(vec![Vec3::zeros(), nan], vec![[0, 1, 0]]).contains("vertex 1 is not finite"));
    let far = Vec3::new(1e9, 0.0, 0.0);
    assert!(error(vec![far], vec![[0, 0, 0]]).contains("scale"));
}

/// On one half edges may grow to a fifth of the radius, on the other at will.
#[test]
fn a_limit_on_edges_holds_where_it_is_set() {
    let ball = shapes::sphere(1.0, 24);
    let limit = |p: &Vec3| if p.x > 0.0 { 0.2 } else { f64::INFINITY };
    let limits = ball.positions.iter().map(limit).collect();
    let simple = decimate_within(&ball, 100, limits).unwrap();
    let edges = |right: bool| {
        let all = simple.triangles.iter().flat_map(|t| (0..3).map(move |k| [t[k], t[(k + 1) % 3]]));
        let ends = all.map(|e| e.map(|v| simple.positions[v as usize]));
        let half = ends.filter(move |e| e.iter().all(|x| (x.x > 0.0) == right));
        half.map(|[a, b]| (a - b).norm()).fold(0.0, f64::max)
    };
    assert!(edges(true) <= 0.2 && edges(false) > 0.5, "{} {}", edges(true), edges(false));
    assert!(simple.triangles.len() < ball.triangles.len() / 2);
    assert!((simple.volume() / ball.volume() - 1.0).abs() < 1e-9);
    assert!(decimate_within(&ball, 100, vec![1.0; 3]).is_err());
}
