//! The compliance of the whole constrained system at the contacts, `W = J_c K⁻¹ J_cᵀ`, and the
//! impulses found on it.
//!
//! The rows of the contacts are put together from few columns (`handles`), whose own compliance
//! (`columns`) gives W (`combine`). Row and column 3m + a of W belong to axis a of member m
//! (`members`). Impulses come from sweeps over them (`sweeps`). All this is in the factor's
//! precision: rounds with the true velocities correct what it lacks.

mod anderson;
mod columns;
mod combine;
mod convex;
mod creep;
mod handles;
mod members;
mod newton;
mod sweeps;
#[cfg(test)]
mod tests;
mod turns;
mod work;

use crate::math::Vec3;
use crate::model::Cone;
use crate::solver::contact_law::Response;
use crate::solver::monolithic::System;
use crate::solver::monolithic::aligned::Aligned;
use crate::solver::monolithic::coarse::Coarse;
use crate::solver::monolithic::compliance::Compliance;
use crate::solver::monolithic::decay::{Decay, SAFETY};
use crate::solver::monolithic::direct::Direct;
use crate::solver::monolithic::factor::LANES;
use crate::solver::monolithic::pcg::Workspace;
use crate::solver::{ContactRow, ContactRows};
use anderson::Anderson;
use columns::Columns;
use combine::CombineWorkspace;
use fearless_simd::dispatch;
use handles::Handles;
use members::Members;
use newton::Newton;
use std::ops::Range;
pub use sweeps::{SweepOutcome, within};
use turns::Turns;
use work::WorkBudget;

/// W of the contacts that may press, and the iteration on it.
#[derive(Clone, Debug)]
pub struct Delassus {
    members: Members,
    /// Number of members that W holds already.
    built: usize,
    handles: Handles,
    columns: Columns,
    combine: CombineWorkspace,
    W: Compliance,
    /// Own response of each member.
    own: Vec<Response>,
    /// One number per handle.
    per_handle: Vec<f64>,
    /// `J Δv` less its target, at the present impulses.
    d: Aligned<f64>,
    /// That before the present sweep.
    before: Aligned<f64>,
    decay: Decay,
    anderson: Anderson,
    newton: Newton,
    turns: Turns,
    /// Impulses of the members before a sweep, and what it changed.
    x: Vec<f64>,
    f: Vec<f64>,
    /// Impulse of every contact at which `measured` is known.
    applied: Vec<Vec3>,
    /// True `J Δv` less its target of every contact at the impulse `applied`, from which W goes on.
    measured: Vec<Vec3>,
    /// Values of `measured` before the first sweep of the step, and the most that sweeps have moved
    /// a contact from there \[m/s\].
    first: Vec<Vec3>,
    moved: f64,
    /// Sweeps of the step, and those that Newton's method has cost as much as.
    swept: u32,
    spent: u32,
    /// Work of the step, spent and allowed.
    work: WorkBudget,
    /// Attempts of the step by Newton's method that failed, and all that went by convex problems.
    failed: u32,
    walked: u32,
}

impl Delassus {
    /// Room for `capacity` contacts in W, of `contacts_max` found.
    pub fn new(
        capacity: usize,
        contacts_max: usize,
        bodies: usize,
        system: &Direct,
        freedoms: usize,
    ) -> Self {
        let nodes = system.factor.symbolic.place_of_node.len();
        let batches = (3 * capacity).div_ceil(LANES);
        Self {
            members: Members::new(capacity, contacts_max, nodes),
            built: 0,
            handles: Handles::new(capacity, nodes, bodies),
            columns: Columns::new(batches, system, freedoms),
            combine: CombineWorkspace::new(batches),
            W: Compliance::new(batches),
            own: vec![Response::default(); capacity],
            per_handle: vec![0.0; batches * LANES],
            d: Aligned::new(batches * LANES),
            before: Aligned::new(batches * LANES),
            decay: Decay::default(),
            anderson: Anderson::new(3 * capacity),
            newton: Newton::new(capacity),
            turns: Turns::new(capacity),
            x: vec![0.0; 3 * capacity],
            f: vec![0.0; 3 * capacity],
            applied: vec![Vec3::zeros(); contacts_max],
            measured: vec![Vec3::zeros(); contacts_max],
            first: vec![Vec3::zeros(); contacts_max],
            moved: 0.0,
            swept: 0,
            spent: 0,
            work: WorkBudget::default(),
            failed: 0,
            walked: 0,
        }
    }

    /// Starts a step that may cost this many multiply-adds; no bound when `None`.
    pub fn allow(&mut self, work_max: Option<u64>) {
        self.work = WorkBudget::within(work_max);
    }

    /// True when the step has cost what it may.
    pub fn is_spent(&self) -> bool {
        self.work.is_spent()
    }

    /// Starts anew with the contacts that press and some of those that close although these press.
    pub fn begin(&mut self, contacts: &mut ContactRows, direct: &Direct) {
        self.forget();
        self.first.copy_from_slice(&self.measured);
        (self.moved, self.swept, self.spent, self.failed, self.walked) = (0.0, 0, 0, 0, 0);
        self.members.begin(contacts, &self.measured);
        self.arrange(contacts, direct);
    }

    /// Nobody is in W: what it holds is of another step.
    pub fn leave(&mut self) {
        self.forget();
        self.members.clear();
    }

