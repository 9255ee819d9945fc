//! Response of some bodies and contacts to wrenches on these bodies and to contact forces, which
//! touch needs of the system.
//!
//! With the flesh eliminated, `K⁻¹` of the bodies is `Z S⁻¹ Zᵀ`. One column of Z per body and
//! direction, half solved, `G = L_S⁻¹ Zᵀ`, gives both products with the H of the contacts
//! (`delassus`):
//!
//! ```text
//!   bodies by wrenches     Gᵀ G
//!   contacts by wrenches   Hᵀ G
//!   contacts by forces     W
//! ```
//!
//! and the same factor tells where all comes to rest.

use crate::math::Vec3;
use crate::solver::monolithic::{
    Accuracy, Coordinates, Monolithic, StepSystem, pcg, small_cholesky, system,
};
use crate::solver::{ContactRows, JointBlock};
use std::ops::Range;

/// Output of the responses; row-major, n bodies of six directions (linear, then angular, world), m
/// rows of contacts.
#[derive(Debug)]
pub struct ReducedCompliance<'a> {
    /// 6n × 6n.
    pub bodies: &'a mut Vec<f64>,
    /// m × 6n.
    pub lift: &'a mut Vec<f64>,
    /// m × m.
    pub contacts: &'a mut Vec<f64>,
}

impl Monolithic {
    /// Fills `to` with `h² K⁻¹`: displacements \[m, rad\] per force \[N, N m\], for the system of a
    /// step of `h`. Contacts come in the order returned. `None` when the system cannot be factored
    /// or the contacts are too many.
    pub fn reduced_compliance(
        &mut self,
        step: &StepSystem<'_>,
        joints: &[JointBlock],
        (v, h): (&[Vec3], f64),
        chosen: &[u32],
        contacts: &ContactRows,
        body_range: Range<usize>,
        to: &mut ReducedCompliance<'_>,
    ) -> Option<&[u32]> {
        if !self.factor_for(step, joints, v, h) {
            return None;
        }
        let Self { bodies, carried, springs, split, coarse, direct, delassus, x, pulled, .. } =
            self;
        let system = system(step, bodies, carried, springs, split);
        if !delassus.begin_with(chosen, contacts, direct) {
            return None;
        }
        delassus.extend(&system, coarse, direct, contacts);

        let (n, m) = (6 * body_range.len(), 3 * delassus.members().len());
        let square = h * h;
        to.contacts.clear();
        for row in 0..m {
            to.contacts.extend((0..m).map(|column| square * delassus.entry(row, column)));
        }
        to.lift.clear();
        to.lift.resize(m * n, 0.0);
        to.bodies.clear();
        for (k, body) in body_range.clone().enumerate() {
            for direction in 0..6 {
                x.u.fill(0.0);
                if let Some(group) = bodies.group_of_body(body) {
                    bodies.columns(body).for_each(|(dof, c)| x.u[dof] = c[direction]);
                    let dofs = bodies.groups()[group].clone();
                    let (factor, u) = (&direct.schur[coarse.block(group)], &mut x.u);
                    small_cholesky::forward(factor, dofs.len(), &mut u[dofs.clone()]);
                    delassus.pulled_by(&u[dofs.clone()], &dofs, pulled);
                    let column = to.lift.iter_mut().skip(6 * k + direction).step_by(n);
                    column.zip(&*pulled).for_each(|(to, pulled)| *to = square * pulled);
                    small_cholesky::backward(factor, dofs.len(), &mut u[dofs]);
                }
                for other in body_range.clone() {
                    let mut motion = [0.0; 6];
                    for (dof, c) in bodies.columns(other) {
                        (0..6).for_each(|r| motion[r] += c[r] * x.u[dof]);
                    }
                    to.bodies.extend(motion.map(|q| square * q));
                }
            }
        }
        Some(self.delassus.members())
    }

    /// The solution `K v = b` of the system that `reduced_compliance` has just factored, to this
    /// accuracy.
    pub fn solve_factored(&mut self, step: &StepSystem<'_>, accuracy: &Accuracy, v: &mut [Vec3]) {
        let Self { bodies, carried, springs, split, coarse, direct, x, work, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        x.clear();
        system.residual(step.b, x, &mut work.r, &mut work.v, &mut work.f);
        let apply = |r: &Coordinates, z: &mut Coordinates| direct.apply(&system, coarse, r, z);
        pcg::solve(&system, apply, x, accuracy.stop(1, accuracy.iterations_max), work);
        system.velocities(x, v);
    }

    /// Factors the whole system, without a solve.
    fn factor_for(
        &mut self,
        step: &StepSystem<'_>,
        joints: &[JointBlock],
        v: &[Vec3],
        h: f64,
    ) -> bool {
        for c in &self.carried {
            self.springs[c.node as usize] = c.spring;
        }
        if !self.bodies.refresh(step.A, joints, v, h) {
            return false;
        }
        let Self { bodies, carried, springs, split, coarse, direct, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        coarse.refresh(&system, true);
        direct.refresh(&system, coarse)
    }
}
