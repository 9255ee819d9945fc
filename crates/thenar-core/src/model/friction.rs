//! Friction that depends on how hard two bodies press each other.

use crate::model::BodyId;

/// A Coulomb coefficient that depends on load, for one pair of bodies; it replaces any other
/// coefficient of the pair.
///
/// The load is that of the whole patch: the sum of the normal forces between the two bodies in the
/// step before, or, where a body has [`BodyParts`], between one of its parts (a finger) and the
/// other body. Published coefficients of skin are measured so, per fingertip; shared out over the
/// points of a patch they would depend on how finely it is meshed.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionTable {
    /// The pair, in any order.
    pub bodies: [BodyId; 2],
    /// Load \[N\] and coefficient, by rising load: straight lines between, constant outside.
    pub points: Vec<[f64; 2]>,
}

impl FrictionTable {
    /// The coefficient at this load \[N\]; 0 of an empty table.
    pub fn at(&self, load: f64) -> f64 {
        let after = self.points.partition_point(|p| p[0] <= load);
        match (after.checked_sub(1).map(|i| self.points[i]), self.points.get(after)) {
            (Some([x0, mu0]), Some([x1, mu1])) => mu0 + (mu1 - mu0) * (load - x0) / (x1 - x0),
            (Some([_, mu]), None) | (None, Some(&[_, mu])) => mu,
            (None, None) => 0.0,
        }
    }
}

/// The parts of a deformable body that count as one patch each, such as the fingers of a hand. Part
/// 0 is also what nothing is said of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyParts {
    /// Index into `WorldDesc::softs`.
    pub soft: u32,
    /// Part of each collision vertex.
    pub vertices: Vec<u8>,
    /// Rigid bodies inside, each with its part; the last of a part is at its tip.
    pub bones: Vec<(u32, u8)>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_linear_between_and_constant_outside() {
        let points = vec![[1.0, 0.9], [5.0, 0.7], [20.0, 0.4]];
        let table = FrictionTable { bodies: [BodyId::Rigid(0); 2], points };
        let wanted = [(0.0, 0.9), (1.0, 0.9), (3.0, 0.8), (5.0, 0.7), (10.0, 0.6), (99.0, 0.4)];
        for (load, mu) in wanted {
            assert!((table.at(load) - mu).abs() < 1e-12, "{load} N: {}", table.at(load));
        }
    }
}
