//! Blocks of tetrahedra on a rectangular lattice.

use super::soft::{SoftModel, SoftOptions, soft_from_tets};
use crate::RigError;
use crate::error::positive;
use thenar_core::Vec3;
use thenar_core::model::Material;

/// Cut of each lattice cell into tetrahedra.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Cubes {
    /// Six tetrahedra that share the diagonal from (0,0,0) to (1,1,1) (Kuhn 1960).
    Kuhn6,
    /// Five: a regular one in the middle and four corners, mirrored in every other cell.
    Five,
}

/// Most tetrahedra of a block or a ball, so that memory stays bounded.
pub(super) const TETS_MAX: usize = 2_000_000;

/// A box of these edge lengths \[m\] and numbers of cells, centred at the origin. Node
/// `i + (nx + 1) (j + (ny + 1) k)` lies at lattice place (i, j, k). Collision and render surface
/// are its boundary.
pub fn lattice_box(
    size: &Vec3,
    cells: [u32; 3],
    pattern: Cubes,
    material: impl Fn(&Vec3) -> Material,
    options: &SoftOptions,
) -> Result<SoftModel, RigError> {
    let mut axes = [const { Vec::new() }; 3];
    for k in 0..3 {
        positive("size", size[k])?;
        let n = cells[k];
        if n == 0 || n > 10_000 {
            return Err(RigError::invalid(format!("a lattice needs 1 to 10000 cells, not {n}")));
        }
        axes[k] = (0..=n).map(|i| size[k] * (f64::from(i) / f64::from(n) - 0.5)).collect();
    }
    let [xs, ys, zs] = &axes;
    graded_block(xs, ys, zs, pattern, material, options)
}

/// A block whose lattice planes lie at these ascending coordinates \[m\]. `material` is asked at
/// each element's centroid.
pub fn graded_block(
    xs: &[f64],
    ys: &[f64],
    zs: &[f64],
    pattern: Cubes,
    material: impl Fn(&Vec3) -> Material,
    options: &SoftOptions,
) -> Result<SoftModel, RigError> {
    for axis in [xs, ys, zs] {
        if axis.len() < 2 || !axis.iter().all(|x| x.is_finite()) {
            return Err(RigError::invalid("a block needs at least two finite planes per axis"));
        }
        if let Some(pair) = axis.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(RigError::invalid(format!(
                "the planes of a block must ascend, but {} follows {}",
                pair[1], pair[0]
            )));
        }
    }
    let tets = lattice_tets([xs.len() - 1, ys.len() - 1, zs.len() - 1], pattern)?;
    let mut nodes = Vec::with_capacity(xs.len() * ys.len() * zs.len());
    for &z in zs {
        for &y in ys {
            nodes.extend(xs.iter().map(|&x| Vec3::new(x, y, z)));
        }
    }
    let centroid = |t: &[u32; 4]| t.iter().map(|&n| nodes[n as usize]).sum::<Vec3>() * 0.25;
    let materials = tets.iter().map(|t| material(&centroid(t))).collect();
    Ok(soft_from_tets("box", nodes, tets, materials, options)?.0)
}

/// The tetrahedra of a lattice of cells, positively oriented, cell after cell (x fastest).
pub(crate) fn lattice_tets(cells: [usize; 3], pattern: Cubes) -> Result<Vec<[u32; 4]>, RigError> {
    let [nx, ny, nz] = cells;
    let per_cell = cell_tets(pattern, false).len();
    let count = nx.checked_mul(ny).and_then(|n| n.checked_mul(nz)?.checked_mul(per_cell));
    if count.is_none_or(|n| n > TETS_MAX) {
        return Err(RigError::invalid(format!(
            "a lattice of {nx} x {ny} x {nz} cells has more than {TETS_MAX} tetrahedra"
        )));
    }
    let mut tets = Vec::new();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                // Corner c of the cell has bit 0 for +x, bit 1 for +y, bit 2 for +z.
                let node = |c: usize| {
                    let (i, j, k) = (i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
                    (i + (nx + 1) * (j + (ny + 1) * k)) as u32
                };
                let mirrored = (i + j + k) % 2 == 1;
                tets.extend(cell_tets(pattern, mirrored).iter().map(|t| t.map(node)));
            }
        }
    }
    Ok(tets)
}

/// ```text
///      6-----7
///     /|    /|        y
///    4-----5 |        |
///    | 2---|-3        +-- x
///    |/    |/        /
///    0-----1        z       (bits: 1 = +x, 2 = +y, 4 = +z; drawn with z towards the reader,
///                            so that 4-5-7-6 is the front)
/// ```
fn cell_tets(pattern: Cubes, mirrored: bool) -> &'static [[usize; 4]] {
    match (pattern, mirrored) {
        // One per order of walking the three axes from 0 to 7; odd orders are turned.
        (Cubes::Kuhn6, _) => {
            &[[0, 1, 3, 7], [0, 5, 1, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 6, 4, 7]]
        }
        (Cubes::Five, false) => {
            &[[0, 1, 2, 4], [3, 2, 1, 7], [5, 4, 7, 1], [6, 7, 4, 2], [1, 2, 4, 7]]
        }
        (Cubes::Five, true) => {
            &[[1, 0, 5, 3], [2, 3, 6, 0], [4, 5, 0, 6], [7, 6, 3, 5], [0, 5, 3, 6]]
        }
    }
}

/// Coordinates from `from` to `to` \[m\] whose steps begin with about `first` and grow by at most
/// `ratio` from one to the next. For blocks that are fine where they are touched.
pub fn graded(from: f64, to: f64, first: f64, ratio: f64) -> Result<Vec<f64>, RigError> {
    positive("first step", first)?;
    if !(ratio >= 1.0 && ratio.is_finite() && from.is_finite() && to.is_finite()) {
        return Err(RigError::Parameter { name: "ratio", expected: "at least 1", value: ratio });
    }
    let length = (to - from).abs();
    let mut steps = Vec::new();
    let mut reached = 0.0;
    while reached < length * (1.0 - 1e-9) {
        if steps.len() >= 10_000 {
            return Err(RigError::invalid("more than 10000 graded steps"));
        }
        steps.push(first * ratio.powi(steps.len() as i32));
        reached += steps[steps.len() - 1];
    }
    let stretch = (to - from) / reached;
    let mut x = from;
    let mut planes = vec![from];
    for (i, step) in steps.iter().enumerate() {
        x += step * stretch;
        planes.push(if i + 1 == steps.len() { to } else { x });
    }
    Ok(planes)
}
