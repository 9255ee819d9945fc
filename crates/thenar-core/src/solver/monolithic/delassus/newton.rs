//! Newton's method on the contact law, where sweeps creep.
//!
//! Sweeps pass load on from contact to contact. Where many contacts hold a body that is light for
//! their stiffness, thousands of them are needed, and what each changes says little of what is
//! left. So once sweeps have cost as much as a factorisation of the pressing contacts, the law is
//! solved for all of these at once, as the root of (Alart and Curnier 1991; d is affine in the
//! impulses, `Δd = W Δλ`)
//!
//! ```text
//!   d_n = 0                                pressing, of those that keep an impulse λ_n - d_n / w_n > 0
//!   λ_n = 0, λ_t = 0                       all others
//!   d_t = 0                                sticking, where |z| ≤ μ λ_n, z = λ_t - d_t / w_t
//!   λ_t = μ λ_n z / |z|                    sliding
//! ```
//!
//! w is the contact's own response. The root is sought by steps with the derivative on the present
//! piece of each condition, shortened where that brings the law nearer; what a step would change
//! tells how far the one before was off. Pieces may alternate for ever: then impulses are put back,
//! and sweeps go on.

use super::Delassus;
use super::anderson::FULL;
use super::convex::{ALTERNATIONS, Convex, MEMBERS_MAX};
use super::sweeps::{visit, within};
use super::work;
use crate::math::{Mat3, Vec3};
use crate::model::Cone;
use crate::solver::contact_law::is_immovable;
use crate::solver::monolithic::compliance::Compliance;
use crate::solver::monolithic::decay::SAFETY;
use crate::solver::monolithic::factor::LANES;
use crate::solver::{ContactRow, ContactRows, DenseLu};
use fearless_simd::Simd;

/// Pressing contacts at most: with more, a factorisation costs as much as sweeps are allowed to.
const PRESSING_MAX: usize = 96;
/// Steps of one attempt at most.
const STEPS_MAX: u32 = 60;
/// A step that, made whole, would change no velocity by more than this part of the tolerance has
/// come close: what it changes shrinks as its square near the root, and hardly at all where the
/// root is on another piece. How much of it was made says nothing: at the root round-off hides
/// whether the law comes nearer.
const CLOSE: f64 = 0.1;
/// Steps of this kind in a row that end an attempt: after the first, a sweep may still find a
/// contact on another piece.
const CALM: u32 = 2;
/// Parts of a step, tried until one brings the law nearer.
const PARTS: [f64; 7] = [1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015625];
/// Parts of a step that are made all the same where none brings the law nearer, as at the border of
/// a piece: the next step is on another piece. Attempts take turns: half a step crosses most
/// borders, where grasps slide; a small part is safer where a body is jammed. With either alone
/// steps of both kinds ran out.
const ACROSS: [f64; 2] = [0.5, 0.015625];
/// Every third attempt walks by convex problems (`convex`), as does one for which the sweeps' share
/// is used up; so often in a step at most.
const KINDS: u32 = 3;
const WALKS_MAX: u32 = 2;
/// Numbers of convex problems after which Newton's method is tried, and steps that it may then
/// make: a walk of n contacts costs as much as `1900 + 48 n` sweeps, no more than the sweeps and
/// steps that ran out before.
const TRIED_AFTER: [u32; 4] = [8, 16, 32, 64];
const TRIAL_STEPS: u32 = 12;
/// A part of a step must bring the law nearer by so much of itself (Armijo).
const DESCENT: f64 = 0.2;
/// Added to each contact's own response, in parts of it: ten times the round-off of W, which is of
/// single precision. Contacts that share a load at will (four under a rigid box) then share it
/// evenly.
const REGULAR: f64 = 10.0 * f32::EPSILON as f64;

/// Work space.
#[derive(Debug)]
pub struct Newton {
    capacity: usize,
    lu: DenseLu,
    /// Members that press or close, and their changes of impulse.
    pressing: Vec<u32>,
    change: Vec<f64>,
    /// Impulse of each member where the attempt began.
    began: Vec<Vec3>,
    velocities: Vec<f64>,
    convex: Convex,
}