    /// Goes on with other rows for the same contacts, no impulse yet; what asks for one joins.
    /// False when none does.
    pub fn begin_push(
        &mut self,
        contacts: &ContactRows,
        change: &[Vec3],
        tolerance: f64,
        direct: &Direct,
    ) -> bool {
        self.measure(contacts, change);
        self.first.copy_from_slice(&self.measured);
        (self.moved, self.swept, self.spent, self.decay) = (0.0, 0, 0, Decay::default());
        self.members.queue(contacts, &self.measured, tolerance);
        if self.members.waiting() > 0 {
            self.join(contacts, direct);
        }
        !self.members.list().is_empty()
    }

    /// Takes in what the present impulses truly do, the change of velocities that they make.
    pub fn measure(&mut self, contacts: &ContactRows, change: &[Vec3]) {
        let own = self.applied.iter_mut().zip(&mut self.measured);
        for (row, (applied, measured)) in contacts.rows.iter().zip(own) {
            *applied = row.lambda;
            *measured = row.frame * contacts.relative_velocity(row, change) - row.target;
        }
    }

    /// Returns the deviation of the present impulses from the law at the velocities measured
    /// \[m/s\]; infinite for the linearised cone, which is not asked.
    pub fn strays(&self, contacts: &ContactRows, cone: Cone) -> f64 {
        if cone == Cone::Linearised {
            return f64::INFINITY;
        }
        let rows = contacts.rows.iter().zip(&self.measured);
        // What is not a number stays one.
        rows.map(|(row, d)| row.strays(d)).fold(0.0, |most, x| if x <= most { most } else { x })
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

    /// Adds to the residual what the impulses are more than was measured; false when that is
    /// nothing.
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
        self.members.clear();
        let fits = chosen.iter().all(|&i| self.members.admit(i as usize));
        self.arrange(contacts, direct);
        fits
    }

    /// W is built anew.
    fn forget(&mut self) {
        (self.built, self.decay) = (0, Decay::default());
        self.handles.clear();
        self.columns.clear();
    }

    fn arrange(&mut self, contacts: &ContactRows, direct: &Direct) {
        self.members.arrange(self.built, contacts, &direct.factor.symbolic.in_space);
    }

    /// The contacts in W, in its order.
    pub fn members(&self) -> &[u32] {
        self.members.list()
    }

    /// One entry of W.
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        f64::from(self.W.at(row, column))
    }

    /// `to = Hᵀ g` for all contacts of W, one number per column, H being what they pull on the
    /// bodies, half solved; g holds the half-solved freedoms `dofs`, all others are zero.
    pub fn pulled_by(&mut self, g: &[f64], dofs: &Range<usize>, to: &mut Vec<f64>) {
        self.columns.pulled_by(g, dofs, &mut self.per_handle);
        to.clear();
        for m in 0..self.built {
            to.extend((0..3).map(|a| {
                let terms = self.handles.terms(m).iter();
                terms
                    .map(|t| f64::from(t.weights[a]) * self.per_handle[t.column as usize])
                    .sum::<f64>()
            }));
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
        let Self { members, built, handles, columns, combine, W, own, .. } = self;
        let members = members.list();
        let place = &direct.factor.symbolic.place_of_node;
        let moves = |body: usize| system.bodies.group_of_body(body).is_some();
        handles.extend(&members[*built..], contacts, place, moves);
        columns.extend(system, coarse, direct, contacts, handles.list());
        dispatch!(direct.factor.level, simd => {
            combine.fill(simd, &columns.G, handles, (*built, members.len()), W)
        });
        for m in *built..members.len() {
            own[m] = Response::new(&W.own(m));
        }
        *built = members.len();
    }

    /// Compares with the true change of velocities, from which W goes on; contacts
    /// that would now close by more than `tolerance` allows for join.
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
        for (m, &i) in self.members.list().iter().enumerate() {
            let (row, d) = (&contacts.rows[i as usize], self.measured[i as usize]);
            let missed = d - Vec3::from_column_slice(&self.d[3 * m..3 * m + 3]);
            well &= missed.norm() <= tolerance / SAFETY;
            violation = violation.max(missed.norm());
            let own = &self.own[m];
            let lambda = row.resolved(cone, own, &d);
            violation = violation.max((own.W * (lambda - row.lambda)).norm());
        }
        violation = violation.max(self.members.queue(contacts, &self.measured, tolerance / SAFETY));
        let next = if self.members.waiting() > 0 {
            if self.join(contacts, direct) { NextPass::Joined } else { NextPass::Full }
        } else if well {
            NextPass::Done
        } else {
            NextPass::Correct
        };
        Verdict { next, violation }
    }

    /// Lets contacts in that wait; where there is no room, members without impulse leave. False
    /// when all have one.
    fn join(&mut self, contacts: &ContactRows, direct: &Direct) -> bool {
        let mut complete = self.members.join(contacts, false);
        if !complete && self.members.keep_pressing(contacts) {
            self.forget();
            complete = self.members.join(contacts, false);
        }
        self.arrange(contacts, direct);
        complete
    }
}

/// Assessment of the impulses by the true velocities.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    /// Next pass to make.
    pub next: NextPass,
    /// Largest violation of the contact law \[m/s\].
    pub violation: f64,
}

/// Next pass over contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NextPass {
    /// Nothing is left to do.
    Done,
    /// Solve again with what W missed.
    Correct,
    /// Solve again with contacts that joined.
    Joined,
    /// More should join, and all members press.
    Full,
}

fn nodes_of<'a>(
    contacts: &'a ContactRows,
    row: &ContactRow,
) -> impl Iterator<Item = (usize, f64)> + 'a {
    let range = row.nodes.start as usize..row.nodes.end as usize;
    let nodes = contacts.nodes[range.clone()].iter().map(|n| *n as usize);
    nodes.zip(contacts.weights[range].iter().copied())
}
