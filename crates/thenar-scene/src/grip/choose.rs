//! Where pads go on an object: opposed places of its surface, near where the hand has its pads.
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
/// What a line at right angles to the pads' own counts as \[m\].
const TILT: f64 = 0.06;
/// What a line that is neither level nor upright counts as \[m\].
const SLOPE: f64 = 0.1;
/// What a second normal at right angles to the line counts as \[m\].
const SLANT: f64 = 0.06;
/// A second normal farther off the line than 45° holds nothing \[cosine\].
const SLANT_MIN: f64 = 0.7;
/// Added for a pair outside the cone of friction \[m²\]: it is taken where there is no other.
const SLIPS: f64 = 1.0;
/// What a finger reached for counts beside where it is wanted.
const MISS: f64 = 16.0;
/// How far the palm goes aside at most, so that pads get to their places \[m\]: a finger and a
/// half; farther off, a hand is not yet where it is to grip.
const SHIFT_MAX: f64 = 0.03;
/// How far down of that \[m\]: what an object lies on is below.
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
/// What the way from the middle of the object to the line counts.
const ASIDE: f64 = 0.5;
/// A pad that ends farther than this from its place is out of reach \[m\]: what fingers that close
/// do not make up.
pub const REACH: f64 = 0.012;
/// What the way counts that a bone before a pad lacks: it keeps the pad off its place.
const CROWD: f64 = 4.0 * MISS;
/// What such a bone lacks at least for the palm to go aside \[m\].
const CROWD_MIN: f64 = 0.5e-3;
/// A pad needs so much room before its place \[m\]: half of a pad's thickness.
const ROOM: f64 = 4e-3;
/// Bones before a pad come near to things wider than this \[m\], which is as thick as a finger:
/// pads close on thinner ones before them.
const THICK: f64 = 16e-3;
/// Object wider than this part of what pads span: where one ends out of reach, that is why.
const WIDE: f64 = 0.85;
/// A finger beside another has a place of its own where the surface goes on: no farther off than
/// this, as part of the distance of fingers, with a normal within 60° of the line's.
const BESIDE: f64 = 0.6;

/// Turns of the row of fingers that are tried \[degrees\]: along a thing that is too narrow across.
const TURNS_DEG: [f64; 5] = [0.0, 35.0, -35.0, 70.0, -70.0];

/// Where the pads of a grip go.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// Place of each pad, the base's first; none for one that has nothing to touch.
    pub anchors: [Option<Anchor>; PADS_MAX],
    /// Angles of each chain at its place.
    pub angles: [Angles; PADS_MAX],
    /// How far the palm is to go aside for that, in its own frame \[m\].
    pub shift_P: Vec3,
    /// What does not fit.
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
    cost: f64,
}

/// Memory to choose in.
#[derive(Clone, Debug)]
pub struct Scratch {
    samples: Vec<Sample>,
    best: Vec<Pair>,
}

