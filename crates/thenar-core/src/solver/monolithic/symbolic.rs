//! The fixed structure of the flesh factor: which columns are eliminated together (supernodes),
//! where their panels lie, and where everything is added to.
//!
//! A supernode with p nodes and m rows below owns a panel of 3p columns, each of 3(p + m) numbers
//! padded to whole registers, column by column; the first 3p rows are the (lower triangular) pivot
//! block.

use crate::math::Vec3;
use crate::solver::BlockMatrix;
use crate::solver::monolithic::dense;
use crate::solver::monolithic::factor::LANES;
use crate::solver::monolithic::minimum_degree::minimum_degree;
use crate::solver::monolithic::ordering::nested_dissection;
use std::ops::Range;

/// Explicit zeros that a merged supernode may hold, in parts of it. A factorisation of the default
/// hand takes the same time to a few parts in a hundred from half to twice of this and the next.
const ZEROS_MAX: f64 = 0.2;
/// Explicit zeros of a small one, which costs more to find than to compute.
const ZEROS_OF_SMALL_MAX: f64 = 0.6;
/// Nodes of a small one: no more than a register has room for, in columns.
const SMALL: usize = LANES / 3;

/// Nodes eliminated together.
#[derive(Clone, Copy, Debug)]
pub struct Supernode {
    /// First node, in elimination order.
    pub first: usize,
    /// Number of nodes.
    nodes: usize,
    /// Offset of its rows below the pivots in `Symbolic::rows`.
    pub rows: usize,
    /// Number of nodes below.
    pub below: usize,
    /// Offset of its panel.
    panel: usize,
    /// The supernode of its first row below.
    pub parent: Option<u32>,
    /// Segments of the supernode in `Symbolic::segments`.
    pub segments: [usize; 2],
    /// Loads of the pivots' columns: a range of `Symbolic::loads`.
    pub loads: [usize; 2],
}

impl Supernode {
    /// Columns of its panel.
    pub fn width(&self) -> usize {
        3 * self.nodes
    }

    /// Rows of its panel.
    pub fn height(&self) -> usize {
        3 * (self.nodes + self.below)
    }

    /// From column to column of its panel.
    pub fn stride(&self) -> usize {
        dense::stride(self.height())
    }

    /// Pivots of the supernode among all unknowns, in elimination order.
    pub fn pivots(&self) -> Range<usize> {
        3 * self.first..3 * self.first + self.width()
    }

    /// Returns the range of its panel.
    pub fn panel(&self) -> Range<usize> {
        self.panel..self.panel + self.width() * self.stride()
    }

    /// From column to column of its outer product, whose columns begin at the register's boundary
    /// before the first row below.
    pub fn update_stride(&self) -> usize {
        self.stride() - dense::line(self.width())
    }

    /// Returns the offset of the first row below in a column of the outer product.
    pub fn update_offset(&self) -> usize {
        self.width() - dense::line(self.width())
    }
}

/// The rows of one supernode that are columns of another, later one.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// The later supernode.
    pub target: u32,
    /// One past the last of these rows, in nodes counted from the first below the pivots.
    pub end: usize,
    /// Range of `Symbolic::runs` by which these rows and those below find their place in the
    /// target's panel.
    pub runs: [usize; 2],
}

/// Rows that follow each other both in one supernode and in a later one.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// First row, counted from the first below the pivots.
    pub row: usize,
    /// First row in the later supernode's panel.
    pub place: usize,
    /// Number of rows.
    pub length: usize,
}

impl Run {
    /// Rows of the run, counted from the first below the pivots.
    pub fn rows(&self) -> Range<usize> {
        self.row..self.row + self.length
    }
}

/// Place of one block of the matrix in a panel.
#[derive(Clone, Copy, Debug)]
pub struct Load {
    /// Entry in the matrix.
    pub entry: u32,
    /// Upper left number in the supernode's panel.
    pub place: u32,
}

/// The structure of the factor.
#[derive(Clone, Debug)]
pub struct Symbolic {
    /// Place of each node in the elimination order.
    pub place_of_node: Vec<u32>,
    /// Place of each node in an order in which neighbours are near each other in space.
    pub in_space: Vec<u32>,
    /// Supernodes in elimination order.
    pub supernodes: Vec<Supernode>,
    /// Rows below the pivots, as places in the elimination order.
    pub rows: Vec<u32>,
    /// See [`Segment`].
    pub segments: Vec<Segment>,
    /// See [`Segment`].
    pub runs: Vec<Run>,
    /// The matrix's blocks.
    pub loads: Vec<Load>,
    /// Offset of each node's diagonal in the panels, and stride from column to column there.
    pub diagonals: Vec<(u32, u32)>,
    /// Supernode of each place.
    pub supernode_of: Vec<u32>,
    /// Numbers in all panels.
    pub size: usize,
}

