//! Forces that the digits of a hand feel from an object.

use super::kind::GripKind;
use crate::build::BuiltHand;
use thenar_core::model::{BodyId, Digit};
use thenar_core::readout::part_touched;
use thenar_core::world::ContactPoint;
use thenar_core::{Vec3, World};

/// Things that the digits of a grip touch.
#[derive(Clone, Copy, Debug)]
pub enum Against {
    /// A body.
    Object(BodyId),
    /// The digits on the other side of a grip of this kind: fingers beside each other that touch do
    /// not press.
    OtherSide(GripKind),
}

/// Sum of the normal forces between each digit (palm, thumb, index, middle, ring, little) and what
/// it grips, on skin and on bones where flesh is crushed, in the last step \[N\].
pub fn felt(world: &World, hand: &BuiltHand, against: Against) -> [f64; 6] {
    let mut felt = [0.0; 6];
    touches(world, hand, against, |part, contact, _| {
        felt[part] += contact.force_W.dot(&contact.normal_W);
    });
    felt
}

/// Contact and friction on the digits of one side.
#[derive(Clone, Copy, Debug, Default)]
pub struct Side {
    /// Sum of the normal forces \[N\].
    load: f64,
    /// Along the side, on its digits \[N\].
    pull_W: Vec3,
    /// All that contact does to its digits \[N\].
    force_W: Vec3,
    /// About the side's axis, which points into its digits \[N m\].
    twist: f64,
    /// The most that friction can give of either \[N, N m\].
    most: [f64; 2],
    /// Centre of pressure, world \[m\], and mean direction into the digits.
    patch: Option<(Vec3, Vec3)>,
}

impl Side {
    /// Direction along the side that comes nearest to one: friction acts along sides. Where a side
    /// faces that direction none is nearest, and the direction itself is returned.
    fn along(&self, way: &Vec3) -> Vec3 {
        let axis = self.patch.map_or(Vec3::zeros(), |(_, axis)| axis);
        (way - axis * axis.dot(way)).try_normalize(1e-6).unwrap_or(*way)
    }
}

/// Sums up contact and friction on the digits `own` of a side. Forces within a side that cancel
/// count for nothing.
pub fn side(world: &World, hand: &BuiltHand, against: Against, own: [bool; 6]) -> Side {
    let (mut centre, mut normal_W, mut load) = (Vec3::zeros(), Vec3::zeros(), 0.0);
    touches(world, hand, against, |part, contact, sign| {
        if own[part] {
            let normal = contact.force_W.dot(&contact.normal_W);
            centre += contact.position_W * normal;
            normal_W += contact.normal_W * (sign * normal);
            load += normal;
        }
    });
    let axis = normal_W.try_normalize(1e-9).filter(|_| load > 0.0);
    let Some(axis) = axis else { return Side::default() };
    centre /= load;
    let mut side = Side { load, patch: Some((centre, axis)), ..Side::default() };
    touches(world, hand, against, |part, contact, sign| {
        if own[part] {
            let normal = contact.force_W.dot(&contact.normal_W);
            let along_W = (contact.force_W - contact.normal_W * normal) * sign;
            let arm = contact.position_W - centre;
            side.pull_W += along_W;
            side.force_W += contact.force_W * sign;
            side.twist += arm.cross(&along_W).dot(&axis);
            side.most[0] += contact.friction * normal;
            side.most[1] += contact.friction * normal * axis.cross(&arm).norm();
        }
    });
    side.pull_W -= axis * axis.dot(&side.pull_W);
    side
}

/// Use of friction by two sides that hold an object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Use {
    /// Part of what is there for the load that the load uses up, on the side with less in hand: 1
    /// where it slips, 0 where nothing is touched.
    pub load: f64,
    /// Part of what friction gives towards where the object falls that pads lack whose line from
    /// one to the other is at a slant to where they press, or which lean towards each other and
    /// push out what they press: 0 where they press straight. It grows with the force, and a larger
    /// force does not make it less.
    pub slant: f64,
    /// Pads carry the object.
    pub carried: bool,
}

/// Slant of [`Use`] once an object hangs between two sides, `down` being where it falls: each
/// presses on it along the line between their centres, however it is turned.
pub fn foreseen(sides: &[Side; 2], down: &Vec3) -> f64 {
    let [Some((base, _)), Some((fingers, _))] = [sides[0].patch, sides[1].patch] else {
        return 0.0;
    };
    let Some(line) = (fingers - base).try_normalize(1e-6) else { return 0.0 };
    let slant = |side: &Side, way: Vec3| {
        let axis = side.patch.map_or(way, |(_, axis)| axis);
        let along = axis.dot(&way);
        let given = along.max(0.0) * side.most[0];
        let aside_W = (way - axis * along) * side.load;
        if aside_W.norm() < given { 1.0 - left(&(aside_W / given), &side.along(down)) } else { 1.0 }
    };
    slant(&sides[0], -line).max(slant(&sides[1], line))
}

