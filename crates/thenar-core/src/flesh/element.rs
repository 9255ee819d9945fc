//! One linear tetrahedron: deformation gradient to nodal forces and stiffness blocks.

use crate::flesh::living::Living;
use crate::flesh::polar::{rotation_of, signed_svd};
use crate::flesh::principal::{Density, density};
use crate::math::{Mat3, Vec3};
use crate::model::{Law, Material};

/// Rest shape and material of an element.
#[derive(Clone, Copy, Debug)]
pub struct RestTet {
    /// Rest volume \[m³\].
    pub volume: f64,
    /// Gradients of the four barycentric coordinates in the rest shape \[1/m\].
    pub gradients: [Vec3; 4],
    /// First Lamé parameter \[Pa\].
    pub lambda: f64,
    /// Shear modulus \[Pa\].
    pub mu: f64,
    /// Constitutive law.
    pub law: Law,
    /// Density \[kg/m³\].
    pub density: f64,
}

impl RestTet {
    /// The element with these rest positions; `None` when its volume is not positive.
    pub fn new(x: &[Vec3; 4], material: &Material) -> Option<Self> {
        let Dm = Mat3::from_columns(&[x[1] - x[0], x[2] - x[0], x[3] - x[0]]);
        let det = Dm.determinant();
        if det <= 0.0 || !det.is_finite() {
            return None;
        }
        let inverse = Dm.try_inverse()?;
        let g: [Vec3; 3] = std::array::from_fn(|i| inverse.row(i).transpose());
        let (e, nu) = (material.young, material.poisson);
        Some(Self {
            volume: det / 6.0,
            gradients: [-(g[0] + g[1] + g[2]), g[0], g[1], g[2]],
            lambda: e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
            mu: e / (2.0 * (1.0 + nu)),
            law: material.law,
            density: material.density,
        })
    }

    /// Young's modulus at small strain \[Pa\].
    pub fn young(&self) -> f64 {
        self.mu * (3.0 * self.lambda + 2.0 * self.mu) / (self.lambda + self.mu)
    }

    /// Deformation gradient `F = Σ x_a ⊗ g_a`.
    #[inline]
    pub fn deformation_gradient(&self, x: &[Vec3; 4]) -> Mat3 {
        // Column by column: outer products would call nalgebra's general matrix product.
        let (g, sides) = (&self.gradients, [x[1] - x[0], x[2] - x[0], x[3] - x[0]]);
        let column = |k: usize| sides[0] * g[1][k] + sides[1] * g[2][k] + sides[2] * g[3][k];
        Mat3::from_columns(&[column(0), column(1), column(2)])
    }

    /// Deformation gradient of the tetrahedron with these nodes, at the positions `x` of all.
    #[inline]
    pub fn gradient_at(&self, [i, j, k, l]: &[u32; 4], x: &[Vec3]) -> Mat3 {
        self.deformation_gradient(&[x[*i as usize], x[*j as usize], x[*k as usize], x[*l as usize]])
    }
}

