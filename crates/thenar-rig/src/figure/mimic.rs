//! Joints that follow another, as linkages and gears make them.

use thenar_core::model::{HandModel, JointKind};

/// Coefficients of a mimic's law, from the constant one on.
pub const MIMIC_TERMS: usize = 5;

/// An axis of a joint that follows an axis of another: `angle = Σ law[i] · angle of the leaderⁱ`,
/// both from the rest pose.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Mimic {
    /// Index of the joint that follows.
    pub joint: u32,
    /// Axis of it: 0, or of a universal joint 0 or 1.
    pub axis: u8,
    /// Index of the joint that leads.
    pub leader: u32,
    /// Axis of that.
    pub leader_axis: u8,
    /// Coefficients of the powers of the leader's angle \[rad\], the constant first.
    pub law: [f64; MIMIC_TERMS],
}

impl Mimic {
    /// Angle that the law asks for \[rad\] and its change with the leader's, at this angle of the
    /// leader \[rad\].
    pub fn at(&self, leader: f64) -> (f64, f64) {
        polynomial(&self.law, leader)
    }

    /// Leader and follower as pairs of joint and axis.
    pub fn ends(&self) -> [(u32, u8); 2] {
        [(self.leader, self.leader_axis), (self.joint, self.axis)]
    }

    /// True when both axes are there.
    pub(crate) fn fits(&self, figure: &HandModel) -> bool {
        self.ends().into_iter().all(|(joint, axis)| {
            let kind = figure.joints.get(joint as usize).map(|joint| joint.kind);
            kind.is_some_and(|kind| has_axis(kind, axis))
        })
    }
}

/// True when a joint of this kind has this axis; a ball has none.
pub(super) fn has_axis(kind: JointKind, axis: u8) -> bool {
    kind != JointKind::Ball && usize::from(axis) < kind.angles()
}

/// Value of a polynomial and its derivative, by Horner's rule.
pub(super) fn polynomial(law: &[f64; MIMIC_TERMS], x: f64) -> (f64, f64) {
    let step = |(value, slope): (f64, f64), c: &f64| (value * x + c, slope * x + value);
    law.iter().rev().fold((0.0, 0.0), step)
}

/// The first mimic that follows itself, through others or not, or whose axis follows another
/// already.
pub(crate) fn tangled(mimics: &[Mimic]) -> Option<Mimic> {
    let above = |end: (u32, u8)| mimics.iter().find(|mimic| mimic.ends()[1] == end);
    let second = |i: usize| mimics[..i].iter().any(|first| first.ends()[1] == mimics[i].ends()[1]);
    let circles = |mimic: &&Mimic| {
        let mut at = mimic.ends()[0];
        for _ in 0..=mimics.len() {
            match above(at) {
                Some(next) => at = next.ends()[0],
                None => return false,
            }
        }
        true
    };
    (0..mimics.len()).find(|&i| circles(&&mimics[i]) || second(i)).map(|i| mimics[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1 + 2x - 3x³ + x⁴ and its derivative 2 - 9x² + 4x³, by hand.
    #[test]
    fn a_law_is_its_polynomial() {
        let law = [1.0, 2.0, 0.0, -3.0, 1.0];
        for x in [-1.5, 0.0, 0.5, 2.0] {
            let (value, slope) = polynomial(&law, x);
            assert!((value - (1.0 + 2.0 * x - 3.0 * x.powi(3) + x.powi(4))).abs() < 1e-12, "{x}");
            assert!((slope - (2.0 - 9.0 * x * x + 4.0 * x.powi(3))).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn circles_and_second_leaders_are_found() {
        let follows = |joint: u32, leader: u32| Mimic {
            joint,
            axis: 0,
            leader,
            leader_axis: 0,
            law: [0.0, 1.0, 0.0, 0.0, 0.0],
        };
        assert_eq!(tangled(&[follows(2, 1), follows(3, 2), follows(4, 1)]), None);
        assert!(tangled(&[follows(1, 1)]).is_some());
        assert!(tangled(&[follows(4, 1), follows(1, 2), follows(2, 3), follows(3, 1)]).is_some());
        assert!(tangled(&[follows(2, 1), Mimic { axis: 0, ..follows(2, 3) }]).is_some());
        // Said twice it would count twice.
        assert!(tangled(&[follows(2, 1), follows(2, 1)]).is_some());
        // The other axis of a universal joint is free to follow.
        assert_eq!(tangled(&[follows(2, 1), Mimic { axis: 1, ..follows(2, 3) }]), None);
    }
}
