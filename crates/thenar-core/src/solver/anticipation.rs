//! Contact response (Eq. 12) by iterative constraint anticipation (Otaduy, Tamstorf, Steinemann
//! and Gross 2009).
//!
//! Wanted: `A x = Jᵀ λ` with `0 ≤ λ ⊥ J x ≥ p` and friction, where `x` is the change that contact
//! makes to the contact-free velocities. With `A = D + L + U` and D its block diagonal, one sweep
//!
//! 1. anticipates the velocities a Jacobi step ahead without contact, `y = -D⁻¹ (L + U) x`;
//! 2. finds λ for `J (y + D⁻¹ Jᵀ λ) ≥ p` by projected Gauss-Seidel over the contacts;
//! 3. relaxes `A x = Jᵀ λ` by one block Gauss-Seidel sweep over the unknowns.

use crate::capacity_vec::CapacityVec;
use crate::math::{Vec3, Vec6};
use crate::model::Cone;
use crate::solver::{BlockDiagonal, BlockMatrix, ContactRows, Convergence};

/// Stopping rules and friction cone.
#[derive(Clone, Copy, Debug)]
pub struct AnticipationSettings {
    /// Stop when a sweep changes x by less than this part of x (energy norm).
    pub tolerance: f64,
    /// Most sweeps of one solve.
    pub sweeps_max: u32,
    /// Passes over the contacts within one sweep.
    pub inner_passes: u32,
    /// Friction cone.
    pub cone: Cone,
}

/// Sweeps from one look at contacts that do not press to the next: most points near another surface
/// never touch it. A solution is accepted only after a sweep that looked at all.
const FULL_PASS_EVERY: u32 = 4;

/// Contacts that a pass visits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ContactSubset {
    /// Every contact.
    All,
    /// Only contacts with an impulse.
    Pressing,
}

/// Workspace of the solver.
#[derive(Clone, Debug)]
pub struct Anticipation {
    /// Jᵀ λ per unknown.
    impulse: Vec<Vec3>,
    /// y + D⁻¹ Jᵀ λ, valid at touched rows.
    anticipated: Vec<Vec3>,
    /// Rigid bodies and nodes that some contact holds.
    touched_rigids: CapacityVec<u32>,
    touched_nodes: CapacityVec<u32>,
    mark: Vec<bool>,
}

impl Anticipation {
    /// Room for this many bodies and nodes.
    pub fn new(rigids: usize, nodes: usize) -> Self {
        let rows = 2 * rigids + nodes;
        Self {
            impulse: vec![Vec3::zeros(); rows],
            anticipated: vec![Vec3::zeros(); rows],
            touched_rigids: CapacityVec::with_capacity(rigids),
            touched_nodes: CapacityVec::with_capacity(nodes),
            mark: vec![false; rows],
        }
    }

    /// Solves for `x` (start value kept from the caller) and the impulses in `contacts`, which
    /// start from their present values.
    pub fn solve(
        &mut self,
        a: &BlockMatrix,
        d: &BlockDiagonal,
        contacts: &mut ContactRows,
        settings: &AnticipationSettings,
        x: &mut [Vec3],
    ) -> Convergence {
        if contacts.rows.iter().all(|row| row.target.x <= 0.0) {
            // The contact-free velocities keep every gap open: nothing presses.
            contacts.rows.iter_mut().for_each(|row| row.lambda = Vec3::zeros());
            x.fill(Vec3::zeros());
            return Convergence::default();
        }
        contacts.refresh_responses(d);
        self.find_touched(contacts);
        let mut convergence = Convergence { iterations: 0, residual: f64::INFINITY };
        while convergence.iterations < settings.sweeps_max {
            self.anticipate(a, d, contacts, x);
            let all = convergence.iterations.is_multiple_of(FULL_PASS_EVERY);
            for pass in 0..settings.inner_passes {
                let who =
                    if all && pass == 0 { ContactSubset::All } else { ContactSubset::Pressing };
                self.pass_over_contacts(d, contacts, settings.cone, who);
            }
            self.gather_impulse(contacts);
            let change2 = self.relax(a, d, x);
            let energy: f64 = x.iter().zip(&self.impulse).map(|(x, f)| x.dot(f)).sum();
            convergence.iterations += 1;
            convergence.residual =
                if change2 > 0.0 { (change2 / energy.abs()).sqrt() } else { 0.0 };
            if all && convergence.residual <= settings.tolerance {
                break;
            }
        }
        convergence
    }