/// The pairs of nodes whose stiffness blocks are computed; the others are their transposes.
pub const PAIRS: [(usize, usize); 10] =
    [(0, 0), (1, 1), (2, 2), (3, 3), (0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

/// The elastic response of one element.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// Energy \[J\].
    pub energy: f64,
    /// Force on each node, `-V P g_a` \[N\].
    pub forces: [Vec3; 4],
    /// ≈ -∂force_a/∂x_b \[N/m\] for each (a, b) of [`PAIRS`]; the whole 12×12 matrix is symmetric
    /// and positive semi-definite.
    pub stiffness: [Mat3; 10],
    /// The element has negative volume.
    pub inverted: bool,
}

/// Evaluates an element at node positions `x`. The forces are the exact derivative of the energy,
/// hence free of net force and torque; the stiffness leaves out what would make it indefinite:
/// the rotation's derivative (corotational), negative eigenvalues (the others).
#[inline]
pub fn respond(rest: &RestTet, x: &[Vec3; 4]) -> Response {
    let F = rest.deformation_gradient(x);
    match rest.law {
        Law::Corotational => corotational(rest, &F),
        Law::NeoHookean | Law::StableNeoHookean | Law::Ogden { .. } => hyperelastic(rest, &F),
    }
}

/// `P = R (2μ (S - I) + λ tr(S - I) I)` (Müller and Gross 2004, in the form of an energy).
/// With the gradients rotated into the present frame, `g' = R g`, the warped stiffness
/// `R K Rᵀ` needs no products with R:
/// `K_ab = V (λ g'_a g'_bᵀ + μ g'_b g'_aᵀ + μ (g'_a·g'_b) I)`.
#[inline]
fn corotational(rest: &RestTet, F: &Mat3) -> Response {
    let R = rotation_of(F);
    let S = R.tr_mul(F);
    let strain = S - Mat3::identity();
    let (lambda, mu, volume) = (rest.lambda, rest.mu, rest.volume);
    let trace = strain.trace();
    let stress = strain * (2.0 * mu) + Mat3::from_diagonal_element(lambda * trace);
    let g = rest.gradients.map(|g| R * g);
    let P = R * stress;
    Response {
        energy: volume * (mu * strain.norm_squared() + 0.5 * lambda * trace * trace),
        forces: rest.gradients.map(|g| P * g * -volume),
        stiffness: PAIRS.map(|(a, b)| {
            let (ga, gb) = (g[a] * volume, g[b]);
            let outer = ga * gb.transpose();
            outer * lambda
                + outer.transpose() * mu
                + Mat3::from_diagonal_element(mu * outer.trace())
        }),
        inverted: F.determinant() < 0.0,
    }
}

/// Elastic stress of an element in its own rotated frame.
#[derive(Clone, Copy, Debug)]
pub struct Stress {
    /// `Rᵀ P` \[Pa\], symmetric.
    pub biot: Mat3,
    /// ψ \[J/m³\].
    pub energy: f64,
    /// Stress fades in this shape.
    pub lives: bool,
}

/// An element as a step sees it: its stress and stiffness where the step begins, in the axes of
/// `F = U σ Vᵀ`.
#[derive(Clone, Copy, Debug)]
pub struct Linear {
    /// `Uᵀ P V` \[Pa\].
    pub stress: Mat3,
    /// Stiffness of the diagonal of `G = Uᵀ dF V` \[Pa\].
    pub stretch: Mat3,
    /// Stiffness of each pair of axes, against `G_ij²` and against `G_ij G_ji` \[Pa\].
    pub pairs: [[[f64; 2]; 3]; 3],
}

impl Linear {
    /// Stress and stiffness of an elastic law of which the share `part`, from 0 to 1, is left.
    pub fn elastic(of: &Principal, part: f64) -> Self {
        let mut pairs = [[[0.0; 2]; 3]; 3];
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let pair = of.twist_flip(i, j).map(|k| k * part);
            pairs[i][j] = pair;
            pairs[j][i] = pair;
        }
        Self {
            stress: Mat3::from_diagonal(&of.at.stress.into()) * part,
            stretch: positive_part(&of.at.hessian) * part,
            pairs,
        }
    }

    /// `dF : P` and `dF : dP` of a change with these entries in the axes.
    pub fn along(&self, G: &Mat3) -> [f64; 2] {
        let d = G.diagonal();
        let mut curved = d.dot(&(self.stretch * d));
        for i in 0..3 {
            for j in (0..3).filter(|&j| j != i) {
                let [own, cross] = self.pairs[i][j];
                curved += own * G[(i, j)] * G[(i, j)] + cross * G[(i, j)] * G[(j, i)];
            }
        }
        [self.stress.component_mul(G).sum(), curved]
    }

    /// Forces and stiffness of an element with this shape; `energy` is per volume.
    pub fn response(&self, rest: &RestTet, of: &Principal, energy: f64) -> Response {
        let P = of.U * self.stress * of.V.transpose();
        Response {
            energy: rest.volume * energy,
            forces: rest.gradients.map(|g| P * g * -rest.volume),
            stiffness: of.blocks(rest, &self.stretch, &self.pairs),
            inverted: of.s[2] < 0.0,
        }
    }
}

/// The stress at a deformation gradient; `living` is that of the law.
pub fn stress(rest: &RestTet, F: &Mat3, living: &Living) -> Stress {
    let (lambda, mu) = (rest.lambda, rest.mu);
    if rest.law == Law::Corotational {
        let R = rotation_of(F);
        let strain = R.tr_mul(F) - Mat3::identity();
        let trace = strain.trace();
        return Stress {
            biot: strain * (2.0 * mu) + Mat3::from_diagonal_element(lambda * trace),
            energy: mu * strain.norm_squared() + 0.5 * lambda * trace * trace,
            lives: true,
        };
    }
    let shape = Principal::new(rest, F);
    Stress { biot: shape.biot(), energy: shape.at.energy, lives: living.holds(mu, &shape) }
}

/// An element's deformation gradient `F = U σ Vᵀ` and its law there.
#[derive(Clone, Copy, Debug)]
pub struct Principal {
    /// Axes in the world.
    pub U: Mat3,
    /// Stretches; only the last, smallest may be negative.
    pub s: [f64; 3],
    /// Axes in the rest shape.
    pub V: Mat3,
    /// ψ and its derivatives.
    pub at: Density,
}

