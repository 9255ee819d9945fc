//! The compliance of the whole constrained system at the contacts, `W = J_c K⁻¹ J_cᵀ`, and the
//! impulses found on it.
//!
//! With K eliminated flesh first, and R the contact's pull on the freedoms once the flesh has
//! answered,
//!
//! ```text
//!   W = J_w K_ww⁻¹ J_wᵀ + Hᵀ H,   H = L_S⁻¹ R,   R = J_uᵀ - Xᵀ J_wᵀ
//! ```

use crate::math::{Mat3, Vec3};
use crate::model::Cone;
use crate::solver::exact::coarse::Coarse;
use crate::solver::exact::direct::Direct;
use crate::solver::exact::factor::{LANES, Lanes, Scalar};
use crate::solver::exact::gauss_seidel::impulse;
use crate::solver::exact::{System, small_cholesky};
use crate::solver::{ContactRow, ContactRows, Convergence};

/// Contacts solved for in one panel of right-hand sides.
const BATCH: usize = LANES / 3;

/// W of the contacts that may press, and the iteration on it.
#[derive(Clone, Debug)]
pub struct Delassus {
    capacity: usize,
    /// The contacts in W.
    pub members: Vec<u32>,
    /// True for contacts in W.
    is_member: Vec<bool>,
    /// How many of them W holds already.
    built: usize,
    /// W, row by row; a row has `3 capacity` numbers.
    w: Vec<f64>,
    /// `J Δv` less its target, at the present impulses.
    d: Vec<f64>,
    /// What the true `J Δv` has more than W says.
    correction: Vec<Vec3>,
    /// H: per contact and side, three columns of the widest group.
    h: Vec<f64>,
    groups: Vec<[Option<u32>; 2]>,
    widest: usize,
}

impl Delassus {
    /// Room for `capacity` contacts in W, of `contacts_max` found.
    pub fn new(capacity: usize, contacts_max: usize, widest: usize) -> Self {
        Self {
            members: Vec::with_capacity(capacity),
            is_member: vec![false; contacts_max],
            built: 0,
            w: vec![0.0; 9 * capacity * capacity],
            d: vec![0.0; 3 * capacity],
            correction: vec![Vec3::zeros(); capacity],
            h: vec![0.0; 6 * widest * capacity],
            groups: vec![[None; 2]; capacity],
            capacity,
            widest,
        }
    }

    /// Starts anew with the contacts that close, or pressed before; the others get no impulse. False
    /// when they are too many.
    pub fn begin(&mut self, contacts: &mut ContactRows) -> bool {
        self.built = 0;
        self.members.clear();
        self.is_member.fill(false);
        for i in 0..contacts.rows.len() {
            let row = &mut contacts.rows[i];
            if row.target.x > 0.0 || row.lambda.x > 0.0 {
                if !self.admit(i) {
                    return false;
                }
            } else {
                row.lambda = Vec3::zeros();
            }
        }
        true
    }

    fn admit(&mut self, contact: usize) -> bool {
        if self.members.len() == self.capacity || contact >= self.is_member.len() {
            return false;
        }
        self.correction[self.members.len()] = Vec3::zeros();
        self.members.push(contact as u32);
        self.is_member[contact] = true;
        true
    }

    /// Fills the parts of W that new members bring.
    pub fn extend(
        &mut self,
        system: &System<'_>,
        coarse: &Coarse,
        direct: &mut Direct,
        contacts: &ContactRows,
    ) {
        for m in self.built..self.members.len() {
            self.pull_on_bodies(m, system, coarse, direct, contacts);
        }
        direct.factor.want_none();
        for &member in &self.members {
            let row = &contacts.rows[member as usize];
            nodes_of(contacts, row).for_each(|(node, _)| direct.factor.want(node));
        }
        for first in (self.built..self.members.len()).step_by(BATCH) {
            let end = (first + BATCH).min(self.members.len());
            self.answer_of_flesh(first..end, system, direct, contacts);
        }
        for i in 0..self.members.len() {
            for j in self.built.max(i)..self.members.len() {
                self.add_answer_of_bodies(i, j);
            }
        }
        self.built = self.members.len();
    }

