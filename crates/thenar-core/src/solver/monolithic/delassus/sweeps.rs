//! Gauss-Seidel sweeps over the members of W.

use super::anderson::FULL;
use super::creep::Creeping;
use super::{Delassus, work};
use crate::math::Vec3;
use crate::model::Cone;
use crate::solver::contact_law::Response;
use crate::solver::monolithic::compliance::Compliance;
use crate::solver::monolithic::decay::SAFETY;
use crate::solver::monolithic::direct::Direct;
use crate::solver::monolithic::factor::LANES;
use crate::solver::monolithic::respond::RESUMED_MAX;
use crate::solver::{ContactRow, ContactRows, Convergence};
use fearless_simd::{Simd, dispatch};

/// The last sweeps are plain: what they leave is not thrown off by a combination.
const LAST: u32 = 8;
/// Number of sweeps that must agree before what mixing expects is believed: the first ones know few
/// directions.
const LOOKS: usize = 5;
/// Steps of Newton's method cost at most this many times what the sweeps do that run out otherwise.
/// With one time 11 of 162 steps of `bread-grasp` missed the tolerance, with four 1 does, and the
/// slowest of a hundred takes a fifth less time: where steps end before the sweeps do, sweeps are
/// made no longer.
const NEWTON_SHARE: u32 = 4;
/// Times that Newton's method may fail before what mixing expects is believed all the same.
const ATTEMPTS: u32 = 3;
/// Factor from what mixing expects to the change taken for all further sweeps: twice the factor for
/// bodies that move more than their contacts, as the history knows only some directions.
const EXPECTED_SAFETY: f64 = 2.0 * SAFETY;
/// Velocities that W tells are known to this part of what a contact does to its own: W is of single
/// precision. Contacts that share a load at will contradict each other by as much, and no sweep
/// settles that; the next round goes on from the true velocities.
const ROUND_OFF: f64 = f32::EPSILON as f64;

/// Outcome of sweeps.
#[derive(Clone, Copy, Debug)]
pub struct SweepOutcome {
    /// Number of sweeps made, and their possible error \[m/s\].
    pub found: Convergence,
    /// True when sweeps reached the accuracy asked for, or that of W; false when they ran out.
    pub settled: bool,
}

impl Delassus {
    /// Finds impulses from the present ones by sweeps over the members, until one changes no
    /// contact's velocity by more than `tolerance` \[m/s\] through its own impulse, and all further
    /// ones together are not expected to change any velocity by more: as their mixing tells, or,
    /// where they are plain, a geometric series. Velocities are sought no finer than W tells them.
    /// Where sweeps have cost as much as Newton's method, it takes over (`newton`); where it fails,
    /// limits of joints are held from then on (`turns`). Where they run out before, the residual is
    /// the larger of what the last sweep changed and what the last mixing expected; it is no more
    /// than sweeps have moved a contact in this step, but enough above the tolerance not to pass
    /// for converged.
    ///
    /// `ran_out` says that those of the round before did: these begin where a creep of load ends
    /// (`creep`).
    pub fn solve(
        &mut self,
        contacts: &mut ContactRows,
        cone: Cone,
        tolerance: f64,
        sweeps_max: u32,
        ran_out: bool,
        direct: &Direct,
    ) -> SweepOutcome {
        dispatch!(direct.factor.level, simd => {
            self.begin_sweeps(simd, contacts);
            let led = if ran_out && !self.work.is_spent() {
                self.lead_on(simd, contacts, cone)
            } else {
                0
            };
            let mut swept = self.sweep(simd, contacts, cone, tolerance, sweeps_max);
            swept.found.iterations += led;
            swept
        })
    }

    /// Returns how many sweeps it took.
    #[inline(always)]
    fn lead_on<S: Simd>(&mut self, simd: S, contacts: &mut ContactRows, cone: Cone) -> u32 {
        let Self { members, W, own, d, f, swept, work, .. } = self;
        let (members, n) = (members.list(), members.list().len());
        let d = &mut d[..(3 * n).next_multiple_of(LANES)];
        let mut creeping = Creeping { members, contacts, cone, W, own, d };
        let sweeps = creeping.lead_on(simd, &mut f[..3 * n]);
        *swept += sweeps;
        // A lead costs no more than a sweep, and comes after two.
        work.add(u64::from(sweeps + sweeps / 2) * work::of_sweep(n));
        sweeps
    }

