//! The flesh matrix of a hand at rest, `M + h D + h² K` and the springs to the bones, as a step has
//! it in `B + G`.

use crate::math::Vec3;
use crate::solver::BlockMatrix;
use thenar_core::Mat3;
use thenar_core::model::HandModel;

/// Time step \[s\].
const STEP: f64 = 1e-3;

/// The matrix in blocks of three by three.
pub struct Matrix {
    /// Without springs \[kg\].
    pub blocks: BlockMatrix,
    /// Of each node \[kg\].
    pub springs: Vec<f64>,
    /// Places of the nodes \[m\].
    pub positions: Vec<Vec3>,
    pub tets: usize,
}

impl Matrix {
    pub fn of(hand: &HandModel) -> Self {
        let flesh = &hand.flesh;
        let n = flesh.nodes.len();
        let pairs = flesh
            .tets
            .iter()
            .flat_map(|t| (0..4).flat_map(move |a| (0..a).map(move |c| (t[a], t[c]))));
        let mut A = BlockMatrix::with_pattern(n, pairs);
        for (tet, material) in flesh.tets.iter().zip(&flesh.materials) {
            let [p0, p1, p2, p3] = tet.map(|n| flesh.nodes[n as usize]);
            let edges = Mat3::from_columns(&[p1 - p0, p2 - p0, p3 - p0]);
            let volume = edges.determinant() / 6.0;
            // Gradients of the four shape functions; a tetrahedron of the hand is not flat.
            let Some(inverse) = edges.try_inverse() else { continue };
            let g: [Vec3; 3] = std::array::from_fn(|k| inverse.row(k).transpose());
            let g = [-(g[0] + g[1] + g[2]), g[0], g[1], g[2]];
            let (young, poisson) = (material.young, material.poisson);
            let mu = young / (2.0 * (1.0 + poisson));
            let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
            let scale = volume * STEP * (STEP + flesh.stiffness_damping);
            for a in 0..4 {
                for c in 0..4 {
                    let block = (g[a] * g[c].transpose()) * lambda
                        + (g[c] * g[a].transpose()) * mu
                        + Mat3::identity() * (mu * g[a].dot(&g[c]));
                    A.add(A.entry(tet[a], tet[c]), &(block * scale));
                }
                let mass = 0.25 * material.density * volume * (1.0 + STEP * flesh.mass_damping);
                A.add_scalar(A.diagonal[tet[a] as usize], mass);
            }
        }
        let stiffness = hand.usual_coupling_stiffness(thenar_core::model::CouplingKind::Uniform);
        let springs = hand.node_volumes.iter().map(|v| STEP * STEP * stiffness * v).collect();
        Self { blocks: A, springs, positions: flesh.nodes.clone(), tets: flesh.tets.len() }
    }

    /// Number of unknowns.
    pub fn size(&self) -> usize {
        3 * self.positions.len()
    }

    /// The whole product, springs included.
    pub fn times(&self, x: &[Vec3]) -> Vec<Vec3> {
        (0..x.len()).map(|i| self.blocks.row_times(i, x) + x[i] * self.springs[i]).collect()
    }

    /// Upper triangle by columns, with the rows in each ascending: column starts, rows, values.
    pub fn upper(&self) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
        let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for j in 0..self.size() {
            let (node, c) = (j / 3, j % 3);
            for k in self.blocks.row(node) {
                // Block (node, other) is the transpose of (other, node).
                let other = self.blocks.columns[k] as usize;
                for r in (0..3).filter(|r| 3 * other + r <= j) {
                    let spring = if 3 * other + r == j { self.springs[node] } else { 0.0 };
                    rows.push(3 * other + r);
                    values.push(self.blocks.blocks[k][3 * r + c] + spring);
                }
            }
            starts.push(rows.len());
        }
        (starts, rows, values)
    }
}