    /// H of one member.
    fn pull_on_bodies(
        &mut self,
        m: usize,
        system: &System<'_>,
        coarse: &Coarse,
        direct: &Direct,
        contacts: &ContactRows,
    ) {
        let row = &contacts.rows[self.members[m] as usize];
        let row0 = 2 * system.bodies.bodies();
        let widest = self.widest;
        let h = &mut self.h[6 * widest * m..6 * widest * (m + 1)];
        h.fill(0.0);
        let groups = &mut self.groups[m];
        *groups = [None; 2];
        let mut side_of = |group: usize| {
            let at = groups.iter().position(|g| *g == Some(group as u32));
            let at = at.or_else(|| groups.iter().position(Option::is_none)).unwrap_or(1);
            groups[at] = Some(group as u32);
            at
        };
        for (node, weight) in nodes_of(contacts, row) {
            let Some((group, cross)) = coarse.cross_of(node) else { continue };
            let side = side_of(group);
            for axis in 0..3 {
                let f = system.unknown(row0 + node, &(row.frame.row(axis).transpose() * weight));
                let column = &mut h[(3 * side + axis) * widest..(3 * side + axis + 1) * widest];
                column.iter_mut().zip(&direct.X[cross.clone()]).for_each(|(h, x)| *h -= x.dot(&f));
                coarse.skin_of(node).for_each(|(dof, motion)| column[dof] += motion.dot(&f));
            }
        }
        for (body, lever, sign) in row.rigids.iter().flatten() {
            let Some(group) = system.bodies.group_of_body(*body as usize) else { continue };
            let (side, start) = (side_of(group), system.bodies.groups()[group].start);
            for axis in 0..3 {
                let [f, moment] = row.wrench(&(row.frame.row(axis).transpose() * *sign), lever);
                let column = &mut h[(3 * side + axis) * widest..(3 * side + axis + 1) * widest];
                for (dof, c) in system.bodies.columns(*body as usize) {
                    let (lin, ang) = (Vec3::new(c[0], c[1], c[2]), Vec3::new(c[3], c[4], c[5]));
                    column[dof - start] += lin.dot(&f) + ang.dot(&moment);
                }
            }
        }
        for (side, group) in groups.iter().enumerate() {
            let Some(group) = group.map(|g| g as usize) else { continue };
            let n = system.bodies.groups()[group].len();
            for axis in 0..3 {
                let at = (3 * side + axis) * widest;
                let l = &direct.schur[coarse.block(group)];
                small_cholesky::forward(l, n, &mut h[at..at + n]);
            }
        }
    }

    /// `J_w K_ww⁻¹ J_wᵀ` in the columns of some members, and by symmetry in their rows.
    fn answer_of_flesh(
        &mut self,
        batch: std::ops::Range<usize>,
        system: &System<'_>,
        direct: &mut Direct,
        contacts: &ContactRows,
    ) {
        let row0 = 2 * system.bodies.bodies();
        direct.factor.clear_many();
        let mut soft = false;
        for (k, m) in batch.clone().enumerate() {
            let row = &contacts.rows[self.members[m] as usize];
            for (node, weight) in nodes_of(contacts, row) {
                soft = true;
                let rhs = direct.factor.many_mut(node);
                for axis in 0..3 {
                    let f = row.frame.row(axis).transpose() * weight;
                    let f = system.unknown(row0 + node, &f);
                    (0..3).for_each(|r| rhs[r][3 * k + axis] += f[r] as Scalar);
                }
            }
        }
        if soft {
            direct.factor.solve_many();
        }
        let stride = 3 * self.capacity;
        for i in 0..batch.end {
            let row = &contacts.rows[self.members[i] as usize];
            let mut moved: [Lanes; 3] = [[0.0; LANES]; 3];
            for (node, weight) in nodes_of(contacts, row).filter(|_| soft) {
                let known = &system.known[row0 + node];
                let solution = direct.factor.many_of(node);
                for r in (0..3).filter(|&r| !known[r]) {
                    for lane in 0..LANES {
                        moved[r][lane] += weight as Scalar * solution[r][lane];
                    }
                }
            }
            for (k, j) in batch.clone().enumerate() {
                for a in 0..3 {
                    for b in 0..3 {
                        let value: f64 =
                            (0..3).map(|r| row.frame[(a, r)] * moved[r][3 * k + b] as f64).sum();
                        self.w[(3 * i + a) * stride + 3 * j + b] = value;
                        self.w[(3 * j + b) * stride + 3 * i + a] = value;
                    }
                }
            }
        }
    }

    /// `Hᵀ H` of two members.
    fn add_answer_of_bodies(&mut self, i: usize, j: usize) {
        let (stride, widest) = (3 * self.capacity, self.widest);
        let column = |m: usize, side: usize, axis: usize| {
            let at = 6 * widest * m + (3 * side + axis) * widest;
            &self.h[at..at + widest]
        };
        let mut sum = Mat3::zeros();
        for (p, group) in self.groups[i].iter().enumerate() {
            for (q, other) in self.groups[j].iter().enumerate() {
                if group.is_none() || group != other {
                    continue;
                }
                for a in 0..3 {
                    for b in 0..3 {
                        let pairs = column(i, p, a).iter().zip(column(j, q, b));
                        sum[(a, b)] += pairs.map(|(x, y)| x * y).sum::<f64>();
                    }
                }
            }
        }
        for a in 0..3 {
            for b in 0..3 {
                self.w[(3 * i + a) * stride + 3 * j + b] += sum[(a, b)];
                if i != j {
                    self.w[(3 * j + b) * stride + 3 * i + a] += sum[(a, b)];
                }
            }
        }
    }