    #[inline(always)]
    fn sweep<S: Simd>(
        &mut self,
        simd: S,
        contacts: &mut ContactRows,
        cone: Cone,
        asked: f64,
        sweeps_max: u32,
    ) -> SweepOutcome {
        self.turns.forget();
        let mut convergence = Convergence { iterations: 0, residual: f64::INFINITY };
        let mut settled = true;
        // What mixing expected to be left after each of the last sweeps.
        let mut expected = [f64::INFINITY; LOOKS];
        let mut mixed = false;
        let (mut tolerance, mut sweeps_max) = (asked, sweeps_max);
        let worth = self.sweeps_worth_steps(contacts, cone);
        let (mut wait, mut attempts) = (worth, 0);
        let budget = (NEWTON_SHARE * (1 + RESUMED_MAX)).saturating_mul(sweeps_max);
        loop {
            let steps_max = budget.saturating_sub(self.spent) / worth;
            let may_try = !self.work.is_spent() && (steps_max > 0 || self.may_walk());
            if self.swept >= wait && may_try {
                let improved = self.improve(simd, contacts, cone, tolerance, steps_max);
                if let Some(left) = improved {
                    convergence.residual = left;
                    break;
                }
                // From here on limits give way within each visit.
                self.failed += 1;
                (wait, attempts) = (self.swept.saturating_mul(2), attempts + 1);
                self.decay.interrupt();
                self.anderson.restart();
                expected = [f64::INFINITY; LOOKS];
            }
            let Self {
                members,
                W,
                own,
                d,
                before,
                decay,
                anderson,
                x,
                f,
                applied,
                first,
                moved,
                swept,
                turns,
                work,
                ..
            } = self;
            let (members, n) = (members.list(), members.list().len());
            let used = (3 * n).next_multiple_of(LANES);
            let (d, before, x, f) =
                (&mut d[..used], &mut before[..used], &mut x[..3 * n], &mut f[..3 * n]);
            let gives_way = attempts > 0;
            if gives_way {
                turns.hold(simd, members, contacts, W, d);
            }
            before.copy_from_slice(d);
            gather(members, contacts, x);
            let mut own_change = 0.0_f64;
            for m in 0..n {
                let row = &mut contacts.rows[members[m] as usize];
                if !gives_way {
                    own_change = own_change.max(visit(simd, m, W, &own[m], cone, row, d));
                } else if !turns.holds(m) {
                    let change = visit(simd, m, W, turns.own(m), cone, row, d);
                    own_change = own_change.max(change);
                    if change > 0.0 {
                        turns.settle(simd, members, contacts, W, d);
                    }
                }
            }
            if gives_way {
                own_change = own_change.max(turns.pull(members, contacts, W));
            }
            convergence.iterations += 1;
            *swept += 1;
            work.add(work::of_sweep(n));
            if work.is_spent() {
                // The last sweeps follow now, after as many as mixing needs to show what it can do.
                sweeps_max = sweeps_max.min((convergence.iterations + LAST).max(FULL));
            }
            tolerance = asked;
            for ((&i, own), d) in members.iter().zip(&*own).zip(d.as_chunks::<3>().0) {
                let i = i as usize;
                *moved = moved.max((Vec3::from(*d) - first[i]).norm());
                let pushed = own.W * (contacts.rows[i].lambda - applied[i]);
                tolerance = tolerance.max(ROUND_OFF * pushed.norm());
            }
            let change = largest_change(before, d);
            let last = convergence.iterations + LAST > sweeps_max;
            convergence.residual = own_change.max(decay.error_after(change));
            // Where Newton's method is worth it, estimates are not believed, unless it failed
            // often.
            let believed = *swept < worth || attempts >= ATTEMPTS || worth > budget;
            // After a mixing one plain sweep says nothing of what shrinks slowest.
            if convergence.residual <= tolerance && (last || !mixed || change == 0.0) {
                if believed || change == 0.0 {
                    break;
                }
                wait = 0;
                if !last {
                    continue;
                }
            }
            if last {
                if convergence.iterations >= sweeps_max {
                    let left = (EXPECTED_SAFETY * largest(&expected)).min(convergence.residual);
                    convergence.residual = own_change.max(left).max(SAFETY * asked);
                    settled = false;
                    break;
                }
                continue;
            }
            // From here on `before` keeps the velocities that the sweep ended with, x its impulses.
            before.copy_from_slice(d);
            for (m, x) in x.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                let lambda = contacts.rows[members[m] as usize].lambda;
                let weight = own[m].W.trace().sqrt();
                (0..3).for_each(|a| f[3 * m + a] = weight * (lambda[a] - x[a]));
                *x = lambda.into();
            }
            if !anderson.mix(f, x, &mut d[..3 * n]) {
                expected = [f64::INFINITY; LOOKS];
                continue;
            }
            mixed = true;
            expected.rotate_left(1);
            expected[LOOKS - 1] = largest_change(before, d);
            convergence.residual = own_change.max(EXPECTED_SAFETY * largest(&expected));
            if convergence.residual <= tolerance {
                d.copy_from_slice(before);
                if believed {
                    break;
                }
                wait = 0;
                continue;
            }
            decay.interrupt();
            for m in 0..n {
                let row = &mut contacts.rows[members[m] as usize];
                let mixed = Vec3::from_column_slice(&x[3 * m..3 * m + 3]);
                row.lambda = within(cone, row.friction, &mixed);
                let delta = row.lambda - mixed;
                if delta != Vec3::zeros() {
                    W.add_answer(simd, m, &delta, d);
                }
            }
        }
        if attempts > 0 {
            let Self { members, W, d, turns, .. } = self;
            let used = (3 * members.list().len()).next_multiple_of(LANES);
            turns.release(simd, members.list(), contacts, W, &mut d[..used]);
        }
        convergence.residual = convergence.residual.min(SAFETY * asked + self.moved);
        SweepOutcome { found: convergence, settled }
    }

    /// Velocities at the present impulses: the true ones, and what W says of the rest.
    #[inline(always)]
    fn begin_sweeps<S: Simd>(&mut self, simd: S, contacts: &ContactRows) {
        let Self { members, W, d, applied, measured, decay, anderson, .. } = self;
        let members = members.list();
        let d = &mut d[..(3 * members.len()).next_multiple_of(LANES)];
        d.fill(0.0);
        for (m, &i) in members.iter().enumerate() {
            let more = contacts.rows[i as usize].lambda - applied[i as usize];
            if more != Vec3::zeros() {
                W.add_answer(simd, m, &more, d);
            }
        }
        for (m, &i) in members.iter().enumerate() {
            (0..3).for_each(|a| d[3 * m + a] += measured[i as usize][a]);
        }
        decay.interrupt();
        anderson.restart();
    }
}