impl Principal {
    /// At a deformation gradient.
    pub fn new(rest: &RestTet, F: &Mat3) -> Self {
        Self::of(F, |s| density(rest.law, rest.lambda, rest.mu, s))
    }

    /// At a deformation gradient, of a law that is a function of the signed stretches.
    pub fn of(F: &Mat3, law: impl Fn([f64; 3]) -> Density) -> Self {
        let (U, s, V) = signed_svd(F);
        Self { U, s, V, at: law(s) }
    }

    /// `Rᵀ P` \[Pa\].
    pub fn biot(&self) -> Mat3 {
        self.V * Mat3::from_diagonal(&self.at.stress.into()) * self.V.transpose()
    }

    /// Right stretch tensor S.
    pub fn stretch(&self) -> Mat3 {
        self.V * Mat3::from_diagonal(&self.s.into()) * self.V.transpose()
    }

    /// `(Pᵢ - Pⱼ) / (σᵢ - σⱼ)`.
    pub fn flip(&self, i: usize, j: usize) -> f64 {
        let difference = self.s[i] - self.s[j];
        if difference.abs() > 1e-6 {
            (self.at.stress[i] - self.at.stress[j]) / difference
        } else {
            self.at.hessian[(i, i)] - self.at.hessian[(i, j)]
        }
    }

    /// Stiffness of a pair of axes, against `G_ij² + G_ji²` and against `2 G_ij G_ji`: a twist and
    /// a flip (Smith, de Goes and Kim 2019), each kept non-negative.
    pub fn twist_flip(&self, i: usize, j: usize) -> [f64; 2] {
        let sum = self.s[i] + self.s[j];
        let both = self.at.stress[i] + self.at.stress[j];
        let twist = if sum.abs() > 1e-9 { both / sum } else { 0.0 };
        let (twist, flip) = (twist.max(0.0), self.flip(i, j).max(0.0));
        [0.5 * (flip + twist), 0.5 * (flip - twist)]
    }

    /// Stiffness blocks of [`PAIRS`] from the derivative of P in the axes, with `G = Uᵀ dF V`:
    /// `stretch` of the diagonal of G, and of each pair of axes `[[own, cross]; 3]; 3]`, so that
    /// `own[i][j]` goes with `G_ij²` and `cross[i][j]` with `G_ij G_ji`.
    pub fn blocks(&self, rest: &RestTet, stretch: &Mat3, pairs: &[[[f64; 2]; 3]; 3]) -> [Mat3; 10] {
        let U = &self.U;
        let g = rest.gradients.map(|g| self.V.tr_mul(&g));
        PAIRS.map(|(a, b)| {
            let local = Mat3::from_fn(|i, k| {
                if i == k {
                    let shear: f64 = (0..3)
                        .filter(|&j| j != i)
                        .map(|j| pairs[i][j][0] * g[a][j] * g[b][j])
                        .sum();
                    stretch[(i, i)] * g[a][i] * g[b][i] + shear
                } else {
                    stretch[(i, k)] * g[a][i] * g[b][k] + pairs[i][k][1] * g[a][k] * g[b][i]
                }
            });
            U * local * U.transpose() * rest.volume
        })
    }
}

/// Any isotropic law through its principal stretches. In the frames of `F = U σ Vᵀ` the
/// derivative of P splits into the 3×3 Hessian of ψ and, for each pair of axes, a twist and a
/// flip with known eigenvalues (Smith, de Goes and Kim 2019); each is kept non-negative.
fn hyperelastic(rest: &RestTet, F: &Mat3) -> Response {
    let shape = Principal::new(rest, F);
    Linear::elastic(&shape, 1.0).response(rest, &shape, shape.at.energy)
}

