//! Choice of places for pads on an object: opposed places of its surface, near where the hand has
//! its pads.
//!
//! Every sample of the surface is a place for the base's pad: a line goes in there along the inward
//! normal, and where it leaves again the fingers are to press. Such pairs are ranked by how far
//! they are from the pads of the hand at that width (see [`Opposition`]), how their line lies to
//! the pads' own, how far the second normal is off the line, how far the line passes the middle of
//! the object, and by how long a lever weight turns it about the line. The best few are reached for
//! by inverse kinematics, with the palm where it is or a little aside, and the one that is reached
//! best is taken.

use super::crowd::crowded;
use super::kind::GripKind;
use super::opposition::{Opposition, PADS_MAX, Span};
use super::row::Ground;
use super::size::{middle, pads_middle};
use super::surface::{Anchor, Sample, clearance, nearest, sample, through};
use super::trouble::Trouble;
use thenar_core::model::{BodyId, Motion};
use thenar_core::{Pose, Vec3, World};
use thenar_track::reach::{Angles, Chain, Goal, solve};

/// Surface is looked at within this of the middle of the pads \[m\]: a finger's length.
const NEIGHBOURHOOD: f64 = 0.12;
/// Width at which pads are when a hand is about to close \[m\].
pub const READY: f64 = 0.04;
/// Pairs that are reached for.
const TRIED: usize = 16;
/// Rounds of inverse kinematics for each.
const ROUNDS: usize = 30;
/// Distance that a line at right angles to the pads' own counts as \[m\].
const TILT: f64 = 0.06;
/// Distance that a second normal at right angles to the line counts as \[m\].
const SLANT: f64 = 0.06;
/// A normal farther off the line than 45° holds nothing \[cosine\].
const SLANT_MIN: f64 = 0.7;
/// Added for a pair outside the cone of friction \[m²\]: it is taken where there is no other.
const SLIPS: f64 = 1.0;
/// Weight of the squared distance at which a pad ends from its place.
const MISS: f64 = 16.0;
/// Limit of the palm's shift that brings pads to their places \[m\]: a finger and a half; farther
/// off, a hand is not yet where it is to grip.
const SHIFT_MAX: f64 = 0.03;
/// Limit of the downward part of that shift \[m\]: what an object lies on is below.
const DOWN_MAX: f64 = 0.5 * REACH;
/// The palm stays where pads lack less than this, for which they make up as they close \[m\].
const SHIFT_MIN: f64 = 0.25 * REACH;
/// Weight of its way aside: less than that of pads that lack as much.
const SHIFT: f64 = 0.25 * MISS;
/// Times that the palm is put aside by what pads lack.
const SHIFTS: usize = 4;
/// Weight of the lever by which gravity turns an object in its pads: more than that of a pad that
/// ends as far from its place, for which closing makes up, while friction of a pad holds a lever of
/// a few millimetres only. Found by trial: with that of a pad, an egg 4 mm farther off and an
/// ellipsoid in a pinch fell; with this they were held.
const LEVER: f64 = 2.5 * MISS;
/// A longer lever is as good as any \[m\]: long things are held where the hand is, and by two
/// hands.
const LEVER_MAX: f64 = 0.5 * SHIFT_MAX;
/// Weight of the squared distance from the middle of the object to the line.
const ASIDE: f64 = 0.5;
/// A pad that ends farther than this from its place is out of reach \[m\]: what fingers that close
/// do not make up.
pub const REACH: f64 = 0.012;
/// Weight of the squared way that a bone before a pad lacks: half way from the knuckle to the pad
/// it keeps the pad off its place by twice as much.
const CROWD: f64 = 4.0 * MISS;
/// Least way that a bone before a pad lacks for the palm to go aside \[m\].
const CROWD_MIN: f64 = 0.5e-3;
/// Room that a pad needs before its place \[m\]: half of a pad's thickness.
const ROOM: f64 = 4e-3;
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

/// A place for the base, one for the fingers.
#[derive(Clone, Copy, Debug)]
struct Pair {
    base: Sample,
    fingers: Sample,
    /// From the base to the fingers.
    way: Vec3,
    cost: f64,
}

/// Memory to choose in.
#[derive(Clone, Debug)]
pub struct Scratch {
    samples: Vec<Sample>,
    best: Vec<Pair>,
    /// Bodies that stand fast, with their distance from where the hand grips \[m\], the nearest
    /// first.
    near: Vec<(BodyId, f64)>,
}

