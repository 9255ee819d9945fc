//! Deformable bodies: volume, rotation, stress.

use super::NodeSet;
use crate::math::{Mat3, Vec3};
use thenar_core::World;
use thenar_core::kernels::{RestTet, respond, signed_svd};

/// One element whose stress is measured.
#[derive(Debug)]
pub struct Element {
    pub nodes: [u32; 4],
    pub tet: RestTet,
    /// Rest positions \[m\].
    pub rest: [Vec3; 4],
}

pub fn volume(world: &World, soft: u32) -> f64 {
    let x = world.nodes(soft);
    let sixfold = |tet: &[u32; 4]| {
        let [a, b, c, d] = tet.map(|n| x[n as usize]);
        (b - a).cross(&(c - a)).dot(&(d - a))
    };
    world.desc().softs[soft as usize].flesh.tets.iter().map(sixfold).sum::<f64>() / 6.0
}

/// Rotation vector that best takes the nodes' rest places to their places (Kabsch 1976).
pub fn rotation(world: &World, set: &NodeSet) -> Vec3 {
    let centre = set.mean(|k| set.place(world, k));
    let centre_rest = set.mean(|k| set.rest[k]);
    let moment: Mat3 = (0..set.nodes.len())
        .map(|k| (set.place(world, k) - centre) * (set.rest[k] - centre_rest).transpose())
        .sum();
    let (U, _, V) = signed_svd(&moment);
    let R = nalgebra::Rotation3::from_matrix_unchecked(U * V.transpose());
    thenar_core::Quat::from_rotation_matrix(&R).scaled_axis()
}

/// First Piola-Kirchhoff stress \[Pa\] of an element, from its forces: `Σ f_a ⊗ X_a = -V P`.
fn nominal_stress(element: &Element, x: &[Vec3; 4]) -> Mat3 {
    let forces = respond(&element.tet, x).forces;
    let sum: Mat3 = forces.iter().zip(&element.rest).map(|(f, X)| f * X.transpose()).sum();
    -sum / element.tet.volume
}

/// Stress of an element, nominal or Cauchy (`P Fᵀ / det F`).
fn stress_of(element: &Element, nodes: &[Vec3], nominal: bool) -> Mat3 {
    let x = element.nodes.map(|n| nodes[n as usize]);
    let P = nominal_stress(element, &x);
    if nominal {
        return P;
    }
    let F = element.tet.deformation_gradient(&x);
    P * F.transpose() / F.determinant()
}

/// Mean by rest volume, and the largest deviation of an element from it.
pub fn stress(nodes: &[Vec3], elements: &[Element], nominal: bool, out: &mut Vec<f64>) {
    let volume: f64 = elements.iter().map(|e| e.tet.volume).sum();
    let mean: Mat3 =
        elements.iter().map(|e| stress_of(e, nodes, nominal) * e.tet.volume).sum::<Mat3>() / volume;
    let off = |e: &Element| (stress_of(e, nodes, nominal) - mean).norm();
    let spread = elements.iter().map(off).fold(0.0, f64::max);
    if nominal {
        out.extend(mean.transpose().iter()); // row by row
    } else {
        let deviator = mean - Mat3::identity() * (mean.trace() / 3.0);
        let m = |i, j| mean[(i, j)];
        out.extend([m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(2, 0)]);
        out.push((1.5_f64).sqrt() * deviator.norm());
    }
    out.push(spread);
}