impl Symbolic {
    /// Analyses the flesh part of `a`, whose rows begin at `row0`. Only where bones carry flesh is
    /// another order than that of dissection looked for: in single precision the factor of a
    /// slender bar that nothing binds (elastica, steps of 10 s) preconditions well in the order of
    /// dissection only.
    pub fn new(a: &BlockMatrix, row0: usize, positions: &[Vec3], bound: bool) -> Self {
        let dissected = nested_dissection(a, row0, positions);
        let in_space = places(&dissected);
        let order = best_order(a, row0, dissected, bound);
        let n = order.len();
        let place_of_node = places(&order);
        let columns = column_structures(a, row0, &order, &place_of_node);
        let (starts, rows_of) = supernodes(&columns, bound);

        let mut symbolic = Self {
            place_of_node,
            in_space,
            supernodes: Vec::with_capacity(starts.len()),
            rows: Vec::new(),
            segments: Vec::new(),
            runs: Vec::new(),
            loads: Vec::new(),
            diagonals: vec![(0, 0); n],
            supernode_of: vec![0; n],
            size: 0,
        };
        for (s, (start, rows)) in starts.iter().zip(&rows_of).enumerate() {
            let end = starts.get(s + 1).map_or(n, |next| *next);
            let node = Supernode {
                first: *start,
                nodes: end - start,
                rows: symbolic.rows.len(),
                below: rows.len(),
                panel: symbolic.size,
                parent: None,
                segments: [0; 2],
                loads: [0; 2],
            };
            symbolic.supernode_of[*start..end].fill(s as u32);
            symbolic.rows.extend(rows);
            symbolic.size += node.panel().len();
            symbolic.supernodes.push(node);
        }
        symbolic.find_segments();
        symbolic.find_loads(a, row0, &order);
        symbolic
    }

    /// Multiplications and additions of one factorisation.
    pub fn flops(&self) -> f64 {
        let columns = |node: &Supernode| {
            let (width, below) = (node.width(), 3 * node.below);
            (0..width).map(|k| ((width - k + below) as f64).powi(2)).sum::<f64>()
        };
        self.supernodes.iter().map(columns).sum()
    }

    /// The row of a supernode's panel, in nodes, that holds this place.
    fn row_in(&self, s: usize, place: u32) -> usize {
        let node = &self.supernodes[s];
        let place = place as usize;
        if place < node.first + node.nodes {
            return place - node.first;
        }
        let rows = &self.rows[node.rows..node.rows + node.below];
        let at = rows.partition_point(|&r| (r as usize) < place);
        debug_assert_eq!(rows.get(at), Some(&(place as u32)), "a place that the panel lacks");
        node.nodes + at
    }

    fn find_segments(&mut self) {
        for s in 0..self.supernodes.len() {
            let node = self.supernodes[s];
            let first = self.segments.len();
            let mut begin = 0;
            while begin < node.below {
                let target = self.supernode_of[self.rows[node.rows + begin] as usize];
                let belongs =
                    |k: usize| self.supernode_of[self.rows[node.rows + k] as usize] == target;
                let end = (begin..node.below).find(|&k| !belongs(k)).unwrap_or(node.below);
                let first = self.runs.len();
                for k in begin..node.below {
                    let place = 3 * self.row_in(target as usize, self.rows[node.rows + k]);
                    match self.runs[first..].last_mut() {
                        Some(run) if run.place + run.length == place => run.length += 3,
                        _ => self.runs.push(Run { row: 3 * k, place, length: 3 }),
                    }
                }
                let runs = [first, self.runs.len()];
                self.segments.push(Segment { target, end, runs });
                begin = end;
            }
            self.supernodes[s].segments = [first, self.segments.len()];
            self.supernodes[s].parent = self.segments.get(first).map(|segment| segment.target);
        }
    }

    fn find_loads(&mut self, a: &BlockMatrix, row0: usize, order: &[u32]) {
        for (place, &node) in order.iter().enumerate() {
            let s = self.supernode_of[place] as usize;
            let (stride, first, panel) = {
                let node = &mut self.supernodes[s];
                if place == node.first {
                    node.loads[0] = self.loads.len();
                }
                (node.stride(), node.first, node.panel)
            };
            let column = 3 * (place - first) * stride;
            for k in a.row(row0 + node as usize) {
                // Row `node` of A holds the transposes of the blocks below the diagonal in column
                // `node`; those blocks themselves are read, wherever they are stored.
                let Some(other) = (a.columns[k] as usize).checked_sub(row0) else { continue };
                let below = self.place_of_node[other];
                if (below as usize) < place {
                    continue;
                }
                let at = column + 3 * self.row_in(s, below);
                if other == node as usize {
                    self.diagonals[other] = ((panel + at) as u32, stride as u32);
                }
                self.loads.push(Load {
                    entry: a.entry((row0 + other) as u32, (row0 + node as usize) as u32),
                    place: at as u32,
                });
            }
            self.supernodes[s].loads[1] = self.loads.len();
        }
    }
}

