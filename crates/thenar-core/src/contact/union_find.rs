//! Union-find: a forest of disjoint sets (Galler & Fisher 1964), emptied at the cost of what was
//! joined.

use crate::capacity_vec::CapacityVec;

/// A partition of `0..n`, at first of single numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct UnionFind {
    parent: Vec<u32>,
    /// The numbers that were ever joined.
    joined: CapacityVec<u32>,
}

impl UnionFind {
    pub fn with_size(n: usize) -> Self {
        Self { parent: (0..n as u32).collect(), joined: CapacityVec::with_capacity(n) }
    }

    /// The lowest number of the group of `i`, whatever the order in which it grew.
    pub fn find(&self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            i = self.parent[i as usize];
        }
        i
    }

    /// Makes one group of two.
    pub fn union(&mut self, i: u32, j: u32) {
        let (i, j) = (self.find_halving(i), self.find_halving(j));
        let (low, high) = (i.min(j), i.max(j));
        if low != high {
            self.parent[high as usize] = low;
            self.joined.push(high);
        }
    }

    /// Finds what [`UnionFind::find`] does, halving the paths up.
    fn find_halving(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let up = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = up;
            i = up;
        }
        i
    }

    pub fn clear(&mut self) {
        for i in self.joined.drain(..) {
            self.parent[i as usize] = i;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_known_by_their_lowest_number_until_cleared() {
        let mut groups = UnionFind::with_size(9);
        for (i, j) in [(8, 5), (3, 4), (5, 4), (7, 7), (8, 3)] {
            groups.union(i, j);
        }
        let all = |groups: &UnionFind| (0..9).map(|i| groups.find(i)).collect::<Vec<_>>();
        assert_eq!(all(&groups), [0, 1, 2, 3, 3, 3, 6, 7, 3]);
        groups.clear();
        assert_eq!(all(&groups), (0..9).collect::<Vec<_>>());
    }
}
