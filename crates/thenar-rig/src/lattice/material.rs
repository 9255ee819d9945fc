//! Materials of partly filled elements.

use super::{Lattice, tet};
use thenar_core::Vec3;
use thenar_core::model::{Law, Material};

/// Smallest filled fraction by which a material is scaled: softer elements would only make the
/// system ill-conditioned.
const FILL_FLOOR: f64 = 0.1;

impl Lattice {
    /// One material per tetrahedron, for a body whose material at each place is `at`: modulus and
    /// density are the mean over the body inside the element times its filled fraction (Nesme et
    /// al. 2009). Poisson's ratio is the mean weighted by modulus; the law is that of the places
    /// whose moduli sum to most. The total mass is exactly the integral of `at`'s density over the
    /// body.
    pub fn materials(&self, at: impl Fn(&Vec3) -> Material) -> Vec<Material> {
        self.sample_materials(|i| at(&self.sample_position(i)))
    }

    /// Materials of the tetrahedra, given the material of each inside point by its index.
    pub fn sample_materials(&self, at: impl Fn(usize) -> Material) -> Vec<Material> {
        // Every tetrahedron that was kept holds inside points.
        let mut sums: Vec<Option<Material>> = vec![None; self.tets.len()];
        let mut laws: Vec<Vec<(Law, f64)>> = vec![Vec::new(); self.tets.len()];
        for i in 0..self.sample_count() {
            let m = at(i);
            let t = self.sample_tet(i) as usize;
            match laws[t].iter_mut().find(|(law, _)| *law == m.law) {
                Some((_, young)) => *young += m.young,
                None => laws[t].push((m.law, m.young)),
            }
            let sum = &mut sums[t];
            *sum = Some(match *sum {
                None => Material { poisson: m.poisson * m.young, ..m },
                Some(s) => Material {
                    law: s.law,
                    young: s.young + m.young,
                    poisson: s.poisson + m.poisson * m.young,
                    density: s.density + m.density,
                },
            });
        }

        // A sum times the volume of one point is an integral over the element.
        let per_sample = self.filled.iter().sum::<f64>() / self.sample_count() as f64;
        let mut masses = [0.0; 2];
        let mut materials: Vec<Material> = sums
            .iter()
            .enumerate()
            .filter_map(|(t, sum)| Some((t, (*sum)?)))
            .map(|(t, sum)| {
                let volume = tet::volume(&self.corners(t));
                let fill = self.filled[t] / volume;
                let scale = per_sample / volume * fill.clamp(FILL_FLOOR, 1.0) / fill;
                let more = |a: (Law, f64), b: &(Law, f64)| if b.1 > a.1 { *b } else { a };
                let scaled = Material {
                    law: laws[t].iter().fold((sum.law, 0.0), more).0,
                    young: sum.young * scale,
                    poisson: sum.poisson / sum.young,
                    density: sum.density * scale,
                };
                masses[0] += sum.density * per_sample;
                masses[1] += scaled.density * volume;
                scaled
            })
            .collect();
        materials.iter_mut().for_each(|m| m.density *= masses[0] / masses[1]);
        materials
    }
}
