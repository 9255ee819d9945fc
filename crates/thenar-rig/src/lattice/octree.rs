//! A balanced octree: cubes that halve where the body wants smaller elements.
//!
//! Two leaves that share a face or an edge differ by a factor of two at most, the weak balance that
//! the transition tetrahedra of `graded` need (Labelle & Shewchuk 2007, section 3).

use crate::RigError;
use thenar_core::Vec3;

/// Cubes that the finest level may have: a byte of memory each, about.
const CUBES_MAX: f64 = 1e8;

/// A cube of the tree: its level, 0 the coarsest, and its place among those of its level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Octant {
    pub level: usize,
    pub at: [i32; 3],
}

impl Octant {
    /// The cube of the same size `by` cubes further.
    pub fn beside(&self, by: [i32; 3]) -> Self {
        Self { level: self.level, at: std::array::from_fn(|d| self.at[d] + by[d]) }
    }

    /// The cube of twice the size around it. Not for the coarsest.
    fn parent(&self) -> Self {
        Self { level: self.level - 1, at: self.at.map(|x| x.div_euclid(2)) }
    }
}

/// Cubes over a box, some of them split.
pub(super) struct Octree {
    /// Low corner of the box \[m\].
    origin: Vec3,
    /// Edge of the coarsest cubes \[m\].
    coarse: f64,
    /// Coarsest cubes along x, y, z.
    dims: [usize; 3],
    /// Per level but the finest: whether each cube is split (x fastest).
    split: Vec<Vec<bool>>,
}

impl Octree {
    /// Cubes of edge `coarse` over the box from `low` to `high`, with one around it on every side,
    /// that are halved up to `levels` times.
    ///
    /// # Errors
    /// The box is too large for cubes of this size.
    pub fn new([low, high]: [Vec3; 2], coarse: f64, levels: usize) -> Result<Self, RigError> {
        let extent = (high - low) / coarse;
        let cubes =
            extent.iter().map(|x| x.ceil() + 2.0).product::<f64>() * 8_f64.powi(levels as i32);
        if cubes.is_nan() || cubes > CUBES_MAX {
            return Err(RigError::invalid("the mesh is too large for elements of this size"));
        }
        let dims: [usize; 3] = std::array::from_fn(|d| extent[d].ceil() as usize + 2);
        let half = Vec3::from(dims.map(|n| n as f64)) * (coarse / 2.0);
        let count = dims.iter().product::<usize>();
        let split = (0..levels).map(|level| vec![false; count << (3 * level)]).collect();
        Ok(Self { origin: (low + high) / 2.0 - half, coarse, dims, split })
    }

    /// Times that the coarsest cubes may be halved.
    pub fn levels(&self) -> usize {
        self.split.len()
    }

    /// Edge of the cubes of a level \[m\].
    pub fn edge(&self, level: usize) -> f64 {
        self.coarse / (1_u32 << level) as f64
    }

    /// Low corner of the box \[m\].
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Splits the cubes around `p` until they are no larger than `edge`, or as small as they get.
    pub fn refine(&mut self, p: &Vec3, edge: f64) {
        for level in 0..self.levels() {
            if self.edge(level) <= edge {
                return;
            }
            let around = self.around(p, level);
            if let Some(i) = self.index(&around) {
                self.split[level][i] = true;
            }
        }
    }

    /// Splits more cubes until leaves that share a face or an edge differ by a factor of two at
    /// most.
    pub fn balance(&mut self) {
        for level in (1..self.levels()).rev() {
            let dims = self.dims.map(|n| (n << level) as i32);
            for z in 0..dims[2] {
                for y in 0..dims[1] {
                    for x in 0..dims[0] {
                        let octant = Octant { level, at: [x, y, z] };
                        if self.is_split(&octant) {
                            self.split_around(&octant);
                        }
                    }
                }
            }
        }
    }

