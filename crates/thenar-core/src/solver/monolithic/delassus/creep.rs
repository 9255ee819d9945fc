//! Load that creeps from contact to contact.
//!
//! Two contacts that hold nearly the same thing back, sliding, may hand load to each other by a
//! little in every sweep, in one direction, until one has none: with friction the common response
//! of the two need not be positive, what a sweep changes then even grows, and what mixing leads to
//! is the other way. So sweeps that ran out first go along with what they change,
//!
//! ```text
//!   λ ← λ + t Δ,  t = r + r² + ... = r/(1 - r), but at most until a contact has lost its load,
//! ```
//!
//! where Δ is what the last sweep changed and r how much of what the one before did. A part of a
//! step of a soaked hand that 1600 sweeps did not settle took one of these, as long as 4398 sweeps.

use super::sweeps::{visit, within};
use crate::math::Vec3;
use crate::model::Cone;
use crate::solver::ContactRows;
use crate::solver::contact_law::Response;
use crate::solver::monolithic::compliance::Compliance;
use fearless_simd::Simd;

/// Times that sweeps are led on in a row.
const LEADS_MAX: u32 = 16;
/// Sweeps creep where this part of what one changes is left in the next. Of what shrinks faster 200
/// sweeps leave less than 1e-9.
const CREEPS: f64 = 0.9;

/// Data that sweeps work on.
pub(super) struct Creeping<'a> {
    pub members: &'a [u32],
    pub contacts: &'a mut ContactRows,
    pub cone: Cone,
    pub W: &'a Compliance,
    /// Own response of each member.
    pub own: &'a [Response],
    /// Velocities of the members, less their targets.
    pub d: &'a mut [f64],
}

