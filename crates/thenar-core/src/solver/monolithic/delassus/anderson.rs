//! Acceleration of the sweeps: Anderson's mixing of the last few.
//!
//! A sweep takes impulses x to g(x); wanted is g(x) = x. Of the last sweeps the affine combination
//! is taken whose changes f = g - x sum to the least (least squares, damped), and the next sweep
//! starts from the same combination of their results, brought back into the friction cones
//! (Anderson 1965; Walker and Ni 2011). Velocities at the contacts are affine in the impulses, so
//! they are combined alike: no product with W is needed, but for what the cones change.
//!
//! Contact is smooth only piece by piece, and a combination across a kink may lead away. So the
//! mixing is guarded: where a sweep changes more than twice the least that any has since the
//! history began, the history is dropped and plain sweeps go on.

/// Sweeps that are combined at most.
const HISTORY: usize = 15;
/// Damping of the least squares, in parts of each difference's own square: where the changes are
/// alike (load that creeps from contact to contact) it bounds how far a combination goes.
const DAMPING: f64 = 0.02;
/// A sweep that changes so much more than the best of the history ends it.
const GROWTH: f64 = 2.0;
/// Plain sweeps before a history begins.
const PLAIN: u32 = 2;
/// Squares of differences below this part of those of the changes themselves are round-off.
const ROUND_OFF: f64 = 1e-12;

/// Sweeps until as many are combined as ever are.
pub const FULL: u32 = PLAIN + HISTORY as u32;

/// The last sweeps.
#[derive(Clone, Debug)]
pub struct Anderson {
    /// Room of one sweep in the lists.
    stride: usize,
    /// Changes, weighted so that their squares are energies, results, and velocities at these, in a
    /// ring.
    changes: Vec<f64>,
    results: Vec<f64>,
    velocities: Vec<f64>,
    /// Scalar products of the changes.
    products: [[f64; HISTORY]; HISTORY],
    /// Number of sweeps kept, and place of the oldest.
    kept: usize,
    oldest: usize,
    least: f64,
    plain: u32,
}

impl Anderson {
    /// Room for this many numbers a sweep.
    pub fn new(numbers: usize) -> Self {
        let room = vec![0.0; HISTORY * numbers];
        Self {
            stride: numbers,
            changes: room.clone(),
            results: room.clone(),
            velocities: room,
            products: [[0.0; HISTORY]; HISTORY],
            kept: 0,
            oldest: 0,
            least: f64::INFINITY,
            plain: PLAIN,
        }
    }

    /// Forgets all sweeps.
    pub fn restart(&mut self) {
        (self.kept, self.oldest, self.least, self.plain) = (0, 0, f64::INFINITY, PLAIN);
    }

    /// Takes in a sweep: what it changed, weighted, to which impulses, and the velocities there.
    /// Replaces the last two by the combination. False when there is none to go on from.
    pub fn mix(&mut self, change: &[f64], result: &mut [f64], velocity: &mut [f64]) -> bool {
        let size = dot(change, change);
        self.least = self.least.min(size);
        if size > GROWTH * GROWTH * self.least {
            self.restart();
            return false;
        }
        if self.plain > 0 {
            self.plain -= 1;
            return false;
        }
        self.keep(change, result, velocity);
        let Some(parts) = self.combination() else { return false };
        result.fill(0.0);
        velocity.fill(0.0);
        for (k, part) in parts.iter().enumerate().take(self.kept) {
            let at = self.place(k) * self.stride;
            add(result, *part, &self.results[at..]);
            add(velocity, *part, &self.velocities[at..]);
        }
        true
    }

    /// Returns the place of the k-th oldest.
    fn place(&self, k: usize) -> usize {
        (self.oldest + k) % HISTORY
    }

    fn keep(&mut self, change: &[f64], result: &[f64], velocity: &[f64]) {
        if self.kept == HISTORY {
            self.oldest = (self.oldest + 1) % HISTORY;
        } else {
            self.kept += 1;
        }
        let (place, n) = (self.place(self.kept - 1), change.len());
        let at = place * self.stride;
        self.changes[at..at + n].copy_from_slice(change);
        self.results[at..at + n].copy_from_slice(result);
        self.velocities[at..at + n].copy_from_slice(velocity);
        for k in 0..self.kept {
            let other = self.place(k);
            let product = dot(change, &self.changes[other * self.stride..]);
            self.products[place][other] = product;
            self.products[other][place] = product;
        }
    }

