//! Holes of a surface, closed.

use crate::TriMesh;
use thenar::Vec3;

/// A hole that was closed.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Hole {
    /// Edges of its border.
    pub edges: usize,
    /// Length of the border \[m\].
    pub border: f64,
    /// Area of what closes it \[m²\].
    pub area: f64,
}

/// The mesh with each hole whose border is one simple loop closed by a fan about the loop's middle, and those holes,
/// the largest first. Borders that meet in a vertex stay open.
pub fn close_holes(mesh: &TriMesh) -> (TriMesh, Vec<Hole>) {
    let mut whole = mesh.clone();
    let mut holes = Vec::new();
    for ring in rings(mesh) {
        let middle = whole.positions.len() as u32;
        let places = ring.iter().map(|side| mesh.positions[side[0] as usize]);
        whole.positions.push(places.sum::<Vec3>() / ring.len() as f64);
        let first = whole.triangles.len();
        whole.triangles.extend(ring.iter().map(|&[a, b]| [a, b, middle]));
        let length =
            |[a, b]: &[u32; 2]| (mesh.positions[*b as usize] - mesh.positions[*a as usize]).norm();
        holes.push(Hole {
            edges: ring.len(),
            border: ring.iter().map(length).sum(),
            area: (first..whole.triangles.len()).map(|t| whole.area_vector(t).norm()).sum(),
        });
    }
    holes.sort_by(|a, b| b.border.total_cmp(&a.border));
    (whole, holes)
}

/// The borders that are simple loops, each side running against that of the triangle along it.
fn rings(mesh: &TriMesh) -> Vec<Vec<[u32; 2]>> {
    let mut sides: Vec<[u32; 2]> =
        mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    sides.sort_unstable();
    let has = |side: &[u32; 2]| sides.binary_search(side).is_ok();
    let mut border: Vec<[u32; 2]> =
        sides.iter().filter(|[a, b]| !has(&[*b, *a])).map(|&[a, b]| [b, a]).collect();
    border.sort_unstable();
    let mut done = vec![false; border.len()];
    let mut rings = Vec::new();
    for first in 0..border.len() {
        let mut ring = Vec::new();
        let mut at = first;
        while !std::mem::replace(&mut done[at], true) {
            ring.push(border[at]);
            let from = border[at][1];
            let next = border.partition_point(|side| side[0] < from);
            let ways = border[next..].iter().take_while(|side| side[0] == from).count();
            if ways != 1 {
                ring.clear();
                break;
            }
            at = next;
        }
        if ring.len() >= 3 && at == first {
            rings.push(ring);
        }
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Topology, shapes};

    fn without(mesh: &TriMesh, gone: impl Fn(&Vec3) -> bool) -> TriMesh {
        let triangles = mesh.triangles.iter().copied();
        let triangles =
            triangles.filter(|t| !t.iter().any(|&v| gone(&mesh.positions[v as usize]))).collect();
        TriMesh { positions: mesh.positions.clone(), triangles }.compacted()
    }

    /// Two caps cut off a ball of radius r at heights ±h leave flat circles, which are closed flat.
    #[test]
    fn caps_of_a_ball_are_closed_flat() {
        let ball = shapes::sphere(1.0, 40);
        let open = without(&ball, |p| p.y.abs() > 0.8);
        let (closed, holes) = close_holes(&open);
        let topology = Topology::of(&closed);
        assert!(topology.closed() && topology.oriented() && topology.manifold());
        assert_eq!(holes.len(), 2);
        let rim = open.positions.iter().map(|p| p.y).fold(0.0, f64::max);
        // Between the planes at ±z a ball holds 2π (z − z³/3), less what the triangles cut off.
        let expected = std::f64::consts::TAU * (rim - rim.powi(3) / 3.0);
        assert!((closed.volume() / expected - 1.0).abs() < 0.03, "{} {expected}", closed.volume());
        for hole in holes {
            let circle = std::f64::consts::PI * (1.0 - rim * rim);
            assert!((hole.area / circle - 1.0).abs() < 0.1, "{} against {circle}", hole.area);
        }
    }

    #[test]
    fn a_closed_mesh_stays_as_it_is() {
        let cube = shapes::cuboid(&Vec3::repeat(1.0));
        assert_eq!(close_holes(&cube), (cube, Vec::new()));
    }

    /// Two triangles that are gone at one vertex leave borders that meet there.
    #[test]
    fn borders_that_meet_in_a_vertex_stay_open() {
        let ball = shapes::sphere(1.0, 8);
        let around: Vec<usize> =
            (0..ball.triangles.len()).filter(|&t| ball.triangles[t].contains(&5)).collect();
        let apart = around.iter().find(|&&t| {
            let shared = |t: usize, u: usize| {
                ball.triangles[t].iter().filter(|v| ball.triangles[u].contains(v)).count()
            };
            shared(t, around[0]) == 1
        });
        let mut open = ball.clone();
        let gone = [around[0], *apart.unwrap()];
        let mut t = 0;
        open.triangles.retain(|_| {
            t += 1;
            !gone.contains(&(t - 1))
        });
        let (closed, holes) = close_holes(&open);
        assert!(holes.is_empty());
        assert_eq!(closed, open);
    }

    #[test]
    fn a_sheet_and_nothing_at_all_do_no_harm() {
        assert_eq!(close_holes(&TriMesh::default()).1, []);
        let sheet = TriMesh {
            positions: vec![Vec3::zeros(), Vec3::x(), Vec3::y()],
            triangles: vec![[0, 1, 2]],
        };
        // The other side of a triangle closes it, however thin that is.
        assert_eq!(close_holes(&sheet).1.len(), 1);
    }
}