impl Scratch {
    /// Memory for a world of `bodies` rigid bodies.
    pub fn for_bodies(bodies: usize) -> Self {
        let samples = Vec::with_capacity(super::surface::SAMPLES_MAX);
        let (best, near) = (Vec::with_capacity(TRIED + 1), Vec::with_capacity(bodies));
        Self { samples, best, near }
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
    let opening = opposition.opening();
    let Scratch { samples, best, near } = scratch;
    let around = pads_middle(palm, opposition);
    sample(world, object, &around, NEIGHBOURHOOD, samples);
    let centre = middle(world, object);
    fast_by_distance(world, object, &around, near);
    best.clear();
    let gravity = world.desc().gravity;
    let falls = match object {
        BodyId::Rigid(i) => world.desc().rigids[i as usize].motion == Motion::Dynamic,
        BodyId::Soft(_) => true,
    };
    let down = gravity.try_normalize(1e-9).filter(|_| falls).unwrap_or_else(Vec3::zeros);
    // Two pads hold what lies between them when the line from one to the other is within both cones
    // of friction.
    let least = 1.0 / (1.0 + friction * friction).sqrt();
    // Two fingers beside each other do not bear alike on a slope; one turns with what it holds. A
    // line half way between level and upright counts as a pad that is off by half of what the hand
    // opens to.
    let aslant = if opposition.kind == GripKind::Tripod { opening * opening } else { 0.0 };
    let mut narrowest = f64::INFINITY;
    for base in samples.iter() {
        let Some((way, fingers)) = opposite(world, base, least) else { continue };
        if fingers.normal.dot(&way) < SLANT_MIN {
            continue;
        }
        let width = (fingers.point - base.point).norm();
        if [base, &fingers].iter().any(|place| is_covered(world, near, &around, place)) {
            continue;
        }
        narrowest = narrowest.min(width);
        if width <= opening {
            let cost = rank([base, &fingers], &way, opposition.at(width), palm, &centre)
                + LEVER * lever(&(centre - base.point), &down, &way).powi(2)
                + aslant * slope(&down, &way);
            let cost = if faces([base, &fingers], &way) < least { cost + SLIPS } else { cost };
            keep(best, Pair { base: *base, fingers, way, cost });
        }
    }
    let mut choice: Option<(f64, Choice)> = None;
    for pair in best.iter() {
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

/// From a place inwards to where the body ends, and the direction of that way: straight in or,
/// where that leaves at a slant that is not in the cone of friction, whose cosine is `least`, as
/// far off one normal as off the other: sides that lean towards each other, as a cone's do, are
/// held level.
fn opposite(world: &World, base: &Sample, least: f64) -> Option<(Vec3, Sample)> {
    let straight = -base.normal;
    let there = through(world, base, &straight)?;
    if there.normal.dot(&straight) < least
        && let Some(between) = (straight + there.normal).try_normalize(1e-6)
        && let Some(there) = through(world, base, &between)
        && faces([base, &there], &between) > least
    {
        return Some((between, there));
    }
    Some((straight, there))
}

/// Cosine of the angle between a line and that of the normals at its ends which is farther off it.
fn faces([base, fingers]: [&Sample; 2], way: &Vec3) -> f64 {
    fingers.normal.dot(way).min(-base.normal.dot(way))
}

/// Returns the cost of a pair before anything is reached for \[m²\].
fn rank([base, fingers]: [&Sample; 2], way: &Vec3, span: &Span, palm: &Pose, centre: &Vec3) -> f64 {
    let off = (base.point - palm.point(&span.base)).norm_squared()
        + (fingers.point - palm.point(&span.fingers)).norm_squared();
    let tilt = 1.0 - way.dot(&palm.vector(&span.axis));
    let slant = 2.0 - way.dot(&fingers.normal) + way.dot(&base.normal);
    let aside = (centre - base.point).cross(way).norm_squared();
    off + TILT * TILT * tilt + SLANT * SLANT * slant + ASIDE * aside
}

/// Lever of gravity on an object held along the line `way` by two pads, one of which is `arm` from
/// its middle \[m\]; at most `LEVER_MAX`.
fn lever(arm: &Vec3, down: &Vec3, way: &Vec3) -> f64 {
    (arm - way * arm.dot(way)).cross(down).norm().min(LEVER_MAX)
}

/// Fills `near` with what stands fast but for the object, by its distance from a point, world.
fn fast_by_distance(world: &World, object: BodyId, from: &Vec3, near: &mut Vec<(BodyId, f64)>) {
    near.clear();
    let rigids = world.desc().rigids.iter().zip(0..);
    let fast = rigids
        .filter(|(rigid, _)| rigid.motion == Motion::Prescribed && rigid.shape.is_some())
        .map(|(_, i)| BodyId::Rigid(i))
        .filter(|body| *body != object);
    near.extend(fast.map(|body| (body, clearance(world, body, from))));
    // Stable sorts allocate.
    near.sort_unstable_by(|a, b| a.1.total_cmp(&b.1));
}

/// Bodies of a list by distance that can be within `way` of where distances are from: no distance
/// changes by more than the way that is gone.
fn within(near: &[(BodyId, f64)], way: f64) -> &[(BodyId, f64)] {
    &near[..near.partition_point(|(_, distance)| *distance < way)]
}

/// True where what stands fast leaves no room for skin: below what lies on a table. Distances are
/// from `from`.
fn is_covered(world: &World, near: &[(BodyId, f64)], from: &Vec3, place: &Sample) -> bool {
    let skin = place.point + place.normal * ROOM;
    let bodies = within(near, (skin - from).norm());
    bodies.iter().any(|(body, _)| clearance(world, *body, &skin) < 0.0)
}

/// Measures how far a line is from level and from upright, 1/4 at half way, where a round thing's
/// weight is too little on one side and too much on the other.
fn slope(down: &Vec3, way: &Vec3) -> f64 {
    let steep = way.dot(down).powi(2);
    steep * (1.0 - steep)
}

/// Keeps the pair if it is among the best.
fn keep(best: &mut Vec<Pair>, pair: Pair) {
    let place = best.partition_point(|other| other.cost <= pair.cost);
    if place < TRIED {
        best.insert(place, pair);
        best.truncate(TRIED);
    }
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
    use crate::session::Session;
    use std::path::Path;

    /// A thousand things stand fast, one each 0.1 m farther off; those within 0.25 m of where
    /// distances are from are looked at: the way to a place bounds how much nearer to it they can
    /// be.
    #[test]
    fn only_what_is_near_is_looked_at() {
        let near: Vec<_> = (0..1000).map(|i| (BodyId::Rigid(i), 0.1 * f64::from(i))).collect();
        assert_eq!(within(&near, 0.25).len(), 3);
        assert!(within(&near, -0.1).is_empty());
    }

    /// Weight turns what two fingers hold askew the most where the line to the thumb is half way
    /// between level and upright.
    #[test]
    fn a_slope_is_steepest_half_way() {
        let down = -Vec3::y();
        let at = |deg: f64| {
            slope(&down, &Vec3::new(deg.to_radians().cos(), -deg.to_radians().sin(), 0.0))
        };
        assert!(at(0.0) < 1e-12 && at(90.0) < 1e-12 && (at(45.0) - 0.25).abs() < 1e-12);
        assert!((at(30.0) - 3.0 / 16.0).abs() < 1e-12);
    }

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

    /// Sides of a cone lean towards each other by twice `atan r/h`: the line is level where both
    /// are in the cone of friction, and straight in where the surface behind is so, or where no
    /// line is.
    #[test]
    fn a_line_through_a_cone_is_level() {
        let way = |radius: f64, friction: f64| {
            let text = format!(
                "version = 1\n[[rigid]]\nname = \"cone\"\nmotion = \"fixed\"\n\
                 shape = {{ kind = \"cone\", radius = {radius}, height = 0.05 }}\n"
            );
            let session = Session::from_text(&text, Path::new("cone.toml"), &[])
                .unwrap_or_else(|error| panic!("{error}"));
            let world = session.world();
            let beside = Vec3::new(0.35 * radius, 0.02, 0.0);
            let base = nearest(world, BodyId::Rigid(0), &beside).expect("a surface");
            let least = 1.0 / (1.0 + friction * friction).sqrt();
            let (way, there) = opposite(world, &base, least).expect("a way");
            (way.y, faces([&base, &there], &way))
        };
        let (down, faces) = way(0.02, 0.8);
        assert!(down.abs() < 1e-3 && (faces - 0.4f64.atan().cos()).abs() < 1e-3, "{down} {faces}");
        // Straight in: down by as much as the side leans, and out of it at twice that.
        let lean = 0.4f64.atan();
        let (down, faces) = way(0.02, 1.5);
        assert!((down + lean.sin()).abs() < 1e-3, "{down}");
        assert!((faces - (2.0 * lean).cos()).abs() < 1e-3, "{faces}");
        let (down, _) = way(0.05, 0.8);
        assert!(down < -0.5, "{down}");
    }
}