/// The nearest positive semi-definite matrix to a symmetric one.
pub fn positive_part(m: &Mat3) -> Mat3 {
    if m[(0, 1)] == 0.0 && m[(0, 2)] == 0.0 && m[(1, 2)] == 0.0 {
        return m.map(|x| x.max(0.0));
    }
    let eigen = m.symmetric_eigen();
    let values = eigen.eigenvalues.map(|x| x.max(0.0));
    eigen.eigenvectors * Mat3::from_diagonal(&values) * eigen.eigenvectors.transpose()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::random::Random;
    use crate::testing::{assert_close, jacobian};

    /// Corners of a tetrahedron.
    pub const REST: [Vec3; 4] = [
        Vec3::new(0.0, 0.0, 0.0),
        Vec3::new(0.011, 0.001, 0.0),
        Vec3::new(-0.001, 0.009, 0.002),
        Vec3::new(0.002, 0.001, 0.012),
    ];

    /// Young's modulus of that element \[Pa\].
    pub const YOUNG: f64 = 5e4;

    /// The element of this law.
    pub fn rest_of(law: Law) -> RestTet {
        let material = Material { law, young: YOUNG, poisson: 0.43, density: 1000.0 };
        RestTet::new(&REST, &material).unwrap()
    }

    fn nodes(x: &[f64]) -> [Vec3; 4] {
        std::array::from_fn(|a| Vec3::new(x[3 * a], x[3 * a + 1], x[3 * a + 2]))
    }

    fn flat(x: &[Vec3; 4]) -> Vec<f64> {
        x.iter().flat_map(|x| [x.x, x.y, x.z]).collect()
    }

    /// The 12×12 stiffness with the sign of a force's derivative.
    fn derivative(response: &Response) -> Vec<Vec<f64>> {
        let mut whole = vec![vec![0.0; 12]; 12];
        for (block, (a, b)) in response.stiffness.iter().zip(PAIRS) {
            for i in 0..3 {
                for j in 0..3 {
                    whole[3 * a + i][3 * b + j] = -block[(i, j)];
                    whole[3 * b + j][3 * a + i] = -block[(i, j)];
                }
            }
        }
        whole
    }

    const LAWS: [Law; 4] =
        [Law::Corotational, Law::NeoHookean, Law::StableNeoHookean, Law::Ogden { alpha: 8.0 }];

    #[test]
    fn forces_are_minus_the_gradient_of_the_energy() {
        let mut random = Random::new(1);
        for law in LAWS {
            let rest = rest_of(law);
            for _ in 0..100 {
                let turn = random.rotation(3.1);
                let x = REST.map(|x| turn * x + random.vector(0.002));
                let numeric =
                    jacobian(|x| vec![-respond(&rest, &nodes(x)).energy], &flat(&x), 1e-8);
                assert_close(&[flat(&respond(&rest, &x).forces)], &numeric, 1e-6);
            }
        }
    }

    /// Near rest (where nothing is dropped or clamped) the stiffness is the exact derivative;
    /// a uniform stretch keeps the corotational rotation's derivative out of it too.
    #[test]
    fn stiffness_is_minus_the_derivative_of_the_force_at_rest() {
        for law in LAWS {
            let rest = rest_of(law);
            let here = respond(&rest, &REST);
            let numeric = jacobian(|x| flat(&respond(&rest, &nodes(x)).forces), &flat(&REST), 1e-8);
            let analytic = derivative(&here);
            assert_close(&analytic, &numeric, 1e-6);
        }
    }

    /// Stretched states, where the neo-Hookean laws are convex, so that no eigenvalue is clamped.
    #[test]
    fn hyperelastic_stiffness_is_exact_under_tension() {
        let mut random = Random::new(2);
        for law in [Law::NeoHookean, Law::StableNeoHookean, Law::Ogden { alpha: 8.0 }] {
            let rest = rest_of(law);
            for _ in 0..20 {
                let turn = random.rotation(3.0).to_rotation_matrix();
                let pull = Mat3::from_diagonal(&Vec3::new(1.06, 1.04, 1.02));
                let F = turn * pull * random.rotation(3.0).to_rotation_matrix();
                let x = REST.map(|x| F * x);
                let here = respond(&rest, &x);
                let numeric =
                    jacobian(|x| flat(&respond(&rest, &nodes(x)).forces), &flat(&x), 1e-8);
                let analytic = derivative(&here);
                assert_close(&analytic, &numeric, 1e-5);
            }
        }
    }

    #[test]
    fn no_net_force_no_net_torque_and_rotation_invariance() {
        let mut random = Random::new(9);
        for law in LAWS {
            let rest = rest_of(law);
            for _ in 0..300 {
                let x = REST.map(|x| x + random.vector(0.006));
                let f = respond(&rest, &x).forces;
                let scale: f64 = f.iter().map(|f| f.norm()).sum();
                let net: Vec3 = f.iter().sum();
                let torque: Vec3 = x.iter().zip(&f).map(|(x, f)| x.cross(f)).sum();
                assert!(net.norm() < 1e-12 * scale);
                assert!(torque.norm() < 1e-12 * scale * 0.02, "{}", torque.norm() / scale);
                let turn = random.rotation(3.1);
                let turned = respond(&rest, &x.map(|x| turn * x)).forces;
                for (f, t) in f.iter().zip(&turned) {
                    assert!((turn * f - t).norm() < 1e-9 * scale);
                }
            }
        }
    }
}
