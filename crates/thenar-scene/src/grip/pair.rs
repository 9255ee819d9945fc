//! Pairs of opposed places of an object's surface, ranked before anything is reached for.
//!
//! Every sample of the surface is a place for the base's pad: a line goes in there along the inward
//! normal, and where it leaves again the fingers are to press. Such pairs are ranked by how far
//! they are from the pads of the hand at that width (see [`Opposition`]), how their line lies to
//! the pads' own, how far the second normal is off the line, how far the line passes the middle of
//! the object, and by how long a lever weight turns it about the line.

use super::choose::{MISS, SHIFT_MAX};
use super::kind::GripKind;
use super::opposition::{Opposition, Span};
use super::size::{middle, pads_middle};
use super::surface::{SAMPLES_MAX, Sample, clearance, sample, through};
use thenar_core::model::{BodyId, Motion};
use thenar_core::{Pose, Vec3, World};

/// Surface is looked at within this of the middle of the pads \[m\]: a finger's length.
pub const NEIGHBOURHOOD: f64 = 0.12;
/// Pairs that are reached for.
const TRIED: usize = 16;
/// Distance that a line at right angles to the pads' own counts as \[m\].
const TILT: f64 = 0.06;
/// Distance that a second normal at right angles to the line counts as \[m\].
const SLANT: f64 = 0.06;
/// A normal farther off the line than 45° holds nothing \[cosine\].
const SLANT_MIN: f64 = 0.7;
/// Added for a pair outside the cone of friction \[m²\]: it is taken where there is no other.
const SLIPS: f64 = 1.0;
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
/// Room that a pad needs before its place \[m\]: half of a pad's thickness.
const ROOM: f64 = 4e-3;

/// A place for the base, one for the fingers.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Place of the base's pad.
    pub base: Sample,
    /// Place in the middle of the fingers' pads.
    pub fingers: Sample,
    /// From the base to the fingers.
    pub way: Vec3,
    /// Cost before anything is reached for \[m²\].
    pub cost: f64,
}

/// Memory to choose in.
#[derive(Clone, Debug)]
pub struct Scratch {
    samples: Vec<Sample>,
    /// The best pairs, by rising cost.
    pub best: Vec<Pair>,
    /// Bodies that stand fast, with their distance from where the hand grips \[m\], the nearest
    /// first.
    near: Vec<(BodyId, f64)>,
}

impl Scratch {
    /// Memory for a world of `bodies` rigid bodies.
    pub fn for_bodies(bodies: usize) -> Self {
        let samples = Vec::with_capacity(SAMPLES_MAX);
        let (best, near) = (Vec::with_capacity(TRIED + 1), Vec::with_capacity(bodies));
        Self { samples, best, near }
    }
}

/// Fills the memory with the best pairs of places on an object that fit between pads of a hand
/// whose palm is at `palm`, world. Returns the least width of any pair \[m\], infinite where there
/// is none.
pub fn pairs(
    opposition: &Opposition,
    world: &World,
    (object, friction): (BodyId, f64),
    palm: &Pose,
    scratch: &mut Scratch,
) -> f64 {
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
    narrowest
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grip::surface::nearest;
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
