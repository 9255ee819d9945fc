//! Flesh as bones feel it: `Jᵀ B J` between the motions of bones, and the rows of `B J` it comes
//! from.
//!
//! J has a 3×6 block for each bone that carries a node. For each node the product with its row of B
//! is formed bone by bone (a *slot*), and a slot then adds `J_ni` times it to the block (i, j) of
//! the bones. Only i ≥ j is kept.

use crate::solver::BlockMatrix;
use crate::solver::monolithic::{CarriedNode, Reduction, System};
use fearless_simd::{Simd, f64x8, prelude::*};
use std::collections::BTreeSet;
use std::ops::Range;

/// Six numbers (of a motion or a wrench: linear, angular) and two zeros.
pub type Lane = [f64; 8];
/// Columns of Z of a body, eight by eight: for each component of the motion, eight freedoms.
pub type Columns = [Lane; 6];

/// One node's row of `B J`, one bone's part of it.
#[derive(Clone, Copy, Debug)]
struct Slot {
    node: u32,
    bone: u32,
    terms: (u32, u32),
    targets: (u32, u32),
}

/// The plan of what is multiplied with what, and the result.
#[derive(Clone, Debug)]
pub struct Condensed {
    /// Carried node and carrier of each block of J.
    levers: Vec<(u32, u8)>,
    /// Jacobian J of the contacts.
    J: Vec<[Lane; 3]>,
    slots: Vec<Slot>,
    /// Products to form: a block of the matrix times a block of J.
    terms: Vec<[u32; 2]>,
    /// Products to add up: a block of J, transposed, times the slot, and the pair that it goes to.
    targets: Vec<[u32; 2]>,
    /// Pairs of bones.
    pairs: Vec<[u32; 2]>,
    /// Blocks of bones, rows of the first times columns of the second.
    K: Vec<[Lane; 6]>,
    /// Blocks of A of two bodies: entry, pair, and which parts (linear, angular) of its rows and
    /// columns.
    bodies: Vec<(u32, u32, [usize; 2])>,
    /// Two blocks of J of a held node, their pair, and the carried node.
    held: Vec<([u32; 2], u32, u32)>,
    /// Index of each body's first column in `columns`; one more at the end.
    columns_start: Vec<usize>,
    columns: Vec<Columns>,
}

