//! Eq. 5: `A_f = M_f + Δt D_f + Δt² K_f` and `b_f = M_f v_0 + Δt F_f`, over all deformable bodies.

use crate::flesh::{PAIRS, RestTet, respond};
use crate::math::Vec3;
use crate::solver::BlockMatrix;

/// Elements and masses of all deformable bodies, nodes numbered through.
#[derive(Clone, Debug, Default)]
pub struct FleshModel {
    /// Nodes of each element.
    pub tets: Vec<[u32; 4]>,
    /// Rest shape and material of each element.
    pub rest: Vec<RestTet>,
    /// Stiffness-proportional damping of each element \[s\].
    pub stiffness_damping: Vec<f64>,
    /// Where each element's 4×4 blocks lie in the system matrix.
    pub entries: Vec<[[u32; 4]; 4]>,
    /// Lumped mass of each node \[kg\].
    pub mass: Vec<f64>,
    /// Mass-proportional damping of each node \[1/s\].
    pub mass_damping: Vec<f64>,
}

/// Sums over elements.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Elastic energy \[J\].
    pub energy: f64,
    /// Elements of negative volume.
    pub inverted: u32,
}

impl FleshModel {
    /// Adds the flesh to `A` and `b`; `row0` is the block row of node 0, `x` and `v` are nodal.
    pub fn assemble(
        &self,
        x: &[Vec3],
        v: &[Vec3],
        h: f64,
        row0: usize,
        A: &mut BlockMatrix,
        b: &mut [Vec3],
    ) -> Tally {
        for (n, &mass) in self.mass.iter().enumerate() {
            A.add_scalar(A.diagonal[row0 + n], mass * (1.0 + h * self.mass_damping[n]));
            b[row0 + n] += v[n] * mass;
        }
        let mut tally = Tally::default();
        for (t, tet) in self.tets.iter().enumerate() {
            let response = respond(&self.rest[t], &tet.map(|n| x[n as usize]));
            let scale = h * h + h * self.stiffness_damping[t];
            for a in 0..4 {
                b[row0 + tet[a] as usize] += response.forces[a] * h;
            }
            for (block, (a, c)) in response.stiffness.iter().zip(PAIRS) {
                let block = block * scale;
                A.add(self.entries[t][a][c], &block);
                if a != c {
                    A.add(self.entries[t][c][a], &block.transpose());
                }
            }
            tally.energy += response.energy;
            tally.inverted += u32::from(response.inverted);
        }
        tally
    }

    /// Elastic energy \[J\] and inverted elements at these positions.
    pub fn tally(&self, x: &[Vec3]) -> Tally {
        let mut tally = Tally::default();
        for (tet, rest) in self.tets.iter().zip(&self.rest) {
            let response = respond(rest, &tet.map(|n| x[n as usize]));
            tally.energy += response.energy;
            tally.inverted += u32::from(response.inverted);
        }
        tally
    }
}