impl Default for Scratch {
    fn default() -> Self {
        let samples = Vec::with_capacity(super::surface::SAMPLES_MAX);
        Self { samples, best: Vec::with_capacity(TRIED + 1) }
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
    let Scratch { samples, best } = scratch;
    sample(world, object, &pads_middle(palm, opposition), NEIGHBOURHOOD, samples);
    let centre = middle(world, object);
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
    // Two fingers beside each other do not bear alike on a slope; one turns with what it holds.
    let aslant = if opposition.kind == GripKind::Tripod { SLOPE * SLOPE } else { 0.0 };
    let mut narrowest = f64::INFINITY;
    for base in samples.iter() {
        let way = -base.normal;
        let Some(fingers) = through(world, base, &way) else { continue };
        if fingers.normal.dot(&way) < SLANT_MIN {
            continue;
        }
        let width = (fingers.point - base.point).norm();
        if [base, &fingers].iter().any(|place| is_covered(world, object, place)) {
            continue;
        }
        narrowest = narrowest.min(width);
        if width <= opening {
            let cost = rank(&base.point, &fingers, &way, opposition.at(width), palm, &centre)
                + LEVER * lever(&(centre - base.point), &down, &way).powi(2)
                + aslant * slope(&down, &way);
            let slips = fingers.normal.dot(&way) < least;
            let cost = if slips { cost + SLIPS } else { cost };
            keep(best, Pair { base: *base, fingers, cost });
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

/// What a pair costs before anything is reached for \[m²\].
fn rank(base: &Vec3, fingers: &Sample, way: &Vec3, span: &Span, palm: &Pose, centre: &Vec3) -> f64 {
    let off = (base - palm.point(&span.base)).norm_squared()
        + (fingers.point - palm.point(&span.fingers)).norm_squared();
    let tilt = 1.0 - way.dot(&palm.vector(&span.axis));
    let slant = 1.0 - way.dot(&fingers.normal);
    let aside = (centre - base).cross(way).norm_squared();
    off + TILT * TILT * tilt + SLANT * SLANT * slant + ASIDE * aside
}

/// Lever of gravity on an object held along the line `way` by two pads, one of which is `arm` from
/// its middle \[m\]; at most `LEVER_MAX`.
fn lever(arm: &Vec3, down: &Vec3, way: &Vec3) -> f64 {
    (arm - way * arm.dot(way)).cross(down).norm().min(LEVER_MAX)
}

/// True where what stands fast leaves no room for skin: below what lies on a table.
fn is_covered(world: &World, object: BodyId, place: &Sample) -> bool {
    let skin = place.point + place.normal * ROOM;
    let rigids = world.desc().rigids.iter().enumerate();
    let fast =
        rigids.filter(|(_, rigid)| rigid.motion == Motion::Prescribed && rigid.shape.is_some());
    fast.map(|(i, _)| BodyId::Rigid(i as u32))
        .any(|body| body != object && clearance(world, body, &skin) < 0.0)
}

/// How far a line is from level and from upright, 1/4 at half way: what a round thing's weight
/// lacks on one side there, it has too much on the other.
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
    let (mut least, mut choice, mut lacks_P) = reach_from(opposition, world, object, palm, pair);
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
        let (cost, mut tried, lacks) = reach_from(opposition, world, object, &beside, pair);
        let cost = cost + SHIFT * shift_P.norm_squared();
        lacks_P = lacks;
        if cost < least {
            tried.shift_P = shift_P;
            (least, choice) = (cost, tried);
        }
    }
    (least, choice)
}

/// Reaches for a pair from a place of the palm: cost \[m²\], choice, and in the palm's frame what
/// pads lack in the mean and what bones before them lack at most \[m\].
fn reach_from(
    opposition: &Opposition,
    world: &World,
    object: BodyId,
    palm: &Pose,
    pair: &Pair,
) -> (f64, Choice, [Vec3; 2]) {
    let width = (pair.fingers.point - pair.base.point).norm();
    let span = opposition.at(width);
    let places = side_by_side(opposition, world, object, pair, &palm.vector(&span.across));
    let mut choice = Choice { angles: span.angles, ..Choice::none() };
    let mut cost = pair.cost;
    let mut worst: Option<(usize, f64)> = None;
    let (mut lack_P, mut count, mut crowd_P) = (Vec3::zeros(), 0.0, Vec3::zeros());
    for pad in 0..opposition.pads() {
        let place = match pad {
            0 => Some(pair.base),
            _ => places[pad - 1],
        };
        let Some(place) = place else { continue };
        choice.anchors[pad] = Some(place.anchor);
        let Some(chain) = opposition.chain(pad) else { continue };
        let miss_P = approach(chain, &mut choice.angles[pad], palm, &place);
        let miss = miss_P.norm();
        cost += MISS * miss * miss;
        (lack_P, count) = (lack_P + miss_P, count + 1.0);
        let links = pad.checked_sub(1).and_then(|finger| opposition.links.get(finger));
        if let Some(links) = links.filter(|_| width > THICK) {
            let way_P = crowded(links, chain, &choice.angles[pad], palm, (world, object));
            cost += CROWD * way_P.norm_squared();
            crowd_P = if way_P.norm() > crowd_P.norm() { way_P } else { crowd_P };
        }
        if worst.is_none_or(|(_, most)| miss > most) {
            worst = Some((pad, miss));
        }
    }
    choice.trouble = worst.filter(|(_, miss)| *miss > REACH).map(|(pad, miss)| {
        let (pad, opening) = (pad as u8, opposition.opening());
        match width > WIDE * opening {
            true => Trouble::Wide { width, opening, pad, miss },
            false => Trouble::OutOfReach { pad, miss },
        }
    });
    (cost, choice, [lack_P / f64::max(count, 1.0), crowd_P])
}

/// Places of the fingers beside each other, as the hand has them or turned about the line, so that
/// most find one.
fn side_by_side(
    opposition: &Opposition,
    world: &World,
    object: BodyId,
    pair: &Pair,
    across_W: &Vec3,
) -> [Option<Sample>; PADS_MAX] {
    let way = -pair.base.normal;
    let across = (across_W - way * way.dot(across_W)).try_normalize(1e-9);
    let across = across.unwrap_or_else(|| way.cross(&pair.fingers.normal.yzx()));
    let count = opposition.pads() - 1;
    let mut most: (usize, [Option<Sample>; PADS_MAX]) = (0, [None; PADS_MAX]);
    for turn_deg in TURNS_DEG {
        let (sin, cos) = f64::to_radians(turn_deg).sin_cos();
        let across = across * cos + way.cross(&across) * sin;
        let mut places = [None; PADS_MAX];
        for (i, place) in places.iter_mut().enumerate().take(count) {
            *place = beside(opposition, world, object, pair, &across, i);
        }
        let found = places.iter().flatten().count();
        if found > most.0 {
            most = (found, places);
        }
        if most.0 == count {
            break;
        }
    }
    // On the narrowest things one finger presses.
    if most.0 == 0 {
        most.1[0] = Some(pair.fingers);
    }
    most.1
}

/// Place of finger `i` beside the fingers' middle; `None` where the surface does not go on.
fn beside(
    opposition: &Opposition,
    world: &World,
    object: BodyId,
    pair: &Pair,
    across: &Vec3,
    i: usize,
) -> Option<Sample> {
    let offset = opposition.offset(i);
    if offset == 0.0 {
        return Some(pair.fingers);
    }
    let wanted = pair.fingers.point + across * offset;
    let found = nearest(world, object, &wanted)?;
    let way = -pair.base.normal;
    let near = (found.point - wanted).norm() < BESIDE * opposition.spacing;
    (near && found.normal.dot(&way) > 0.5).then_some(found)
}

/// Brings a chain to a place; what it lacks at its end, in the palm's frame \[m\].
fn approach(chain: &Chain, angles: &mut Angles, palm: &Pose, place: &Sample) -> Vec3 {
    let centre = palm.inverse_point(&(place.point + place.normal * chain.pad.radius));
    let normal = -palm.inverse_vector(&place.normal);
    solve(chain, &chain.ease(), angles, &Goal { centre, normal }, ROUNDS);
    centre - chain.reach(angles).centre
}

/// What can be had of an object that does not fit: each pad goes to what is nearest.
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
