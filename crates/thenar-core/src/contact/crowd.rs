//! Bound on the number of pairs of rigid bodies examined, so that a crowd in one place ends.
//!
//! Spheres of any sizes that touch without overlap have fewer than 14.93 neighbours on average
//! (Kuperberg and Schramm, *Average kissing numbers for non-congruent sphere packings*, 1994),
//! which is fewer than 7.47 pairs per body. Four times as many are looked at, as boxes around
//! bodies meet more often than these. A world in which more are near each other is entangled, or
//! made of grains smaller than the margin, or of long bodies askew: then only pairs whose boxes
//! overlap without the margin are looked at, and of each body only as many. Bodies that do not move
//! by forces meet any number.

/// Pairs of rigid bodies that are looked at per body: four times 7.47, and a bit.
pub(crate) const PAIRS_PER_BODY: usize = 32;

/// Pairs that one search may still look at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Allowance {
    all: usize,
    of_body: usize,
}

impl Allowance {
    /// Room for a search among `bodies` bodies.
    pub fn new(bodies: usize) -> Self {
        Self { all: PAIRS_PER_BODY * bodies, of_body: 0 }
    }

    /// The next body begins.
    pub fn next_body(&mut self) {
        self.of_body = PAIRS_PER_BODY;
    }

    /// Returns the distance within which boxes are examined, given a contact margin \[m\]; `None`
    /// once the pairs of this body are used up.
    pub fn margin(&self, margin: f64) -> Option<f64> {
        match (self.all, self.of_body) {
            (1.., _) => Some(margin),
            (0, 1..) => Some(0.0),
            (0, 0) => None,
        }
    }

    /// Counts a pair that is looked at.
    pub fn spend(&mut self) {
        match &mut self.all {
            0 => self.of_body -= 1,
            all => *all -= 1,
        }
    }
}