/// Nothing in it outlives an attempt; a clone has as much room.
impl Clone for Newton {
    fn clone(&self) -> Self {
        Self::new(self.capacity)
    }
}

impl Newton {
    /// Room for this many members.
    pub fn new(capacity: usize) -> Self {
        let most = PRESSING_MAX.min(capacity);
        Self {
            capacity,
            lu: DenseLu::new(3 * most),
            pressing: Vec::with_capacity(capacity),
            change: Vec::with_capacity(3 * most),
            began: Vec::with_capacity(capacity),
            velocities: Vec::with_capacity((3 * capacity).next_multiple_of(LANES)),
            convex: Convex::new(capacity),
        }
    }
}

impl Delassus {
    /// Returns the number of sweeps that cost as much as a step of Newton's method for the members
    /// that press now: `2 (3 n)²` operations each, against `2/3 (3 n)³`; no fewer than mixing needs
    /// to show what it can do, as sweeps stay nearer to the impulses of the step before. More than
    /// are ever made, where no step is.
    pub(super) fn sweeps_worth_steps(&self, contacts: &ContactRows, cone: Cone) -> u32 {
        let rows = || self.members.list().iter().map(|&i| &contacts.rows[i as usize]);
        let pressing = rows().filter(|row| row.lambda.x > 0.0).count();
        let may = cone == Cone::Circular
            && pressing <= PRESSING_MAX
            && rows().all(|row| row.push.is_none());
        if may { FULL.max(pressing as u32) } else { u32::MAX }
    }

    /// Goes on from the present impulses by Newton's method, for this attempt of a solve. The error
    /// that is left \[m/s\]; `None` where it leads nowhere, with the impulses as they were.
    #[inline(always)]
    pub(super) fn improve<S: Simd>(
        &mut self,
        simd: S,
        contacts: &mut ContactRows,
        cone: Cone,
        tolerance: f64,
        steps_max: u32,
    ) -> Option<f64> {
        let n = self.members.list().len();
        let used = (3 * n).next_multiple_of(LANES);
        self.newton.velocities.clear();
        self.newton.velocities.extend_from_slice(&self.d[..used]);
        self.newton.began.clear();
        for &i in self.members.list() {
            let row = &contacts.rows[i as usize];
            self.newton.began.push(row.lambda);
        }
        let left = if steps_max == 0 || self.walks() {
            self.walk(simd, contacts, cone, tolerance)
        } else {
            let across = ACROSS[(self.failed % KINDS) as usize % ACROSS.len()];
            self.approach(simd, contacts, cone, tolerance, steps_max.min(STEPS_MAX), across)
        };
        if left.is_none() {
            self.d[..used].copy_from_slice(&self.newton.velocities);
            for (&i, lambda) in self.members.list().iter().zip(&self.newton.began) {
                contacts.rows[i as usize].lambda = *lambda;
            }
        }
        left
    }

    /// True when it is the turn of convex problems.
    fn walks(&self) -> bool {
        self.failed % KINDS == KINDS - 1 && self.may_walk()
    }

    /// True when convex problems may still be tried in this step.
    pub(super) fn may_walk(&self) -> bool {
        self.walked < WALKS_MAX && self.members.list().len() <= MEMBERS_MAX
    }

    /// Steps from where convex problems lead.
    #[inline(always)]
    fn walk<S: Simd>(
        &mut self,
        simd: S,
        contacts: &mut ContactRows,
        cone: Cone,
        tolerance: f64,
    ) -> Option<f64> {
        self.walked += 1;
        let spent = self.spent;
        let used = (3 * self.members.list().len()).next_multiple_of(LANES);
        let (members, d) = (self.members.list(), &self.d[..used]);
        let n = members.len();
        self.work.add(work::of_convex_factor(n));
        if !self.newton.convex.begin(simd, members, contacts, &self.W, d) {
            return None;
        }
        let mut solved = 0;
        for tried_after in TRIED_AFTER {
            while solved < tried_after {
                if self.work.is_spent() {
                    return None;
                }
                self.work.add(work::of_convex_problem(n, ALTERNATIONS));
                if !self.newton.convex.go_on(simd, &self.W) {
                    return None;
                }
                solved += 1;
            }
            let Self { members, W, d, newton, .. } = &mut *self;
            d[..used].copy_from_slice(newton.convex.without());
            for (m, &i) in members.list().iter().enumerate() {
                let lambda = newton.convex.impulse(m);
                contacts.rows[i as usize].lambda = lambda;
                W.add_answer(simd, m, &lambda, &mut d[..used]);
            }
            let left = self.approach(simd, contacts, cone, tolerance, TRIAL_STEPS, ACROSS[0]);
            // Walks have a share of their own.
            self.spent = spent;
            if left.is_some() {
                return left;
            }
        }
        None
    }

