//! The rotation of a deformation gradient, also for inverted elements.

use crate::math::Mat3;

/// The rotation R of the polar decomposition `F = R S`; R is a rotation also when `det F ≤ 0`,
/// where the direction of least stretch is taken as the inverted one (Irving et al. 2004), so
/// that the elastic force turns the element right again.
pub fn rotation_of(F: &Mat3) -> Mat3 {
    let scale = F.norm();
    if F.determinant() > 1e-3 * scale * scale * scale {
        newton(F)
    } else {
        let (U, _, V) = signed_svd(F);
        U * V.transpose()
    }
}

/// Newton's iteration `R ← (R + R⁻ᵀ)/2` (Higham 1986), to round-off.
fn newton(F: &Mat3) -> Mat3 {
    let mut R = *F;
    for _ in 0..30 {
        let cofactor = cofactor(&R);
        let det = R.column(0).dot(&cofactor.column(0));
        let next = (R + cofactor / det) * 0.5;
        let change = (next - R).norm_squared();
        R = next;
        if change < 1e-30 {
            break;
        }
    }
    R
}

/// The cofactor matrix, `det(M) M⁻ᵀ`.
pub fn cofactor(M: &Mat3) -> Mat3 {
    let (a, b, c) = (M.column(0), M.column(1), M.column(2));
    Mat3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
}

/// `F = U diag(σ) Vᵀ` with rotations U and V; only the last, smallest σ may be negative.
pub fn signed_svd(F: &Mat3) -> (Mat3, [f64; 3], Mat3) {
    let svd = F.svd(true, true);
    let (Some(mut U), Some(V_t)) = (svd.u, svd.v_t) else {
        return (Mat3::identity(), [0.0; 3], Mat3::identity());
    };
    let mut V = V_t.transpose();
    let mut sigma = [svd.singular_values[0], svd.singular_values[1], svd.singular_values[2]];
    for m in [&mut U, &mut V] {
        if m.determinant() < 0.0 {
            let flipped = -m.column(2);
            m.set_column(2, &flipped);
            sigma[2] = -sigma[2];
        }
    }
    (U, sigma, V)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn is_a_rotation_and_leaves_a_symmetric_stretch() {
        let mut random = Random::new(11);
        for i in 0..2000 {
            let mut F = Mat3::from_fn(|_, _| random.range(-1.0, 1.0));
            if i % 2 == 0 {
                F = random.rotation(3.13).to_rotation_matrix() * (Mat3::identity() + 0.3 * F);
            }
            let R = rotation_of(&F);
            assert!((R.transpose() * R - Mat3::identity()).norm() < 1e-12);
            assert!((R.determinant() - 1.0).abs() < 1e-12);
            let S = R.transpose() * F;
            assert!((S - S.transpose()).norm() < 1e-10, "{S}");
        }
    }

    #[test]
    fn svd_rebuilds_its_matrix() {
        let mut random = Random::new(12);
        for _ in 0..500 {
            let F = Mat3::from_fn(|_, _| random.range(-1.0, 1.0));
            let (U, s, V) = signed_svd(&F);
            let back = U * Mat3::from_diagonal(&s.into()) * V.transpose();
            assert!((back - F).norm() < 1e-12);
            assert!(s[0] >= s[1] && s[1] >= s[2].abs());
            assert!(s[2].signum() == F.determinant().signum());
        }
    }
}
