//! The bodies' part of the reduced matrix: `K_uu = Zᵀ (A_s + Jᵀ B J) Z` and `C = K_wu = B J Z`.
//!
//! Bodies that share neither a tree nor flesh do not meet in K_uu; it is one dense block per group.
//! C has, per node, one 3-vector for each freedom of its group.

use crate::math::Vec3;
use crate::solver::BlockMatrix;
use crate::solver::monolithic::condense::{Columns, Condensed};
use crate::solver::monolithic::{CarriedNode, Reduction, System};
use fearless_simd::{Level, dispatch, f64x8, prelude::*};
use std::ops::Range;

/// K_uu and C.
#[derive(Clone, Debug)]
pub struct Coarse {
    /// Group of each node.
    group_of_node: Vec<Option<u32>>,
    /// Index of the first freedom of each group.
    group_start: Vec<usize>,
    /// Offset of each group's block in `blocks`.
    block_start: Vec<usize>,
    /// K_uu, blocks row by row.
    pub blocks: Vec<f64>,
    /// Offset of each node's row in `cross`; one more at the end.
    cross_start: Vec<usize>,
    /// Cross blocks C.
    pub cross: Vec<Vec3>,
    /// Offset of each node's entries of J Z; one more at the end.
    skin_start: Vec<usize>,
    /// Freedom of each entry, counted within the group.
    skin_dofs: Vec<u32>,
    /// J Z.
    skin: Vec<Vec3>,
    /// For each carried node and each freedom of its second bone: the entry.
    second: Vec<Vec<u32>>,
    condensed: Condensed,
    /// C and J Z belong to the present step.
    crossed: bool,
}

