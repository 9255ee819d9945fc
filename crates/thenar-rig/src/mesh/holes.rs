//! Holes of a surface, closed.

use crate::TriMesh;
use thenar_core::Vec3;

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

/// Work spent on borders on which a fan folds, of all holes together: cubes of their numbers of
/// edges.
const FOLDED_WORK_MAX: usize = 512 * 512 * 512;
/// A triangle faces away if it does by more than this part of the product of areas: no round-off.
const FACES_AWAY: f64 = 1e-9;
/// A triangle flatter than this part of its longest side squared costs as much as if it had this
/// area.
const FLAT: f64 = 1e-3;

/// The mesh with each hole whose border is one simple loop closed, and those holes, the largest
/// first: by a fan about the loop's middle, or where that folds, as an L-shaped hole's does, by the
/// triangles of least area between the vertices of its border (Barequet and Sharir 1995), if there
/// are such without edges that the mesh has already and all that fold have about 512 edges or
/// fewer. Borders that meet in a vertex stay open.
pub fn close_holes(mesh: &TriMesh) -> (TriMesh, Vec<Hole>) {
    let mut whole = mesh.clone();
    let mut holes = Vec::new();
    let sides = sides(mesh);
    let mut work = 0_usize;
    for ring in rings(&sides) {
        let first = whole.triangles.len();
        let middle = whole.positions.len() as u32;
        let places = ring.iter().map(|side| mesh.positions[side[0] as usize]);
        whole.positions.push(places.sum::<Vec3>() / ring.len() as f64);
        whole.triangles.extend(ring.iter().map(|&[a, b]| [a, b, middle]));
        let cost = ring.len().saturating_pow(3);
        if folds(&whole, first) && work.saturating_add(cost) <= FOLDED_WORK_MAX {
            work += cost;
            if let Some(triangles) = least_area(&mesh.positions, &ring, &sides) {
                whole.positions.truncate(middle as usize);
                whole.triangles.truncate(first);
                whole.triangles.extend(triangles);
            }
        }
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

/// True if one of the last triangles of a mesh, from `first` on, faces away from their mean.
fn folds(mesh: &TriMesh, first: usize) -> bool {
    let areas = || (first..mesh.triangles.len()).map(|t| mesh.area_vector(t));
    let mean: Vec3 = areas().sum();
    areas().any(|area| area.dot(&mean) < -FACES_AWAY * area.norm() * mean.norm())
}

/// The triangles between a ring's vertices whose areas sum to the least, without chords that are
/// edges of the mesh; `None` where none are without.
fn least_area(positions: &[Vec3], ring: &[[u32; 2]], sides: &[[u32; 2]]) -> Option<Vec<[u32; 3]>> {
    let n = ring.len();
    let is_edge = |a: usize, c: usize| {
        let [a, c] = [a, c].map(|k| ring[k][0]);
        [[a, c], [c, a]].iter().any(|side| sides.binary_search(side).is_ok())
    };
    let at = |k: usize| positions[ring[k][0] as usize];
    let cost = |a: usize, b: usize, c: usize| {
        let sides = [at(b) - at(a), at(c) - at(b), at(a) - at(c)];
        let longest = sides.iter().map(Vec3::norm_squared).fold(0.0, f64::max);
        (sides[0].cross(&sides[1]).norm() / 2.0).hypot(FLAT * longest)
    };
    // Of the part of the ring from a to c, closed by a chord: its least cost, and the vertex that
    // the chord's triangle has between them.
    let mut least = vec![(0.0, 0); n * n];
    for length in 2..n {
        for a in 0..n - length {
            let c = a + length;
            if length < n - 1 && is_edge(a, c) {
                least[a * n + c].0 = f64::INFINITY;
                continue;
            }
            let by = |b: usize| least[a * n + b].0 + least[b * n + c].0 + cost(a, b, c);
            let all = (a + 1..c).map(|b| (by(b), b));
            least[a * n + c] =
                all.fold((f64::INFINITY, a + 1), |m, x| if x.0 < m.0 { x } else { m });
        }
    }
    if least[n - 1].0 == f64::INFINITY {
        return None;
    }
    let mut triangles = Vec::with_capacity(n - 2);
    let mut parts = vec![[0, n - 1]];
    while let Some([a, c]) = parts.pop() {
        if c - a >= 2 {
            let b = least[a * n + c].1;
            triangles.push([a, b, c].map(|k| ring[k][0]));
            parts.extend([[a, b], [b, c]]);
        }
    }
    Some(triangles)
}

/// The directed sides of all triangles, sorted.
fn sides(mesh: &TriMesh) -> Vec<[u32; 2]> {
    let mut sides: Vec<[u32; 2]> =
        mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    sides.sort_unstable();
    sides
}

/// The borders that are simple loops, each side running against that of the triangle along it.
fn rings(sides: &[[u32; 2]]) -> Vec<Vec<[u32; 2]>> {
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

    /// A wall in the form of an L, a U and a comb, whose open top no place sees whole. The volume
    /// below a flat top is that of the prism.
    #[test]
    fn holes_that_no_fan_closes_are_closed_flat() {
        let l = vec![[0, 0], [4, 0], [4, 1], [1, 1], [1, 4], [0, 4]];
        let u = vec![[0, 0], [5, 0], [5, 6], [4, 6], [4, 1], [1, 1], [1, 6], [0, 6]];
        let mut comb = vec![[0, 0], [9, 0]];
        for k in (0..5).rev() {
            comb.extend([[2 * k + 1, 5], [2 * k, 5]]);
            comb.extend((k > 0).then_some([2 * k, 1]));
            comb.extend((k > 0).then_some([2 * k - 1, 1]));
        }
        for (outline, area) in [(l, 7.0), (u, 15.0), (comb, 29.0)] {
            // Borders of scans have many vertices on a straight line.
            for cuts in [1, 3] {
                let outline = cut_sides(&outline, cuts);
                let (closed, holes) = close_holes(&wall(&outline));
                let topology = Topology::of(&closed);
                assert!(topology.closed() && topology.oriented() && topology.manifold());
                assert_eq!(holes.len(), 2);
                assert!((closed.volume() - area).abs() < 1e-9, "{}", closed.volume());
                for hole in holes {
                    assert!((hole.area - area).abs() < 1e-9, "{} against {area}", hole.area);
                }
            }
        }
    }

    /// An outline whose sides have as many parts.
    fn cut_sides(outline: &[[i32; 2]], parts: usize) -> Vec<[f64; 2]> {
        let n = outline.len();
        let at = |k: usize, j: usize| {
            let [a, b] = [outline[k], outline[(k + 1) % n]].map(|p| p.map(f64::from));
            let t = j as f64 / parts as f64;
            [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
        };
        (0..n).flat_map(|k| (0..parts).map(move |j| at(k, j))).collect()
    }

    #[test]
    fn a_long_border_on_which_a_fan_folds_is_closed_by_it() {
        let outline = cut_sides(&[[0, 0], [4, 0], [4, 1], [1, 1], [1, 4], [0, 4]], 100);
        let wall = wall(&outline);
        let (closed, holes) = close_holes(&wall);
        assert!(Topology::of(&closed).closed() && holes.len() == 2);
        assert_eq!(closed.triangles.len(), wall.triangles.len() + 2 * outline.len());
    }

    /// An L-shaped wall of which a side ends in a tooth: the chord below that is an edge of the
    /// wall.
    #[test]
    fn an_ear_of_the_border_is_not_closed_by_a_second_triangle_on_it() {
        for height in [0.2, 0.5, 1.0, 3.0] {
            let outline = cut_sides(&[[0, 0], [4, 0], [4, 1], [1, 1], [1, 4], [0, 4]], 3);
            let mut wall = wall(&outline);
            let n = outline.len() as u32;
            let [a, b] = [n + 1, n + 2];
            let top = (wall.positions[a as usize] + wall.positions[b as usize]) / 2.0;
            wall.positions.push(top + Vec3::z() * height);
            wall.triangles.push([a, b, 2 * n]);
            let (closed, holes) = close_holes(&wall);
            let topology = Topology::of(&closed);
            assert!(topology.closed() && topology.manifold(), "{height}: {topology:?}");
            assert_eq!(holes.len(), 2);
        }
    }

    /// A wall of unit height over an outline, open below and above.
    fn wall(outline: &[[f64; 2]]) -> TriMesh {
        let n = outline.len() as u32;
        let level = |z: f64| outline.iter().map(move |p| Vec3::new(p[0], p[1], z));
        let side = |k: u32| [[k, (k + 1) % n, n + k], [(k + 1) % n, n + (k + 1) % n, n + k]];
        TriMesh {
            positions: level(0.0).chain(level(1.0)).collect(),
            triangles: (0..n).flat_map(side).collect(),
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