    /// Steps until they are calm, or run out; the error that is left then.
    #[inline(always)]
    fn approach<S: Simd>(
        &mut self,
        simd: S,
        contacts: &mut ContactRows,
        cone: Cone,
        tolerance: f64,
        steps_max: u32,
        across: f64,
    ) -> Option<f64> {
        let mut calm = 0;
        for _ in 0..steps_max {
            if self.work.is_spent() {
                return None;
            }
            let made = self.newton_step(simd, contacts, across);
            let pressing = self.newton.pressing.len();
            self.work.add(work::of_newton_step(pressing, self.members.list().len()));
            self.spent = self.spent.saturating_add(pressing as u32);
            let step = made?;
            if step > CLOSE * tolerance {
                calm = 0;
                continue;
            }
            let left = SAFETY * step.max(self.plain_sweep(simd, contacts, cone));
            calm = if left <= tolerance { calm + 1 } else { 0 };
            if calm == CALM {
                return Some(left);
            }
        }
        None
    }

    /// Brings impulses into their cones and sweeps once; returns the most that a contact changed
    /// its own velocity \[m/s\].
    #[inline(always)]
    fn plain_sweep<S: Simd>(&mut self, simd: S, contacts: &mut ContactRows, cone: Cone) -> f64 {
        let Self { members, W, own, d, .. } = self;
        let members = members.list();
        let d = &mut d[..(3 * members.len()).next_multiple_of(LANES)];
        let mut swept = 0.0_f64;
        for (m, &i) in members.iter().enumerate() {
            let row = &mut contacts.rows[i as usize];
            let allowed = within(cone, row.friction, &row.lambda);
            let delta = allowed - row.lambda;
            row.lambda = allowed;
            W.add_answer(simd, m, &delta, d);
            swept = swept.max(visit(simd, m, W, &own[m], cone, row, d));
        }
        swept
    }

    /// Returns the distance of the members from the law: the sum of the squares of the residuals of
    /// its conditions.
    fn merit(&self, contacts: &ContactRows) -> f64 {
        let members = self.members.list().iter().enumerate();
        members
            .map(|(m, &i)| {
                let (row, value) = (
                    &contacts.rows[i as usize],
                    Vec3::from_column_slice(&self.d[3 * m..3 * m + 3]),
                );
                if row.lambda == Vec3::zeros() && value.x >= 0.0 || is_immovable(&self.own[m].W) {
                    return 0.0;
                }
                conditions(row, &self.own[m].W, &value).iter().map(|c| c.value * c.value).sum()
            })
            .sum()
    }

