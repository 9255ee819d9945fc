//! Finite differences that tests compare with.

/// Central differences of a vector function of a vector: entry `[i][j]` is ∂f_i/∂x_j.
pub fn jacobian(f: impl Fn(&[f64]) -> Vec<f64>, x: &[f64], step: f64) -> Vec<Vec<f64>> {
    let columns: Vec<Vec<f64>> = (0..x.len())
        .map(|j| {
            let at = |s: f64| {
                let mut x = x.to_vec();
                x[j] += s;
                f(&x)
            };
            at(step).iter().zip(at(-step)).map(|(a, b)| (a - b) / (2.0 * step)).collect()
        })
        .collect();
    (0..columns[0].len()).map(|i| columns.iter().map(|c| c[i]).collect()).collect()
}

/// Asserts that two matrices agree to `tolerance` relative to the larger one's largest entry.
pub fn assert_close(got: &[Vec<f64>], want: &[Vec<f64>], tolerance: f64) {
    let largest = |m: &[Vec<f64>]| m.iter().flatten().fold(0.0_f64, |a, x| a.max(x.abs()));
    let scale = largest(want).max(largest(got)).max(1e-300);
    assert_eq!(got.len(), want.len());
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        for (j, (g, w)) in got.iter().zip(want).enumerate() {
            assert!((g - w).abs() <= tolerance * scale, "entry ({i},{j}): {g} against {w}");
        }
    }
}
