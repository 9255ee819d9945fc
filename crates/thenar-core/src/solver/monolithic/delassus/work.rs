//! Budget of a step for the law of contact, counted in multiply-adds: a count is the same on every
//! machine, a time is not.

/// Multiply-adds done in a step, and how many it may do.
#[derive(Clone, Copy, Debug)]
pub struct WorkBudget {
    done: u64,
    most: u64,
}

impl Default for WorkBudget {
    fn default() -> Self {
        Self { done: 0, most: u64::MAX }
    }
}

impl WorkBudget {
    /// Nothing is done of so much, or of any amount.
    pub fn within(most: Option<u64>) -> Self {
        Self { done: 0, most: most.unwrap_or(u64::MAX) }
    }

    /// So much more is done.
    pub fn add(&mut self, more: u64) {
        self.done = self.done.saturating_add(more);
    }

    /// Returns the work that may still be done.
    pub fn left(&self) -> u64 {
        self.most.saturating_sub(self.done)
    }

    /// Nothing is left to do anything with.
    pub fn is_spent(&self) -> bool {
        self.left() == 0
    }
}

/// A sweep over n contacts: each row of W once.
pub fn of_sweep(n: usize) -> u64 {
    9 * (n * n) as u64
}

/// A step of Newton's method for `pressing` of n contacts: the system's rows, its factor, what the
/// step does to all.
pub fn of_newton_step(pressing: usize, n: usize) -> u64 {
    let (p, n) = (pressing as u64, n as u64);
    9 * p * p * (p + 1) + 9 * p * n
}

/// The factor of a convex problem for n contacts, half a product of n³.
pub fn of_convex_factor(n: usize) -> u64 {
    27 * (n * n * n) as u64 / 6
}

/// A convex problem for n contacts: two triangles of the factor at each alternation.
pub fn of_convex_problem(n: usize, alternations: usize) -> u64 {
    9 * (n * n * alternations) as u64
}
