//! Choice of places for pads on an object: opposed places of its surface, near where the hand has
//! its pads.
//!
//! The best [`pairs`] of places are reached for by inverse kinematics, with the palm where it is or
//! a little aside, and the one that is reached best is taken.

use super::crowd::crowded;
use super::kind::GripKind;
use super::opposition::{Opposition, PADS_MAX};
use super::pair::{NEIGHBOURHOOD, Pair, Scratch, pairs};
use super::row::Ground;
use super::surface::{Anchor, Sample, nearest};
use super::trouble::Trouble;
use thenar_core::model::BodyId;
use thenar_core::{Pose, Vec3, World};
use thenar_track::reach::{Angles, Chain, Goal, solve};

/// Width at which pads are when a hand is about to close \[m\].
pub const READY: f64 = 0.04;
/// Rounds of inverse kinematics for each pad.
const ROUNDS: usize = 30;
/// Weight of the squared distance at which a pad ends from its place.
pub const MISS: f64 = 16.0;
/// Limit of the palm's shift that brings pads to their places \[m\]: a finger and a half; farther
/// off, a hand is not yet where it is to grip.
pub const SHIFT_MAX: f64 = 0.03;
/// Limit of the downward part of that shift \[m\]: what an object lies on is below.
const DOWN_MAX: f64 = 0.5 * REACH;
/// The palm stays where pads lack less than this, for which they make up as they close \[m\].
const SHIFT_MIN: f64 = 0.25 * REACH;
/// Weight of its way aside: less than that of pads that lack as much.
const SHIFT: f64 = 0.25 * MISS;
/// Times that the palm is put aside by what pads lack.
const SHIFTS: usize = 4;
/// A pad that ends farther than this from its place is out of reach \[m\]: what fingers that close
/// do not make up.
pub const REACH: f64 = 0.012;
/// Weight of the squared way that a bone before a pad lacks: half way from the knuckle to the pad
/// it keeps the pad off its place by twice as much.
const CROWD: f64 = 4.0 * MISS;
/// Least way that a bone before a pad lacks for the palm to go aside \[m\].
const CROWD_MIN: f64 = 0.5e-3;
/// Bones before a pad come near to things wider than this \[m\], which is as thick as a finger:
/// pads close on thinner ones before them.
const THICK: f64 = 16e-3;

/// Places for the pads of a grip.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// Place of each pad, the base's first; none for one that has nothing to touch.
    pub anchors: [Option<Anchor>; PADS_MAX],
    /// Angles of each chain at its place.
    pub angles: [Angles; PADS_MAX],
    /// Shift of the palm for that, in its own frame \[m\].
    pub shift_P: Vec3,
    /// Trouble of an object or a place that does not fit.
    pub trouble: Option<Trouble>,
}

impl Choice {
    fn none() -> Self {
        let (anchors, angles) = ([None; PADS_MAX], Default::default());
        Self { anchors, angles, shift_P: Vec3::zeros(), trouble: None }
    }
}

/// Chooses places for a hand whose palm is at `palm`, world.
pub fn choose(
    opposition: &Opposition,
    world: &World,
    (object, friction): (BodyId, f64),
    palm: &Pose,
    scratch: &mut Scratch,
) -> Choice {
    let narrowest = pairs(opposition, world, (object, friction), palm, scratch);
    let mut choice: Option<(f64, Choice)> = None;
    for pair in &scratch.best {
        // Costs only grow from here, and pairs are in order.
        if choice.as_ref().is_some_and(|(least, _)| pair.cost >= *least) {
            break;
        }
        let (cost, tried) = reach_for(opposition, world, object, palm, pair);
        if choice.as_ref().is_none_or(|(least, _)| cost < *least) {
            choice = Some((cost, tried));
        }
    }
    match choice {
        Some((_, choice)) => choice,
        None => stand_in(opposition, world, object, palm, narrowest),
    }
}