/// Force on the digits of two sides along a direction \[N\]: less than nothing where they press the
/// object against what it lies on.
pub fn carried(sides: &[Side; 2], down: &Vec3) -> f64 {
    (sides[0].force_W + sides[1].force_W).dot(down)
}

/// Part of friction that is left towards a direction where `aside`, over what friction gives, is in
/// use: both add as vectors.
fn left(aside: &Vec3, towards: &Vec3) -> f64 {
    let along = aside.dot(towards);
    let over = (1.0 - aside.norm_squared()).max(0.0);
    ((along * along + over).sqrt() - along).clamp(0.0, 1.0)
}

/// Returns the use of friction by two sides where objects fall `down`: pull and twist over the most
/// of each are the two half axes of an ellipse [Howe and Cutkosky 1996].
///
/// The load is the sum of both sides' pulls, and of their twists. A twist by which sides wring what
/// lies between them is none of it: where that slips, less of it is left. Nor is what keeps in an
/// object that sides push out as they press.
pub fn friction_used(sides: &[Side; 2], down: &Vec3) -> Use {
    let part = |what: f64, most: f64| if most > 0.0 { what / most } else { 0.0 };
    let load: f64 = sides.iter().map(|side| side.load).sum();
    let pulls_W = sides[0].pull_W + sides[1].pull_W;
    let pushed_W = pulls_W - (sides[0].force_W + sides[1].force_W);
    let keeps = part(pushed_W.dot(&pulls_W), pulls_W.norm_squared()).clamp(0.0, 1.0);
    let pull_W = pulls_W * (1.0 - keeps);
    let twist = sides[0].twist - sides[1].twist;
    let twisted = part(twist.abs(), sides[0].most[1] + sides[1].most[1]);
    let (mut pulled, mut slant) = (0.0f64, 0.0f64);
    for side in sides.iter().filter(|side| side.most[0] > 0.0) {
        let own_W = pull_W * part(side.load, load);
        let aside = (side.pull_W - own_W) / side.most[0];
        if let Some(towards) = own_W.try_normalize(0.0) {
            let carried = own_W.norm() / side.most[0];
            pulled = pulled.max(carried / left(&aside, &towards).max(carried));
        }
        slant = slant.max(1.0 - left(&aside, &side.along(down)));
    }
    Use { load: pulled.hypot(twisted).min(1.0), slant, carried: false }
}

/// Contacts of a hand's digits with what they grip: the number of the digit, the contact, and the
/// sign that makes its force that on the digit.
fn touches(
    world: &World,
    hand: &BuiltHand,
    against: Against,
    mut then: impl FnMut(usize, &ContactPoint, f64),
) {
    for contact in world.contacts() {
        for side in 0..2 {
            let Some(digit) = digit_touched(world, contact, side, hand) else { continue };
            let counts = match against {
                Against::Object(object) => contact.bodies[1 - side] == object,
                Against::OtherSide(kind) => digit_touched(world, contact, 1 - side, hand)
                    .is_some_and(|other| kind.opposes(digit, other)),
            };
            if counts {
                then(usize::from(digit.part()), contact, [1.0, -1.0][side]);
            }
        }
    }
}

