//! A box of cells cut into tetrahedra.

use super::assets::unit;
use crate::format::{LatticeShape, SplitWord};
use crate::math::Vec3;
use crate::session::Random;
use crate::text::{Fault, Located};
use thenar_rig::object::{Cubes, SoftModel, SoftOptions, graded_block};

/// Most cells of a lattice.
const CELLS_MAX: usize = 200_000;

/// Builds the lattice, of material 1.
///
/// # Errors
/// It is not clear what is wanted, or it is too large.
pub fn build(shape: &LatticeShape, at: &Located<impl Sized>) -> Result<SoftModel, Fault> {
    let planes = planes(shape, at)?;
    let cells = planes.each_ref().map(|p| p.len() - 1);
    if cells.iter().product::<usize>() > CELLS_MAX {
        return Err(at.fault(format!("expected at most {CELLS_MAX} cells, got {cells:?}")));
    }
    let cubes = match shape.split {
        SplitWord::Kuhn => Cubes::Kuhn6,
        SplitWord::Five => Cubes::Five,
    };
    let [x, y, z] = &planes;
    let mut model = graded_block(x, y, z, cubes, |_| unit(), &SoftOptions::default())
        .map_err(|e| at.fault(e.to_string()))?;
    if shape.jitter > 0.0 {
        jitter(&mut model.flesh.nodes, &planes, shape);
    }
    Ok(model)
}

fn planes(shape: &LatticeShape, at: &Located<impl Sized>) -> Result<[Vec<f64>; 3], Fault> {
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

/// Moves inner nodes by up to a part of the smallest cell beside them; up to 0.15 of it no element
/// turns inside out.
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
    use super::*;
    use crate::text::SourcePlace;

    fn sixfold_volume(x: [Vec3; 4]) -> f64 {
        (x[1] - x[0]).cross(&(x[2] - x[0])).dot(&(x[3] - x[0]))
    }

    #[test]
    fn jitter_moves_inner_nodes_only_and_inverts_nothing() {
        for (split, seed) in [(SplitWord::Kuhn, 1), (SplitWord::Five, 2), (SplitWord::Kuhn, 3)] {
            let mut shape = LatticeShape {
                size: Some(Vec3::new(3.0, 2.0, 1.0)),
                cells: Some([5, 6, 7]),
                coordinates: None,
                split,
                jitter: 0.0,
                seed,
            };
            let at = Located { value: (), place: SourcePlace::Text(0..0), key: String::new() };
            let regular = build(&shape, &at).unwrap().flesh;
            shape.jitter = 0.15;
            let moved = build(&shape, &at).unwrap().flesh;
            let mut count = 0;
            for (a, b) in regular.nodes.iter().zip(&moved.nodes) {
                let half = Vec3::new(1.5, 1.0, 0.5);
                let inner = (0..3).all(|k| a[k].abs() < half[k] - 1e-9);
                assert_eq!(inner, (a - b).norm() > 0.0);
                count += usize::from(inner);
            }
            assert_eq!(count, 4 * 5 * 6);
            let volume = |t: &[u32; 4]| sixfold_volume(t.map(|n| moved.nodes[n as usize])) / 6.0;
            assert!(moved.tets.iter().all(|t| volume(t) > 0.0));
            let total: f64 = moved.tets.iter().map(volume).sum();
            assert!((total - 6.0).abs() < 1e-12, "{total}");
        }
    }
}