    /// Makes every cube as large as `octant` that shares a face or an edge with it exist.
    fn split_around(&mut self, octant: &Octant) {
        for code in 0..27 {
            let by = [code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1];
            // Those at the corners alone may be larger.
            if by.iter().all(|b| *b != 0) {
                continue;
            }
            let parent = octant.beside(by).parent();
            if let Some(i) = self.index(&parent) {
                self.split[parent.level][i] = true;
            }
        }
    }

    /// The leaf that holds `p`, and where in it: from -½ to ½ of its edge along each axis.
    pub fn leaf(&self, p: &Vec3) -> (Octant, Vec3) {
        let mut octant = self.around(p, 0);
        while self.is_split(&octant) {
            octant = self.around(p, octant.level + 1);
        }
        let u = (p - self.origin) / self.edge(octant.level);
        (octant, u - Vec3::from(octant.at.map(f64::from)) - Vec3::repeat(0.5))
    }

    /// True if a cube is halved. Nothing outside the box is.
    pub fn is_split(&self, octant: &Octant) -> bool {
        octant.level < self.levels()
            && self.index(octant).is_some_and(|i| self.split[octant.level][i])
    }

    /// True if a cube is there, as a leaf or halved; if not, a larger one is in its place.
    pub fn exists(&self, octant: &Octant) -> bool {
        octant.level == 0 || self.is_split(&octant.parent())
    }

    fn around(&self, p: &Vec3, level: usize) -> Octant {
        let u = (p - self.origin) / self.edge(level);
        Octant { level, at: std::array::from_fn(|d| u[d].floor() as i32) }
    }

    fn index(&self, octant: &Octant) -> Option<usize> {
        let dims = self.dims.map(|n| n << octant.level);
        let inside = (0..3).all(|d| octant.at[d] >= 0 && (octant.at[d] as usize) < dims[d]);
        let [x, y, z] = octant.at.map(|x| x as usize);
        inside.then(|| (z * dims[1] + y) * dims[0] + x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cubes of 1 m over 4 m, split down to 1/16 m around one place.
    fn tree() -> Octree {
        let mut tree = Octree::new([Vec3::zeros(), Vec3::repeat(4.0)], 1.0, 4).unwrap();
        tree.refine(&Vec3::new(1.3, 2.1, 0.7), 1.0 / 16.0);
        tree.balance();
        tree
    }

    #[test]
    fn leaves_that_share_a_face_or_an_edge_differ_by_two_at_most() {
        let tree = tree();
        let mut levels = [0; 5];
        // A lattice of places in the middle of the smallest cubes finds all leaves.
        let place = |k: usize| (k as f64 + 0.5) / 16.0;
        for i in 0..64 * 64 * 64 {
            let p = Vec3::new(place(i % 64), place(i / 64 % 64), place(i / 4096));
            let (leaf, within) = tree.leaf(&p);
            levels[leaf.level] += 1;
            assert!(within.amax() < 0.5);
            for code in (0..27).filter(|code| [code % 3, code / 3 % 3, code / 9].contains(&1)) {
                let beside = leaf.beside([code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1]);
                // As large, or halved once, or within a leaf of twice the size.
                assert!(!tree.exists(&beside) || !tree.is_split(&beside) || leaf.level < 4);
                assert!(
                    tree.exists(&beside) || tree.exists(&beside.parent()),
                    "{leaf:?} {beside:?}"
                );
            }
        }
        assert!(levels.iter().all(|n| *n > 0), "{levels:?}");
    }

    #[test]
    fn a_place_has_the_edge_asked_for() {
        for (edge, level) in [(2.0, 0), (1.0, 0), (0.6, 1), (0.25, 2), (1e-3, 4)] {
            let mut tree = Octree::new([Vec3::zeros(), Vec3::repeat(4.0)], 1.0, 4).unwrap();
            let p = Vec3::new(1.3, 2.1, 0.7);
            tree.refine(&p, edge);
            tree.balance();
            assert_eq!(tree.leaf(&p).0.level, level);
        }
    }
}
