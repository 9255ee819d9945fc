//! Choice of the contacts that enter the compliance next.
//!
//! At long time steps the velocities without contact carry a hand far into a table, and every point
//! of it seems to press. Few do once the others hold it. So those that pressed before start, then
//! those that close the fastest, a few at a time, until the true velocities close no gap.

use crate::capacity_vec::CapacityVec;
use crate::solver::{ContactRow, ContactRows};

/// So few contacts are not sorted out: all enter at once.
pub const ALL_AT_ONCE: usize = 96;
/// No more enter between two solutions.
const JOIN_MAX: usize = 64;

/// The contacts that wait, and which places are taken.
#[derive(Clone, Debug, Default)]
pub struct JoinQueue {
    /// Closing speed of each \[m/s\], and its row.
    waiting: CapacityVec<(f64, u32)>,
    /// Per node, the last round in which a contact that leans mostly on it entered.
    taken: Vec<u32>,
    round: u32,
}

impl JoinQueue {
    /// Room for this many contacts on this many nodes.
    pub fn new(contacts: usize, nodes: usize) -> Self {
        Self { waiting: CapacityVec::with_capacity(contacts), taken: vec![0; nodes], round: 0 }
    }

    /// Nobody waits.
    pub fn clear(&mut self) {
        self.waiting.clear();
    }

    /// Contact `i` waits; it closes at `speed` \[m/s\].
    pub fn wait(&mut self, i: usize, speed: f64) {
        self.waiting.push((speed, i as u32));
    }

    /// Returns the number that wait.
    pub fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Offers those that close the fastest to `admit` until it refuses: all when they are few or
    /// `all` says so, else one per place, since it holds its neighbours too. Returns how many
    /// entered.
    pub fn admit(
        &mut self,
        contacts: &ContactRows,
        all: bool,
        mut admit: impl FnMut(usize) -> bool,
    ) -> usize {
        self.waiting.sort_unstable_by(|(s, i), (t, j)| t.total_cmp(s).then(i.cmp(j)));
        let all = all || self.waiting.len() <= JOIN_MAX;
        self.round = self.round.wrapping_add(1);
        let mut joined = 0;
        for &(_, i) in &self.waiting {
            let place = heaviest(contacts, &contacts.rows[i as usize]);
            let taken = place.map(|node| &mut self.taken[node]);
            let free = taken.is_none_or(|t| std::mem::replace(t, self.round) != self.round);
            if !all && (!free || joined == JOIN_MAX) {
                continue;
            }
            if !admit(i as usize) {
                break;
            }
            joined += 1;
        }
        joined
    }
}

/// The node that a contact leans on the most.
fn heaviest(contacts: &ContactRows, row: &ContactRow) -> Option<usize> {
    let nodes = row.nodes.start as usize..row.nodes.end as usize;
    let weight = |k: &usize| contacts.weights[*k].abs();
    let k = nodes.max_by(|i, j| weight(i).total_cmp(&weight(j)).then(j.cmp(i)))?;
    Some(contacts.nodes[k] as usize)
}