/// Places where pads meet when nothing is between them: they move with the palm, which is this
/// body.
pub fn each_other(opposition: &Opposition, palm: u32) -> Choice {
    let span = opposition.at(0.0);
    let mut choice = Choice { angles: span.angles, ..Choice::none() };
    for (pad, anchor) in choice.anchors.iter_mut().enumerate().take(opposition.pads()) {
        let (point_B, normal_B) = match pad {
            0 => (span.base, -span.axis),
            _ => (span.fingers + span.across * opposition.offset(pad - 1), span.axis),
        };
        *anchor = Some(Anchor::Rigid { body: palm, point_B, normal_B });
    }
    choice
}

/// Reaches for a pair with all pads, from where the palm is or, when pads lack something there,
/// from beside it; the cost of what is reached \[m²\].
fn reach_for(
    opposition: &Opposition,
    world: &World,
    object: BodyId,
    palm: &Pose,
    pair: &Pair,
) -> (f64, Choice) {
    let width = (pair.fingers.point - pair.base.point).norm();
    let (middle, way) = (pair.fingers, pair.way);
    let ground = Ground { opposition, world, object, middle, way };
    let places = ground.row(&palm.vector(&opposition.at(width).across));
    let reach = |palm: &Pose| reach_from(&ground, palm, pair, &places);
    let (mut least, mut choice, mut lacks_P) = reach(palm);
    let mut shift_P = Vec3::zeros();
    let gravity = world.desc().gravity;
    let down_P = palm.inverse_vector(&gravity.try_normalize(1e-9).unwrap_or_else(Vec3::zeros));
    for _ in 0..SHIFTS {
        // A palm that is one of the two sides is where it is.
        let enough = lacks_P[0].norm() < SHIFT_MIN && lacks_P[1].norm() < CROWD_MIN;
        if enough || !opposition.kind.has_thumb() {
            break;
        }
        shift_P += lacks_P[0] + lacks_P[1];
        shift_P -= down_P * (shift_P.dot(&down_P) - DOWN_MAX).max(0.0);
        shift_P *= (SHIFT_MAX / shift_P.norm().max(1e-9)).min(1.0);
        let beside = Pose::new(palm.point(&shift_P), palm.rotation);
        let (cost, mut tried, lacks) = reach(&beside);
        let cost = cost + SHIFT * shift_P.norm_squared();
        lacks_P = lacks;
        if cost < least {
            tried.shift_P = shift_P;
            (least, choice) = (cost, tried);
        }
    }
    (least, choice)
}

/// Reaches for a pair and the `places` of fingers there from a place of the palm: cost \[m²\],
/// choice, and in the palm's frame what pads lack in the mean and what bones before them lack at
/// most \[m\].
fn reach_from(
    ground: &Ground,
    palm: &Pose,
    pair: &Pair,
    places: &[Option<Sample>; PADS_MAX],
) -> (f64, Choice, [Vec3; 2]) {
    let Ground { opposition, world, object, .. } = *ground;
    let width = (pair.fingers.point - pair.base.point).norm();
    let mut choice = Choice { angles: opposition.at(width).angles, ..Choice::none() };
    let mut cost = pair.cost;
    let mut misses = [0.0; PADS_MAX];
    let (mut lack_P, mut count, mut crowd_P) = (Vec3::zeros(), 0.0, Vec3::zeros());
    for pad in 0..opposition.pads() {
        let place = match pad {
            0 => Some(pair.base),
            _ => places[pad - 1],
        };
        let Some(place) = place else {
            cost += MISS * REACH * REACH;
            continue;
        };
        choice.anchors[pad] = Some(place.anchor);
        let Some(chain) = opposition.chain(pad) else { continue };
        let miss_P = approach(chain, &mut choice.angles[pad], palm, &place);
        misses[pad] = miss_P.norm();
        let may_lack = opposition.kind == GripKind::Power && pad > 0;
        if may_lack && misses[pad] > REACH {
            cost += MISS * REACH * REACH;
            continue;
        }
        cost += MISS * misses[pad] * misses[pad];
        (lack_P, count) = (lack_P + miss_P, count + 1.0);
        let links = pad.checked_sub(1).and_then(|finger| opposition.links.get(finger));
        if let Some(links) = links.filter(|_| width > THICK) {
            let way_P = crowded(links, chain, &choice.angles[pad], palm, (world, object));
            cost += CROWD * way_P.norm_squared();
            crowd_P = if way_P.norm() > crowd_P.norm() { way_P } else { crowd_P };
        }
    }
    leave_out(opposition.kind, &misses, &mut choice.anchors);
    let farthest = (0..opposition.pads()).filter(|pad| choice.anchors[*pad].is_some());
    let worst = farthest.max_by(|a, b| misses[*a].total_cmp(&misses[*b]));
    choice.trouble = worst.filter(|pad| misses[*pad] > REACH).map(|pad| {
        let (miss, pad, opening) = (misses[pad], pad as u8, opposition.opening());
        match width > opening - 2.0 * REACH {
            true => Trouble::Wide { width, opening, pad, miss },
            false => Trouble::OutOfReach { pad, miss },
        }
    });
    (cost, choice, [lack_P / f64::max(count, 1.0), crowd_P])
}

