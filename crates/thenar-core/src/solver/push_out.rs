//! Undoing overlaps without a speed: the second solve of a step (split impulses).
//!
//! The velocities v keep overlaps from growing, no more. What undoes them is a pseudo-velocity p on
//! the same system, `K p = J_nᵀ μ`, by which positions move too and which is then forgotten. Of all
//! p it is the one with the least
//!
//! ```text
//!   ½ pᵀ K p + ½ Σ (wanted - J p)₊² / (YIELD W_ii)      so that  J p ≥ least
//! ```
//!
//! the sum over contacts that overlap. As every `least` is at most zero, p = 0 is always allowed:
//! there is always a solution, one only, and `pᵀ K p ≤ Σ wanted² / (YIELD W_ii)`. Two contacts that
//! pull one point apart meet in the middle. There is no friction. (After the split impulses of
//! Guendelman, Bridson and Fedkiw 2003 and of Bullet; the yielding is ours.)

use crate::math::{Mat3, Vec3};
use crate::solver::contact_law::is_immovable;
use crate::solver::{ContactRow, ContactRows};

/// Yield of a contact's wish, in parts of its own response: one that is alone undoes ten elevenths
/// of what it wants in a step, two that contradict each other settle by a factor of 0.8 a sweep.
const YIELD: f64 = 0.1;

/// Pseudo-velocity that a contact asks for, along its normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PushTarget {
    /// Velocity at which the overlap should go \[m/s\]; where the contact is open,
    /// [`PushTarget::least`].
    pub wanted: f64,
    /// Least velocity, below which the contact would close too fast in any case; not above zero
    /// \[m/s\].
    pub least: f64,
}

/// A row that takes part in pushing out, and what it was in the solve for velocities.
#[derive(Clone, Copy, Debug)]
pub struct PushRow {
    wish: PushTarget,
    lambda: Vec3,
    target: Vec3,
    included: f64,
}

impl PushRow {
    /// The impulse of a contact whose `J p` less what it wants would be `rest` without it.
    pub fn impulse(&self, W: &Mat3, rest: f64) -> Vec3 {
        if is_immovable(W) {
            return Vec3::zeros();
        }
        let yielding = -rest / (W.m11 * (1.0 + YIELD));
        let firm = (self.wish.least - self.wish.wanted - rest) / W.m11;
        Vec3::new(yielding.max(firm).max(0.0), 0.0, 0.0)
    }
}

impl ContactRows {
    /// Until [`ContactRows::end_push`] rows stand for these wishes, in their order, and their
    /// impulses are those that push, zero at first.
    pub fn begin_push(&mut self, wishes: &[PushTarget]) {
        for (row, wish) in self.rows.iter_mut().zip(wishes) {
            row.begin_push(*wish);
        }
    }

    /// Rows are again what they were.
    pub fn end_push(&mut self) {
        for row in &mut self.rows {
            if let Some(push) = row.push.take() {
                (row.lambda, row.target, row.included) = (push.lambda, push.target, push.included);
            }
        }
    }
}

impl ContactRow {
    fn begin_push(&mut self, wish: PushTarget) {
        let (lambda, target, included) = (self.lambda, self.target, self.included);
        self.push = Some(PushRow { wish, lambda, target, included });
        self.lambda = Vec3::zeros();
        self.target = Vec3::new(wish.wanted, 0.0, 0.0);
        self.included = 0.0;
    }
}
