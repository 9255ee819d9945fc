//! The compliance of the whole constrained system at the contacts, `W = J_c K⁻¹ J_cᵀ`, and the
//! impulses found on it.
//!
//! With K eliminated flesh first, `K_ww = L Lᵀ`, half solves are enough:
//!
//! ```text
//!   Y_J = L⁻¹ J_wᵀ,   H = L_S⁻¹ (J_uᵀ - Yᵀ Y_J),   W = Y_Jᵀ Y_J + Hᵀ H
//! ```
//!
//! where `Y = L⁻¹ C` and `S = L_S L_Sᵀ` are those of `direct`. Column 3m + a of W belongs to axis a
//! of member m; columns come in batches of `LANES`. All this is in the factor's precision: rounds
//! with the true velocities correct what it lacks.

use crate::math::Vec3;
use crate::model::Cone;
use crate::solver::exact::aligned::Aligned;
use crate::solver::exact::coarse::Coarse;
use crate::solver::exact::compliance::Compliance;
use crate::solver::exact::decay::{Decay, SAFETY};
use crate::solver::exact::direct::Direct;
use crate::solver::exact::factor::{LANES, Lanes, Scalar};
use crate::solver::exact::gauss_seidel::Response;
use crate::solver::exact::half_solves::{HalfSolves, add_common_product, add_product};
use crate::solver::exact::joining::{ALL_AT_ONCE, Joining};
use crate::solver::exact::pcg::Workspace;
use crate::solver::exact::{System, small_cholesky};
use crate::solver::{ContactRow, ContactRows, Convergence};
use fearless_simd::{Simd, dispatch};
use std::ops::Range;

/// W of the contacts that may press, and the iteration on it.
#[derive(Clone, Debug)]
pub struct Delassus {
    capacity: usize,
    /// The contacts in W.
    members: Vec<u32>,
    /// True for contacts in W.
    is_member: Vec<bool>,
    /// How many of them W holds already.
    built: usize,
    joining: Joining,
    /// Y_J.
    half: HalfSolves,
    /// All supernodes.
    flesh: Vec<u32>,
    /// H: per batch, one register per freedom.
    pull: Aligned<Scalar>,
    freedoms: usize,
    /// Per batch: the groups of bodies that it pulls on.
    pulls_on: Vec<bool>,
    W: Compliance,
    /// Own response of each member.
    own: Vec<Response>,
    /// `J Δv` less its target, at the present impulses.
    d: Aligned<f64>,
    /// That before the present sweep.
    before: Aligned<f64>,
    decay: Decay,
    /// Of every contact: an impulse, and the true `J Δv` less its target there, from which W goes on.
    applied: Vec<Vec3>,
    measured: Vec<Vec3>,
    /// The latter before the first sweep of the step, and the most that sweeps have moved a contact
    /// from there \[m/s\].
    first: Vec<Vec3>,
    moved: f64,
}

impl Delassus {
    /// Room for `capacity` contacts in W, of `contacts_max` found.
    pub fn new(capacity: usize, contacts_max: usize, system: &Direct, freedoms: usize) -> Self {
        let symbolic = &system.factor.symbolic;
        let batches = (3 * capacity).div_ceil(LANES);
        Self {
            members: Vec::with_capacity(capacity),
            is_member: vec![false; contacts_max],
            built: 0,
            joining: Joining::new(contacts_max, symbolic.place_of_node.len()),
            half: HalfSolves::new(symbolic, batches),
            flesh: (0..symbolic.supernodes.len() as u32).collect(),
            pull: Aligned::new(batches * freedoms * LANES),
            freedoms,
            pulls_on: vec![false; batches * system.flesh_of_group.len()],
            W: Compliance::new(batches),
            own: vec![Response::default(); capacity],
            d: Aligned::new(batches * LANES),
            before: Aligned::new(batches * LANES),
            decay: Decay::default(),
            applied: vec![Vec3::zeros(); contacts_max],
            measured: vec![Vec3::zeros(); contacts_max],
            first: vec![Vec3::zeros(); contacts_max],
            moved: 0.0,
            capacity,
        }
    }

    /// Starts anew with the contacts that press and some of those that close although these press.
    pub fn begin(&mut self, contacts: &mut ContactRows, direct: &Direct) {
        self.forget();
        self.first.copy_from_slice(&self.measured);
        self.moved = 0.0;
        self.joining.clear();
        for i in 0..contacts.rows.len() {
            let (row, d) = (&mut contacts.rows[i], self.measured[i].x);
            let presses = row.lambda.x != 0.0 || row.included != 0.0;
            let needed = presses || (row.turns && d < 0.0);
            if !needed || !self.admit(i) {
                row.lambda = Vec3::zeros();
                if d < 0.0 {
                    self.joining.wait(i, -d);
                }
            }
        }
        let all = self.members.len() + self.joining.len() <= ALL_AT_ONCE;
        self.join(contacts, all, direct);
    }

