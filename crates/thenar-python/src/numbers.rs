//! Rows of numbers, out to Python and in from it.

use pyo3::PyResult;
use pyo3::exceptions::PyValueError;

/// Rows of `N` numbers.
///
/// # Errors
/// The bytes are not a whole number of rows.
pub fn rows<const N: usize>(bytes: &[u8]) -> PyResult<Vec<[f64; N]>> {
    let (numbers, rest) = bytes.as_chunks::<8>();
    let numbers: Vec<f64> = numbers.iter().map(|bytes| f64::from_ne_bytes(*bytes)).collect();
    let (rows, left) = numbers.as_chunks::<N>();
    if !rest.is_empty() || !left.is_empty() {
        let count = bytes.len();
        return Err(PyValueError::new_err(format!("{count} bytes are no rows of {N} numbers")));
    }
    Ok(rows.to_vec())
}

/// Exactly `R` rows of `N` numbers.
///
/// # Errors
/// There are more or fewer.
pub fn table<const R: usize, const N: usize>(bytes: &[u8]) -> PyResult<[[f64; N]; R]> {
    let rows = rows::<N>(bytes)?;
    let count = rows.len();
    rows.try_into().map_err(|_| {
        PyValueError::new_err(format!("expected {R} rows of {N} numbers, got {count}"))
    })
}