    fn find_touched(&mut self, contacts: &ContactRows) {
        self.touched_rigids.clear();
        self.touched_nodes.clear();
        self.mark.fill(false);
        self.impulse.fill(Vec3::zeros());
        let rigids = contacts.rigids;
        for row in &contacts.rows {
            for (body, _, _) in row.rigids.iter().flatten() {
                if !std::mem::replace(&mut self.mark[2 * *body as usize], true) {
                    self.touched_rigids.push(*body);
                }
            }
        }
        for &node in &contacts.nodes {
            if !std::mem::replace(&mut self.mark[2 * rigids + node as usize], true) {
                self.touched_nodes.push(node);
            }
        }
    }

    /// `anticipated = D⁻¹ (Jᵀ λ - (L + U) x)` at the touched rows.
    fn anticipate(
        &mut self,
        a: &BlockMatrix,
        d: &BlockDiagonal,
        contacts: &ContactRows,
        x: &[Vec3],
    ) {
        self.gather_impulse(contacts);
        for &body in &self.touched_rigids {
            let b = body as usize;
            let (change, _) = rigid_change(a, d, &self.impulse, b, x);
            self.anticipated[2 * b] = x[2 * b] + change[0];
            self.anticipated[2 * b + 1] = x[2 * b + 1] + change[1];
        }
        for &node in &self.touched_nodes {
            let i = 2 * contacts.rigids + node as usize;
            let residual = self.impulse[i] - a.row_times(i, x);
            self.anticipated[i] = x[i] + d.node[node as usize] * residual;
        }
    }

    fn pass_over_contacts(
        &mut self,
        d: &BlockDiagonal,
        contacts: &mut ContactRows,
        cone: Cone,
        who: ContactSubset,
    ) {
        for i in 0..contacts.rows.len() {
            let row = &contacts.rows[i];
            if who == ContactSubset::Pressing && row.lambda.x == 0.0 {
                continue;
            }
            let w = contacts.relative_velocity(row, &self.anticipated);
            let value = row.frame * w - row.target;
            let lambda = row.projected(cone, &value);
            let change = row.frame.tr_mul(&(lambda - row.lambda));
            if change != Vec3::zeros() {
                contacts.scatter_response(row, &change, d, &mut self.anticipated);
                contacts.rows[i].lambda = lambda;
            }
        }
    }

    fn gather_impulse(&mut self, contacts: &ContactRows) {
        let rigids = contacts.rigids;
        for &b in &self.touched_rigids {
            self.impulse[2 * b as usize] = Vec3::zeros();
            self.impulse[2 * b as usize + 1] = Vec3::zeros();
        }
        for &n in &self.touched_nodes {
            self.impulse[2 * rigids + n as usize] = Vec3::zeros();
        }
        for row in contacts.rows.iter().filter(|row| row.lambda.x > 0.0) {
            contacts.scatter(row, &row.frame.tr_mul(&row.lambda), &mut self.impulse);
        }
    }

    /// One block Gauss-Seidel sweep over all unknowns; returns the square of its change in the
    /// norm of D.
    fn relax(&mut self, a: &BlockMatrix, d: &BlockDiagonal, x: &mut [Vec3]) -> f64 {
        let rigids = d.rigid.len();
        let nodes = d.node.len();
        let mut change2 = 0.0;
        for k in 0..rigids + nodes {
            if k < rigids {
                let (change, residual) = rigid_change(a, d, &self.impulse, k, x);
                for part in 0..2 {
                    change2 += change[part].dot(&residual[part]);
                    x[2 * k + part] += change[part];
                }
            } else {
                let i = rigids + k;
                let residual = self.impulse[i] - a.row_times(i, x);
                let change = d.node[k - rigids] * residual;
                change2 += change.dot(&residual);
                x[i] += change;
            }
        }
        change2
    }
}

