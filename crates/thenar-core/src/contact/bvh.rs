//! A binary tree of bounding boxes: built once, refitted when its items move.

use crate::contact::aabb::Aabb;
use crate::contact::triangle::ROUNDED_UP;
use crate::math::Vec3;
use std::ops::Range;

/// Most items of a leaf: a node's box is looked at before those of its items, which pays only where
/// it is passed over for several. It decides the time and the order of visits.
const LEAF_ITEMS_MAX: usize = 4;
/// Median splits halve the items, so 2³² items need no more than this.
const STACK: usize = 64;
/// Room for pairs of nodes that wait: each level of either tree leaves at most two.
const WAITING: usize = 4 * STACK;

/// A leaf holds `items[first..first + count]`; an inner node (`count` 0) the children `first`
/// and `first + 1`, always later in the list than itself.
#[derive(Clone, Copy, Debug)]
struct Node {
    aabb: Aabb,
    first: u32,
    count: u32,
}

impl Node {
    /// The items of a leaf.
    fn range(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// The tree. Its shape depends only on the boxes it was built from.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    items: Vec<u32>,
    /// Boxes of the items, in their order here.
    boxes: Vec<Aabb>,
    /// The groups, and the node that holds all of each.
    roots: Vec<(u32, u32)>,
}

impl Bvh {
    /// Builds over these boxes, splitting at the median centre along the longest axis.
    pub fn build(boxes: &[Aabb]) -> Self {
        Self::build_grouped(boxes, |_| 0)
    }

    /// Builds over these boxes like [`Bvh::build`], with the items of each group under a node of
    /// their own.
    pub fn build_grouped(boxes: &[Aabb], group_of: impl Fn(u32) -> u32) -> Self {
        let items = (0..boxes.len() as u32).collect();
        let mut tree = Self { items, boxes: boxes.to_vec(), ..Self::default() };
        if boxes.is_empty() {
            return tree;
        }
        tree.nodes.push(Node { aabb: Aabb::EMPTY, first: 0, count: 0 });
        tree.items.sort_by_key(|&i| (group_of(i), i));
        let mut open = vec![(0usize, 0usize, boxes.len(), false)];
        while let Some((node, start, end, grouped)) = open.pop() {
            let group = group_of(tree.items[start]);
            let one = grouped || group_of(tree.items[end - 1]) == group;
            if one && !grouped {
                tree.roots.push((group, node as u32));
            }
            if one && end - start <= LEAF_ITEMS_MAX {
                tree.nodes[node].first = start as u32;
                tree.nodes[node].count = (end - start) as u32;
                continue;
            }
            let middle = match one {
                true => tree.split(boxes, start, end),
                false => boundary(&tree.items, start, end, &group_of),
            };
            let left = tree.nodes.len();
            let empty = Node { aabb: Aabb::EMPTY, first: 0, count: 0 };
            tree.nodes.extend([empty, empty]);
            tree.nodes[node].first = left as u32;
            open.push((left, start, middle, one));
            open.push((left + 1, middle, end, one));
        }
        tree.roots.sort_unstable();
        tree.refit(|i| boxes[i as usize]);
        tree
    }

    /// Parts the items in two equal halves; returns where the second begins.
    fn split(&mut self, boxes: &[Aabb], start: usize, end: usize) -> usize {
        let items = &mut self.items[start..end];
        let centers: Vec<_> = items.iter().map(|&i| boxes[i as usize].center()).collect();
        let centers = Aabb::of_points(centers.iter());
        let axis = (centers.max - centers.min).imax();
        let middle = (end - start) / 2;
        items.select_nth_unstable_by(middle, |&i, &j| {
            let (ci, cj) = (boxes[i as usize].center(), boxes[j as usize].center());
            ci[axis].total_cmp(&cj[axis]).then(i.cmp(&j))
        });
        start + middle
    }

    /// Recomputes every box from `box_of(item)`, children before parents.
    pub fn refit(&mut self, box_of: impl Fn(u32) -> Aabb) {
        for (aabb, &item) in self.boxes.iter_mut().zip(&self.items) {
            *aabb = box_of(item);
        }
        for n in (0..self.nodes.len()).rev() {
            let Node { first, count, .. } = self.nodes[n];
            let first = first as usize;
            self.nodes[n].aabb = if count > 0 {
                let boxes = &self.boxes[first..first + count as usize];
                boxes.iter().fold(Aabb::EMPTY, Aabb::union)
            } else {
                self.nodes[first].aabb.union(&self.nodes[first + 1].aabb)
            };
        }
    }

    /// Numbers the items as their leaves follow each other; returns the former number of each.
    pub fn renumber(&mut self) -> Vec<u32> {
        let in_order = (0..self.items.len() as u32).collect();
        std::mem::replace(&mut self.items, in_order)
    }

    /// Calls `visit` for every item, leaf by leaf.
    pub fn in_order(&self, visit: impl FnMut(u32)) {
        self.items.iter().copied().for_each(visit);
    }

