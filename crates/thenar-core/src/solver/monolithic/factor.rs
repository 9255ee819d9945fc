//! Cholesky factor of the flesh matrix, `K_ww = B + G = L Lᵀ`, by supernodes, right-looking: each
//! panel is factored, and its outer product is taken off the panels of later ones.

use crate::math::Vec3;
use crate::solver::monolithic::aligned::Aligned;
use crate::solver::monolithic::symbolic::{Supernode, Symbolic};
use crate::solver::monolithic::{System, dense, substitution};
use fearless_simd::{Level, Simd, dispatch};

/// Numbers of the factor. Single precision halves the memory and doubles the speed; conjugate
/// gradients in double precision around it give back the accuracy.
pub type Scalar = f32;

/// Numbers in a register, and right-hand sides solved together.
pub const LANES: usize = 16;
/// One number of each of them.
pub type Lanes = [Scalar; LANES];

/// The largest number of a right-hand side comes between half of this and this, so that what
/// follows from it is far from both ends of single precision. Processors are slow with subnormal
/// numbers: solves of the default hand took 14 times as long.
const LARGEST: f64 = (1_u64 << 32) as f64;
/// Smaller numbers of such a right-hand side count as zero: those below 2⁻⁶⁴ of the largest. What
/// is left of earlier steps in a body that nothing touches is 10⁴⁰ times smaller than what a
/// contact elsewhere does. The last change of a solve is at most 2·10⁴ times its tolerance
/// (`RATE_MIN` in `pcg`), so that what is dropped of a light body beside a heavy one comes to less
/// than the tolerance, if their inertias differ by less than 10¹⁵.
const SMALLEST: f64 = 1.0 / LARGEST;

/// The factor, and work space to compute it and solve with it.
#[derive(Clone, Debug)]
pub struct Factor {
    /// Structure of the factor.
    pub symbolic: Symbolic,
    /// The vector instructions that this machine has.
    pub level: Level,
    panels: Aligned<Scalar>,
    /// The outer product of one supernode.
    update: Aligned<Scalar>,
    /// Right-hand side in elimination order, times `scale`.
    pub x: Vec<Scalar>,
    /// Power of two by which the right-hand side is multiplied.
    scale: f64,
    /// The rows of the right-hand side that one supernode reads or changes.
    column: Aligned<Scalar>,
}

impl Factor {
    /// Room for a factor of this structure.
    pub fn new(symbolic: Symbolic) -> Self {
        let n = 3 * symbolic.place_of_node.len();
        let update = |node: &Supernode| 3 * node.below * node.update_stride();
        let update = symbolic.supernodes.iter().map(update).max().unwrap_or(0);
        let column = symbolic.supernodes.iter().map(Supernode::stride).max().unwrap_or(0);
        Self {
            level: Level::new(),
            panels: Aligned::new(symbolic.size),
            update: Aligned::new(update),
            x: vec![0.0; n],
            scale: 1.0,
            column: Aligned::new(column),
            symbolic,
        }
    }

    /// Factors the matrix; false when a pivot is not positive.
    pub fn refresh(&mut self, system: &System<'_>) -> bool {
        let nodes = self.symbolic.place_of_node.len();
        debug_assert_eq!(system.springs.len(), nodes, "springs, nodes planned for");
        debug_assert_eq!(system.A.rows(), 2 * system.bodies.bodies() + nodes, "block rows");
        self.load(system);
        dispatch!(self.level, simd => self.factor(simd))
    }

    #[inline(always)]
    fn factor<S: Simd>(&mut self, simd: S) -> bool {
        for s in 0..self.symbolic.supernodes.len() {
            let node = self.symbolic.supernodes[s];
            let (stride, width) = (node.stride(), node.width());
            let panel = &mut self.panels[node.panel()];
            if !dense::factor_panel(simd, panel, stride, width) {
                return false;
            }
            if node.below > 0 {
                dense::outer_product(simd, panel, stride, node.height(), width, &mut self.update);
                self.subtract_update(simd, &node);
            }
        }
        true
    }