/// `D⁻¹ (f - A x)` and `f - A x` at the two rows of a rigid body.
#[inline]
fn rigid_change(
    a: &BlockMatrix,
    d: &BlockDiagonal,
    f: &[Vec3],
    b: usize,
    x: &[Vec3],
) -> ([Vec3; 2], [Vec3; 2]) {
    let [lin, ang] = [2 * b, 2 * b + 1].map(|i| f[i] - a.row_times(i, x));
    let y = d.rigid[b] * Vec6::new(lin.x, lin.y, lin.z, ang.x, ang.y, ang.z);
    ([Vec3::new(y[0], y[1], y[2]), Vec3::new(y[3], y[4], y[5])], [lin, ang])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Mat3;
    use crate::random::Random;
    use crate::solver::DenseSystem;

    /// A first guess that already carries the node away from the wall, by way of its neighbour,
    /// must not pass for the answer that nothing presses.
    #[test]
    fn a_good_first_guess_does_not_hide_a_contact() {
        let mut a = BlockMatrix::with_pattern(2, [(0, 1)]);
        for (i, j, k) in [(0, 0, 2.0), (1, 1, 2.0), (0, 1, -1.0), (1, 0, -1.0)] {
            a.add_scalar(a.entry(i, j), k);
        }
        let mut d = BlockDiagonal::new(0, 2);
        assert!(d.refresh(&a));
        let mut rows = ContactRows::with_capacity(0, 1);
        let i = rows.begin(&Vec3::y(), 0.0, &Vec3::zeros());
        rows.hold_node(0, 1.0);
        rows.rows[i].target = Vec3::new(0.5, 0.0, 0.0);
        let settings = AnticipationSettings {
            tolerance: 1e-9,
            sweeps_max: 100,
            inner_passes: 2,
            cone: Cone::Circular,
        };
        for start in [0.0, 0.5, 3.0] {
            let mut x = [Vec3::zeros(), Vec3::y() * start];
            Anticipation::new(0, 2).solve(&a, &d, &mut rows.clone(), &settings, &mut x);
            assert!((x[0].y - 0.5).abs() < 1e-6, "from {start}: {}", x[0].y);
            assert!((x[1].y - 0.25).abs() < 1e-6, "from {start}: {}", x[1].y);
        }
    }

    /// One rigid body on springs to a chain of nodes, all of it being pushed against walls: the
    /// impulses must be those of the dense solution.
    #[test]
    fn agrees_with_the_dense_solution() {
        let mut random = Random::new(41);
        let nodes = 12;
        let pairs = (0..nodes - 1).map(|n| (2 + n, 3 + n)).chain([(0, 1), (0, 2), (1, 2)]);
        let mut a = BlockMatrix::with_pattern(2 + nodes as usize, pairs);
        for i in 0..a.rows() as u32 {
            a.add_scalar(a.diagonal[i as usize], random.range(0.5, 1.5));
        }
        let mut spring = |i: u32, j: u32, k: f64| {
            let n = random.vector(1.0).normalize();
            let block = n * n.transpose() * k + Mat3::identity() * (0.2 * k);
            for (p, q, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
                a.add(a.entry(p, q), &(block * sign));
            }
        };
        (0..nodes - 1).for_each(|n| spring(2 + n, 3 + n, 3.0));
        spring(0, 2, 2.0);
        spring(1, 2, 1.0);
        let mut d = BlockDiagonal::new(1, nodes as usize);
        assert!(d.refresh(&a));

        for cone in [Cone::Circular, Cone::Linearised] {
            let mut rows = ContactRows::with_capacity(1, 8);
            for k in 0..6 {
                let normal = (Vec3::y() + random.vector(0.3)).normalize();
                let i = rows.begin(&normal, 0.4, &Vec3::zeros());
                rows.hold_node(2 * k % nodes, 0.7);
                rows.hold_node((2 * k + 1) % nodes, 0.3);
                if k == 5 {
                    rows.hold_rigid(0, random.vector(0.5), -1.0);
                }
                rows.rows[i].target = Vec3::new(random.range(-0.2, 1.0), 0.3, -0.2);
            }
            let mut exact = rows.clone();
            let reference = DenseSystem::new(&a, &[]).unwrap();
            let known = vec![[false; 3]; a.rows()];
            let (want, _) = reference.contact(&mut exact, &known, cone, 1e-13);

            let mut x = vec![Vec3::zeros(); a.rows()];
            let settings =
                AnticipationSettings { tolerance: 1e-12, sweeps_max: 5000, inner_passes: 8, cone };
            let mut solver = Anticipation::new(1, nodes as usize);
            let reached = solver.solve(&a, &d, &mut rows, &settings, &mut x);
            assert!(reached.residual < 1e-12, "{reached:?}");
            let error = x.iter().zip(&want).map(|(x, w)| (x - w).norm()).fold(0.0, f64::max);
            assert!(error < 1e-8, "{cone:?}: {error}");
            for (a, b) in rows.rows.iter().zip(&exact.rows) {
                assert!((a.lambda - b.lambda).norm() < 1e-7, "{} {}", a.lambda, b.lambda);
            }
        }
    }
}
