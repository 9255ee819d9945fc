//! Limits of joints that press, held while contacts are visited.
//!
//! A body that touches and whose joint is at its limit passes load from contact to limit and back:
//! each visit of one undoes the other, and where friction pulls on a long lever this never ends. So
//! limits L that press give way within each visit (block Gauss-Seidel): the contact m sees the
//! response
//!
//! ```text
//!   W_mm - W_mL W_LL⁻¹ W_Lm
//! ```
//!
//! and λ_L follows so that `d_L = 0`. A limit that pulls is let go before the next sweep.

use super::Compliance;
use crate::capacity_vec::CapacityVec;
use crate::math::{Mat3, Vec3};
use crate::solver::ContactRows;
use crate::solver::contact_law::{PIVOT_LEAST, Response};
use crate::solver::monolithic::small_cholesky;
use fearless_simd::Simd;

/// Limits held at most: as many as two hands have joints at once; others are visited like contacts.
const HELD_MAX: usize = 64;

/// The limits held, and how contacts answer meanwhile.
#[derive(Clone, Debug)]
pub struct Turns {
    /// Members of W.
    held: CapacityVec<u32>,
    /// Number of members when these were held; zero where W is another one now.
    prepared: usize,
    /// Marks the members that are held.
    is_held: Vec<bool>,
    /// Response of each member while limits give way.
    own: Vec<Response>,
    /// Cholesky factor of W_LL, and what is solved with it.
    gram: Vec<f64>,
    values: Vec<f64>,
}

impl Turns {
    /// Room for this many members.
    pub fn new(capacity: usize) -> Self {
        let most = HELD_MAX.min(capacity);
        Self {
            held: CapacityVec::with_capacity(most),
            prepared: 0,
            is_held: vec![false; capacity],
            own: vec![Response::default(); capacity],
            gram: vec![0.0; most * most],
            values: vec![0.0; most],
        }
    }

    /// W is another one now.
    pub fn forget(&mut self) {
        self.held.clear();
        self.prepared = 0;
    }

    /// Lets go of limits that pull.
    #[inline(always)]
    pub fn release<S: Simd>(
        &self,
        simd: S,
        members: &[u32],
        contacts: &mut ContactRows,
        W: &Compliance,
        d: &mut [f64],
    ) {
        for (m, &i) in members.iter().enumerate() {
            let row = &mut contacts.rows[i as usize];
            if row.turns && row.lambda.x < 0.0 {
                W.add_answer(simd, m, &-row.lambda, d);
                row.lambda = Vec3::zeros();
            }
        }
    }

    /// Holds those of the members that are limits and press, and lets go of those that pull.
    #[inline(always)]
    pub fn hold<S: Simd>(
        &mut self,
        simd: S,
        members: &[u32],
        contacts: &mut ContactRows,
        W: &Compliance,
        d: &mut [f64],
    ) {
        self.release(simd, members, contacts, W, d);
        let most = self.values.len();
        let presses =
            |i: u32| contacts.rows[i as usize].turns && contacts.rows[i as usize].lambda.x > 0.0;
        let pressing =
            || (0_u32..).zip(members).filter(|(_, i)| presses(**i)).map(|(m, _)| m).take(most);
        if self.prepared != members.len() || !pressing().eq(self.held.iter().copied()) {
            self.held.clear();
            self.held.extend(pressing());
            self.prepare(members.len(), W);
        }
        self.settle(simd, members, contacts, W, d);
    }

    /// Factors W_LL, and finds how each of n members answers.
    fn prepare(&mut self, n: usize, W: &Compliance) {
        let k = self.held.len();
        for (a, &row) in self.held.iter().enumerate() {
            for (b, &column) in self.held.iter().enumerate() {
                self.gram[a * k + b] = f64::from(W.at(3 * row as usize, 3 * column as usize));
            }
        }
        if !small_cholesky::factor(&mut self.gram[..k * k], k) {
            // Limits that depend on each other share the load in any way: they are visited one by
            // one.
            self.held.clear();
        }
        self.is_held[..n].fill(false);
        self.held.iter().for_each(|&m| self.is_held[m as usize] = true);
        for m in 0..n {
            let own = W.own(m);
            let left = own - self.given_way(W, m);
            // What limits take all of leaves nothing but round-off: such a contact answers by
            // itself.
            let sound = left.symmetric_eigenvalues().min() > PIVOT_LEAST * own.trace();
            self.own[m] = Response::new(if sound { &left } else { &own });
        }
        self.prepared = n;
    }