    fn load(&mut self, system: &System<'_>) {
        for node in &self.symbolic.supernodes {
            let panel = &mut self.panels[node.panel()];
            bytemuck::fill_zeroes(panel);
            let stride = node.stride();
            for load in &self.symbolic.loads[node.loads[0]..node.loads[1]] {
                let block = &system.A.blocks[load.entry as usize];
                for c in 0..3 {
                    let column = &mut panel[load.place as usize + c * stride..][..3];
                    for r in 0..3 {
                        column[r] = block[3 * c + r] as Scalar;
                    }
                }
            }
        }
        let row0 = 2 * system.bodies.bodies();
        for (n, spring) in system.springs.iter().enumerate() {
            let (at, stride) = self.symbolic.diagonals[n];
            let spring = system.unknown(row0 + n, &Vec3::repeat(*spring));
            for k in 0..3 {
                self.panels[at as usize + k * (stride as usize + 1)] += spring[k] as Scalar;
            }
        }
    }

    #[inline(always)]
    fn subtract_update<S: Simd>(&mut self, simd: S, node: &Supernode) {
        let (stride, offset) = (node.update_stride(), node.update_offset());
        for segment in &self.symbolic.segments[node.segments[0]..node.segments[1]] {
            let target = self.symbolic.supernodes[segment.target as usize];
            let panel = &mut self.panels[target.panel().start..];
            let runs = &self.symbolic.runs[segment.runs[0]..segment.runs[1]];
            for (r, columns) in runs.iter().enumerate() {
                let rows = columns.rows();
                // The columns of a node have their rows in common.
                for column in (rows.start..rows.end.min(3 * segment.end)).step_by(3) {
                    let place = columns.place + column - rows.start;
                    let from = &self.update[column * stride + offset..];
                    let to = &mut panel[place * target.stride()..];
                    let strides = [stride, target.stride()];
                    // The lower triangle only.
                    for c in 0..3 {
                        let from = &from[c * strides[0]..][column + c..rows.end];
                        dense::take_off(simd, from, &mut to[c * strides[1] + place + c..]);
                    }
                    for run in &runs[r + 1..] {
                        let (from, to) = (&from[run.row..], &mut to[run.place..]);
                        dense::take_off_columns(simd, from, to, strides, run.length);
                    }
                }
            }
        }
    }

    /// Brings a right-hand side per node into elimination order and to the factor's scale;
    /// `largest` is the largest of its numbers and of those that bodies have beside it.
    pub fn gather(&mut self, w: &[Vec3], largest: f64) {
        debug_assert_eq!(w.len(), self.symbolic.place_of_node.len(), "nodes, planned for");
        self.scale = scale_of(largest);
        for (n, w) in w.iter().enumerate() {
            let place = self.symbolic.place_of_node[n] as usize;
            for k in 0..3 {
                self.x[3 * place + k] = self.scaled(w[k]);
            }
        }
    }

    /// A number beside the right-hand side at the factor's scale.
    pub fn scaled(&self, value: f64) -> Scalar {
        let value = value * self.scale;
        if value.abs() < SMALLEST { 0.0 } else { value as Scalar }
    }

    /// A number at the factor's scale, brought back.
    pub fn unscaled(&self, value: Scalar) -> f64 {
        f64::from(value) / self.scale
    }

    /// Brings the solution back.
    pub fn spread(&self, w: &mut [Vec3]) {
        for (w, place) in w.iter_mut().zip(&self.symbolic.place_of_node) {
            for k in 0..3 {
                w[k] = self.unscaled(self.x[3 * *place as usize + k]);
            }
        }
    }

    /// `x = L⁻¹ x`.
    pub fn forward(&mut self) {
        let Self { symbolic, level, panels, x, column, .. } = self;
        dispatch!(*level, simd => for node in &symbolic.supernodes {
            let rows = &symbolic.rows[node.rows..node.rows + node.below];
            let below = node.width()..node.height();
            let column = &mut column[..node.stride()];
            column.fill(0.0);
            substitution::forward(simd, &panels[node.panel()], &mut x[node.pivots()], column);
            for (row, change) in rows.iter().zip(column[below].as_chunks::<3>().0) {
                for k in 0..3 {
                    x[3 * *row as usize + k] += change[k];
                }
            }
        });
    }

