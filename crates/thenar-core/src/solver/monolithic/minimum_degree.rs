//! Elimination order of the flesh nodes: by minimum degree.
//!
//! Of the nodes that are left, that with the fewest neighbours is eliminated, whose neighbours then
//! all meet. What they share is kept as an *element*, the list of nodes that met, not as edges
//! between them (the quotient graph of George and Liu 1981), and degrees are the bound of Amestoy,
//! Davis and Duff (1996), which counts a node twice where two older elements hold it.

use std::collections::BTreeSet;

/// The order in which to eliminate the nodes of a graph, given the neighbours of each.
pub fn minimum_degree(neighbours: Vec<Vec<u32>>) -> Vec<u32> {
    let n = neighbours.len();
    let mut graph = Quotient {
        elements_of: vec![Vec::new(); n],
        met: vec![Vec::new(); n],
        outside: vec![0; n],
        seen: vec![0; n],
        stamp: 0,
        neighbours,
    };
    let mut degree: Vec<usize> = graph.neighbours.iter().map(Vec::len).collect();
    let mut queue: BTreeSet<(usize, u32)> =
        degree.iter().enumerate().map(|(node, degree)| (*degree, node as u32)).collect();
    let mut order = Vec::with_capacity(n);
    while let Some((_, pivot)) = queue.pop_first() {
        order.push(pivot);
        graph.eliminate(pivot);
        for k in 0..graph.met[pivot as usize].len() {
            let node = graph.met[pivot as usize][k];
            let bound = graph.degree(node, pivot).min(queue.len() - 1);
            let old = std::mem::replace(&mut degree[node as usize], bound);
            queue.remove(&(old, node));
            queue.insert((bound, node));
        }
    }
    order
}

/// The rest of the graph while nodes are eliminated.
struct Quotient {
    /// Neighbours of each node that no element tells.
    neighbours: Vec<Vec<u32>>,
    /// Elements that hold each node; an element bears the name of the node that made it.
    elements_of: Vec<Vec<u32>>,
    /// Nodes of each element.
    met: Vec<Vec<u32>>,
    /// Number of nodes of each element that are not in the newest.
    outside: Vec<usize>,
    /// Stamp at which each node was last met.
    seen: Vec<u32>,
    stamp: u32,
}

impl Quotient {
    /// Makes an element of the nodes that meet once `pivot` is gone; the elements that held them go
    /// with it.
    fn eliminate(&mut self, pivot: u32) {
        let p = pivot as usize;
        let elements = std::mem::take(&mut self.elements_of[p]);
        let mut met = std::mem::take(&mut self.neighbours[p]);
        for &element in &elements {
            met.extend(std::mem::take(&mut self.met[element as usize]));
        }
        met.sort_unstable();
        met.dedup();
        met.retain(|&node| node != pivot);

        self.stamp += 1;
        met.iter().for_each(|&node| self.seen[node as usize] = self.stamp);
        let (seen, stamp) = (&self.seen, self.stamp);
        for &node in &met {
            let own = &mut self.elements_of[node as usize];
            own.retain(|element| !elements.contains(element));
            own.push(pivot);
            self.neighbours[node as usize]
                .retain(|&other| other != pivot && seen[other as usize] != stamp);
        }
        self.met[p] = met;
        self.count_outside(pivot);
    }

    /// Counts, for each element that shares a node with that of `pivot`, its nodes that do not;
    /// elements with none add nothing to the newest one and go.
    fn count_outside(&mut self, pivot: u32) {
        let met = std::mem::take(&mut self.met[pivot as usize]);
        let mut older: Vec<u32> = Vec::new();
        for &node in &met {
            older.extend(self.elements_of[node as usize].iter().filter(|&&e| e != pivot));
        }
        older.sort_unstable();
        for shared in older.chunk_by(|a, b| a == b) {
            let element = shared[0] as usize;
            self.outside[element] = self.met[element].len() - shared.len();
            if self.outside[element] == 0 {
                self.met[element].clear();
            }
        }
        for &node in &met {
            let outside = &self.outside;
            self.elements_of[node as usize].retain(|&e| e == pivot || outside[e as usize] > 0);
        }
        self.met[pivot as usize] = met;
    }

    /// A bound on the neighbours of a node of the newest element.
    fn degree(&self, node: u32, newest: u32) -> usize {
        let elements = self.elements_of[node as usize].iter().filter(|&&e| e != newest);
        let outside: usize = elements.map(|&e| self.outside[e as usize]).sum();
        self.neighbours[node as usize].len() + self.met[newest as usize].len() - 1 + outside
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// A chain is eliminated from its ends, a star from its rays: neither fills in.
    #[test]
    fn trees_do_not_fill_in() {
        let chain: Vec<Vec<u32>> = (0..9_u32)
            .map(|i| [i.checked_sub(1), (i < 8).then_some(i + 1)].into_iter().flatten().collect())
            .collect();
        let mut star = vec![(1..9).collect::<Vec<u32>>()];
        star.extend((1..9).map(|_| vec![0]));
        for graph in [chain, star] {
            assert_eq!(fill(&graph, &minimum_degree(graph.clone())), 0);
        }
    }

    /// The order holds each node once, and fills in no more than ten random orders do.
    #[test]
    fn fills_in_less_than_chance() {
        let mut random = Random::new(7);
        for n in [1, 2, 20, 60] {
            let mut graph = vec![Vec::new(); n];
            for i in 0..n {
                for j in 0..i {
                    if random.range(0.0, 1.0) < 4.0 / n as f64 {
                        graph[i].push(j as u32);
                        graph[j].push(i as u32);
                    }
                }
            }
            let order = minimum_degree(graph.clone());
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert!(sorted.iter().copied().eq(0..n as u32));
            let least = fill(&graph, &order);
            for _ in 0..10 {
                let mut other = order.clone();
                for i in (1..n).rev() {
                    other.swap(i, random.range(0.0, (i + 1) as f64) as usize);
                }
                assert!(least <= fill(&graph, &other), "{n} nodes");
            }
        }
    }

    /// Edges that elimination in this order adds.
    fn fill(graph: &[Vec<u32>], order: &[u32]) -> usize {
        let mut left: Vec<BTreeSet<u32>> =
            graph.iter().map(|list| list.iter().copied().collect()).collect();
        let mut added = 0;
        for &node in order {
            let met: Vec<u32> = std::mem::take(&mut left[node as usize]).into_iter().collect();
            for &a in &met {
                left[a as usize].remove(&node);
                for &b in met.iter().filter(|&&b| b != a) {
                    added += usize::from(left[a as usize].insert(b));
                }
            }
        }
        added / 2
    }
}