    /// Own response of a member.
    fn own(&self, m: usize) -> Mat3 {
        let stride = 3 * self.capacity;
        Mat3::from_fn(|a, b| self.w[(3 * m + a) * stride + 3 * m + b])
    }

    fn value(&self, m: usize) -> Vec3 {
        Vec3::from_column_slice(&self.d[3 * m..3 * m + 3])
    }

    /// Finds impulses from the present ones, until a sweep changes no contact's velocity by more
    /// than `tolerance` \[m/s\] through its own impulse.
    pub fn solve(
        &mut self,
        contacts: &mut ContactRows,
        cone: Cone,
        tolerance: f64,
        sweeps_max: u32,
    ) -> Convergence {
        let (n, stride) = (self.members.len(), 3 * self.capacity);
        for m in 0..n {
            let start = self.correction[m] - contacts.rows[self.members[m] as usize].target;
            self.d[3 * m..3 * m + 3].copy_from_slice(start.as_slice());
        }
        for m in 0..n {
            let lambda = contacts.rows[self.members[m] as usize].lambda;
            self.spread(m, &lambda, stride);
        }
        let mut convergence = Convergence { iterations: 0, residual: f64::INFINITY };
        while convergence.iterations < sweeps_max && convergence.residual > tolerance {
            convergence.residual = 0.0;
            for m in 0..n {
                let change = self.visit(m, contacts, cone);
                convergence.residual = convergence.residual.max(change);
            }
            convergence.iterations += 1;
        }
        convergence
    }

    /// Gives one contact its impulse; returns the change of its velocity \[m/s\].
    fn visit(&mut self, m: usize, contacts: &mut ContactRows, cone: Cone) -> f64 {
        let row = &mut contacts.rows[self.members[m] as usize];
        let d = self.value(m);
        if row.lambda == Vec3::zeros() && d.x >= 0.0 {
            return 0.0;
        }
        let own = self.own(m);
        let lambda = wanted(cone, row, &own, &d);
        let delta = lambda - row.lambda;
        if delta == Vec3::zeros() {
            return 0.0;
        }
        row.lambda = lambda;
        self.spread(m, &delta, 3 * self.capacity);
        (own * delta).norm()
    }

    /// `d += W δ` for a change at one member.
    fn spread(&mut self, m: usize, delta: &Vec3, stride: usize) {
        if *delta == Vec3::zeros() {
            return;
        }
        let n = 3 * self.members.len();
        let [a, b, c] = [0, 1, 2].map(|k| &self.w[(3 * m + k) * stride..(3 * m + k) * stride + n]);
        for (d, ((a, b), c)) in self.d[..n].iter_mut().zip(a.iter().zip(b).zip(c)) {
            *d += a * delta.x + b * delta.y + c * delta.z;
        }
    }

    /// Compares with the true change of velocities. Members are corrected by what W missed, contacts
    /// that would now close by more than `tolerance` join. Returns whether all is well, and the
    /// largest violation of the contact law \[m/s\]; `None` when too many would join.
    pub fn check(
        &mut self,
        contacts: &ContactRows,
        change: &[Vec3],
        cone: Cone,
        tolerance: f64,
    ) -> Option<(bool, f64)> {
        let (mut well, mut violation) = (true, 0.0_f64);
        for m in 0..self.members.len() {
            let row = &contacts.rows[self.members[m] as usize];
            let d = row.frame * contacts.relative_velocity(row, change) - row.target;
            let missed = d - self.value(m);
            self.correction[m] += missed;
            well &= missed.norm() <= tolerance;
            let own = self.own(m);
            let lambda = wanted(cone, row, &own, &d);
            violation = violation.max((own * (lambda - row.lambda)).norm());
        }
        for (i, row) in contacts.rows.iter().enumerate() {
            if self.is_member[i] {
                continue;
            }
            let normal: Vec3 = row.frame.row(0).transpose();
            let d = normal.dot(&contacts.relative_velocity(row, change)) - row.target.x;
            if d < -tolerance {
                if !self.admit(i) {
                    return None;
                }
                (well, violation) = (false, violation.max(-d));
            }
        }
        Some((well, violation))
    }
}

/// The impulse a contact should have, all others being what they are.
fn wanted(cone: Cone, row: &ContactRow, own: &Mat3, d: &Vec3) -> Vec3 {
    let lambda = impulse(cone, row.friction, own, &(d - own * row.lambda), &row.lambda);
    let excess = lambda.x / row.impulse_max;
    if excess > 1.0 { lambda / excess } else { lambda }
}

fn nodes_of<'a>(
    contacts: &'a ContactRows,
    row: &ContactRow,
) -> impl Iterator<Item = (usize, f64)> + 'a {
    let range = row.nodes.start as usize..row.nodes.end as usize;
    let nodes = contacts.nodes[range.clone()].iter().map(|n| *n as usize);
    nodes.zip(contacts.weights[range].iter().copied())
}