    /// `x = L⁻ᵀ x`.
    pub fn backward(&mut self) {
        let Self { symbolic, level, panels, x, column, .. } = self;
        dispatch!(*level, simd => for node in symbolic.supernodes.iter().rev() {
            let rows = &symbolic.rows[node.rows..node.rows + node.below];
            let below = node.width()..node.height();
            let column = &mut column[..node.stride()];
            column[below.end..].fill(0.0);
            for (row, value) in rows.iter().zip(column[below].as_chunks_mut::<3>().0) {
                value.copy_from_slice(&x[3 * *row as usize..3 * *row as usize + 3]);
            }
            substitution::backward(simd, &panels[node.panel()], &mut x[node.pivots()], column);
        });
    }

    /// `x = L⁻¹ x` for many right-hand sides, in elimination order; `reached` tells which
    /// supernodes hold any, and then which the results do.
    pub fn forward_many(&self, x: &mut [Lanes], reached: &mut [bool]) {
        let Self { symbolic, level, panels, .. } = self;
        dispatch!(*level, simd => for (s, node) in symbolic.supernodes.iter().enumerate() {
            if !reached[s] {
                continue;
            }
            if let Some(parent) = node.parent {
                reached[parent as usize] = true;
            }
            let rows = &symbolic.rows[node.rows..node.rows + node.below];
            substitution::forward_many(simd, &panels[node.panel()], node, rows, x);
        });
    }
}