    /// The parts, of sum 1, of the sweeps kept, the oldest first.
    fn combination(&self) -> Option<[f64; HISTORY]> {
        let n = self.kept.checked_sub(1).filter(|n| *n > 0)?;
        let product = |i: usize, j: usize| self.products[self.place(i)][self.place(j)];
        let mut squares = [[0.0; HISTORY]; HISTORY];
        let mut rhs = [0.0; HISTORY];
        for i in 0..n {
            for j in 0..n {
                squares[i][j] =
                    product(i + 1, j + 1) - product(i + 1, j) - product(i, j + 1) + product(i, j);
            }
            rhs[i] = product(i + 1, n) - product(i, n);
            let least = ROUND_OFF * (product(i + 1, i + 1) + product(i, i));
            squares[i][i] = squares[i][i].max(least) * (1.0 + DAMPING);
        }
        solve(&mut squares, &mut rhs, n)?;
        let mut parts = [0.0; HISTORY];
        parts[n] = 1.0;
        for (i, part) in rhs.iter().enumerate().take(n) {
            parts[i + 1] -= part;
            parts[i] += part;
        }
        Some(parts)
    }
}

/// Solves by Cholesky's method, in place; `None` when the matrix is not positive definite.
fn solve(a: &mut [[f64; HISTORY]; HISTORY], x: &mut [f64; HISTORY], n: usize) -> Option<()> {
    for i in 0..n {
        for j in 0..=i {
            let sum = a[i][j] - (0..j).map(|k| a[i][k] * a[j][k]).sum::<f64>();
            if i > j {
                a[i][j] = sum / a[j][j];
            } else if sum > 0.0 {
                a[i][i] = sum.sqrt();
            } else {
                return None;
            }
        }
        x[i] = (x[i] - (0..i).map(|k| a[i][k] * x[k]).sum::<f64>()) / a[i][i];
    }
    for i in (0..n).rev() {
        x[i] = (x[i] - (i + 1..n).map(|k| a[k][i] * x[k]).sum::<f64>()) / a[i][i];
    }
    Some(())
}

/// Scalar product over the length of `a`, in eight sums that go on side by side.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let b = &b[..a.len()];
    let (a, rest_a) = a.as_chunks::<8>();
    let (b, rest_b) = b.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        (0..8).for_each(|i| sums[i] += a[i] * b[i]);
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

fn add(to: &mut [f64], part: f64, other: &[f64]) {
    to.iter_mut().zip(other).for_each(|(to, other)| *to += part * other);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use nalgebra::{DMatrix, DVector};

    /// Gauss-Seidel on a chain of springs, which creeps, comes to the dense solution; velocities
    /// stay those of the impulses.
    #[test]
    fn a_slow_linear_iteration_comes_to_the_dense_solution() {
        let mut random = Random::new(5);
        let n = 40;
        let A = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        });
        let b = DVector::from_fn(n, |_, _| random.range(-1.0, 1.0));
        let want = A.clone().cholesky().unwrap().solve(&b);
        let run = |mixed: bool| {
            let mut anderson = Anderson::new(n + 8);
            let mut x = DVector::zeros(n);
            let mut sweeps = 0;
            while (&x - &want).amax() > 1e-6 * want.amax() && sweeps < 100_000 {
                let before = x.clone();
                for i in 0..n {
                    let row = A.row(i).transpose();
                    x[i] -= (row.dot(&x) - b[i]) / A[(i, i)];
                }
                sweeps += 1;
                let mut v = &A * &x;
                let change = &x - before;
                if mixed {
                    anderson.mix(change.as_slice(), x.as_mut_slice(), v.as_mut_slice());
                    assert!((&A * &x - &v).amax() < 1e-9 * (1.0 + x.amax()));
                }
            }
            sweeps
        };
        let (plain, mixed) = (run(false), run(true));
        assert!(plain > 1000 && mixed * 5 < plain, "{plain} plain, {mixed} mixed");
    }

    /// A sweep that changes more than twice the least ends the history.
    #[test]
    fn growth_ends_the_history() {
        let mut anderson = Anderson::new(3);
        let mut mix = |f: f64| anderson.mix(&[f, 0.0, 0.1 * f * f], &mut [f; 3], &mut [0.0; 3]);
        assert_eq!([1.0, 0.9, 0.8, 0.7].map(&mut mix), [false, false, false, true]);
        assert_eq!([1.5, 1.0, 0.9, 0.8, 0.6].map(&mut mix), [false, false, false, false, true]);
    }
}
