//! The core's factor: single precision, supernodes, an order that is fixed with the structure.

use crate::Engine;
use crate::flesh::Matrix;
use crate::math::Vec3;
use crate::solver::monolithic::factor::{Factor, LANES, Lanes};
use crate::solver::monolithic::symbolic::Symbolic;
use crate::solver::monolithic::{NoBodies, System};

pub struct Ours<'a> {
    matrix: &'a Matrix,
    factor: Factor,
    columns: Vec<Lanes>,
    reached: Vec<bool>,
}

impl<'a> Ours<'a> {
    pub fn new(matrix: &'a Matrix) -> Self {
        let factor = Factor::new(Symbolic::new(&matrix.blocks, 0, &matrix.positions, true));
        let reached = vec![false; factor.symbolic.supernodes.len()];
        Self { matrix, columns: vec![[0.0; LANES]; matrix.size()], reached, factor }
    }

    /// Unknowns in the order of elimination.
    pub fn order(&self) -> Vec<usize> {
        let places = &self.factor.symbolic.place_of_node;
        let mut order = vec![0; 3 * places.len()];
        for (node, place) in places.iter().enumerate() {
            (0..3).for_each(|k| order[3 * *place as usize + k] = 3 * node + k);
        }
        order
    }
}

impl Engine for Ours<'_> {
    fn name(&self) -> String {
        "Thenar, f32".into()
    }

    fn numbers(&self) -> usize {
        self.factor.symbolic.size
    }

    fn refresh(&mut self) -> bool {
        let Matrix { blocks: A, springs, .. } = self.matrix;
        self.factor.refresh(&System { A, bodies: NoBodies, springs })
    }

    fn solve(&mut self, x: &mut [Vec3]) {
        self.factor.gather(x);
        self.factor.forward();
        self.factor.backward();
        self.factor.spread(x);
    }

    fn solve_columns(&mut self, touched: Option<usize>) {
        self.columns.fill([0.0; LANES]);
        self.reached.fill(touched.is_none());
        if let Some(node) = touched {
            let place = self.factor.symbolic.place_of_node[node] as usize;
            self.reached[self.factor.symbolic.supernode_of[place] as usize] = true;
            (0..3).for_each(|k| self.columns[3 * place + k][k] = 1.0);
        } else {
            self.columns.fill([1.0; LANES]);
        }
        self.factor.forward_many(&mut self.columns, &mut self.reached);
    }
}