    /// The number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// The two children of an inner node; `Err` with the items of a leaf.
    pub fn children(&self, node: usize) -> Result<[usize; 2], &[u32]> {
        let Node { first, count, .. } = self.nodes[node];
        let first = first as usize;
        if count > 0 {
            Err(&self.items[first..first + count as usize])
        } else {
            Ok([first, first + 1])
        }
    }

    /// Calls `visit` for every item of A with every item of B whose boxes come within `reach`.
    pub fn pairs(a: &Self, b: &Self, reach: f64, mut visit: impl FnMut(u32, u32)) {
        let mut stack = [(0, 0); WAITING];
        walk((a, b), (0, 0), reach, |_, _| false, &mut stack, &mut visit);
    }

    /// Calls `visit` once for every two items of this tree whose boxes come within `reach`; two
    /// groups for which `apart` holds and pairs of nodes for which `skip` holds are left out.
    pub fn pairs_within(
        &self,
        reach: f64,
        apart: impl Fn(u32, u32) -> bool,
        skip: impl Fn(usize, usize) -> bool,
        mut visit: impl FnMut(u32, u32),
    ) {
        let mut stack = [(0, 0); WAITING];
        for (k, &(g, n)) in self.roots.iter().enumerate() {
            for &(_, m) in self.roots[k..].iter().filter(|(h, _)| !apart(g, *h)) {
                walk((self, self), (n, m), reach, &skip, &mut stack, &mut visit);
            }
        }
    }

    /// Calls `visit` for every item of a leaf whose box reaches below `height` along `up`.
    pub fn below(&self, up: &Vec3, height: f64, mut visit: impl FnMut(u32)) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = [0u32; STACK];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let node = self.nodes[stack[top] as usize];
            if up.dot(&node.aabb.center()) - up.abs().dot(&node.aabb.half()) > height {
                continue;
            }
            if node.count > 0 {
                (node.first..node.first + node.count).for_each(|k| visit(self.items[k as usize]));
                continue;
            }
            (stack[top], stack[top + 1]) = (node.first + 1, node.first);
            top += 2;
        }
    }

    /// The groups in order, each with the box around it and its node.
    pub fn groups(&self) -> impl Iterator<Item = (u32, &Aabb, u32)> {
        self.roots.iter().map(|&(group, node)| (group, &self.nodes[node as usize].aabb, node))
    }

    /// Goes through the items below `node` whose box is nearer to `p` than the least squared
    /// distance that `visit` has returned so far, at first `reach_squared`; the nearer box first.
    pub fn nearest(
        &self,
        node: u32,
        p: &Vec3,
        reach_squared: f64,
        mut visit: impl FnMut(u32) -> f64,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let to = |n: u32| self.nodes[n as usize].aabb.distance_squared(p);
        let mut least = reach_squared;
        // Of two lists, which are sooner cleared than one of pairs.
        let (mut distances, mut stack) = ([0.0; STACK], [0u32; STACK]);
        (distances[0], stack[0]) = (to(node), node);
        let mut top = 1;
        while top > 0 {
            top -= 1;
            if distances[top] >= least {
                continue;
            }
            let Node { first, count, .. } = self.nodes[stack[top] as usize];
            if count > 0 {
                for k in first as usize..(first + count) as usize {
                    if self.boxes[k].distance_squared(p) < least * ROUNDED_UP {
                        least = least.min(visit(self.items[k]));
                    }
                }
                continue;
            }
            let (l, r) = ((to(first), first), (to(first + 1), first + 1));
            let (near, far) = if l.0 <= r.0 { (l, r) } else { (r, l) };
            (distances[top], stack[top]) = far;
            (distances[top + 1], stack[top + 1]) = near;
            top += 2;
        }
    }

    /// The box around all.
    pub fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, |root| root.aabb)
    }

    /// Goes through the items whose leaf's box a ray from `p` along `d` meets nearer than the least
    /// distance (in lengths of `d`) that `visit` has returned so far.
    pub fn along_ray(&self, p: &Vec3, d: &Vec3, mut visit: impl FnMut(u32) -> f64) {
        if self.nodes.is_empty() {
            return;
        }
        let mut least = f64::INFINITY;
        let mut stack = [0u32; STACK];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let Node { aabb, first, count } = &self.nodes[stack[top] as usize];
            if aabb.met_by_ray(p, d).is_none_or(|at| at > least) {
                continue;
            }
            if *count > 0 {
                for k in *first..first + count {
                    least = least.min(visit(self.items[k as usize]));
                }
                continue;
            }
            (stack[top], stack[top + 1]) = (first + 1, *first);
            top += 2;
        }
    }

    /// Calls `visit` for every item whose box meets `query`.
    pub fn overlapping(&self, query: &Aabb, visit: impl FnMut(u32)) {
        self.overlapping_near(query, |_| true, visit);
    }

    /// Calls `visit` for every item whose box meets `query`, but for items below nodes around whose
    /// box nothing is near.
    pub fn overlapping_near(
        &self,
        query: &Aabb,
        is_near: impl Fn(&Aabb) -> bool,
        mut visit: impl FnMut(u32),
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = [0u32; STACK];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let node = self.nodes[stack[top] as usize];
            if !node.aabb.overlaps(query) || !is_near(&node.aabb) {
                continue;
            }
            if node.count > 0 {
                for k in node.range().filter(|&k| self.boxes[k].overlaps(query)) {
                    visit(self.items[k]);
                }
                continue;
            }
            stack[top] = node.first + 1;
            stack[top + 1] = node.first;
            top += 2;
        }
    }
}