impl Coarse {
    /// Plans for these bodies, carried nodes and this pattern of A; `group_of_node` as found from
    /// the bodies whose flesh the nodes are.
    pub fn new(
        bodies: &Reduction,
        group_of_node: Vec<Option<u32>>,
        carried: &[CarriedNode],
        pattern: &BlockMatrix,
    ) -> Self {
        let nodes = group_of_node.len();
        let width = |g: usize| bodies.groups()[g].len();
        let mut block_start = vec![0];
        for g in 0..bodies.groups().len() {
            block_start.push(block_start[g] + width(g) * width(g));
        }
        let mut cross_start = vec![0];
        for (n, group) in group_of_node.iter().enumerate() {
            cross_start.push(cross_start[n] + group.map_or(0, |g| width(g as usize)));
        }
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); nodes];
        let mut second = Vec::with_capacity(carried.len());
        for &CarriedNode { node, bones, bone_count, .. } in carried {
            let list = &mut lists[node as usize];
            let Some(group) = group_of_node[node as usize] else {
                second.push(Vec::new());
                continue;
            };
            let start = bodies.groups()[group as usize].start as u32;
            list.extend(bodies.path(bones[0] as usize).iter().map(|d| d - start));
            let other = if bone_count == 2 { bodies.path(bones[1] as usize) } else { &[] };
            let place = other.iter().map(|d| {
                let at = list.iter().position(|e| *e == d - start).unwrap_or_else(|| {
                    list.push(d - start);
                    list.len() - 1
                });
                at as u32
            });
            second.push(place.collect());
        }
        let mut skin_start = vec![0];
        for (n, list) in lists.iter().enumerate() {
            skin_start.push(skin_start[n] + list.len());
        }
        let skin_dofs: Vec<u32> = lists.concat();
        Self {
            group_start: bodies.groups().iter().map(|g| g.start).collect(),
            blocks: vec![0.0; block_start.last().copied().unwrap_or(0)],
            cross: vec![Vec3::zeros(); cross_start.last().copied().unwrap_or(0)],
            skin: vec![Vec3::zeros(); skin_dofs.len()],
            group_of_node,
            block_start,
            cross_start,
            skin_start,
            skin_dofs,
            second,
            condensed: Condensed::new(bodies, carried, pattern, 2 * bodies.bodies()),
            crossed: false,
        }
    }

    /// Group of a node and its row of C.
    pub fn cross_of(&self, node: usize) -> Option<(usize, Range<usize>)> {
        let range = self.cross_start[node]..self.cross_start[node + 1];
        self.group_of_node[node].map(|g| (g as usize, range))
    }

    /// Returns the range of a group's block.
    pub fn block(&self, group: usize) -> Range<usize> {
        self.block_start[group]..self.block_start[group + 1]
    }

    /// `J Z` of a node: freedom within the group, and motion per unit of it.
    pub fn skin_of(&self, node: usize) -> impl Iterator<Item = (usize, &Vec3)> {
        let range = self.skin_start[node]..self.skin_start[node + 1];
        self.skin_dofs[range.clone()].iter().map(|&d| d as usize).zip(&self.skin[range])
    }

    /// Fills K_uu, and with `cross` also C and J Z, which only the direct solver needs.
    pub fn refresh(&mut self, system: &System<'_>, cross: bool) {
        self.condensed.refresh(system);
        self.crossed = false;
        self.sweep(system, true, cross);
        self.condensed.add_bodies(system);

        let Self { condensed, blocks, group_start, block_start, .. } = self;
        let bodies = system.bodies;
        blocks.fill(0.0);
        dispatch!(Level::new(), simd => condensed.reduce(simd, bodies, #[inline(always)] |[i, j], p, range, row| {
            let Some(group) = bodies.group_of_body(i) else { return };
            let (start, n) = (group_start[group], bodies.groups()[group].len());
            let block = &mut blocks[block_start[group]..block_start[group + 1]];
            let p = bodies.path(i)[p] as usize - start;
            for (q, x) in bodies.path(j)[range].iter().zip(row) {
                let q = *q as usize - start;
                block[p * n + q] += x;
                if i != j {
                    block[q * n + p] += x;
                }
            }
        }));
        for g in 0..self.group_start.len() {
            let block = self.block(g);
            bodies.stiffen(g, &mut self.blocks[block]);
        }
    }

    /// Fills C and J Z unless that is done.
    pub fn complete(&mut self, system: &System<'_>) {
        if !self.crossed {
            self.sweep(system, false, true);
        }
    }

    fn sweep(&mut self, system: &System<'_>, condense: bool, cross: bool) {
        if !cross {
            dispatch!(Level::new(), simd => {
                let then = None::<fn(usize, usize, &[Columns], &[f64x8<_>; 3])>;
                self.condensed.sweep(simd, system.A, condense, then)
            });
            return;
        }
        self.crossed = true;
        self.fill_skin(system);
        bytemuck::fill_zeroes(&mut self.cross);
        let Self { condensed, cross, cross_start, group_start, group_of_node, .. } = self;
        dispatch!(Level::new(), simd => {
            // C = (B J) Z, bone by bone.
            let then = Some(
                #[inline(always)]
                |node: usize, bone: usize, columns: &[Columns], row: &[f64x8<_>; 3]| {
                let Some(group) = group_of_node[node] else { return };
                let start = group_start[group as usize];
                let out = &mut cross[cross_start[node]..cross_start[node + 1]];
                let row = [row[0].to_array(), row[1].to_array(), row[2].to_array()];
                let paths = system.bodies.path(bone).chunks(8);
                for (columns, dofs) in columns.iter().zip(paths) {
                    let mut sums = [simd.splat_f64x8(0.0); 3];
                    for (c, column) in columns.iter().enumerate() {
                        let column = f64x8::load_array_ref(simd, column);
                        for r in 0..3 {
                            sums[r] = column.mul_add(row[r][c], sums[r]);
                        }
                    }
                    let sums = [sums[0].to_array(), sums[1].to_array(), sums[2].to_array()];
                    for (k, dof) in dofs.iter().enumerate() {
                        out[*dof as usize - start] += Vec3::new(sums[0][k], sums[1][k], sums[2][k]);
                    }
                }
            });
            condensed.sweep(simd, system.A, condense, then)
        });
    }

    fn fill_skin(&mut self, system: &System<'_>) {
        for (c, second) in system.carried.iter().zip(&self.second) {
            let start = self.skin_start[c.node as usize];
            let entries = &mut self.skin[start..self.skin_start[c.node as usize + 1]];
            entries.fill(Vec3::zeros());
            for j in 0..c.bone_count as usize {
                for (k, (_, column)) in system.bodies.columns(c.bones[j] as usize).enumerate() {
                    let lin = Vec3::new(column[0], column[1], column[2]);
                    let ang = Vec3::new(column[3], column[4], column[5]);
                    let at = if j == 0 { k } else { second[k] as usize };
                    entries[at] += lin * c.weights[j] + c.turning.velocity(j, &ang);
                }
            }
        }
    }
}