    /// `W_mL W_LL⁻¹ W_Lm`.
    fn given_way(&mut self, W: &Compliance, m: usize) -> Mat3 {
        let k = self.held.len();
        let mut columns = Mat3::zeros();
        for axis in 0..3 {
            for (value, &limit) in self.values.iter_mut().zip(&self.held) {
                *value = f64::from(W.at(3 * limit as usize, 3 * m + axis));
            }
            self.solve();
            for (value, &limit) in self.values[..k].iter().zip(&self.held) {
                for row in 0..3 {
                    columns[(row, axis)] +=
                        f64::from(W.at(3 * m + row, 3 * limit as usize)) * value;
                }
            }
        }
        0.5 * (columns + columns.transpose())
    }

    fn solve(&mut self) {
        let k = self.held.len();
        small_cholesky::forward(&self.gram[..k * k], k, &mut self.values[..k]);
        small_cholesky::backward(&self.gram[..k * k], k, &mut self.values[..k]);
    }

    /// True when member `m` is held and follows the others.
    pub fn holds(&self, m: usize) -> bool {
        self.is_held[m]
    }

    /// Returns the response of a member while limits give way.
    pub fn own(&self, m: usize) -> &Response {
        &self.own[m]
    }

    /// Lets the limits follow what was visited.
    #[inline(always)]
    pub fn settle<S: Simd>(
        &mut self,
        simd: S,
        members: &[u32],
        contacts: &mut ContactRows,
        W: &Compliance,
        d: &mut [f64],
    ) {
        for (value, &limit) in self.values.iter_mut().zip(&self.held) {
            *value = -d[3 * limit as usize];
        }
        self.solve();
        for (value, &limit) in self.values.iter().zip(&self.held) {
            let delta = Vec3::new(*value, 0.0, 0.0);
            contacts.rows[members[limit as usize] as usize].lambda += delta;
            W.add_answer(simd, limit as usize, &delta, d);
        }
    }