    /// Takes in what the present impulses truly do, the change of velocities that they make.
    pub fn measure(&mut self, contacts: &ContactRows, change: &[Vec3]) {
        let own = self.applied.iter_mut().zip(&mut self.measured);
        for (row, (applied, measured)) in contacts.rows.iter().zip(own) {
            *applied = row.lambda;
            *measured = row.frame * contacts.relative_velocity(row, change) - row.target;
        }
    }

    /// Begins a step: the impulses of the one before press, and nothing of them has been measured.
    /// False when there are none.
    pub fn start(&mut self, contacts: &mut ContactRows) -> bool {
        let mut any = false;
        for (row, applied) in contacts.rows.iter_mut().zip(&mut self.applied) {
            *applied = Vec3::new(row.included, 0.0, 0.0);
            if row.lambda.x <= 0.0 {
                row.lambda = Vec3::zeros();
            }
            any |= row.lambda != *applied;
        }
        any
    }

    /// Adds to the residual what the impulses are more than was measured; false when that is nothing.
    pub fn load_more(
        &self,
        system: &System<'_>,
        contacts: &ContactRows,
        work: &mut Workspace,
    ) -> bool {
        let mut any = false;
        work.f.fill(Vec3::zeros());
        for (row, applied) in contacts.rows.iter().zip(&self.applied) {
            let more = row.lambda - applied;
            if more != Vec3::zeros() {
                contacts.scatter(row, &row.frame.tr_mul(&more), &mut work.f);
                any = true;
            }
        }
        for (i, f) in work.f.iter_mut().enumerate() {
            *f = system.unknown(i, f);
        }
        system.gather(&mut work.f, &mut work.q);
        work.r.add(1.0, &work.q);
        any
    }

    /// Starts anew with these contacts; false when they are too many.
    pub fn begin_with(&mut self, chosen: &[u32], contacts: &ContactRows, direct: &Direct) -> bool {
        self.forget();
        let fits = chosen.iter().all(|&i| self.admit(i as usize));
        self.arrange(contacts, direct);
        fits
    }

    fn forget(&mut self) {
        self.built = 0;
        self.decay = Decay::default();
        self.members.clear();
        self.is_member.fill(false);
    }

    /// New neighbours in the elimination tree share a batch, which then reaches less of it.
    fn arrange(&mut self, contacts: &ContactRows, direct: &Direct) {
        let place = &direct.factor.symbolic.place_of_node;
        self.members[self.built..].sort_unstable_by_key(|&m| {
            let first = nodes_of(contacts, &contacts.rows[m as usize]).next();
            (first.map_or(0, |(node, _)| place[node]), m)
        });
    }

    /// The contacts in W, in its order.
    pub fn members(&self) -> &[u32] {
        &self.members
    }

