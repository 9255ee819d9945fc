//! A box of cells cut into tetrahedra.

use crate::format::{LatticeShape, SplitWord};
use crate::math::Vec3;
use crate::session::Random;
use crate::text::{At, Fault};

/// Nodes \[m\] and tetrahedra of positive volume.
pub type Tets = (Vec<Vec3>, Vec<[u32; 4]>);

/// Most cells of a lattice.
const CELLS_MAX: usize = 200_000;

/// The order in which the axes are walked from the least to the greatest corner.
const PATHS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// Five tetrahedra of a cell; corner k has x, y, z in its bits 0, 1, 2.
const FIVE: [[usize; 4]; 5] =
    [[0, 1, 2, 4], [3, 2, 1, 7], [5, 4, 7, 1], [6, 7, 4, 2], [1, 2, 4, 7]];

/// Builds the lattice.
///
/// # Errors
/// It is not clear what is wanted, or it is too large.
pub fn build(shape: &LatticeShape, at: &At<impl Sized>) -> Result<Tets, Fault> {
    let planes = planes(shape, at)?;
    let cells = planes.each_ref().map(|p| p.len() - 1);
    if cells.iter().product::<usize>() > CELLS_MAX {
        return Err(at.fault(format!("expected at most {CELLS_MAX} cells, got {cells:?}")));
    }
    let mut nodes = nodes(&planes);
    let tets = tets(cells, shape.split);
    if shape.jitter > 0.0 {
        jitter(&mut nodes, &planes, shape);
    }
    Ok((nodes, tets))
}

fn planes(shape: &LatticeShape, at: &At<impl Sized>) -> Result<[Vec<f64>; 3], Fault> {
    match (&shape.size, &shape.cells, &shape.coordinates) {
        (Some(size), Some(cells), None) => Ok([0, 1, 2].map(|k| {
            let n = f64::from(cells[k]);
            (0..=cells[k]).map(|i| size[k] * (f64::from(i) / n - 0.5)).collect()
        })),
        (None, None, Some(planes)) => {
            for (k, p) in planes.iter().enumerate() {
                let ascending = p.windows(2).all(|w| w[1] - w[0] >= 1e-6);
                if p.len() < 2 || p.len() > 1000 || !ascending {
                    return Err(at.fault(format!(
                        "`coordinates` along {} must be 2 to 1000 numbers, each at least 1e-6 m above the one before",
                        ["x", "y", "z"][k]
                    )));
                }
            }
            Ok(planes.clone())
        }
        _ => Err(at.fault("a lattice needs `size` with `cells`, or `coordinates`")),
    }
}

fn nodes([x, y, z]: &[Vec<f64>; 3]) -> Vec<Vec3> {
    let mut nodes = Vec::with_capacity(x.len() * y.len() * z.len());
    for &c in z {
        for &b in y {
            nodes.extend(x.iter().map(|&a| Vec3::new(a, b, c)));
        }
    }
    nodes
}

fn tets(cells: [usize; 3], split: SplitWord) -> Vec<[u32; 4]> {
    let [nx, ny, nz] = cells;
    let node = |i: usize, j: usize, k: usize| (i + (nx + 1) * (j + (ny + 1) * k)) as u32;
    let mut tets = Vec::new();
    for (k, j, i) in
        (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i))))
    {
        let corner = |c: usize| node(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1));
        match split {
            SplitWord::Kuhn => tets.extend(PATHS.iter().enumerate().map(|(p, path)| {
                let first = 1 << path[0];
                let second = first | 1 << path[1];
                let tet = [0, first, second, 7].map(corner);
                if p < 3 { tet } else { flipped(tet) } // the last three paths are odd
            })),
            SplitWord::Five => {
                let odd = (i + j + k) % 2 == 1;
                tets.extend(FIVE.iter().map(|tet| {
                    // Mirrored along x, which also turns the orientation around.
                    let tet = tet.map(|c| corner(if odd { c ^ 1 } else { c }));
                    if odd { flipped(tet) } else { tet }
                }));
            }
        }
    }
    tets
}

fn flipped([a, b, c, d]: [u32; 4]) -> [u32; 4] {
    [a, c, b, d]
}

/// Moves inner nodes by up to a part of the smallest cell beside them.
fn jitter(nodes: &mut [Vec3], planes: &[Vec<f64>; 3], shape: &LatticeShape) {
    let mut random = Random::new(u64::from(shape.seed));
    let counts = planes.each_ref().map(Vec::len);
    for (n, node) in nodes.iter_mut().enumerate() {
        let index = [n % counts[0], n / counts[0] % counts[1], n / counts[0] / counts[1]];
        let inner = (0..3).all(|k| index[k] > 0 && index[k] + 1 < counts[k]);
        for k in 0..3 {
            let draw = random.symmetric();
            if inner {
                let p = &planes[k][index[k] - 1..=index[k] + 1];
                node[k] += draw * shape.jitter * (p[1] - p[0]).min(p[2] - p[1]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::boundary;
    use super::*;
    use crate::text::Place;

    fn lattice(cells: [u32; 3], split: SplitWord, jitter: f64) -> Tets {
        let shape = LatticeShape {
            size: Some(Vec3::new(3.0, 2.0, 1.0)),
            cells: Some(cells),
            coordinates: None,
            split,
            jitter,
            seed: 1,
        };
        let at = At { value: (), place: Place::Text(0..0), key: String::new() };
        build(&shape, &at).unwrap()
    }

    #[test]
    fn tetrahedra_fill_the_box_without_gap_or_overlap() {
        for (split, per_cell) in [(SplitWord::Kuhn, 6), (SplitWord::Five, 5)] {
            for jitter in [0.0, 0.3] {
                let (nodes, tets) = lattice([3, 4, 5], split, jitter);
                assert_eq!(tets.len(), 60 * per_cell);
                assert_eq!(nodes.len(), 4 * 5 * 6);
                let volume =
                    |t: &[u32; 4]| boundary::determinant(&t.map(|n| nodes[n as usize])) / 6.0;
                assert!(tets.iter().all(|t| volume(t) > 0.0));
                let total: f64 = tets.iter().map(volume).sum();
                assert!((total - 6.0).abs() < 1e-12, "{total}");
                // Conforming: the boundary has two triangles for each cell face and nothing inside.
                let faces = boundary::faces(&tets);
                assert_eq!(faces.len(), 2 * 2 * (12 + 15 + 20));
                let area: Vec3 = faces
                    .iter()
                    .map(|f| boundary::area_vector(&f.nodes.map(|n| nodes[n as usize])))
                    .sum();
                assert!(area.norm() < 1e-12);
                let outward: f64 = faces
                    .iter()
                    .map(|f| {
                        let x = f.nodes.map(|n| nodes[n as usize]);
                        boundary::area_vector(&x).dot(&(x[0] + x[1] + x[2])) / 9.0
                    })
                    .sum();
                assert!((outward - 6.0).abs() < 1e-12, "divergence theorem: {outward}");
            }
        }
    }

    #[test]
    fn kuhn_cells_share_the_main_diagonal() {
        let (_, tets) = lattice([1, 1, 1], SplitWord::Kuhn, 0.0);
        assert!(tets.iter().all(|t| t.contains(&0) && t.contains(&7)));
    }
}