/// The power of two that brings a number between half of [`LARGEST`] and that.
fn scale_of(largest: f64) -> f64 {
    if !(f64::MIN_POSITIVE * LARGEST..f64::MAX).contains(&largest) {
        return 1.0;
    }
    // The mantissa away: the power of two at or below it, and exact.
    let power = f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits());
    0.5 * LARGEST / power
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::solver::BlockMatrix;
    use crate::solver::monolithic::Reduction;
    use crate::solver::monolithic::half_solves::{HalfSolves, add_common_product};

    /// Blocks of nodes on a lattice, two of them side by side without touching: the solution must
    /// be the one the right-hand side was made from.
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
                // Blocks between two nodes that are not symmetric: read transposed they would be
                // others.
                let ends = [(a, random.vector(1.0)), (b, -random.vector(1.0))];
                for ((i, u), (j, v)) in ends.iter().flat_map(|e| ends.iter().map(move |f| (e, f))) {
                    A.add(A.entry(*i as u32, *j as u32), &(u * v.transpose()));
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
            let mut factor = Factor::new(Symbolic::new(&A, 0, &positions, true));
            assert!(factor.refresh(&system));
            let want: Vec<Vec3> = (0..n).map(|_| random.vector(1.0)).collect();
            let mut x: Vec<Vec3> =
                (0..n).map(|i| A.row_times(i, &want) + want[i] * springs[i]).collect();
            let rhs = x.clone();
            factor.gather(&x, largest(&x));
            factor.forward();
            factor.backward();
            factor.spread(&mut x);
            let error = x.iter().zip(&want).map(|(x, w)| (x - w).norm()).fold(0.0, f64::max);
            assert!(error < 1e4 * f64::from(Scalar::EPSILON), "{cells:?}: {error}");
            half_solves_give(&factor, &rhs, &x);
            solves_alike_at_any_size(&mut factor, &rhs, &x);
            takes_no_subnormal_numbers(&mut factor, &rhs, &x);
            agree_at_all_levels(factor, &system, &rhs, &x);
        }
    }

    fn largest(w: &[Vec3]) -> f64 {
        w.iter().map(|w| w.amax()).fold(0.0, f64::max)
    }

    /// A right-hand side 10¹²⁰ times as large or small, far beyond single precision, has a solution
    /// that is as much larger or smaller, to the bit.
    fn solves_alike_at_any_size(factor: &mut Factor, rhs: &[Vec3], solution: &[Vec3]) {
        for scale in [2_f64.powi(-400), 2_f64.powi(400)] {
            let mut x: Vec<Vec3> = rhs.iter().map(|r| r * scale).collect();
            factor.gather(&x, largest(&x));
            factor.forward();
            factor.backward();
            factor.spread(&mut x);
            assert!(x.iter().zip(solution).all(|(x, y)| *x == y * scale));
        }
    }

    /// Two lattices that do not touch, one with forces much smaller than the other's: its solution
    /// is as much smaller, to the bit, or zero from 10⁻⁴⁰ on, where nothing on the way to it is
    /// subnormal.
    fn takes_no_subnormal_numbers(factor: &mut Factor, rhs: &[Vec3], solution: &[Vec3]) {
        let half = rhs.len() / 2;
        let normal = |x: &[Scalar]| x.iter().all(|x| *x == 0.0 || x.is_normal());
        for (scale, left) in [(2_f64.powi(-40), 2_f64.powi(-40)), (1e-40, 0.0), (0.0, 0.0)] {
            let mut x: Vec<Vec3> = rhs.to_vec();
            x[half..].iter_mut().for_each(|x| *x *= scale);
            factor.gather(&x, largest(&x));
            assert!(normal(&factor.x), "{scale}");
            factor.forward();
            assert!(normal(&factor.x), "{scale}");
            factor.backward();
            assert!(normal(&factor.x), "{scale}");
            factor.spread(&mut x);
            assert_eq!(x[..half], solution[..half], "{scale}");
            let small = x[half..].iter().zip(&solution[half..]);
            small.for_each(|(x, y)| assert_eq!(*x, y * left, "{scale}"));
        }
    }

    /// The product of two columns' half solves is that of one column with the other's solution.
    fn half_solves_give(factor: &Factor, rhs: &[Vec3], solution: &[Vec3]) {
        let mut columns = HalfSolves::new(&factor.symbolic, 2);
        let at = rhs.len() / 2;
        for (i, r) in rhs.iter().enumerate() {
            let rows = columns.node_mut(&factor.symbolic, 0, i);
            (0..3).for_each(|k| rows[k][5] = r[k] as Scalar);
        }
        columns.node_mut(&factor.symbolic, 1, at)[1][3] = 1.0;
        (0..2).for_each(|batch| columns.half_solve(factor, batch));
        let all: Vec<u32> = (0..factor.symbolic.supernodes.len() as u32).collect();
        let mut product = [[0.0; LANES]; LANES];
        add_common_product(factor, (&columns, 0), (&columns, 1), &all, &mut product);
        let error = f64::from(product[5][3]) - solution[at].y;
        assert!(error.abs() < 1e4 * f64::from(Scalar::EPSILON), "{:?}: {error}", factor.level);
        assert!(product[4][3] == 0.0 && product[5][2] == 0.0);
    }

    /// The vector instructions of this machine and lesser ones find the same within round-off.
    fn agree_at_all_levels(mut factor: Factor, system: &System<'_>, rhs: &[Vec3], best: &[Vec3]) {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        let lesser = [
            Some(Level::baseline()),
            Level::new().as_sse2().map(Level::Sse2),
            Level::new().as_avx2().map(Level::Avx2),
        ];
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        let lesser = [Some(Level::baseline())];
        for level in lesser.into_iter().flatten() {
            factor.level = level;
            assert!(factor.refresh(system));
            factor.gather(rhs, largest(rhs));
            factor.forward();
            factor.backward();
            let mut x = rhs.to_vec();
            factor.spread(&mut x);
            let error = x.iter().zip(best).map(|(x, b)| (x - b).norm()).fold(0.0, f64::max);
            assert!(error < 1e4 * f64::from(Scalar::EPSILON), "{level:?}: {error}");
            half_solves_give(&factor, rhs, best);
        }
    }
}