    /// Makes a step, or as much of it as brings the law nearer, or `across` of it; returns the most
    /// that all of it would change a contact's velocity \[m/s\].
    #[inline(always)]
    fn newton_step<S: Simd>(
        &mut self,
        simd: S,
        contacts: &mut ContactRows,
        across: f64,
    ) -> Option<f64> {
        let merit = self.merit(contacts);
        let Self { members, W, own, d, before, newton, .. } = self;
        let members = members.list();
        let used = (3 * members.len()).next_multiple_of(LANES);
        let (d, before) = (&mut d[..used], &mut before[..used]);
        let row_of = |m: u32| members[m as usize] as usize;
        newton.pressing.clear();
        newton.pressing.extend((0..members.len() as u32).filter(|&m| {
            let closes = d[3 * m as usize] < 0.0;
            contacts.rows[row_of(m)].lambda != Vec3::zeros()
                || closes && !is_immovable(&own[m as usize].W)
        }));
        let pressing = newton.pressing.as_slice();
        if pressing.len() > PRESSING_MAX {
            return None;
        }
        newton.lu.restart(3 * pressing.len());
        newton.change.clear();
        for (k, &m) in pressing.iter().enumerate() {
            let value = Vec3::from_column_slice(&d[3 * m as usize..3 * m as usize + 3]);
            let conditions = conditions(&contacts.rows[row_of(m)], &own[m as usize].W, &value);
            for (a, condition) in conditions.iter().enumerate() {
                condition.put(3 * k + a, (k, m), W, pressing, &mut newton.lu);
                newton.change.push(-condition.value);
            }
        }
        if !newton.lu.factor() {
            return None;
        }
        newton.lu.solve(&mut newton.change);
        // What all of the step would do.
        before.fill(0.0);
        for (&m, change) in pressing.iter().zip(newton.change.as_chunks::<3>().0) {
            W.add_answer(simd, m as usize, &Vec3::from(*change), before);
        }
        let step =
            before.as_chunks::<3>().0.iter().map(|d| Vec3::from(*d).norm()).fold(0.0, f64::max);
        if !step.is_finite() {
            return None;
        }
        let mut made = 0.0;
        for part in PARTS {
            self.move_on(contacts, part - made);
            made = part;
            if self.merit(contacts) <= (1.0 - DESCENT * part) * merit {
                return Some(step);
            }
        }
        self.move_on(contacts, across - made);
        Some(step)
    }

    /// Makes so much of the step.
    fn move_on(&mut self, contacts: &mut ContactRows, part: f64) {
        let newton = &self.newton;
        for (&m, change) in newton.pressing.iter().zip(newton.change.as_chunks::<3>().0) {
            contacts.rows[self.members.list()[m as usize] as usize].lambda +=
                part * Vec3::from(*change);
        }
        let used = (3 * self.members.list().len()).next_multiple_of(LANES);
        self.d[..used].iter_mut().zip(&self.before[..used]).for_each(|(d, more)| *d += part * more);
    }
}

/// One condition, made linear: `own · δλ + seen · δd = -value` for its contact's own impulse and
/// velocity.
#[derive(Clone, Copy, Debug)]
struct Condition {
    value: f64,
    own: Vec3,
    seen: Vec3,
}

impl Condition {
    /// Fills a row of the system: the condition of member m, the k-th that presses.
    #[inline(always)]
    fn put(
        &self,
        row: usize,
        (k, m): (usize, u32),
        W: &Compliance,
        pressing: &[u32],
        lu: &mut DenseLu,
    ) {
        let row = lu.row_mut(row);
        for a in (0..3).filter(|&a| self.seen[a] != 0.0) {
            let response = W.row(3 * m as usize + a);
            for (to, &other) in row.as_chunks_mut::<3>().0.iter_mut().zip(pressing) {
                let seen = &response[3 * other as usize..3 * other as usize + 3];
                (0..3).for_each(|b| to[b] += self.seen[a] * f64::from(seen[b]));
            }
        }
        (0..3).for_each(|b| row[3 * k + b] += self.own[b]);
    }
}

