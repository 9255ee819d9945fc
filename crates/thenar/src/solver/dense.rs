//! Dense LU factorisation with partial pivoting, in place: for small or reference systems. `factor` and `solve` are
//! inlined so that they run at their caller's vector width.

/// A factored square matrix.
#[derive(Clone, Debug)]
pub struct DenseLu {
    n: usize,
    /// Row-major; the caller fills it, `factor` overwrites it.
    pub values: Vec<f64>,
    pivots: Vec<usize>,
}

impl DenseLu {
    /// The n×n zero matrix.
    pub fn new(n: usize) -> Self {
        Self { n, values: vec![0.0; n * n], pivots: vec![0; n] }
    }

    /// Makes it the n×n zero matrix; allocates only where it has never been so large.
    pub fn restart(&mut self, n: usize) {
        self.n = n;
        self.values.clear();
        self.values.resize(n * n, 0.0);
        self.pivots.resize(n, 0);
    }

    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.n
    }

    /// Adds to entry (i, j), before factoring.
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        self.values[i * self.n + j] += value;
    }

    /// Factors; false when the matrix is singular to working precision.
    #[inline(always)]
    pub fn factor(&mut self) -> bool {
        let n = self.n;
        for k in 0..n {
            let pivot = (k..n)
                .max_by(|&i, &j| {
                    self.values[i * n + k].abs().total_cmp(&self.values[j * n + k].abs())
                })
                .unwrap_or(k);
            self.pivots[k] = pivot;
            if pivot != k {
                for c in 0..n {
                    self.values.swap(k * n + c, pivot * n + c);
                }
            }
            let d = self.values[k * n + k];
            if d == 0.0 || !d.is_finite() {
                return false;
            }
            let (above, below) = self.values.split_at_mut((k + 1) * n);
            let row_k = &above[k * n + k + 1..];
            for row in below.chunks_exact_mut(n) {
                let factor = row[k] / d;
                row[k] = factor;
                if factor != 0.0 {
                    for (x, y) in row[k + 1..].iter_mut().zip(row_k) {
                        *x -= factor * y;
                    }
                }
            }
        }
        true
    }

    /// Solves in place.
    #[inline(always)]
    pub fn solve(&self, x: &mut [f64]) {
        let n = self.n;
        for k in 0..n {
            x.swap(k, self.pivots[k]);
        }
        for i in 0..n {
            let row = &self.values[i * n..i * n + i];
            x[i] -= row.iter().zip(&x[..i]).map(|(a, b)| a * b).sum::<f64>();
        }
        for i in (0..n).rev() {
            let row = &self.values[i * n + i + 1..(i + 1) * n];
            let s: f64 = row.iter().zip(&x[i + 1..n]).map(|(a, b)| a * b).sum();
            x[i] = (x[i] - s) / self.values[i * n + i];
        }
    }
}