/// The digit of a hand that a point touches on this side.
fn digit_touched(
    world: &World,
    contact: &ContactPoint,
    side: usize,
    hand: &BuiltHand,
) -> Option<Digit> {
    let (soft, part) = part_touched(world, contact, side)?;
    Digit::PARTS.get(part as usize).copied().filter(|_| Some(soft) == hand.flesh())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(load: f64, pull: [f64; 3], twist: f64) -> Side {
        // A friction of 0.5, and pads of 4 mm.
        let most = [0.5 * load, 0.5 * load * 4e-3];
        let pull_W = Vec3::from(pull);
        // What both sides press with cancels.
        Side { load, pull_W, force_W: pull_W, twist, most, patch: None }
    }

    fn used_of(sides: [Side; 2]) -> Use {
        friction_used(&sides, &-Vec3::y())
    }

    /// Two pads with 2 N each and a friction of 0.5 carry 2 N; a weight of 1 N, half on either,
    /// uses half of that.
    #[test]
    fn a_load_uses_its_part_of_what_both_sides_give() {
        let used = used_of([side(2.0, [0.0, -0.5, 0.0], 0.0); 2]);
        assert!((used.load - 0.5).abs() < 1e-12 && used.slant == 0.0, "{used:?}");
        assert_eq!(used_of([Side::default(); 2]), Use::default());
        let slips = used_of([side(2.0, [0.0, -1.0, 0.0], 0.0); 2]);
        assert_eq!(slips.load, 1.0);
    }

    /// Pads that pull against each other by 0.4 N of 1 N are at a slant and carry nothing; of what
    /// is left to them, a weight of 1 N uses 0.5 of 0.6.
    #[test]
    fn what_pads_pull_against_each_other_is_no_load() {
        let slanted = |weight: f64| {
            let own = |aside: f64| side(2.0, [0.0, aside - 0.5 * weight, 0.0], 0.0);
            used_of([own(0.4), own(-0.4)])
        };
        let used = slanted(0.0);
        assert!(used.load == 0.0 && (used.slant - 0.4).abs() < 1e-12, "{used:?}");
        let used = slanted(1.0);
        assert!((used.load - 0.5 / 0.6).abs() < 1e-12, "{used:?}");
    }

    /// Pads aside of each other on level lines pull by 0.6 of what friction gives at right angles
    /// to the weight: 0.8 of it is left, since both add as vectors.
    #[test]
    fn what_pads_pull_across_the_load_leaves_more_of_friction() {
        let sides = [0.6, -0.6].map(|across| side(2.0, [across, -0.4, 0.0], 0.0));
        let used = used_of(sides);
        assert!((used.load - 0.4 / 0.8).abs() < 1e-12, "{used:?}");
        assert!((used.slant - 0.2).abs() < 1e-12, "{used:?}");
        // Between two sides 20 mm apart and 6 mm aside of each other, 0.3 of 0.5 goes across.
        let flat = [-1.0, 1.0].map(|sign| {
            let patch = Some((Vec3::new(0.01 * sign, 0.0, 3e-3 * sign), Vec3::x() * sign));
            Side { patch, ..side(2.0, [0.0; 3], 0.0) }
        });
        let seen = foreseen(&flat, &-Vec3::y());
        assert!((seen - 0.2).abs() < 1e-9, "{seen}");
    }

    /// Level forces of 2 N on sides that lean by an angle whose tangent is 0.2: `0.2 / 0.5` of the
    /// friction keeps the object from being pushed out, all of it is slant while nothing hangs
    /// there, and `1 / (1 - 0.4)` as much force is needed then.
    #[test]
    fn what_keeps_in_an_object_that_is_pushed_out_is_no_load() {
        let (sin, cos) = 0.2f64.atan().sin_cos();
        let sides = |weight: f64| {
            [1.0, -1.0].map(|sign| {
                let force_W = Vec3::new(2.0 * sign, -0.5 * weight, 0.0);
                let normal_W = Vec3::new(cos * sign, sin, 0.0);
                let load = force_W.dot(&normal_W);
                let pull_W = force_W - normal_W * load;
                let patch = Some((Vec3::x() * (0.01 * sign), normal_W));
                Side { load, pull_W, force_W, most: [0.5 * load, 1.0], patch, ..Side::default() }
            })
        };
        let used = used_of(sides(0.0));
        assert!(used.load < 1e-12 && (used.slant - 0.4).abs() < 1e-12, "{used:?}");
        // Half of 2 N on either side is what friction gives at most; 0.3 N use 0.15 of 0.6, but for
        // what lean changes.
        let used = used_of(sides(0.3));
        assert!((used.load - 0.25).abs() < 0.02, "{used:?}");
    }

    /// Pads 20 mm apart on sides that lean by an angle whose tangent is 0.2 will use 0.2 of 0.5 for
    /// that; on sides that face each other straight, none.
    #[test]
    fn what_pads_will_need_is_foreseen() {
        let (sin, cos) = 0.2f64.atan().sin_cos();
        let seen = |cos: f64, sin: f64| {
            let sides = [-1.0, 1.0].map(|sign| {
                let patch = Some((Vec3::x() * (0.01 * sign), Vec3::new(cos * sign, sin, 0.0)));
                Side { patch, ..side(2.0, [0.0; 3], 0.0) }
            });
            foreseen(&sides, &-Vec3::y())
        };
        assert!((seen(cos, sin) - 0.4).abs() < 1e-9, "{}", seen(cos, sin));
        assert_eq!(seen(1.0, 0.0), 0.0);
        assert_eq!(foreseen(&[Side::default(); 2], &-Vec3::y()), 0.0);
    }

    /// Axes of both sides point into the digits, opposite to each other: equal twists about them
    /// cancel on the object and are no load, opposite ones turn it.
    #[test]
    fn sides_that_wring_an_object_do_not_load_it() {
        let twisted = |one: f64, other: f64| {
            used_of([side(2.0, [0.0; 3], one), side(2.0, [0.0; 3], other)]).load
        };
        assert_eq!(twisted(2e-3, 2e-3), 0.0);
        assert!((twisted(2e-3, -2e-3) - 0.5).abs() < 1e-12);
    }
}