/// The order that needs the fewest operations: by dissection, which is better for large lattices,
/// or by minimum degree, for slender and graded ones. The subtrees of each follow each other, the
/// largest next to their parent.
fn best_order(a: &BlockMatrix, row0: usize, dissected: Vec<u32>, bound: bool) -> Vec<u32> {
    if !bound {
        return dissected;
    }
    let flesh = |node: usize| {
        let others = a.columns[a.row(row0 + node)].iter();
        others.filter_map(move |&j| (j as usize).checked_sub(row0)).filter(move |&j| j != node)
    };
    let neighbours = (0..dissected.len()).map(|n| flesh(n).map(|j| j as u32).collect()).collect();
    let orders = [dissected, minimum_degree(neighbours)];
    let counted = orders.map(|order| {
        let columns = column_structures(a, row0, &order, &places(&order));
        let operations: usize = columns.iter().map(|c| (c.len() + 1) * (c.len() + 1)).sum();
        (operations, order, columns)
    });
    let [dissected, least_degree] = counted;
    let (_, order, columns) = if least_degree.0 < dissected.0 { least_degree } else { dissected };
    postorder(&columns).into_iter().map(|place| order[place as usize]).collect()
}

/// Places in the elimination order such that each follows its children, the child with the longest
/// column last.
fn postorder(columns: &[Vec<u32>]) -> Vec<u32> {
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); columns.len()];
    let mut roots = Vec::new();
    for (place, column) in columns.iter().enumerate() {
        match column.first() {
            Some(&parent) => children[parent as usize].push(place as u32),
            None => roots.push(place as u32),
        }
    }
    // Parents first, and of their children the last first; then the other way round.
    let mut order = Vec::with_capacity(columns.len());
    let mut waiting = roots;
    while let Some(place) = waiting.pop() {
        order.push(place);
        let own = &mut children[place as usize];
        own.sort_unstable_by_key(|&child| (columns[child as usize].len(), child));
        waiting.append(own);
    }
    order.reverse();
    order
}

/// Returns the place of each node in an order.
fn places(order: &[u32]) -> Vec<u32> {
    let mut place_of_node = vec![0; order.len()];
    for (k, &node) in order.iter().enumerate() {
        place_of_node[node as usize] = k as u32;
    }
    place_of_node
}

/// Places below the diagonal of each column of the factor.
fn column_structures(
    a: &BlockMatrix,
    row0: usize,
    order: &[u32],
    place_of_node: &[u32],
) -> Vec<Vec<u32>> {
    let n = order.len();
    let mut columns: Vec<Vec<u32>> = Vec::with_capacity(n);
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); n];
    for (place, &node) in order.iter().enumerate() {
        let row = a.row(row0 + node as usize);
        let own = a.columns[row].iter().filter(|&&j| j as usize >= row0);
        let own = own.map(|&j| place_of_node[j as usize - row0]);
        let inherited = children[place].iter().flat_map(|&c| columns[c as usize].iter().copied());
        let mut column: Vec<u32> = own.chain(inherited).filter(|&p| p as usize > place).collect();
        column.sort_unstable();
        column.dedup();
        if let Some(&parent) = column.first() {
            children[parent as usize].push(place as u32);
        }
        columns.push(column);
    }
    columns
}

/// First place of each supernode, and its rows below.
fn supernodes(columns: &[Vec<u32>], bound: bool) -> (Vec<usize>, Vec<Vec<u32>>) {
    // (first, true fill of the columns in it, rows below)
    let mut stack: Vec<(usize, usize, Vec<u32>)> = Vec::new();
    for (place, column) in columns.iter().enumerate() {
        stack.push((place, column.len() + 1, column.clone()));
        // Merge with the one before while that is a child and few zeros appear.
        while stack.len() > 1 {
            let (first, fill, rows) = &stack[stack.len() - 2];
            let (here, own_fill, own_rows) = &stack[stack.len() - 1];
            let is_child = rows.first().is_some_and(|&r| (*here..=place).contains(&(r as usize)));
            let pivots = place + 1 - first;
            let size = pivots * (pivots + 1) / 2 + pivots * own_rows.len();
            let true_fill = fill + own_fill;
            let zeros = size.saturating_sub(true_fill) as f64;
            // A fifth of the whole is a quarter of the true fill.
            let small = bound && pivots <= SMALL;
            let most = if small { ZEROS_OF_SMALL_MAX } else { ZEROS_MAX };
            if !is_child || zeros > most * size as f64 {
                break;
            }
            let merged = (*first, true_fill, own_rows.clone());
            stack.truncate(stack.len() - 2);
            stack.push(merged);
        }
    }
    stack.into_iter().map(|(first, _, rows)| (first, rows)).unzip()
}