impl Condensed {
    /// Plans the products. `row0` is the first block row of `pattern` that belongs to a node.
    pub fn new(
        bodies: &Reduction,
        carried: &[CarriedNode],
        pattern: &BlockMatrix,
        row0: usize,
    ) -> Self {
        let moves = |b: u32| bodies.group_of_body(b as usize).is_some();
        let nodes = pattern.rows() - row0;
        let mut of_node: Vec<Vec<(u32, u32)>> = vec![Vec::new(); nodes];
        let mut levers = Vec::new();
        for (k, c) in carried.iter().enumerate() {
            for j in (0..c.bone_count).filter(|&j| moves(c.bones[j as usize])) {
                of_node[c.node as usize].push((c.bones[j as usize], levers.len() as u32));
                levers.push((k as u32, j));
            }
        }

        // Pairs: bodies that share a block of A, and bones that meet over an edge of the mesh.
        let neighbours = |n: usize| {
            let row = pattern.row(row0 + n);
            row.filter_map(|k| {
                (pattern.columns[k] as usize).checked_sub(row0).map(|m| (k as u32, m))
            })
        };
        let mut pairs: BTreeSet<[u32; 2]> = BTreeSet::new();
        let parts = |i: usize| (i as u32 / 2, i % 2);
        for i in 0..row0 {
            let (a, _) = parts(i);
            let others = pattern.row(i).map(|k| pattern.columns[k] as usize);
            let of_bodies = others.filter(|&j| j < row0).map(|j| parts(j).0);
            pairs.extend(of_bodies.filter(|&b| b <= a && moves(a) && moves(b)).map(|b| [a, b]));
        }
        for n in 0..nodes {
            for (_, m) in neighbours(n) {
                for &(i, _) in &of_node[n] {
                    let below = of_node[m].iter().filter(|(j, _)| *j <= i);
                    pairs.extend(below.map(|&(j, _)| [i, j]));
                }
            }
        }
        let pairs: Vec<[u32; 2]> = pairs.into_iter().collect();
        let pair_of = |i: u32, j: u32| pairs.binary_search(&[i, j]).ok().map(|p| p as u32);

        let (mut slots, mut terms, mut targets) = (Vec::new(), Vec::new(), Vec::new());
        for n in 0..nodes {
            let met: BTreeSet<u32> =
                neighbours(n).flat_map(|(_, m)| of_node[m].iter().map(|(b, _)| *b)).collect();
            for bone in met {
                let (first_term, first_target) = (terms.len() as u32, targets.len() as u32);
                for (k, m) in neighbours(n) {
                    let here = of_node[m].iter().filter(|(b, _)| *b == bone);
                    terms.extend(here.map(|&(_, e)| [k, e]));
                }
                let above = of_node[n].iter().filter(|(i, _)| *i >= bone);
                targets.extend(above.filter_map(|&(i, e)| pair_of(i, bone).map(|p| [e, p])));
                slots.push(Slot {
                    node: n as u32,
                    bone,
                    terms: (first_term, terms.len() as u32),
                    targets: (first_target, targets.len() as u32),
                });
            }
        }

        let mut own = Vec::new();
        for i in 0..row0 {
            for k in pattern.row(i) {
                let j = pattern.columns[k] as usize;
                let ((a, part), (b, other)) = (parts(i), parts(j));
                if j < row0
                    && let Some(pair) = pair_of(a, b)
                {
                    own.push((k as u32, pair, [part, other]));
                }
            }
        }
        let mut held = Vec::new();
        for (k, c) in carried.iter().enumerate().filter(|(_, c)| c.is_held()) {
            for &(i, e) in &of_node[c.node as usize] {
                for &(j, f) in of_node[c.node as usize].iter().filter(|(j, _)| *j <= i) {
                    held.extend(pair_of(i, j).map(|p| ([e, f], p, k as u32)));
                }
            }
        }
        let mut columns_start = vec![0];
        for b in 0..bodies.bodies() {
            columns_start.push(columns_start[b] + bodies.path(b).len().div_ceil(8));
        }
        Self {
            J: vec![[[0.0; 8]; 3]; levers.len()],
            K: vec![[[0.0; 8]; 6]; pairs.len()],
            columns: vec![[[0.0; 8]; 6]; columns_start[bodies.bodies()]],
            levers,
            slots,
            terms,
            targets,
            pairs,
            bodies: own,
            held,
            columns_start,
        }
    }

    /// Takes over where nodes and bones are.
    pub fn refresh(&mut self, system: &System<'_>) {
        for (J, &(k, j)) in self.J.iter_mut().zip(&self.levers) {
            let c = &system.carried[k as usize];
            *J = motion_of(c, j as usize);
            for axis in (0..3).filter(|&axis| c.held[axis]) {
                J[axis] = [0.0; 8];
            }
        }
        for b in 0..system.bodies.bodies() {
            let columns = &mut self.columns[self.columns_start[b]..self.columns_start[b + 1]];
            for (k, column) in system.bodies.lanes(b).iter().enumerate() {
                (0..6).for_each(|r| columns[k / 8][r][k % 8] = column[r]);
            }
        }
    }

    /// Goes through the rows of `B J`. With `condense` fills the blocks of bones; each row is given
    /// to `then` with node, bone, the bone's columns of Z, and its 3×6 numbers.
    #[inline(always)]
    pub fn sweep<S: Simd>(
        &mut self,
        simd: S,
        A: &BlockMatrix,
        condense: bool,
        mut then: Option<impl FnMut(usize, usize, &[Columns], &[f64x8<S>; 3])>,
    ) {
        if condense {
            self.K.fill([[0.0; 8]; 6]);
        }
        for slot in &self.slots {
            let targets = slot.targets.0 as usize..slot.targets.1 as usize;
            if then.is_none() && targets.is_empty() {
                continue;
            }
            // Nine sums, so that none waits for the one before.
            let mut sums = [[simd.splat_f64x8(0.0); 3]; 3];
            for &[k, e] in &self.terms[slot.terms.0 as usize..slot.terms.1 as usize] {
                let (block, J) = (&A.blocks[k as usize], &self.J[e as usize]);
                for c in 0..3 {
                    let row = f64x8::load_array_ref(simd, &J[c]);
                    for r in 0..3 {
                        sums[r][c] = row.mul_add(block[3 * c + r], sums[r][c]);
                    }
                }
            }
            let [x, y, z] = sums;
            let row = [x[0] + (x[1] + x[2]), y[0] + (y[1] + y[2]), z[0] + (z[1] + z[2])];
            if condense {
                for &[e, p] in &self.targets[targets] {
                    add_transposed(simd, &self.J[e as usize], &row, &mut self.K[p as usize]);
                }
            }
            if let Some(then) = &mut then {
                let bone = slot.bone as usize;
                let columns = self.columns_start[bone]..self.columns_start[bone + 1];
                then(slot.node as usize, bone, &self.columns[columns], &row);
            }
        }
    }

