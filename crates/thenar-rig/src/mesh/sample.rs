//! A mesh with vertices everywhere: none crowded, none far apart.

use super::edges::Edges;
use super::{decimate, weld};
use crate::work::phase;
use crate::{RigError, TriMesh};

/// A surface resampled with at most about `points_max` vertices and, as far as that allows, no edge
/// longer than `spacing` \[m\]. Flat faces get vertices too. Fine meshes are simplified first, and
/// if they cannot be, their vertices are merged in ever larger clusters.
pub fn resampled(mesh: &TriMesh, spacing: f64, points_max: usize) -> Result<TriMesh, RigError> {
    mesh.check()?;
    let mut coarse = mesh.clone().compacted();
    // Half of the points carry the shape, the other half fill in.
    if coarse.positions.len() > points_max / 2 {
        coarse = decimate(&coarse, points_max)?;
    }
    let [min, max] = coarse.bounds();
    let mut tolerance = (max - min).norm() / 400.0;
    while coarse.positions.len() > points_max {
        phase("merging vertices")?;
        coarse = weld(&coarse, tolerance).mesh.compacted();
        tolerance *= 1.3;
    }
    coarse.check()?;

    let mut spacing = spacing;
    loop {
        if let Some(fine) = split_long_edges(&coarse, spacing, points_max) {
            return Ok(fine);
        }
        spacing *= 1.2;
    }
}

/// Halves edges longer than `length` until there are none; `None` if that takes more vertices
/// than allowed.
fn split_long_edges(mesh: &TriMesh, length: f64, points_max: usize) -> Option<TriMesh> {
    let mut mesh = mesh.clone();
    loop {
        let edges = Edges::new(&mesh.triangles);
        let lengths: Vec<f64> = edges
            .list
            .iter()
            .map(|edge| {
                let [a, b] = edge.vertices.map(|v| mesh.positions[v as usize]);
                (b - a).norm()
            })
            .collect();
        // Only the longest edge of each triangle, which keeps angles from shrinking.
        let mut middle = vec![None; edges.list.len()];
        for of in &edges.of_triangle {
            let [a, b, c] = of.map(|e| e as usize);
            let longer = |x: usize, y: usize| if lengths[y] > lengths[x] { y } else { x };
            let e = longer(longer(a, b), c);
            if lengths[e] > length && middle[e].is_none() {
                middle[e] = Some(mesh.positions.len() as u32);
                let [a, b] = edges.list[e].vertices.map(|v| mesh.positions[v as usize]);
                mesh.positions.push((a + b) * 0.5);
            }
        }
        if middle.iter().all(Option::is_none) {
            return Some(mesh);
        }
        if mesh.positions.len() > points_max {
            return None;
        }
        let mut triangles = Vec::with_capacity(2 * mesh.triangles.len());
        for (triangle, of) in mesh.triangles.iter().zip(&edges.of_triangle) {
            split_triangle(*triangle, of.map(|e| middle[e as usize]), &mesh, &mut triangles);
        }
        mesh.triangles = triangles;
    }
}

/// Cuts a triangle at the new vertices on its sides.
fn split_triangle(
    [a, b, c]: [u32; 3],
    middle: [Option<u32>; 3],
    mesh: &TriMesh,
    out: &mut Vec<[u32; 3]>,
) {
    let [ab, bc, ca] = middle;
    match (ab, bc, ca) {
        (None, None, None) => out.push([a, b, c]),
        (Some(m), None, None) => out.extend([[a, m, c], [m, b, c]]),
        (None, Some(_), None) => split_triangle([b, c, a], [bc, ca, ab], mesh, out),
        (None, None, Some(_)) => split_triangle([c, a, b], [ca, ab, bc], mesh, out),
        (Some(m), Some(n), None) => {
            // The quad a-m-n-c is cut along its shorter diagonal.
            out.push([m, b, n]);
            let at = |v: u32| mesh.positions[v as usize];
            if (at(a) - at(n)).norm() < (at(m) - at(c)).norm() {
                out.extend([[a, m, n], [a, n, c]]);
            } else {
                out.extend([[a, m, c], [m, n, c]]);
            }
        }
        (None, Some(_), Some(_)) => split_triangle([b, c, a], [bc, ca, ab], mesh, out),
        (Some(_), None, Some(_)) => split_triangle([c, a, b], [ca, ab, bc], mesh, out),
        (Some(m), Some(n), Some(o)) => out.extend([[a, m, o], [b, n, m], [c, o, n], [m, n, o]]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Topology, shapes};
    use thenar_core::Vec3;

    #[test]
    fn a_box_gets_points_on_its_faces_and_stays_a_box() {
        let cube = shapes::cuboid(&Vec3::new(0.01, 0.03, 0.05));
        let fine = resampled(&cube, 0.006, 3000).unwrap();
        assert!((fine.volume() / cube.volume() - 1.0).abs() < 1e-12);
        let t = Topology::of(&fine);
        assert!(t.closed() && t.manifold() && t.oriented());
        for edge in Edges::new(&fine.triangles).list {
            let [a, b] = edge.vertices.map(|v| fine.positions[v as usize]);
            assert!((a - b).norm() <= 0.006);
        }
        // Asked for the impossible, it does what the limit allows.
        let limited = resampled(&cube, 1e-5, 500).unwrap();
        assert!(limited.positions.len() <= 500 && limited.positions.len() > 150);
    }

    #[test]
    fn a_fine_ball_and_a_triangle_soup_are_thinned() {
        let ball = resampled(&shapes::sphere(0.05, 60), 0.01, 1000).unwrap();
        assert!(ball.positions.len() <= 1000 && ball.positions.len() > 300);
        assert!(Topology::of(&ball).closed());
        let dense = shapes::sphere(0.05, 20);
        let mut soup = TriMesh::default();
        for t in 0..dense.triangles.len() {
            let first = soup.positions.len() as u32;
            soup.positions.extend(dense.corners(t));
            soup.triangles.push([first, first + 1, first + 2]);
        }
        let thin = resampled(&soup, 0.01, 1000).unwrap();
        assert!(thin.positions.len() <= 1000 && thin.positions.len() > 200);
    }
}
