//! Why an object slipped out.

use super::hand::GripHand;
use super::memory::GripMemory;
use super::opposition::Opposition;
use super::order::Order;
use super::size::{friction, mass};
use super::trouble::Trouble;
use serde::{Deserialize, Serialize};
use thenar_core::{Vec3, World};

/// Cause of a loss. Lengths in m, forces in N, angles in rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Loss {
    /// Pads pressed less hard than its weight needs.
    Slippery {
        /// Force that keeps it from slipping under its weight.
        needed: f64,
        /// Friction between it and the hand.
        friction: f64,
    },
    /// Sides of the object lean, where pads went, farther off the line between them than friction
    /// holds.
    Leans {
        /// Angle between that line and the normal that is farther off it.
        angle: f64,
        /// Friction between it and the hand.
        friction: f64,
    },
    /// A pad did not get to its place.
    OutOfReach {
        /// Number of the pad: the base 0, the fingers from 1.
        pad: u8,
        /// Distance at which it ended from there.
        miss: f64,
    },
}

impl Loss {
    /// Sentence part that names the cause. `digit` names a pad.
    pub(super) fn clause(&self, digit: impl Fn(u8) -> String) -> String {
        match self {
            Self::Slippery { needed, friction } => {
                format!("its weight needs more than {needed:.2} N at a friction of {friction:.2}")
            }
            Self::Leans { angle, friction } => format!(
                "its sides there lean by {:.0}° off the line between them, and a friction of {friction:.2} holds {:.0}°",
                angle.to_degrees(),
                friction.atan().to_degrees()
            ),
            Self::OutOfReach { pad, miss } => {
                format!("the {} ended {:.0} mm short of its place", digit(*pad), miss * 1e3)
            }
        }
    }
}

impl GripHand {
    /// Why the object of an order is lost, where pads, places and its weight say so. `flesh` is the
    /// hand's.
    pub(super) fn cause(
        &self,
        opposition: &Opposition,
        world: &World,
        flesh: u32,
        order: &Order,
    ) -> Option<Loss> {
        let memory = &self.memory;
        if let Some(Trouble::OutOfReach { pad, miss }) = memory.trouble {
            return Some(Loss::OutOfReach { pad, miss });
        }
        let object = order.object().filter(|_| opposition.kind.has_thumb())?;
        let friction = friction(world.desc(), flesh, object);
        let angle = lean(opposition, world, memory).unwrap_or(0.0);
        if angle > friction.atan() {
            return Some(Loss::Leans { angle, friction });
        }
        let weight = mass(world.desc(), object) * world.desc().gravity.norm();
        let weak = 2.0 * friction * memory.reflex.wanted < weight && friction > 0.0;
        weak.then(|| Loss::Slippery { needed: weight / (2.0 * friction), friction })
    }
}

/// Angle between the line from the base's place to the middle of the fingers' and the normal at its
/// ends that is farther off it \[rad\]; `None` without places.
fn lean(opposition: &Opposition, world: &World, memory: &GripMemory) -> Option<f64> {
    let place = |pad: usize| memory.pads[pad].anchor.map(|anchor| anchor.now(world));
    let (base, out) = place(0)?;
    let fingers = (1..opposition.pads()).filter_map(place);
    let zero = (Vec3::zeros(), Vec3::zeros(), 0.0);
    let (points, normals, count) = fingers
        .fold(zero, |(points, normals, n), (at, normal)| (points + at, normals + normal, n + 1.0));
    let line = (points / f64::max(count, 1.0) - base).try_normalize(1e-6)?;
    let normal = normals.try_normalize(1e-6)?;
    Some(line.angle(&normal).max(line.angle(&-out)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 100 g at a friction of 0.5 need 0.1 · 9.81 / (2 · 0.5) = 0.98 N; `atan 0.5` is 27°.
    #[test]
    fn a_cause_names_its_figures() {
        let said = |loss: Loss| loss.clause(|pad| ["thumb", "index"][usize::from(pad)].into());
        let weak = Loss::Slippery { needed: 0.981, friction: 0.5 };
        assert_eq!(said(weak), "its weight needs more than 0.98 N at a friction of 0.50");
        let leans = Loss::Leans { angle: 0.7, friction: 0.5 };
        assert_eq!(
            said(leans),
            "its sides there lean by 40° off the line between them, and a friction of 0.50 holds 27°"
        );
        let short = Loss::OutOfReach { pad: 1, miss: 0.0174 };
        assert_eq!(said(short), "the index ended 17 mm short of its place");
    }
}