/// Fingers of a power grip that do not get to their places take no part where two others do.
fn leave_out(kind: GripKind, misses: &[f64; PADS_MAX], anchors: &mut [Option<Anchor>; PADS_MAX]) {
    let there = |pad: usize| anchors[pad].is_some() && misses[pad] <= REACH;
    let enough = (1..PADS_MAX).filter(|pad| there(*pad)).count() >= 2;
    if kind == GripKind::Power && enough {
        for pad in (1..PADS_MAX).filter(|pad| misses[*pad] > REACH) {
            anchors[pad] = None;
        }
    }
}

/// Brings a chain to a place; what it lacks at its end, in the palm's frame \[m\].
fn approach(chain: &Chain, angles: &mut Angles, palm: &Pose, place: &Sample) -> Vec3 {
    let centre = palm.inverse_point(&(place.point + place.normal * chain.pad.radius));
    let normal = -palm.inverse_vector(&place.normal);
    solve(chain, &chain.ease(), angles, &Goal { centre, normal }, ROUNDS);
    centre - chain.reach(angles).centre
}

/// Returns a makeshift for an object that does not fit: each pad goes to the nearest place.
fn stand_in(
    opposition: &Opposition,
    world: &World,
    object: BodyId,
    palm: &Pose,
    narrowest: f64,
) -> Choice {
    let opening = opposition.opening();
    let span = opposition.at(opening);
    let mut choice = Choice { angles: span.angles, ..Choice::none() };
    let mut nearest_way = f64::INFINITY;
    for pad in 0..opposition.pads() {
        let at_P = match pad {
            0 => span.base,
            _ => span.fingers + span.across * opposition.offset(pad - 1),
        };
        let at = palm.point(&at_P);
        let Some(place) = nearest(world, object, &at) else { continue };
        let way = (place.point - at).norm();
        nearest_way = nearest_way.min(way);
        if way < NEIGHBOURHOOD {
            choice.anchors[pad] = Some(place.anchor);
            if let Some(chain) = opposition.chain(pad) {
                approach(chain, &mut choice.angles[pad], palm, &place);
            }
        }
    }
    let none = choice.anchors.iter().all(Option::is_none);
    choice.trouble = Some(match narrowest.is_finite() && !none {
        true => Trouble::TooLarge { width: narrowest, opening },
        false if none => Trouble::Far { distance: nearest_way },
        false => Trouble::NoOpposite { opening },
    });
    choice
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fingers of a power grip that miss are left out where two others get there, and no finger of
    /// a tripod.
    #[test]
    fn fingers_that_miss_are_left_out_of_a_power_grip() {
        let place = Some(Anchor::Rigid { body: 0, point_B: Vec3::zeros(), normal_B: Vec3::y() });
        let left = |kind: GripKind, misses: [f64; PADS_MAX]| {
            let mut anchors = [place; PADS_MAX];
            leave_out(kind, &misses, &mut anchors);
            anchors.map(|anchor| anchor.is_some())
        };
        let far = 2.0 * REACH;
        let two = [0.0, far, 0.0, 0.0, far];
        assert_eq!(left(GripKind::Power, two), [true, false, true, true, false]);
        assert_eq!(left(GripKind::Tripod, two), [true; PADS_MAX]);
        assert_eq!(left(GripKind::Power, [0.0, far, 0.0, far, far]), [true; PADS_MAX]);
    }
}
