//! Vertex normals from triangles.

use thenar_core::Vec3;

/// Twice the area of a triangle times its unit normal; zero where an index is out of range.
fn area_normal(positions: &[Vec3], triangle: &[u32; 3]) -> Vec3 {
    match triangle.map(|i| positions.get(i as usize)) {
        [Some(a), Some(b), Some(c)] => (b - a).cross(&(c - a)),
        _ => Vec3::zeros(),
    }
}

/// One unit normal per vertex: the area-weighted mean of the faces around it.
pub fn smooth(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); positions.len()];
    for triangle in triangles {
        let n = area_normal(positions, triangle);
        for &i in triangle {
            if let Some(normal) = normals.get_mut(i as usize) {
                *normal += n;
            }
        }
    }
    for n in &mut normals {
        *n = n.try_normalize(1e-30).unwrap_or_else(Vec3::y);
    }
    normals
}

/// One unit normal per corner of each triangle: the area-weighted mean of those faces around
/// the vertex that turn by less than `crease` \[rad\] from the corner's own face.
pub fn creased(positions: &[Vec3], triangles: &[[u32; 3]], crease: f64) -> Vec<[Vec3; 3]> {
    let faces: Vec<Vec3> = triangles.iter().map(|t| area_normal(positions, t)).collect();
    let units: Vec<Vec3> =
        faces.iter().map(|n| n.try_normalize(1e-30).unwrap_or_else(Vec3::zeros)).collect();
    let around = faces_around(positions.len(), triangles);
    let cosine = crease.cos();
    let corner = |t: usize, i: u32| {
        let sum: Vec3 = around[i as usize]
            .iter()
            .filter(|&&s| units[s as usize].dot(&units[t]) >= cosine)
            .map(|&s| faces[s as usize])
            .sum();
        sum.try_normalize(1e-30).unwrap_or(units[t])
    };
    triangles.iter().enumerate().map(|(t, tri)| tri.map(|i| corner(t, i))).collect()
}

/// The triangles around each vertex, in order.
fn faces_around(vertices: usize, triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); vertices];
    for (t, triangle) in triangles.iter().enumerate() {
        for &i in triangle {
            around[i as usize].push(t as u32);
        }
    }
    around
}

#[cfg(test)]
mod tests {
    use super::super::shapes;
    use super::*;

    #[test]
    fn normals_of_a_fine_sphere_are_radial() {
        let ball = shapes::sphere(Vec3::zeros(), 0.5, 48);
        for (p, n) in ball.positions.iter().zip(smooth(&ball.positions, &ball.triangles)) {
            assert!(p.normalize().dot(&n) > 0.999, "{p} {n}");
        }
    }

    #[test]
    fn a_crease_keeps_the_faces_of_a_cube_flat() {
        let p: Vec<Vec3> = (0..8)
            .map(|i| Vec3::new((i & 1).into(), (i >> 1 & 1).into(), (i >> 2 & 1).into()))
            .collect();
        let t = [[0, 2, 1], [1, 2, 3], [0, 1, 4], [1, 5, 4], [0, 4, 2], [2, 4, 6]];
        for corners in creased(&p, &t, 0.5).iter().take(2) {
            for n in corners {
                assert!((n - Vec3::new(0.0, 0.0, -1.0)).norm() < 1e-12, "{n}");
            }
        }
        let rounded = smooth(&p, &t);
        assert!((rounded[0] - Vec3::repeat(-1.0).normalize()).norm() < 0.3);
    }
}