    /// The most that a limit that pulls is off \[m/s\].
    pub fn pull(&self, members: &[u32], contacts: &ContactRows, W: &Compliance) -> f64 {
        let of = |&limit: &u32| {
            let lambda = contacts.rows[members[limit as usize] as usize].lambda.x;
            f64::from(W.at(3 * limit as usize, 3 * limit as usize)) * (-lambda).max(0.0)
        };
        self.held.iter().map(of).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Cone;
    use crate::random::Random;
    use crate::solver::monolithic::delassus::sweeps::visit;
    use crate::solver::monolithic::factor::LANES;
    use fearless_simd::{Level, dispatch};

    /// Sweeps over a contact and the limit of a joint, of a thing of 1 kg that touches with one
    /// point on a long lever, until they change nothing; the last change \[m/s\].
    fn swept(random: &mut Random, gives_way: bool) -> f64 {
        let turn = *random.rotation(3.1).to_rotation_matrix().matrix();
        let gyration = Vec3::from_fn(|_, _| random.range(0.2, 1.0));
        let inertia = Mat3::from_diagonal(&gyration.map(|k| 1.0 / (k * k)));
        let yields = turn * inertia * turn.transpose();
        let arm = random.vector(1.5).cross_matrix();
        let axis = random.vector(1.0).normalize();
        let contact = Mat3::identity() + arm.transpose() * yields * arm;
        let coupling = arm.transpose() * yields * axis;
        let mut block = [[0.0_f32; LANES]; LANES];
        for i in 0..3 {
            (0..3).for_each(|j| block[i][j] = contact[(i, j)] as f32);
            (block[i][3], block[3][i]) = (coupling[i] as f32, coupling[i] as f32);
        }
        block[3][3] = axis.dot(&(yields * axis)) as f32;
        let mut W = Compliance::new(1);
        W.set(0, 0, &block);

        let mut contacts = ContactRows::with_capacity(0, 2);
        contacts.begin(&Vec3::x(), random.range(0.05, 1.5), &Vec3::zeros());
        contacts.begin(&Vec3::x(), 0.0, &Vec3::zeros());
        contacts.rows[1].turns = true;
        let mut d = [0.0; LANES];
        let mut b = random.vector(1.0);
        b.x = -b.x.abs();
        d[..3].copy_from_slice(b.as_slice());
        d[3] = random.range(-1.0, 0.2);
        let members = [0, 1];
        let own = members.map(|m| Response::new(&W.own(m as usize)));
        let mut turns = Turns::new(2);
        let mut change = f64::INFINITY;
        dispatch!(Level::new(), simd => {
            for _ in 0..500 {
                if gives_way {
                    turns.hold(simd, &members, &mut contacts, &W, &mut d);
                }
                change = 0.0;
                for m in 0..2 {
                    if gives_way && turns.holds(m) {
                        continue;
                    }
                    let own = if gives_way { turns.own(m) } else { &own[m] };
                    let row = &mut contacts.rows[m];
                    change = visit(simd, m, &W, own, Cone::Circular, row, &mut d).max(change);
                    if gives_way {
                        turns.settle(simd, &members, &mut contacts, &W, &mut d);
                    }
                }
                change = change.max(turns.pull(&members, &contacts, &W));
                if change < 1e-6 {
                    break;
                }
            }
            turns.release(simd, &members, &mut contacts, &W, &mut d);
        });
        assert!(contacts.rows.iter().all(|row| row.lambda.x >= 0.0), "limits and contacts push");
        change
    }

    /// A hinge that rests against a wall on its lever and against its limit, which share the load:
    /// what the limit leaves of the contact's motion is round-off, and no impulse comes of it.
    #[test]
    fn a_hinge_between_a_wall_and_its_limit_bears_what_it_is_loaded_with() {
        let mut random = Random::new(41);
        for case in 0..500 {
            let (arm, yields) = (random.vector(1.0), random.range(0.1, 10.0));
            let mut block = [[0.0_f32; LANES]; LANES];
            for i in 0..4 {
                let of = |i: usize| if i < 3 { arm[i] } else { 1.0 };
                (0..4).for_each(|j| block[i][j] = (yields * of(i) * of(j)) as f32);
            }
            let mut W = Compliance::new(1);
            W.set(0, 0, &block);
            let mut contacts = ContactRows::with_capacity(0, 2);
            contacts.begin(&Vec3::x(), 0.5, &Vec3::zeros());
            contacts.begin(&Vec3::x(), 0.0, &Vec3::zeros());
            contacts.rows[1].turns = true;
            contacts.rows[1].lambda.x = 1e-3;
            // It turns towards the limit.
            let mut d = [0.0; LANES];
            (0..3).for_each(|i| d[i] = -arm[i]);
            d[3] = -1.0;
            let members = [0, 1];
            let mut turns = Turns::new(2);
            dispatch!(Level::new(), simd => {
                for _ in 0..20 {
                    turns.hold(simd, &members, &mut contacts, &W, &mut d);
                    let row = &mut contacts.rows[0];
                    visit(simd, 0, &W, turns.own(0), Cone::Circular, row, &mut d);
                    turns.settle(simd, &members, &mut contacts, &W, &mut d);
                }
            });
            // The impulse that stops it, on the lever of the limit, or more where the two jam: by
            // friction never more than a thousand times.
            let most = contacts.rows.iter().map(|row| row.lambda.norm()).fold(0.0, f64::max);
            assert!(most < 1e3 / yields, "case {case}: {most}");
            assert!(d[3].abs() < 1e-3, "case {case}: {d:?}");
        }
    }

    #[test]
    fn what_is_jammed_at_a_limit_comes_to_rest_where_the_limit_gives_way() {
        let moving = |gives_way: bool| {
            let mut random = Random::new(37);
            (0..2000).filter(|_| swept(&mut random, gives_way) > 1e-6).count()
        };
        let (plain, held) = (moving(false), moving(true));
        assert!(plain > 10 && held == 0, "{plain} by plain visits, {held} of 2000");
    }
}
