//! A binary tree of bounding boxes: built once, refitted when its items move.

use crate::contact::aabb::Aabb;
use crate::math::Vec3;

const LEAF_ITEMS_MAX: usize = 4;
/// Median splits halve the items, so 2³² items need no more than this.
const STACK: usize = 64;

/// A leaf holds `items[first..first + count]`; an inner node (`count` 0) the children `first`
/// and `first + 1`, always later in the list than itself.
#[derive(Clone, Copy, Debug)]
struct Node {
    aabb: Aabb,
    first: u32,
    count: u32,
}

/// The tree. Its shape depends only on the boxes it was built from.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    items: Vec<u32>,
}

impl Bvh {
    /// Builds over these boxes, splitting at the median centre along the longest axis.
    pub fn build(boxes: &[Aabb]) -> Self {
        let mut tree = Self { nodes: Vec::new(), items: (0..boxes.len() as u32).collect() };
        if boxes.is_empty() {
            return tree;
        }
        tree.nodes.push(Node { aabb: Aabb::EMPTY, first: 0, count: 0 });
        let mut open = vec![(0usize, 0usize, boxes.len())];
        while let Some((node, start, end)) = open.pop() {
            if end - start <= LEAF_ITEMS_MAX {
                tree.nodes[node].first = start as u32;
                tree.nodes[node].count = (end - start) as u32;
                continue;
            }
            let centers = Aabb::of_points(
                tree.items[start..end]
                    .iter()
                    .map(|&i| boxes[i as usize].center())
                    .collect::<Vec<_>>()
                    .iter(),
            );
            let axis = (centers.max - centers.min).imax();
            let middle = (end - start) / 2;
            tree.items[start..end].select_nth_unstable_by(middle, |&i, &j| {
                let (ci, cj) = (boxes[i as usize].center(), boxes[j as usize].center());
                ci[axis].total_cmp(&cj[axis]).then(i.cmp(&j))
            });
            let left = tree.nodes.len();
            let empty = Node { aabb: Aabb::EMPTY, first: 0, count: 0 };
            tree.nodes.extend([empty, empty]);
            tree.nodes[node].first = left as u32;
            open.push((left, start, start + middle));
            open.push((left + 1, start + middle, end));
        }
        tree.refit(|i| boxes[i as usize]);
        tree
    }

    /// Recomputes every box from `box_of(item)`, children before parents.
    pub fn refit(&mut self, box_of: impl Fn(u32) -> Aabb) {
        for n in (0..self.nodes.len()).rev() {
            let Node { first, count, .. } = self.nodes[n];
            let first = first as usize;
            self.nodes[n].aabb = if count > 0 {
                let items = &self.items[first..first + count as usize];
                items.iter().fold(Aabb::EMPTY, |b, &i| b.union(&box_of(i)))
            } else {
                self.nodes[first].aabb.union(&self.nodes[first + 1].aabb)
            };
        }
    }

    /// Calls `visit(item, bound)` for items whose box may be nearer to `p` than the root of
    /// `bound`; it returns the new squared bound. Near children come first.
    pub fn nearest(&self, p: &Vec3, mut bound: f64, mut visit: impl FnMut(u32, f64) -> f64) {
        let Some(root) = self.nodes.first() else { return };
        let mut stack = [(0u32, 0.0f64); STACK];
        stack[0] = (0, root.aabb.distance_squared(p));
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let (n, distance) = stack[top];
            if distance > bound {
                continue;
            }
            let node = self.nodes[n as usize];
            if node.count > 0 {
                for k in node.first..node.first + node.count {
                    bound = visit(self.items[k as usize], bound);
                }
                continue;
            }
            let child = |c: u32| (c, self.nodes[c as usize].aabb.distance_squared(p));
            let (near, far) = (child(node.first), child(node.first + 1));
            let (near, far) = if far.1 < near.1 { (far, near) } else { (near, far) };
            stack[top] = far;
            stack[top + 1] = near;
            top += 2;
        }
    }

    /// Calls `visit` for every item of a leaf whose box meets `query`.
    pub fn overlapping(&self, query: &Aabb, mut visit: impl FnMut(u32)) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = [0u32; STACK];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let node = self.nodes[stack[top] as usize];
            if !node.aabb.overlaps(query) {
                continue;
            }
            if node.count > 0 {
                (node.first..node.first + node.count).for_each(|k| visit(self.items[k as usize]));
                continue;
            }
            stack[top] = node.first + 1;
            stack[top + 1] = node.first;
            top += 2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::triangle::tests::Random;

    fn boxes(random: &mut Random, n: usize) -> Vec<Aabb> {
        (0..n)
            .map(|_| {
                let center = random.vector(1.0);
                Aabb::symmetric(random.vector(0.05).abs()).translate(&center)
            })
            .collect()
    }

    /// Against brute force, before and after the items have moved.
    #[test]
    fn queries_match_brute_force() {
        let mut random = Random::new(1);
        for n in [0, 1, 4, 5, 300] {
            let mut tree = Bvh::build(&boxes(&mut random, n));
            let moved = boxes(&mut random, n);
            tree.refit(|i| moved[i as usize]);
            for _ in 0..50 {
                let p = random.vector(1.2);
                let mut best = f64::INFINITY;
                tree.nearest(&p, f64::INFINITY, |i, bound| {
                    best = best.min(moved[i as usize].distance_squared(&p));
                    bound.min(best)
                });
                let brute =
                    moved.iter().map(|b| b.distance_squared(&p)).fold(f64::INFINITY, f64::min);
                assert_eq!(best, brute);

                let query = Aabb::symmetric(Vec3::repeat(0.2)).translate(&p);
                let mut found: Vec<u32> = Vec::new();
                tree.overlapping(&query, |i| {
                    if moved[i as usize].overlaps(&query) {
                        found.push(i);
                    }
                });
                found.sort_unstable();
                let brute: Vec<u32> =
                    (0..n as u32).filter(|&i| moved[i as usize].overlaps(&query)).collect();
                assert_eq!(found, brute);
            }
        }
    }
}
