//! Meshes of simple bodies, centred at the origin.

use crate::TriMesh;
use std::f64::consts::{FRAC_PI_2, PI};
use thenar_core::Vec3;

/// A cuboid with these half edge lengths \[m\]: 8 vertices, 12 triangles.
pub fn cuboid(half: &Vec3) -> TriMesh {
    let corner = |i: usize| {
        let sign = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        Vec3::new(sign(0), sign(1), sign(2)).component_mul(half)
    };
    // Corner i has bit 0 for +x, bit 1 for +y, bit 2 for +z.
    let quads: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriMesh { positions: (0..8).map(corner).collect(), triangles }
}

/// A sphere from an icosahedron, each face split into `frequency`² triangles: `20 frequency²`
/// triangles, vertices on the sphere.
pub fn sphere(radius: f64, frequency: u32) -> TriMesh {
    let mut mesh = icosahedron();
    mesh = split_faces(&mesh, frequency.max(1));
    for p in &mut mesh.positions {
        *p = p.normalize() * radius;
    }
    mesh
}

fn icosahedron() -> TriMesh {
    // A vertex at each pole, two rings of five at heights ± 1/√5.
    let height = 1.0 / 5f64.sqrt();
    let ring = |k: u32, y: f64, turn: f64| {
        let angle = (f64::from(k) + turn) * 2.0 * PI / 5.0;
        Vec3::new(2.0 * height * angle.sin(), y, 2.0 * height * angle.cos())
    };
    let mut positions = vec![Vec3::y()];
    positions.extend((0..5).map(|k| ring(k, height, 0.0)));
    positions.extend((0..5).map(|k| ring(k, -height, 0.5)));
    positions.push(-Vec3::y());

    let mut triangles = Vec::new();
    for k in 0..5 {
        let (a, b) = (1 + k, 1 + (k + 1) % 5);
        let (c, d) = (6 + k, 6 + (k + 1) % 5);
        triangles.extend([[0, a, b], [a, c, b], [b, c, d], [11, d, c]]);
    }
    TriMesh { positions, triangles }
}

/// Splits every triangle into n² equal ones, sharing the new vertices along edges.
fn split_faces(mesh: &TriMesh, n: u32) -> TriMesh {
    let mut fine = TriMesh::default();
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        let first = fine.positions.len() as u32;
        // Row i holds i + 1 points, from a (row 0) to bc (row n).
        for i in 0..=n {
            for j in 0..=i {
                let (s, r) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                fine.positions.push(a * (1.0 - s) + b * (s - r) + c * r);
            }
        }
        let at = |i: u32, j: u32| first + i * (i + 1) / 2 + j;
        for i in 0..n {
            for j in 0..=i {
                fine.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                if j < i {
                    fine.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    let [min, max] = mesh.bounds();
    super::weld(&fine, 1e-9 * (max - min).norm()).mesh
}

/// A capsule along y: a segment of length `2 half_length`, rounded by `radius` \[m\].
/// `segments` around, at least 3.
pub fn capsule(radius: f64, half_length: f64, segments: u32) -> TriMesh {
    let segments = segments.max(3);
    let rings_per_cap = segments.div_ceil(4).max(1);
    let mut profile = Vec::new();
    for i in 1..=rings_per_cap {
        let angle = -FRAC_PI_2 + FRAC_PI_2 * f64::from(i) / f64::from(rings_per_cap);
        profile.push((radius * angle.cos(), radius * angle.sin() - half_length));
    }
    // Bands about as high as wide along the cylinder.
    let width = 2.0 * PI * radius / f64::from(segments);
    let bands = (2.0 * half_length / width).round().clamp(1.0, 256.0) as u32;
    for i in 1..bands {
        profile.push((radius, half_length * (2.0 * f64::from(i) / f64::from(bands) - 1.0)));
    }
    for i in 0..rings_per_cap {
        let angle = FRAC_PI_2 * f64::from(i) / f64::from(rings_per_cap);
        profile.push((radius * angle.cos(), radius * angle.sin() + half_length));
    }
    revolved(&profile, [-half_length - radius, half_length + radius], segments)
}

/// The closed body swept by a profile of (radius, y) about the y axis, from the pole at `poles[0]`
/// up to the pole at `poles[1]`.
pub fn revolved(profile: &[(f64, f64)], poles: [f64; 2], segments: u32) -> TriMesh {
    let mut mesh = TriMesh::default();
    mesh.positions.push(Vec3::new(0.0, poles[0], 0.0));
    for &(r, y) in profile {
        for k in 0..segments {
            let angle = 2.0 * PI * f64::from(k) / f64::from(segments);
            mesh.positions.push(Vec3::new(r * angle.sin(), y, r * angle.cos()));
        }
    }
    mesh.positions.push(Vec3::new(0.0, poles[1], 0.0));
    let rings = profile.len() as u32;
    let top = mesh.positions.len() as u32 - 1;
    let at = |ring: u32, k: u32| 1 + ring * segments + k % segments;
    for k in 0..segments {
        mesh.triangles.push([0, at(0, k + 1), at(0, k)]);
        for ring in 0..rings - 1 {
            let [a, b] = [at(ring, k), at(ring, k + 1)];
            let [c, d] = [at(ring + 1, k), at(ring + 1, k + 1)];
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
        mesh.triangles.push([top, at(rings - 1, k), at(rings - 1, k + 1)]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Topology;

    fn is_a_ball(mesh: &TriMesh) {
        let t = Topology::of(mesh);
        assert!(t.closed() && t.manifold() && t.oriented() && t.components == 1, "{t:?}");
        assert_eq!(t.genus(), Some(0));
        assert_eq!(t.degenerate_triangles, 0);
    }

    #[test]
    fn shapes_are_closed_and_approach_their_volumes() {
        let half = Vec3::new(0.01, 0.02, 0.03);
        let cube = cuboid(&half);
        is_a_ball(&cube);
        assert!((cube.volume() / (8.0 * half.product()) - 1.0).abs() < 1e-14);
        assert!((cube.area() - 8.0 * (2e-4 + 6e-4 + 3e-4)).abs() < 1e-16);

        // The volume defect of an inscribed mesh falls with the square of the edge length.
        let defect = |n| 1.0 - sphere(2.0, n).volume() / (32.0 / 3.0 * PI);
        let (coarse, fine) = (defect(4), defect(8));
        is_a_ball(&sphere(2.0, 4));
        assert_eq!(sphere(2.0, 4).triangles.len(), 320);
        assert!(fine > 0.0 && fine < 0.02 && (coarse / fine - 4.0).abs() < 0.2);

        let exact = PI * 0.01f64.powi(2) * (0.04 + 4.0 / 3.0 * 0.01);
        let pill = capsule(0.01, 0.02, 64);
        is_a_ball(&pill);
        assert!((1.0 - pill.volume() / exact).abs() < 0.005);
    }
}
