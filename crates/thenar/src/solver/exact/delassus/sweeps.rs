//! Gauss-Seidel sweeps over the members of W.

use super::Delassus;
use crate::math::Vec3;
use crate::model::Cone;
use crate::solver::exact::compliance::Compliance;
use crate::solver::exact::decay::SAFETY;
use crate::solver::exact::direct::Direct;
use crate::solver::exact::factor::LANES;
use crate::solver::exact::gauss_seidel::Response;
use crate::solver::{ContactRow, ContactRows, Convergence};
use fearless_simd::{Simd, dispatch};

impl Delassus {
    /// Finds impulses from the present ones by sweeps over the members, until one changes no
    /// contact's velocity by more than `tolerance` \[m/s\] through its own impulse, and all
    /// further ones together are not expected to change any velocity by more. Where they run out
    /// before, the residual is no more than sweeps have moved a contact in this step, as a rate near
    /// 1 cannot be told from a standstill, but enough above the tolerance not to pass for converged.
    pub fn solve(
        &mut self,
        contacts: &mut ContactRows,
        cone: Cone,
        tolerance: f64,
        sweeps_max: u32,
        direct: &Direct,
    ) -> Convergence {
        dispatch!(direct.factor.level, simd => {
            self.sweep(simd, contacts, cone, tolerance, sweeps_max)
        })
    }

    #[inline(always)]
    fn sweep<S: Simd>(
        &mut self,
        simd: S,
        contacts: &mut ContactRows,
        cone: Cone,
        tolerance: f64,
        sweeps_max: u32,
    ) -> Convergence {
        let Self { members, W, own, d, before, decay, applied, measured, first, moved, .. } = self;
        let (members, n) = (members.list(), members.list().len());
        let used = (3 * n).next_multiple_of(LANES);
        let d = &mut d[..used];
        d.fill(0.0);
        for m in 0..n {
            let i = members[m] as usize;
            let more = contacts.rows[i].lambda - applied[i];
            if more != Vec3::zeros() {
                W.add_answer(simd, m, &more, d);
            }
        }
        for m in 0..n {
            let start = measured[members[m] as usize];
            (0..3).for_each(|a| d[3 * m + a] += start[a]);
        }
        let before = &mut before[..used];
        let mut convergence = Convergence { iterations: 0, residual: f64::INFINITY };
        decay.interrupt();
        while convergence.iterations < sweeps_max && convergence.residual > tolerance {
            before.copy_from_slice(d);
            let mut own_change = 0.0_f64;
            for m in 0..n {
                let row = &mut contacts.rows[members[m] as usize];
                own_change = own_change.max(visit(simd, m, W, &own[m], cone, row, d));
            }
            convergence.residual = own_change.max(decay.error_after(largest_change(before, d)));
            convergence.iterations += 1;
            for (m, d) in d.as_chunks::<3>().0.iter().enumerate().take(n) {
                *moved = moved.max((Vec3::from(*d) - first[members[m] as usize]).norm());
            }
        }
        convergence.residual = convergence.residual.min(SAFETY * tolerance + *moved);
        convergence
    }
}

/// Gives member m its impulse; returns the change of its velocity \[m/s\].
#[inline(always)]
fn visit<S: Simd>(
    simd: S,
    m: usize,
    W: &Compliance,
    own: &Response,
    cone: Cone,
    row: &mut ContactRow,
    d: &mut [f64],
) -> f64 {
    let value = Vec3::from_column_slice(&d[3 * m..3 * m + 3]);
    if row.lambda == Vec3::zeros() && value.x >= 0.0 {
        return 0.0;
    }
    let lambda = wanted(cone, row, own, &value);
    let delta = lambda - row.lambda;
    if delta == Vec3::zeros() {
        return 0.0;
    }
    row.lambda = lambda;
    W.add_answer(simd, m, &delta, d);
    (own.W * delta).norm()
}

/// Largest change of a contact's velocity \[m/s\].
fn largest_change(before: &[f64], after: &[f64]) -> f64 {
    let pairs = before.as_chunks::<3>().0.iter().zip(after.as_chunks::<3>().0);
    let change2 = |(b, a): (&[f64; 3], &[f64; 3])| {
        (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)
    };
    pairs.map(change2).fold(0.0, f64::max).sqrt()
}

/// The impulse a contact should have, all others being what they are.
pub fn wanted(cone: Cone, row: &ContactRow, own: &Response, d: &Vec3) -> Vec3 {
    let b = d - own.W * row.lambda;
    match &row.push {
        Some(push) => push.impulse(&own.W, b.x),
        None => own.impulse(cone, row.friction, &b, &row.lambda),
    }
}
