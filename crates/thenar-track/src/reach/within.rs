//! Steps of least squares within the ranges of joints.

use nalgebra::{SMatrix, SVector};

/// The step `x` of `matrix x = right`. Freedoms that push against the ends of their ranges, as
/// `ends` says of a freedom's number and its step, are held, until none does. `None` where the
/// matrix has no factor.
pub(crate) fn step_within<const N: usize>(
    mut matrix: SMatrix<f64, N, N>,
    mut right: SVector<f64, N>,
    ends: impl Fn(usize, f64) -> bool,
) -> Option<SVector<f64, N>> {
    loop {
        let step = matrix.cholesky()?.solve(&right);
        let mut more = false;
        for i in (0..N).filter(|&i| ends(i, step[i])) {
            matrix.row_mut(i).fill(0.0);
            matrix.column_mut(i).fill(0.0);
            (matrix[(i, i)], right[i], more) = (1.0, 0.0, true);
        }
        if !more {
            return Some(step);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two freedoms that pull on each other: where the first may not grow, the second goes as if it
    /// were alone.
    #[test]
    fn a_freedom_at_its_end_is_left_out() {
        let matrix = SMatrix::<f64, 2, 2>::new(2.0, 1.0, 1.0, 2.0);
        let right = SVector::<f64, 2>::new(3.0, 3.0);
        let free = step_within(matrix, right, |_, _| false).unwrap();
        assert!((free - SVector::<f64, 2>::new(1.0, 1.0)).norm() < 1e-15);
        let held = step_within(matrix, right, |i, step| i == 0 && step > 0.0).unwrap();
        assert!(held[0] == 0.0 && (held[1] - 1.5).abs() < 1e-15, "{held}");
        let none = step_within(matrix, right, |_, step| step > 0.0).unwrap();
        assert_eq!((none[0], none[1]), (0.0, 0.0));
        assert!(step_within(-matrix, right, |_, _| false).is_none());
    }
}
