//! Cholesky factor of the flesh matrix, `K_ww = B + G = L Lᵀ`, by supernodes, right-looking: each
//! panel is factored, and its outer product is taken off the panels of later ones.

use crate::solver::exact::System;
use crate::solver::exact::dense;
use crate::solver::exact::symbolic::{Supernode, Symbolic};

/// Numbers of the factor. Single precision halves the memory and doubles the speed; conjugate
/// gradients in double precision around it give back the accuracy.
pub type Scalar = f32;

/// Right-hand sides solved together.
pub const LANES: usize = 16;
/// One number of each of them.
pub type Lanes = [Scalar; LANES];

/// The factor, and work space to compute it and solve with it.
#[derive(Clone, Debug)]
pub struct Factor {
    /// Its structure.
    pub symbolic: Symbolic,
    panels: Vec<Scalar>,
    /// The outer product of one supernode.
    update: Vec<Scalar>,
    /// One right-hand side, in elimination order.
    x: Vec<Scalar>,
    below: Vec<Scalar>,
    /// Many right-hand sides: rows of three per place.
    pub many: Vec<Lanes>,
    /// Supernodes that the many right-hand sides reach going up.
    reached: Vec<bool>,
    /// Supernodes at which the many solutions are wanted.
    pub wanted: Vec<bool>,
}

impl Factor {
    /// Room for a factor of this structure.
    pub fn new(symbolic: Symbolic) -> Self {
        let n = 3 * symbolic.place_of_node.len();
        let below = 3 * symbolic.below_max;
        Self {
            panels: vec![0.0; symbolic.size],
            update: vec![0.0; below * below],
            x: vec![0.0; n],
            below: vec![0.0; below],
            many: vec![[0.0; LANES]; n],
            reached: vec![false; symbolic.supernodes.len()],
            wanted: vec![true; symbolic.supernodes.len()],
            symbolic,
        }
    }

    /// Factors the matrix; false when a pivot is not positive.
    pub fn refresh(&mut self, system: &System<'_>) -> bool {
        self.load(system);
        for s in 0..self.symbolic.supernodes.len() {
            let node = self.symbolic.supernodes[s];
            let (height, width) = (node.height(), 3 * node.pivots);
            let panel = &mut self.panels[node.panel..node.panel + width * height];
            if !dense::factor_panel(panel, height, width) {
                return false;
            }
            if node.below > 0 {
                dense::outer_product(panel, height, width, &mut self.update);
                self.subtract_update(&node);
            }
        }
        true
    }

    fn load(&mut self, system: &System<'_>) {
        self.panels.fill(0.0);
        for load in &self.symbolic.loads {
            let block = &system.A.blocks[load.entry as usize];
            for c in 0..3 {
                let at = load.place as usize + c * load.height as usize;
                for r in 0..3 {
                    self.panels[at + r] = block[3 * c + r] as Scalar;
                }
            }
        }
        let row0 = 2 * system.bodies.bodies();
        for (n, spring) in system.springs.iter().enumerate() {
            let (at, height) = self.symbolic.diagonals[n];
            let spring = system.unknown(row0 + n, &crate::math::Vec3::repeat(*spring));
            for k in 0..3 {
                self.panels[at as usize + k * (height as usize + 1)] += spring[k] as Scalar;
            }
        }
    }

    fn subtract_update(&mut self, node: &Supernode) {
        let m = 3 * node.below;
        for segment in &self.symbolic.segments[node.segments[0]..node.segments[1]] {
            let target = self.symbolic.supernodes[segment.target as usize];
            let height = target.height();
            let places = &self.symbolic.places[segment.places..];
            for column in segment.begin..segment.end {
                let first_column = 3 * places[column - segment.begin] as usize;
                for c in 0..3 {
                    let at = target.panel + (first_column + c) * height;
                    let to = &mut self.panels[at..at + height];
                    let from = &self.update[(3 * column + c) * m..(3 * column + c + 1) * m];
                    for row in column..node.below {
                        let place = 3 * places[row - segment.begin] as usize;
                        for r in 0..3 {
                            to[place + r] -= from[3 * row + r];
                        }
                    }
                }
            }
        }
    }

    /// Solves for one right-hand side per node, in place.
    pub fn solve(&mut self, w: &mut [crate::math::Vec3]) {
        for (w, place) in w.iter().zip(&self.symbolic.place_of_node) {
            for k in 0..3 {
                self.x[3 * *place as usize + k] = w[k] as Scalar;
            }
        }
        for node in &self.symbolic.supernodes {
            let (height, width) = (node.height(), 3 * node.pivots);
            let panel = &self.panels[node.panel..node.panel + width * height];
            let rows = &self.symbolic.rows[node.rows..node.rows + node.below];
            let below = &mut self.below[..3 * node.below];
            below.fill(0.0);
            let x = &mut self.x[3 * node.first..3 * node.first + width];
            dense::forward(panel, height, x, below);
            for (row, below) in rows.iter().zip(below.chunks_exact(3)) {
                for k in 0..3 {
                    self.x[3 * *row as usize + k] -= below[k];
                }
            }
        }
        for node in self.symbolic.supernodes.iter().rev() {
            let (height, width) = (node.height(), 3 * node.pivots);
            let panel = &self.panels[node.panel..node.panel + width * height];
            let rows = &self.symbolic.rows[node.rows..node.rows + node.below];
            let below = &mut self.below[..3 * node.below];
            for (row, below) in rows.iter().zip(below.chunks_exact_mut(3)) {
                below.copy_from_slice(&self.x[3 * *row as usize..3 * *row as usize + 3]);
            }
            let x = &mut self.x[3 * node.first..3 * node.first + width];
            dense::backward(panel, height, x, below);
        }
        for (w, place) in w.iter_mut().zip(&self.symbolic.place_of_node) {
            for k in 0..3 {
                w[k] = self.x[3 * *place as usize + k] as f64;
            }
        }
    }