impl Creeping<'_> {
    /// Sweeps, and goes along with what they change as long as they creep. `change` is work space,
    /// three numbers a member. Returns how many sweeps there were.
    #[inline(always)]
    pub fn lead_on<S: Simd>(&mut self, simd: S, change: &mut [f64]) -> u32 {
        for lead in 0..LEADS_MAX {
            change.fill(0.0);
            let [before, _] = self.sweep(simd, change);
            let [_, along] = self.sweep(simd, change);
            let left = along / before;
            // What is not a number does not creep.
            if left.is_nan() || left <= CREEPS || !self.lead(simd, left, change) {
                return 2 * (lead + 1);
            }
        }
        2 * LEADS_MAX
    }

    /// One sweep; what it changes takes the place of what the one before did. Returns squares, by
    /// the members' own response: of its change, and of it along the one before.
    #[inline(always)]
    fn sweep<S: Simd>(&mut self, simd: S, change: &mut [f64]) -> [f64; 2] {
        let mut squares = [0.0; 2];
        for (m, last) in change.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let row = &mut self.contacts.rows[self.members[m] as usize];
            let start = row.lambda;
            visit(simd, m, self.W, &self.own[m], self.cone, row, self.d);
            let now = row.lambda - start;
            let weight = self.own[m].W.trace();
            squares[0] += weight * now.norm_squared();
            squares[1] += weight * now.dot(&Vec3::from(*last));
            *last = now.into();
        }
        squares
    }

    /// Goes along with a sweep's change of which so much is left in the next one; false where
    /// nothing ends that.
    #[inline(always)]
    fn lead<S: Simd>(&mut self, simd: S, left: f64, change: &[f64]) -> bool {
        let change = change.as_chunks::<3>().0;
        let mut length = if left < 1.0 { left / (1.0 - left) } else { f64::INFINITY };
        let mut emptied = None;
        for (m, change) in change.iter().enumerate() {
            let row = &self.contacts.rows[self.members[m] as usize];
            let loses = !row.turns && change[0] < 0.0 && row.lambda.x > 0.0;
            if loses && row.lambda.x < -length * change[0] {
                (length, emptied) = (-row.lambda.x / change[0], Some(m));
            }
        }
        if length == f64::INFINITY {
            return false;
        }
        for (m, change) in change.iter().enumerate() {
            let row = &mut self.contacts.rows[self.members[m] as usize];
            let to = row.lambda + length * Vec3::from(*change);
            let to = match emptied {
                Some(empty) if empty == m => Vec3::zeros(),
                _ if row.turns => row.lambda,
                _ => within(self.cone, row.friction, &to),
            };
            let more = to - row.lambda;
            if more != Vec3::zeros() {
                row.lambda = to;
                self.W.add_answer(simd, m, &more, self.d);
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::monolithic::factor::LANES;
    use fearless_simd::{Level, dispatch};

    const FRICTION: f64 = 0.55;

    /// Two contacts of one thing, which slides along both: normals θ apart, the first's slip along
    /// their plane. A little of each contact's response is its own.
    struct Pair {
        W: Compliance,
        contacts: ContactRows,
        d: [f64; LANES],
        /// Response of normal velocities to normal impulses while both slide.
        M: [[f64; 2]; 2],
    }

    impl Pair {
        /// Without impulses the contacts close at these speeds.
        fn new(theta: f64, closing: [f64; 2]) -> Self {
            let (s, c) = theta.sin_cos();
            // Normals and tangents, in a space of as many dimensions as it takes.
            let axes: [[f64; 5]; 6] = [
                [1.0, 0.0, 0.0, 0.0, 0.0],
                [0.0, -1.0, 0.0, 0.0, 0.0],
                [0.0, 0.0, 0.0, 1.0, 0.0],
                [c, s, 0.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, 0.0, 0.0, 1.0],
            ];
            let own = 1e-3;
            let dot = |i: usize, j: usize| -> f64 {
                let shared: f64 = (0..5).map(|k| axes[i][k] * axes[j][k]).sum();
                shared + if i == j { own } else { 0.0 }
            };
            let mut block = [[0.0_f32; LANES]; LANES];
            (0..6).for_each(|i| (0..6).for_each(|j| block[i][j] = dot(i, j) as f32));
            let mut W = Compliance::new(1);
            W.set(0, 0, &block);
            let mut contacts = ContactRows::with_capacity(0, 2);
            for _ in 0..2 {
                contacts.begin(&Vec3::x(), FRICTION, &Vec3::zeros());
            }
            let mut d = [0.0; LANES];
            d[..6].copy_from_slice(&[-closing[0], 20.0, 0.0, -closing[1], 20.0, 0.0]);
            let slides = |i: usize, j: usize| dot(3 * i, 3 * j) - FRICTION * dot(3 * i, 3 * j + 1);
            let M = [0, 1].map(|i| [0, 1].map(|j| slides(i, j)));
            Self { W, contacts, d, M }
        }

        /// Gives both contacts normal impulses, while they slide.
        fn load(&mut self, loads: [f64; 2]) {
            dispatch!(Level::new(), simd => for (m, load) in loads.into_iter().enumerate() {
                let impulse = Vec3::new(load, -FRICTION * load, 0.0);
                self.contacts.rows[m].lambda = impulse;
                self.W.add_answer(simd, m, &impulse, &mut self.d);
            })
        }

        /// Sweeps until one changes no impulse by more than 1e-9; led on after a few.
        fn sweeps(&mut self, led: bool) -> u32 {
            let own = [0, 1].map(|m| Response::new(&self.W.own(m)));
            let mut swept = Creeping {
                members: &[0, 1],
                contacts: &mut self.contacts,
                cone: Cone::Circular,
                W: &self.W,
                own: &own,
                d: &mut self.d,
            };
            dispatch!(Level::new(), simd => {
                let mut count = 0;
                while count < 4 && led {
                    count += 1;
                    swept.sweep(simd, &mut [0.0; 6]);
                }
                if led {
                    count += swept.lead_on(simd, &mut [0.0; 6]);
                }
                while count < 10_000 {
                    count += 1;
                    if swept.sweep(simd, &mut [0.0; 6])[0] < 1e-18 {
                        break;
                    }
                }
                count
            })
        }
    }

    /// Loads near those at which both contacts would rest, which sweeps lead away from: what is off
    /// grows by `M₁₂ M₂₁/(M₁₁ M₂₂)` in each, and the second contact loses its load. The first one
    /// then bears all.
    #[test]
    fn a_contact_that_loses_its_load_by_little_and_little_loses_it_at_once() {
        for (theta, off) in [(0.48, 1e-2), (0.49, 1e-2), (0.48, 1e-1), (0.4, 1e-3)] {
            let [[a, b], [c, d]] = Pair::new(theta, [1.0; 2]).M;
            let growth = b * c / (a * d);
            assert!(growth > 1.0);
            // Between these both can rest with a load, and each by itself.
            let closing = [1.0, 0.5 * (d / b + c / a)];
            let second = (a * closing[1] - c) / (a * d - b * c) * (1.0 - off);
            let loads = [(1.0 - b * second) / a, second];
            assert!(loads.iter().all(|load| *load > 0.0), "{loads:?}");
            let run = |led: bool| {
                let mut pair = Pair::new(theta, closing);
                pair.load(loads);
                let count = pair.sweeps(led);
                let [first, second] = [0, 1].map(|m| pair.contacts.rows[m].lambda);
                assert_eq!(second, Vec3::zeros());
                assert!((first.x * a - 1.0).abs() < 1e-5, "{first}");
                assert!(pair.d[3] >= 0.0, "the second one opens");
                f64::from(count)
            };
            let (plain, led) = (run(false), run(true));
            // The load is gone when what is off has grown from its part to all.
            let expected = (1.0 / off).ln() / growth.ln();
            assert!((plain / expected - 1.0).abs() < 0.2, "{plain} sweeps of {expected}");
            assert!(led < 12.0, "{led} sweeps, of {plain}");
        }
    }

    /// A creep that dies away is led on to where its series ends.
    #[test]
    fn a_creep_that_shrinks_ends_where_its_series_does() {
        let theta = 0.53;
        let [[a, b], [c, d]] = Pair::new(theta, [1.0; 2]).M;
        let ratio = b * c / (a * d);
        assert!(ratio > 0.95 && ratio < 1.0, "{ratio}");
        let run = |led: bool| {
            // Both rest with a load of a half.
            let mut pair = Pair::new(theta, [0.5 * (a + b), 0.5 * (c + d)]);
            pair.load([0.6, 0.1]);
            let count = pair.sweeps(led);
            let loads = [0, 1].map(|m| pair.contacts.rows[m].lambda.x);
            assert!(loads.iter().all(|load| (load - 0.5).abs() < 1e-4), "{loads:?}");
            count
        };
        let (plain, led) = (run(false), run(true));
        assert!(plain > 200 && 4 * led < plain, "{plain} plain, {led} led on");
    }

    /// Sweeps that come to rest unaided are left alone.
    #[test]
    fn what_does_not_creep_is_not_led_on() {
        let mut pair = Pair::new(1.3, [1.0; 2]);
        pair.load([0.0, 0.0]);
        assert!(pair.sweeps(true) < 40);
    }
}
