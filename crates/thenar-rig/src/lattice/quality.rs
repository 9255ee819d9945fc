//! Quality of the elements' shapes.

use super::tet::{self, Corners};

/// The worst and the mean shapes of a set of tetrahedra.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Quality {
    /// Smallest dihedral angle \[rad\].
    pub dihedral_min: f64,
    /// Largest dihedral angle \[rad\].
    pub dihedral_max: f64,
    /// Largest ratio of longest to shortest edge within one tetrahedron.
    pub edge_ratio_max: f64,
}

impl Quality {
    /// Quality of these tetrahedra.
    pub fn of(tets: impl Iterator<Item = Corners>) -> Self {
        let none = Self {
            dihedral_min: f64::INFINITY,
            dihedral_max: f64::NEG_INFINITY,
            edge_ratio_max: 1.0,
        };
        tets.fold(none, |worst, x| {
            let [low, high] = tet::dihedral_range(&x);
            Self {
                dihedral_min: worst.dihedral_min.min(low),
                dihedral_max: worst.dihedral_max.max(high),
                edge_ratio_max: worst.edge_ratio_max.max(tet::edge_ratio(&x)),
            }
        })
    }
}