    /// One entry of W.
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        f64::from(self.W.at(row, column))
    }

    /// `to = Hᵀ g` for all contacts of W, one number per column; g holds the half-solved freedoms
    /// `dofs`, all others are zero.
    pub fn pulled_by(&self, g: &[f64], dofs: &Range<usize>, to: &mut Vec<f64>) {
        to.clear();
        for batch in 0..(3 * self.members.len()).div_ceil(LANES) {
            let mut sums = [0.0_f64; LANES];
            for (lanes, g) in self.pull_of(batch)[dofs.clone()].iter().zip(g) {
                sums.iter_mut().zip(lanes).for_each(|(sum, pull)| *sum += f64::from(*pull) * g);
            }
            to.extend(sums);
        }
        to.truncate(3 * self.members.len());
    }

    fn admit(&mut self, contact: usize) -> bool {
        if self.members.len() == self.capacity || contact >= self.is_member.len() {
            return false;
        }
        self.members.push(contact as u32);
        self.is_member[contact] = true;
        true
    }

    /// Lets contacts in that wait; where there is no room, members without impulse leave. False
    /// when all have one.
    fn join(&mut self, contacts: &ContactRows, all: bool, direct: &Direct) -> bool {
        let mut waiting = std::mem::take(&mut self.joining);
        let mut joined = waiting.admit(contacts, all, |i| self.admit(i));
        if joined == 0 && waiting.len() > 0 {
            self.keep_pressing(contacts);
            joined = waiting.admit(contacts, all, |i| self.admit(i));
        }
        let complete = joined > 0 || waiting.len() == 0;
        self.joining = waiting;
        self.arrange(contacts, direct);
        complete
    }

    /// Only members with an impulse stay, in their order; W is built anew.
    fn keep_pressing(&mut self, contacts: &ContactRows) {
        let members = self.members.len();
        let mut kept = 0;
        for m in 0..members {
            let i = self.members[m];
            let row = &contacts.rows[i as usize];
            let presses = row.lambda.x > 0.0 || row.included != 0.0;
            self.is_member[i as usize] = presses;
            if presses {
                self.members[kept] = i;
                kept += 1;
            }
        }
        if kept < members {
            self.members.truncate(kept);
            (self.built, self.decay) = (0, Decay::default());
        }
    }

    /// Fills the parts of W that new members bring.
    pub fn extend(
        &mut self,
        system: &System<'_>,
        coarse: &Coarse,
        direct: &Direct,
        contacts: &ContactRows,
    ) {
        // The batch that was not full is done again.
        for batch in 3 * self.built / LANES..(3 * self.members.len()).div_ceil(LANES) {
            self.load(batch, system, coarse, direct, contacts);
            self.half.half_solve(&direct.factor, batch);
            self.solve_bodies(batch, system, coarse, direct);
            (0..=batch).for_each(|other| self.multiply(other, batch, system, direct));
        }
        for m in self.built..self.members.len() {
            self.own[m] = Response::new(&self.W.own(m));
        }
        self.built = self.members.len();
    }

    fn pull_of(&self, batch: usize) -> &[Lanes] {
        &self.pull.as_chunks().0[batch * self.freedoms..(batch + 1) * self.freedoms]
    }

    /// `J_wᵀ` and `J_uᵀ` of one batch.
    fn load(
        &mut self,
        batch: usize,
        system: &System<'_>,
        coarse: &Coarse,
        direct: &Direct,
        contacts: &ContactRows,
    ) {
        let (symbolic, row0) = (&direct.factor.symbolic, 2 * system.bodies.bodies());
        let groups = system.bodies.groups();
        self.half.clear(symbolic, batch);
        let freedoms = batch * self.freedoms..(batch + 1) * self.freedoms;
        let pull = &mut self.pull.as_chunks_mut::<LANES>().0[freedoms];
        pull.fill([0.0; LANES]);
        let pulls_on = &mut self.pulls_on[batch * groups.len()..(batch + 1) * groups.len()];
        pulls_on.fill(false);
        let columns = batch * LANES..((batch + 1) * LANES).min(3 * self.members.len());
        for (lane, column) in columns.enumerate() {
            let row = &contacts.rows[self.members[column / 3] as usize];
            let direction: Vec3 = row.frame.row(column % 3).transpose();
            for (node, weight) in nodes_of(contacts, row) {
                let f = system.unknown(row0 + node, &(direction * weight));
                let rhs = self.half.node_mut(symbolic, batch, node);
                (0..3).for_each(|r| rhs[r][lane] += f[r] as Scalar);
                let Some((group, _)) = coarse.cross_of(node) else { continue };
                pulls_on[group] = true;
                for (dof, motion) in coarse.skin_of(node) {
                    pull[groups[group].start + dof][lane] += motion.dot(&f) as Scalar;
                }
            }
            for (body, lever, sign) in row.rigids.iter().flatten() {
                let body = *body as usize;
                let Some(group) = system.bodies.group_of_body(body) else { continue };
                pulls_on[group] = true;
                let [f, moment] = row.wrench(&(direction * *sign), lever);
                for (dof, c) in system.bodies.columns(body) {
                    let (lin, ang) = (Vec3::new(c[0], c[1], c[2]), Vec3::new(c[3], c[4], c[5]));
                    pull[dof][lane] += (lin.dot(&f) + ang.dot(&moment)) as Scalar;
                }
            }
        }
    }

    /// H of one batch.
    fn solve_bodies(
        &mut self,
        batch: usize,
        system: &System<'_>,
        coarse: &Coarse,
        direct: &Direct,
    ) {
        let groups = system.bodies.groups();
        for (g, dofs) in groups.iter().enumerate() {
            if !self.pulls_on[batch * groups.len() + g] {
                continue;
            }
            let flesh = &direct.flesh_of_group[g];
            let first = batch * self.freedoms;
            let pull = &mut self.pull.as_chunks_mut::<LANES>().0;
            let pull = &mut pull[first + dofs.start..first + dofs.end];
            for (k, pull) in pull.chunks_mut(LANES).enumerate().filter(|_| !flesh.is_empty()) {
                let mut product = [[0.0; LANES]; LANES];
                let (carried, own) = ((&direct.half, k), (&self.half, batch));
                add_common_product(&direct.factor, carried, own, flesh, &mut product);
                let pairs = pull.as_flattened_mut().iter_mut().zip(product.as_flattened());
                pairs.for_each(|(pull, product)| *pull -= product);
            }
            small_cholesky::forward_many(&direct.schur[coarse.block(g)], dofs.len(), pull);
        }
    }

    /// W in the columns of one batch and the rows of another, and by symmetry the other way round.
    fn multiply(&mut self, a: usize, b: usize, system: &System<'_>, direct: &Direct) {
        let mut product = [[0.0; LANES]; LANES];
        let (x, y) = ((&self.half, a), (&self.half, b));
        add_common_product(&direct.factor, x, y, &self.flesh, &mut product);
        let groups = system.bodies.groups();
        let pulls_on = |batch: usize, g: usize| self.pulls_on[batch * groups.len() + g];
        for (g, dofs) in groups.iter().enumerate() {
            if pulls_on(a, g) && pulls_on(b, g) {
                let (x, y) = (&self.pull_of(a)[dofs.clone()], &self.pull_of(b)[dofs.clone()]);
                dispatch!(direct.factor.level, simd => add_product(simd, x, y, &mut product));
            }
        }
        self.W.set(a, b, &product);
    }

    fn value(&self, m: usize) -> Vec3 {
        Vec3::from_column_slice(&self.d[3 * m..3 * m + 3])
    }

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
        let n = self.members.len();
        let used = (3 * n).next_multiple_of(LANES);
        let Self { members, W, own, d, before, decay, applied, measured, first, moved, .. } = self;
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

    /// Compares with the true change of velocities, from which W goes on; contacts
    /// that would now close by more than `tolerance` join.
    pub fn check(
        &mut self,
        contacts: &ContactRows,
        change: &[Vec3],
        cone: Cone,
        tolerance: f64,
        direct: &Direct,
    ) -> Verdict {
        self.measure(contacts, change);
        let (mut well, mut violation) = (true, 0.0_f64);
        for m in 0..self.members.len() {
            let i = self.members[m] as usize;
            let (row, d) = (&contacts.rows[i], self.measured[i]);
            let missed = d - self.value(m);
            well &= missed.norm() <= tolerance / SAFETY;
            violation = violation.max(missed.norm());
            let own = &self.own[m];
            let lambda = wanted(cone, row, own, &d);
            violation = violation.max((own.W * (lambda - row.lambda)).norm());
        }
        self.joining.clear();
        for i in 0..contacts.rows.len() {
            let d = self.measured[i].x;
            if !self.is_member[i] && d < -tolerance {
                self.joining.wait(i, -d);
                violation = violation.max(-d);
            }
        }
        if self.joining.len() > 0 {
            let joined = self.join(contacts, false, direct);
            return Verdict { next: if joined { Next::Joined } else { Next::Full }, violation };
        }
        Verdict { next: if well { Next::Done } else { Next::Correct }, violation }
    }
}

/// What the true velocities say of the impulses.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    /// What is to be done.
    pub next: Next,
    /// Largest violation of the contact law \[m/s\].
    pub violation: f64,
}

/// What is to be done next about contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Nothing.
    Done,
    /// Solve again with what W missed.
    Correct,
    /// Solve again with contacts that joined.
    Joined,
    /// More should join, and all members press.
    Full,
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
fn wanted(cone: Cone, row: &ContactRow, own: &Response, d: &Vec3) -> Vec3 {
    let b = d - own.W * row.lambda;
    let lambda = own.impulse(cone, row.friction, &b, &row.lambda);
    row.bounded(lambda, |push_out| {
        let b = Vec3::new(b.x + push_out, b.y, b.z);
        own.impulse(cone, row.friction, &b, &row.lambda)
    })
}

fn nodes_of<'a>(
    contacts: &'a ContactRows,
    row: &ContactRow,
) -> impl Iterator<Item = (usize, f64)> + 'a {
    let range = row.nodes.start as usize..row.nodes.end as usize;
    let nodes = contacts.nodes[range.clone()].iter().map(|n| *n as usize);
    nodes.zip(contacts.weights[range].iter().copied())
}

#[cfg(test)]
#[path = "delassus_tests.rs"]
mod tests;
