//! The bodies' part of the reduced matrix: `K_uu = Zᵀ (A_s + Jᵀ B J) Z` and `C = K_wu = B J Z`.
//!
//! Bodies that share neither a tree nor flesh do not meet in K_uu; it is one dense block per group.
//! C has, per node, one 3-vector for each freedom of its group.

use crate::math::Vec3;
use crate::solver::BlockMatrix;
use crate::solver::exact::{Reduction, System};
use std::ops::Range;

/// K_uu and C.
#[derive(Clone, Debug)]
pub struct Coarse {
    /// Group of each node.
    group_of_node: Vec<Option<u32>>,
    /// Where the freedoms of each group begin.
    group_start: Vec<usize>,
    /// Where each group's block begins in `blocks`.
    block_start: Vec<usize>,
    /// K_uu, blocks row by row.
    pub blocks: Vec<f64>,
    /// Where each node's row begins in `cross`; one more at the end.
    cross_start: Vec<usize>,
    /// C.
    pub cross: Vec<Vec3>,
    /// Where each node's entries of J Z begin; one more at the end.
    skin_start: Vec<usize>,
    /// Freedom of each entry, counted within the group.
    skin_dofs: Vec<u32>,
    /// J Z.
    skin: Vec<Vec3>,
    /// For each carried node and each freedom of its second bone: the entry.
    second: Vec<Vec<u32>>,
}

impl Coarse {
    /// Room for these bodies and `nodes` nodes; `group_of_node` as found from the bodies whose
    /// flesh they are, and `bones` of each carried node (in the order of `System::carried`).
    pub fn new(
        bodies: &Reduction,
        group_of_node: Vec<Option<u32>>,
        bones: &[(u32, [u32; 2], usize)],
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
        let mut second = Vec::with_capacity(bones.len());
        for &(node, bones, carriers) in bones {
            let list = &mut lists[node as usize];
            let Some(group) = group_of_node[node as usize] else {
                second.push(Vec::new());
                continue;
            };
            let start = bodies.groups()[group as usize].start as u32;
            list.extend(bodies.path(bones[0] as usize).iter().map(|d| d - start));
            let other = if carriers == 2 { bodies.path(bones[1] as usize) } else { &[] };
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
        }
    }

    /// Group of a node and its row of C.
    pub fn cross_of(&self, node: usize) -> Option<(usize, Range<usize>)> {
        let range = self.cross_start[node]..self.cross_start[node + 1];
        self.group_of_node[node].map(|g| (g as usize, range))
    }

    /// Where a group's block lies.
    pub fn block(&self, group: usize) -> Range<usize> {
        self.block_start[group]..self.block_start[group + 1]
    }

    /// `J Z` of a node: freedom within the group, and motion per unit of it.
    pub fn skin_of(&self, node: usize) -> impl Iterator<Item = (usize, &Vec3)> {
        let range = self.skin_start[node]..self.skin_start[node + 1];
        self.skin_dofs[range.clone()].iter().map(|&d| d as usize).zip(&self.skin[range])
    }

    /// Fills K_uu and C.
    pub fn refresh(&mut self, system: &System<'_>) {
        self.blocks.fill(0.0);
        self.fill_skin(system);
        self.fill_cross(system);
        self.add_bodies(system.A, system.split, system.bodies);
        self.add_flesh(system);
        for g in 0..self.group_start.len() {
            let block = self.block(g);
            system.bodies.stiffen(g, &mut self.blocks[block]);
        }
    }

    fn fill_skin(&mut self, system: &System<'_>) {
        for (c, second) in system.carried.iter().zip(&self.second) {
            let start = self.skin_start[c.node as usize];
            let entries = &mut self.skin[start..self.skin_start[c.node as usize + 1]];
            entries.fill(Vec3::zeros());
            for j in 0..c.carriers as usize {
                for (k, (_, column)) in system.bodies.columns(c.bones[j] as usize).enumerate() {
                    let lin = Vec3::new(column[0], column[1], column[2]);
                    let ang = Vec3::new(column[3], column[4], column[5]);
                    let at = if j == 0 { k } else { second[k] as usize };
                    entries[at] += lin * c.weights[j] + ang.cross(&c.levers[j]);
                }
            }
        }
    }

    fn fill_cross(&mut self, system: &System<'_>) {
        self.cross.fill(Vec3::zeros());
        let row0 = 2 * system.bodies.bodies();
        let A = system.A;
        for n in 0..self.group_of_node.len() {
            let row = &mut self.cross[self.cross_start[n]..self.cross_start[n + 1]];
            if row.is_empty() {
                continue;
            }
            for k in system.split[row0 + n] as usize..A.row_start[row0 + n + 1] as usize {
                let m = A.columns[k] as usize - row0;
                let block = &A.blocks[k];
                for e in self.skin_start[m]..self.skin_start[m + 1] {
                    let (x, y) = (&self.skin[e], &mut row[self.skin_dofs[e] as usize]);
                    for r in 0..3 {
                        y[r] += block[r] * x.x + block[3 + r] * x.y + block[6 + r] * x.z;
                    }
                }
            }
        }
        // A given velocity does not follow the bones.
        for c in system.carried.iter().filter(|c| c.is_held()) {
            let row = self.cross_start[c.node as usize]..self.cross_start[c.node as usize + 1];
            self.cross[row].iter_mut().for_each(|x| *x = c.free(x));
        }
    }

    /// `Zᵀ A_s Z`.
    fn add_bodies(&mut self, A: &BlockMatrix, split: &[u32], bodies: &Reduction) {
        for i in 0..2 * bodies.bodies() {
            let Some(group) = bodies.group_of_body(i / 2) else { continue };
            let (start, n) = (self.group_start[group], bodies.groups()[group].len());
            let block_start = self.block_start[group];
            for k in A.row_start[i] as usize..split[i] as usize {
                let (j, block) = (A.columns[k] as usize, &A.blocks[k]);
                if block.iter().all(|&x| x == 0.0) {
                    continue;
                }
                for (q, column) in bodies.columns(j / 2) {
                    let x = part(column, j % 2);
                    let y = Vec3::from_fn(|r, _| {
                        block[r] * x.x + block[3 + r] * x.y + block[6 + r] * x.z
                    });
                    for (p, column) in bodies.columns(i / 2) {
                        self.blocks[block_start + (p - start) * n + q - start] +=
                            part(column, i % 2).dot(&y);
                    }
                }
            }
        }
    }

    /// `Zᵀ Jᵀ C`, and the springs of held nodes.
    fn add_flesh(&mut self, system: &System<'_>) {
        for c in system.carried {
            let node = c.node as usize;
            let Some((group, row)) = self.cross_of(node) else { continue };
            let n = row.len();
            let block = self.block(group);
            let block = &mut self.blocks[block];
            let entries = self.skin_start[node]..self.skin_start[node + 1];
            for e in entries.clone() {
                let (p, motion) = (self.skin_dofs[e] as usize, &self.skin[e]);
                let line = &mut block[p * n..(p + 1) * n];
                let cross = &self.cross[row.clone()];
                line.iter_mut().zip(cross).for_each(|(k, c)| *k += motion.dot(c));
                if c.is_held() {
                    let tied = motion - c.free(motion);
                    for f in entries.clone() {
                        line[self.skin_dofs[f] as usize] += c.spring * tied.dot(&self.skin[f]);
                    }
                }
            }
        }
    }
}

fn part(column: &crate::math::Vec6, part: usize) -> Vec3 {
    Vec3::new(column[3 * part], column[3 * part + 1], column[3 * part + 2])
}