    /// Adds the bodies' own blocks of A, and the springs of held nodes.
    pub fn add_bodies(&mut self, system: &System<'_>) {
        for &(k, p, [part, other]) in &self.bodies {
            let (block, K) = (&system.A.blocks[k as usize], &mut self.K[p as usize]);
            for c in 0..3 {
                for r in 0..3 {
                    K[3 * part + r][3 * other + c] += block[3 * c + r];
                }
            }
        }
        for &([e, f], p, k) in &self.held {
            let c = &system.carried[k as usize];
            let whole = |e: u32| {
                let j = self.levers[e as usize].1 as usize;
                motion_of(c, j)
            };
            let (a, b) = (whole(e), whole(f));
            for axis in (0..3).filter(|&axis| c.held[axis]) {
                for i in 0..6 {
                    for j in 0..6 {
                        self.K[p as usize][i][j] += c.spring * a[axis][i] * b[axis][j];
                    }
                }
            }
        }
    }

    /// `Zᵀ K Z`, given to `add` freedom by freedom of the first bone and up to eight of the second,
    /// the place of whose first in the path is given.
    #[inline(always)]
    pub fn reduce<S: Simd>(
        &self,
        simd: S,
        bodies: &Reduction,
        mut add: impl FnMut([usize; 2], usize, Range<usize>, &Lane),
    ) {
        for (&[i, j], K) in self.pairs.iter().zip(&self.K) {
            let (i, j) = (i as usize, j as usize);
            let mut rows = [simd.splat_f64x8(0.0); 6];
            for (row, K) in rows.iter_mut().zip(K) {
                *row = f64x8::load_array_ref(simd, K);
            }
            let width = bodies.path(j).len();
            let columns = &self.columns[self.columns_start[j]..self.columns_start[j + 1]];
            for (p, z) in bodies.lanes(i).iter().enumerate() {
                let even = rows[0] * z[0] + rows[2] * z[2] + rows[4] * z[4];
                let odd = rows[1] * z[1] + rows[3] * z[3] + rows[5] * z[5];
                let left = (even + odd).to_array();
                for (chunk, columns) in columns.iter().enumerate() {
                    let mut sum = simd.splat_f64x8(0.0);
                    for c in 0..6 {
                        sum = f64x8::load_array_ref(simd, &columns[c]).mul_add(left[c], sum);
                    }
                    add([i, j], p, 8 * chunk..width.min(8 * chunk + 8), &sum.to_array());
                }
            }
        }
    }
}

/// A carried node's motion by that of its bone j, `[w I, turning]`, row by row.
fn motion_of(carried: &CarriedNode, j: usize) -> [Lane; 3] {
    let (w, turn) = (carried.weights[j], carried.turning.matrix(j));
    std::array::from_fn(|r| {
        let mut row = [0.0; 8];
        row[r] = w;
        (0..3).for_each(|c| row[3 + c] = turn[(r, c)]);
        row
    })
}

/// `K += Jᵀ Q`.
#[inline(always)]
fn add_transposed<S: Simd>(simd: S, J: &[Lane; 3], Q: &[f64x8<S>; 3], K: &mut [Lane; 6]) {
    for a in 0..3 {
        K[a] = Q[a].mul_add(J[a][a], f64x8::load_array_ref(simd, &K[a])).to_array();
    }
    for a in 3..6 {
        let mut sum = f64x8::load_array_ref(simd, &K[a]);
        for c in 0..3 {
            sum = Q[c].mul_add(J[c][a], sum);
        }
        K[a] = sum.to_array();
    }
}