    /// Marks no supernode as wanted.
    pub fn want_none(&mut self) {
        self.wanted.fill(false);
    }

    /// Wants the many solutions at this node, and so at all it depends on.
    pub fn want(&mut self, node: usize) {
        let place = self.symbolic.place_of_node[node] as usize;
        let mut next = Some(self.symbolic.supernode_of[place]);
        while let Some(s) = next {
            if std::mem::replace(&mut self.wanted[s as usize], true) {
                break;
            }
            next = self.symbolic.supernodes[s as usize].parent;
        }
    }

    /// Sets the many right-hand sides to zero.
    pub fn clear_many(&mut self) {
        self.many.fill([0.0; LANES]);
        self.reached.fill(false);
    }

    /// The three rows of a node in the many right-hand sides; they become part of the problem.
    pub fn many_mut(&mut self, node: usize) -> &mut [Lanes] {
        let place = self.symbolic.place_of_node[node] as usize;
        self.reached[self.symbolic.supernode_of[place] as usize] = true;
        &mut self.many[3 * place..3 * place + 3]
    }

    /// The three rows of a node in the many solutions.
    pub fn many_of(&self, node: usize) -> &[Lanes] {
        let place = self.symbolic.place_of_node[node] as usize;
        &self.many[3 * place..3 * place + 3]
    }

    /// Solves for the many right-hand sides in place, at the wanted nodes only.
    pub fn solve_many(&mut self) {
        for s in 0..self.symbolic.supernodes.len() {
            if !self.reached[s] {
                continue;
            }
            let node = &self.symbolic.supernodes[s];
            if let Some(parent) = node.parent {
                self.reached[parent as usize] = true;
            }
            let (height, width) = (node.height(), 3 * node.pivots);
            let panel = &self.panels[node.panel..node.panel + width * height];
            let rows = &self.symbolic.rows[node.rows..node.rows + node.below];
            dense::forward_many(panel, height, width, 3 * node.first, rows, &mut self.many);
        }
        for s in (0..self.symbolic.supernodes.len()).rev() {
            if !self.wanted[s] {
                continue;
            }
            let node = &self.symbolic.supernodes[s];
            let (height, width) = (node.height(), 3 * node.pivots);
            let panel = &self.panels[node.panel..node.panel + width * height];
            let rows = &self.symbolic.rows[node.rows..node.rows + node.below];
            dense::backward_many(panel, height, width, 3 * node.first, rows, &mut self.many);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::solver::BlockMatrix;
    use crate::solver::exact::Reduction;
    use crate::testing::Random;

    /// Blocks of nodes on a lattice, two of them side by side without touching: the solution must be
    /// the one the right-hand side was made from.
    #[test]
    fn solves_what_it_factored() {
        for cells in [[1, 1, 1], [2, 2, 2], [7, 3, 2], [12, 2, 2]] {
            let mut random = Random::new(11);
            let mut positions = Vec::new();
            for part in 0..2 {
                for i in 0..=cells[0] {
                    for j in 0..=cells[1] {
                        for k in 0..=cells[2] {
                            let at = Vec3::new(f64::from(i), f64::from(j), f64::from(k));
                            positions.push(at + Vec3::z() * 10.0 * f64::from(part));
                        }
                    }
                }
            }
            let n = positions.len();
            let near = |a: usize, b: usize| (positions[a] - positions[b]).norm() < 1.5;
            let pairs = (0..n).flat_map(|a| (0..a).map(move |b| (a, b)));
            let pairs: Vec<_> = pairs.filter(|&(a, b)| near(a, b)).collect();
            let numbers = pairs.iter().map(|&(a, b)| (a as u32, b as u32));
            let mut A = BlockMatrix::with_pattern(n, numbers);
            for &(a, b) in &pairs {
                let direction = random.vec3(1.0);
                let block = direction * direction.transpose();
                for (i, j, sign) in [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)] {
                    A.add(A.entry(i as u32, j as u32), &(block * sign));
                }
            }
            (0..n).for_each(|a| A.add_scalar(A.diagonal[a], 0.05));
            let springs: Vec<f64> = (0..n).map(|_| random.range(0.0, 0.1)).collect();
            let bodies = Reduction::new(&[], &[], &[], &[]);
            let split: Vec<u32> = A.row_start[..n].to_vec();
            let known = vec![[false; 3]; n];
            let system = System {
                A: &A,
                split: &split,
                bodies: &bodies,
                carried: &[],
                known: &known,
                springs: &springs,
            };
            let mut factor = Factor::new(Symbolic::new(&A, 0, &positions));
            assert!(factor.refresh(&system));
            let want: Vec<Vec3> = (0..n).map(|_| random.vec3(1.0)).collect();
            let mut x: Vec<Vec3> =
                (0..n).map(|i| A.row_times(i, &want) + want[i] * springs[i]).collect();
            let rhs = x.clone();
            factor.solve(&mut x);
            let error = x.iter().zip(&want).map(|(x, w)| (x - w).norm()).fold(0.0, f64::max);
            assert!(error < 1e4 * f64::from(Scalar::EPSILON), "{cells:?}: {error}");
            factor.clear_many();
            for (i, r) in rhs.iter().enumerate() {
                (0..3).for_each(|k| factor.many_mut(i)[k][5] = r[k] as Scalar);
            }
            factor.solve_many();
            for (i, x) in x.iter().enumerate() {
                for k in 0..3 {
                    let lane = f64::from(factor.many_of(i)[k][5]);
                    assert!((lane - x[k]).abs() < 1e4 * f64::from(Scalar::EPSILON));
                }
            }
        }
    }
}