/// Returns the place where the group changes, as near to the middle as possible.
fn boundary(items: &[u32], start: usize, end: usize, group_of: impl Fn(u32) -> u32) -> usize {
    let middle = (start + end) / 2;
    let changes = |&k: &usize| group_of(items[k - 1]) != group_of(items[k]);
    (start + 1..end).filter(changes).min_by_key(|k| k.abs_diff(middle)).unwrap_or(middle)
}

/// Goes down from two nodes at once, always into the larger of two boxes.
fn walk(
    (a, b): (&Bvh, &Bvh),
    from: (u32, u32),
    reach: f64,
    skip: impl Fn(usize, usize) -> bool,
    stack: &mut [(u32, u32); WAITING],
    visit: &mut impl FnMut(u32, u32),
) {
    if a.nodes.is_empty() || b.nodes.is_empty() {
        return;
    }
    let same = std::ptr::eq(a, b);
    stack[0] = from;
    let mut top = 1;
    while top > 0 {
        top -= 1;
        let (n, m) = (stack[top].0 as usize, stack[top].1 as usize);
        let (of_a, of_b) = (&a.nodes[n], &b.nodes[m]);
        let itself = same && n == m;
        // Boxes first: to skip, the caller looks into a table, which costs more.
        if (!itself && !of_a.aabb.inflate(reach).overlaps(&of_b.aabb)) || skip(n, m) {
            continue;
        }
        let size =
            |node: &Node| if node.count > 0 { -1.0 } else { node.aabb.half().norm_squared() };
        match (a.children(n), b.children(m)) {
            (Err(_), Err(_)) => {
                let (of_n, of_m) = (of_a.range(), of_b.range());
                for k in of_n {
                    let near = a.boxes[k].inflate(reach);
                    if !itself && !near.overlaps(&of_b.aabb) {
                        continue;
                    }
                    let first = if itself { k + 1 } else { of_m.start };
                    for l in first..of_m.end {
                        if near.overlaps(&b.boxes[l]) {
                            visit(a.items[k], b.items[l]);
                        }
                    }
                }
            }
            (Ok([l, r]), _) if itself => {
                [(l, r), (r, r), (l, l)].iter().for_each(|&(i, j)| push(stack, &mut top, i, j));
            }
            (Ok(halves), Err(_)) => {
                halves.iter().for_each(|&i| push(stack, &mut top, i, m));
            }
            (Ok(halves), Ok(_)) if size(of_a) >= size(of_b) => {
                halves.iter().for_each(|&i| push(stack, &mut top, i, m));
            }
            (_, Ok(halves)) => halves.iter().for_each(|&j| push(stack, &mut top, n, j)),
        }
    }
}

fn push(stack: &mut [(u32, u32)], top: &mut usize, n: usize, m: usize) {
    stack[*top] = (n as u32, m as u32);
    *top += 1;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

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

    #[test]
    fn pairs_match_brute_force() {
        let mut random = Random::new(2);
        for (n, m) in [(0, 3), (1, 1), (5, 200), (300, 70)] {
            let (one, two) = (boxes(&mut random, n), boxes(&mut random, m));
            let near = |a: &Aabb, b: &Aabb| a.inflate(0.03).overlaps(b);
            let (a, b) = (Bvh::build(&one), Bvh::build(&two));
            let mut found = Vec::new();
            Bvh::pairs(&a, &b, 0.03, |i, j| {
                if near(&one[i as usize], &two[j as usize]) {
                    found.push((i, j));
                }
            });
            found.sort_unstable();
            let all = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
            let brute: Vec<_> = all.filter(|&(i, j)| near(&one[i], &two[j])).collect();
            assert_eq!(found, brute.iter().map(|&(i, j)| (i as u32, j as u32)).collect::<Vec<_>>());

            let mut within = Vec::new();
            b.pairs_within(
                0.03,
                |_, _| false,
                |_, _| false,
                |i, j| {
                    if near(&two[i as usize], &two[j as usize]) {
                        within.push((i.min(j) as usize, i.max(j) as usize));
                    }
                },
            );
            within.sort_unstable();
            let all = (0..m).flat_map(|i| (i + 1..m).map(move |j| (i, j)));
            let brute: Vec<_> = all.filter(|&(i, j)| near(&two[i], &two[j])).collect();
            assert_eq!(within, brute);
        }
    }
}
