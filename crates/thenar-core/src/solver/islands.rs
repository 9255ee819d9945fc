//! Islands: bodies that move each other within a step, by joints, flesh, coupling or contact. What
//! one island does is nothing to the others, so that a step that fails in one is mended in that
//! one.

use crate::math::Vec3;
use crate::solver::{BlockMatrix, ContactRow, ContactRows};

/// For what does not move by itself.
const NONE: u32 = u32::MAX;

/// The islands of a world. Joints, flesh and coupling tie for good; contact ties in one step.
#[derive(Clone, Debug)]
pub struct Islands {
    rigids: usize,
    /// Permanent ties: a number for each block row, [`NONE`] for bodies that do not move.
    tied: Vec<u32>,
    /// Leader of each number: another of the same island, or itself.
    leader: Vec<u32>,
    /// True for each number with a contact or a limit that may bear load.
    touched: Vec<bool>,
    /// True for each number with nodes.
    fleshy: Vec<bool>,
    /// True for each number that stays where it is in this step.
    held: Vec<bool>,
    /// Sums of what [`Islands::add`] was given, for each number.
    sums: Vec<[f64; 2]>,
    /// Part of its velocities that is kept, for each number.
    shares: Vec<f64>,
}

fn find(leader: &[u32], mut k: u32) -> u32 {
    while leader[k as usize] != k {
        k = leader[k as usize];
    }
    k
}

fn join(leader: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(leader, a), find(leader, b));
    leader[a.max(b) as usize] = a.min(b);
}

impl Islands {
    /// Plans the islands of a system with this pattern. `moves` tells of each rigid body whether it
    /// moves by itself; `ties` are further pairs of block rows.
    pub fn new(
        moves: &[bool],
        pattern: &BlockMatrix,
        ties: impl Iterator<Item = [usize; 2]>,
    ) -> Self {
        let (rigids, rows) = (moves.len(), pattern.rows());
        let moved = |row: usize| row >= 2 * rigids || moves[row / 2];
        let mut leader: Vec<u32> = (0..rows as u32).collect();
        let entries = (0..rows)
            .flat_map(|i| pattern.row(i).map(move |entry| [i, pattern.columns[entry] as usize]));
        // A body's linear and angular motion are one.
        let bodies = (0..rigids).map(|b| [2 * b, 2 * b + 1]);
        for [i, j] in bodies.chain(entries).chain(ties) {
            if moved(i) && moved(j) {
                join(&mut leader, i as u32, j as u32);
            }
        }
        // Numbered in the order in which they come.
        let (mut number, mut tied) = (vec![NONE; rows], vec![NONE; rows]);
        let mut count = 0;
        for row in (0..rows).filter(|&row| moved(row)) {
            let first = find(&leader, row as u32) as usize;
            if number[first] == NONE {
                number[first] = count;
                count += 1;
            }
            tied[row] = number[first];
        }
        let leader: Vec<u32> = (0..count).collect();
        let count = count as usize;
        let mut fleshy = vec![false; count];
        tied[2 * rigids..].iter().for_each(|island| fleshy[*island as usize] = true);
        Self {
            rigids,
            tied,
            leader,
            touched: vec![false; count],
            fleshy,
            held: vec![false; count],
            sums: vec![[0.0; 2]; count],
            shares: vec![1.0; count],
        }
    }

    /// The islands of a step with these contacts, whose sums are zero.
    pub fn begin(&mut self, rows: &ContactRows) {
        self.leader.iter_mut().enumerate().for_each(|(k, leader)| *leader = k as u32);
        self.sums.fill([0.0; 2]);
        self.touched.fill(false);
        let Self { tied, leader, rigids, touched, .. } = self;
        for row in &rows.rows {
            let mut first = None;
            each_end(row, rows, *rigids, |end| {
                if tied[end] != NONE {
                    touched[tied[end] as usize] = true;
                    join(leader, *first.get_or_insert(tied[end]), tied[end]);
                }
            });
        }
    }

    /// True for rigid bodies, given by a block row, that only joints hold in this step.
    pub fn are_free(&self, row: usize) -> bool {
        let island = self.tied[row];
        island != NONE && !self.touched[island as usize] && !self.fleshy[island as usize]
    }

    /// Island of a block row; `None` for what does not move by itself.
    fn of(&self, row: usize) -> Option<usize> {
        let tied = self.tied[row];
        (tied != NONE).then(|| find(&self.leader, tied) as usize)
    }

    /// Adds to the sums of the island of a block row: `xᵀ K x`, and `xᵀ (g - K x)` of what is left.
    pub fn add(&mut self, row: usize, length: f64, left: f64) {
        if let Some(island) = self.of(row) {
            self.sums[island][0] += length;
            self.sums[island][1] += left;
        }
    }

    /// Holds no island.
    pub fn release(&mut self) {
        self.held.fill(false);
    }

    /// Holds what is tied for good to a block row.
    pub fn hold(&mut self, row: usize) {
        if self.tied[row] != NONE {
            self.held[self.tied[row] as usize] = true;
        }
    }

    /// True when some are held and others move.
    pub fn hold_some(&self) -> bool {
        self.held.contains(&true) && self.held.contains(&false)
    }

    /// Sets what a list has for each block row to zero where it is held.
    pub fn still(&self, list: &mut [Vec3]) {
        if self.held.contains(&true) {
            let held = |row: usize| self.tied[row] != NONE && self.held[self.tied[row] as usize];
            let rows = list.iter_mut().enumerate().filter(|(row, _)| held(*row));
            rows.for_each(|(_, x)| *x = Vec3::zeros());
        }
    }

    /// Finds the part of its velocities x that each island keeps: s, at most 1, with the least
    /// `½ s² xᵀ K x - s xᵀ g`.
    pub fn weigh(&mut self) {
        for (share, [length, left]) in self.shares.iter_mut().zip(&self.sums) {
            *share = if *left < 0.0 { ((length + left) / length).max(0.0) } else { 1.0 };
        }
    }

    /// The part that the island of a block row keeps.
    pub fn share(&self, row: usize) -> f64 {
        self.of(row).map_or(1.0, |island| self.shares[island])
    }

    /// The part that the island of a contact keeps.
    pub fn share_of_contact(&self, row: &ContactRow, rows: &ContactRows) -> f64 {
        let mut share = 1.0;
        each_end(row, rows, self.rigids, |end| {
            if self.tied[end] != NONE {
                share = self.share(end);
            }
        });
        share
    }

    /// Scales velocities, one for each block row, but for the components that are given.
    pub fn scale(&self, known: &[[bool; 3]], v: &mut [Vec3]) {
        for (row, (v, known)) in v.iter_mut().zip(known).enumerate() {
            let s = self.share(row);
            (0..3).filter(|&k| !known[k]).for_each(|k| v[k] *= s);
        }
    }
}

/// The block rows of what a contact holds.
fn each_end(row: &ContactRow, rows: &ContactRows, rigids: usize, mut tell: impl FnMut(usize)) {
    row.rigids.iter().flatten().for_each(|(body, ..)| tell(2 * *body as usize));
    let nodes = row.nodes.start as usize..row.nodes.end as usize;
    rows.nodes[nodes].iter().for_each(|node| tell(2 * rigids + *node as usize));
}