/// Residual of the law at one contact, on the piece on which it is now; in units of velocity.
fn conditions(row: &ContactRow, W: &Mat3, d: &Vec3) -> [Condition; 3] {
    let axes: [Vec3; 3] = std::array::from_fn(|a| Vec3::ith(a, 1.0));
    let lambda = &row.lambda;
    // At rest without impulse, or held by a little more than its own response.
    let w = [W.m11, 0.5 * (W.m22 + W.m33)];
    let weight = |a: usize| w[a.min(1)];
    let none = |a: usize| {
        let scale = W.m11.max(weight(a));
        Condition { value: scale * lambda[a], own: axes[a] * scale, seen: Vec3::zeros() }
    };
    let held =
        |a: usize| Condition { value: d[a], own: axes[a] * (REGULAR * weight(a)), seen: axes[a] };
    let normal = lambda.x - d.x / w[0];
    if normal <= 0.0 {
        return [none(0), none(1), none(2)];
    }
    // Of a contact that begins to press, what it is about to bear.
    let bears = if lambda.x > 0.0 { lambda.x } else { normal };
    let bound = row.friction * bears.max(0.0);
    if bound == 0.0 || w[1] <= f64::EPSILON * w[0] {
        return [held(0), none(1), none(2)];
    }
    let z = [lambda.y - d.y / w[1], lambda.z - d.z / w[1]];
    let length = z[0].hypot(z[1]);
    if length <= bound {
        return [held(0), held(1), held(2)];
    }
    let (n, part) = ([z[0] / length, z[1] / length], bound / length);
    let slides = |a: usize| {
        // Across the direction of sliding: 1 - n nᵀ.
        let across = Vec3::new(0.0, f64::from(a == 1), f64::from(a == 2))
            - n[a - 1] * Vec3::new(0.0, n[0], n[1]);
        let own = axes[a] - part * across - row.friction * n[a - 1] * axes[0];
        let value = w[1] * (lambda[a] - bound * n[a - 1]);
        Condition { value, own: w[1] * own, seen: part * across }
    };
    [held(0), slides(1), slides(2)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::solver::contact_law::Response;

    fn contact(random: &mut Random) -> (ContactRow, Mat3) {
        let a = Mat3::from_fn(|_, _| random.range(-1.0, 1.0));
        let W = a * a.transpose() + Mat3::identity() * 0.3;
        let mut rows = ContactRows::with_capacity(0, 1);
        rows.begin(&Vec3::x(), random.range(0.1, 1.0), &Vec3::zeros());
        (rows.rows.remove(0), W)
    }

    /// The residuals of the law's conditions vanish where visits have found its impulse.
    #[test]
    fn the_conditions_hold_where_the_law_does() {
        let mut random = Random::new(31);
        let (mut stuck, mut slid) = (0, 0);
        for _ in 0..500 {
            let (mut row, W) = contact(&mut random);
            let (b, response) = (random.vector(1.0), Response::new(&W));
            for _ in 0..300 {
                row.lambda = response.impulse(Cone::Circular, row.friction, &b, &row.lambda);
            }
            let d = b + W * row.lambda;
            for condition in conditions(&row, &W, &d) {
                assert!(condition.value.abs() < 1e-8, "{row:?} {d}");
            }
            slid += usize::from(row.lambda.x > 0.0 && d.yz().norm() > 1e-3);
            stuck += usize::from(row.lambda.x > 0.0 && d.yz().norm() < 1e-9);
        }
        assert!(stuck > 10 && slid > 50, "{stuck} stuck, {slid} slid");
    }

    /// The derivative of the conditions is that of central differences, on every piece but for what
    /// keeps the system regular.
    #[test]
    fn the_conditions_are_made_linear() {
        let mut random = Random::new(32);
        let mut slid = 0;
        for _ in 0..500 {
            let (mut row, W) = contact(&mut random);
            let mut impulse = random.vector(1.0);
            impulse.x = impulse.x.abs() + 0.1;
            let (d, change) = (random.vector(0.5), random.vector(1.0));
            row.lambda = impulse;
            let here = conditions(&row, &W, &d);
            let e = 1e-6;
            let mut at = |part: f64| {
                row.lambda = impulse + part * change;
                conditions(&row, &W, &(d + part * (W * change))).map(|c| c.value)
            };
            let (ahead, behind) = (at(e), at(-e));
            for (k, condition) in here.iter().enumerate() {
                let told = condition.own.dot(&change) + condition.seen.dot(&(W * change));
                let seen = (ahead[k] - behind[k]) / (2.0 * e);
                let regular = 2.0 * REGULAR * W.trace() * change.norm();
                assert!((told - seen).abs() < regular + 1e-7, "condition {k}: {told}, {seen}");
                slid += usize::from(condition.own.norm() > 1e-3 && condition.seen != Vec3::zeros());
            }
        }
        assert!(slid > 100, "{slid} conditions of sliding");
    }
}
