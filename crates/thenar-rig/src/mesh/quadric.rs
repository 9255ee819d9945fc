//! Squared distances to planes, summed (Garland & Heckbert 1997).

use thenar_core::{Mat3, Vec3};

/// A direction whose stiffness is below this part of the largest counts as free.
const FLAT: f64 = 1e-3;

/// `xᵀ A x - 2 bᵀ x + c`: area-weighted sum of squared distances to planes \[m⁴\].
#[derive(Clone, Copy, Debug)]
pub struct Quadric {
    pub A: Mat3,
    pub b: Vec3,
    pub c: f64,
}

impl Quadric {
    pub fn zero() -> Self {
        Self { A: Mat3::zeros(), b: Vec3::zeros(), c: 0.0 }
    }

    /// Quadric of the plane through `point` with unit normal `n`.
    pub fn plane(point: &Vec3, n: &Vec3, weight: f64) -> Self {
        let d = n.dot(point);
        Self { A: n * n.transpose() * weight, b: n * (d * weight), c: d * d * weight }
    }

    pub fn sum(&self, other: &Self) -> Self {
        Self { A: self.A + other.A, b: self.b + other.b, c: self.c + other.c }
    }

    pub fn at(&self, x: &Vec3) -> f64 {
        (x.dot(&(self.A * x)) - 2.0 * self.b.dot(x) + self.c).max(0.0)
    }

    /// The point of least value, on the plane `g·x = d` if `g` is not zero. Directions that the
    /// quadric leaves free are held at `guess`.
    pub fn minimum(&self, guess: &Vec3, g: &Vec3, d: f64) -> Option<Vec3> {
        let eigen = self.A.symmetric_eigen();
        let softest = FLAT * eigen.eigenvalues.amax();
        if softest <= 0.0 {
            return None;
        }
        let residual = self.b - self.A * guess;
        let mut free = *guess;
        let mut inverse = Mat3::zeros();
        for (e, &stiffness) in eigen.eigenvectors.column_iter().zip(&eigen.eigenvalues) {
            inverse += e * e.transpose() / stiffness.max(softest);
            if stiffness > softest {
                free += e * (e.dot(&residual) / stiffness);
            }
        }
        let stiffness = g.dot(&(inverse * g));
        if stiffness <= 0.0 {
            return Some(free);
        }
        Some(free + inverse * g * ((d - g.dot(&free)) / stiffness))
    }
}