fn largest(x: &[f64]) -> f64 {
    x.iter().copied().fold(0.0, f64::max)
}

fn gather(members: &[u32], contacts: &ContactRows, x: &mut [f64]) {
    for (x, &i) in x.as_chunks_mut::<3>().0.iter_mut().zip(members) {
        *x = contacts.rows[i as usize].lambda.into();
    }
}

/// The impulse of the cone that has this normal part, or none, and the nearest friction.
pub fn within(cone: Cone, friction: f64, lambda: &Vec3) -> Vec3 {
    let normal = lambda.x.max(0.0);
    let bound = friction * normal;
    match cone {
        Cone::Circular => {
            let length = lambda.y.hypot(lambda.z);
            let scale = if length > bound { bound / length } else { 1.0 };
            Vec3::new(normal, lambda.y * scale, lambda.z * scale)
        }
        Cone::Linearised => {
            let bound = bound * std::f64::consts::FRAC_1_SQRT_2;
            let t = [lambda.y, lambda.z].map(|t| t.max(-bound).min(bound));
            Vec3::new(normal, t[0], t[1])
        }
    }
}

/// Gives member m its impulse; returns the change of its velocity \[m/s\].
#[inline(always)]
pub(super) fn visit<S: Simd>(
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
    let lambda = row.resolved(cone, own, &value);
    let delta = lambda - row.lambda;
    if delta == Vec3::zeros() {
        return 0.0;
    }
    row.lambda = lambda;
    W.add_answer(simd, m, &delta, d);
    (own.W * delta).norm()
}

/// Largest change of a contact's velocity \[m/s\].
pub(super) fn largest_change(before: &[f64], after: &[f64]) -> f64 {
    let pairs = before.as_chunks::<3>().0.iter().zip(after.as_chunks::<3>().0);
    let change2 = |(b, a): (&[f64; 3], &[f64; 3])| {
        (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)
    };
    pairs.map(change2).fold(0.0, f64::max).sqrt()
}
