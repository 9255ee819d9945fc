//! Round parts of a rigid shape against the triangles of a deformable surface.
//!
//! The inside of each triangle and each edge touch a round part where they are nearest to it, and,
//! where the part is a line of balls or a cylinder, where they are nearest to the ends of its axis:
//! a line along a triangle is thus held at both ends of what lies over it. On a large triangle
//! points beside the place stand for it (`places`). Every such place moves continuously with the
//! bodies, and whether it is there does not depend on the others.

use crate::contact::approach::approach;
use crate::contact::blunt::{blunted, has_edges};
use crate::contact::features::capsule_axis;
use crate::contact::near::{Arrival, Near};
use crate::contact::nearest::point;
use crate::contact::places::{Hold, spread};
use crate::contact::sides::Sight;
use crate::contact::soft_feature::Touch;
use crate::contact::soft_rigid::{KEY_SEGMENT, SoftRigid};
use crate::contact::triangle::{Feature, ROUNDED_UP, closest_on_triangle, segment_parameter};
use crate::contact::{Distance, PlacedShape, Shape};
use crate::math::Vec3;

/// Alternations between line and triangle on the way to their nearest points.
const NEAREST_ROUNDS: usize = 8;
/// Places of one triangle at most: three inside, three on each edge.
pub(crate) const ROUND_PLACES: usize = 12;
/// Numbers for the places of one part.
const PLACES: u32 = ROUND_PLACES as u32;
/// Numbers of the places inside, and of those of one edge: by the ends of what lies along it, and
/// by the nearest.
const INSIDE: u32 = 3;
const ON_EDGE: u32 = 3;
/// The number of the nearest place.
const NEAREST: u32 = 2;

/// Points for which a place may stand.
const SPREAD: u32 = 3;
/// Next to a corner a point goes no farther towards it than this part of the way.
const HALFWAY: f64 = 0.5;

/// Slopes that differ by less are one.
const SLOPE_ROUND_OFF: f64 = 1e-9;

/// Output for contacts of round parts.
pub(crate) struct Touches<'a> {
    pub kept: &'a mut Vec<Touch>,
    pub most: usize,
    /// Number that found no room.
    pub dropped: &'a mut usize,
}

impl Touches<'_> {
    pub fn offer(&mut self, touch: Touch) {
        match self.kept.len() < self.most {
            true => self.kept.push(touch),
            false => *self.dropped += 1,
        }
    }
}

/// A place of a triangle: its number, what of the triangle it lies on, its weights.
type Place = (u32, Feature, [f64; 3]);

/// Lets a triangle touch part `r`; its corners are contacts of their own. If all of it is farther
/// than the margin, it touches where it arrives first in this step.
pub(crate) fn meet_round(
    pair: &SoftRigid,
    near: &Near,
    (r, part): (u32, &PlacedShape),
    sight: &mut Sight,
    touches: &mut Touches,
) {
    let edge = pair.surface.edge_of[near.index as usize];
    let hold = Hold::of(edge, &part.shape);
    if hold == Hold::Corners {
        return;
    }
    let x = near.x.map(|p| part.pose_SP.inverse_point(&p));
    let line = round_line(&part.shape);
    let spread = spread(edge, &part.shape);
    let mut is_far = true;
    for_each_place(&part.shape, line.as_ref(), &x, pair.margin, |(place, feature, nearest)| {
        let now = part.shape.distance(&point(&x, &nearest));
        if now.value > pair.margin {
            return;
        }
        is_far = false;
        let is_held = place == NEAREST && has_sharp_rim(&part.shape);
        if is_held || !pair.surface.owns(near.index, feature) {
            return;
        }
        let seen = blunted_on(pair, near, part, (&point(&x, &nearest), &nearest), now);
        let normal = part.pose_SP.vector(&seen.gradient);
        if outward(pair, near, feature).dot(&normal) >= 0.0 {
            return;
        }
        let is_sharp = has_edges(&part.shape) && is_on_rim(&now, &seen);
        if is_sharp && let Some(seen) = rounded(pair, near, part, (feature, &nearest), now) {
            offer(pair, near, (r, part), (SPREAD * place, feature, nearest), seen, touches);
            return;
        }
        if hold == Hold::Nearest || is_sharp {
            offer(pair, near, (r, part), (SPREAD * place, feature, nearest), seen, touches);
            return;
        }
        let key = [pair.soft, near.index, pair.rigid, r * PLACES + place];
        let farther = |w: &[f64; 3]| part.shape.distance(&point(&x, w)).value - now.value;
        let held = sight.hold(key, nearest, &x, edge, farther);
        for (k, weights) in around(held, &x, spread) {
            let p = point(&x, &weights);
            let seen = blunted_on(pair, near, part, (&p, &weights), part.shape.distance(&p));
            offer(pair, near, (r, part), (SPREAD * place + k, feature, weights), seen, touches);
        }
    });
    if is_far && near.travel > 0.0 {
        match &line {
            Some(line) => arrive_at_line(pair, near, r, part, line, touches),
            None => arrive(pair, near, r, part, &x, touches),
        }
    }
}

/// Numbers and weights of the points that stand for place `held`: `spread` from it towards each
/// corner of what it lies on, or the place itself.
fn around(
    held: [f64; 3],
    x: &[Vec3; 3],
    spread: Option<f64>,
) -> impl Iterator<Item = (u32, [f64; 3])> {
    let p = point(x, &held);
    (0..3).filter_map(move |k| {
        let Some(spread) = spread else { return (k == 0).then_some((0, held)) };
        let share = (spread / (x[k] - p).norm()).min(HALFWAY);
        let mut weights = held.map(|w| w * (1.0 - share));
        weights[k] += share;
        (held[k] > 0.0).then_some((k as u32, weights))
    })
}

/// The line about which a shape is round everywhere, and its radius there.
fn round_line(shape: &Shape) -> Option<([Vec3; 2], f64)> {
    match shape {
        Shape::Sphere { radius } => Some(([Vec3::zeros(); 2], *radius)),
        Shape::Capsule { radius, half_length } => Some((capsule_axis(*half_length), *radius)),
        _ => None,
    }
}

/// True when what is nearest to the inside of a triangle is a point of a sharp rim, or next to one:
/// a straight side, held at the ends of its axis, and a flat end are as near at their ends. On the
/// rim that place goes `R / t` for each radian by which a triangle turns that slopes by t: held
/// there alone it rocks for ever. The points of the rim stay where they are.
fn has_sharp_rim(shape: &Shape) -> bool {
    matches!(shape, Shape::Cylinder { .. })
}

/// True when what a point at distance `now` has `seen` of a cylinder or a cone, blunted, is a rim
/// or a tip. What presses there stays there: a tilt moves it nowhere. Sides and ends have one slope
/// against the axis, along y.
fn is_on_rim(now: &Distance, seen: &Distance) -> bool {
    (seen.gradient.y - now.gradient.y).abs() > SLOPE_ROUND_OFF
}

/// The ends of the axis of a shape that is straight along its side.
fn side_ends(shape: &Shape) -> Option<[Vec3; 2]> {
    let at = |y: f64| Vec3::y() * y;
    match shape {
        Shape::Cylinder { half_length, .. } => Some([at(-half_length), at(*half_length)]),
        _ => None,
    }
}

/// The places inside a triangle and within its edges at which it may touch a convex shape, in the
/// frame of the shape; those of edges that come nowhere `within` so far are left out.
fn for_each_place(
    shape: &Shape,
    line: Option<&([Vec3; 2], f64)>,
    x: &[Vec3; 3],
    within: f64,
    mut visit: impl FnMut(Place),
) {
    let is_inside = |w: &[f64; 3]| w.iter().all(|w| *w > 0.0);
    let along = line.map_or_else(|| side_ends(shape), |(line, _)| Some(*line));
    let ends: &[Vec3] = match (shape, &along) {
        (Shape::Sphere { .. }, Some(line)) => &line[..1],
        (_, Some(line)) => line,
        (_, None) => &[],
    };
    for (place, end) in (0..).zip(ends) {
        let weights = closest_on_triangle(end, x).weights;
        is_inside(&weights).then(|| visit((place, Feature::Face, weights)));
    }
    if line.is_none() {
        let weights = shape.nearest_on_triangle(x);
        is_inside(&weights).then(|| visit((NEAREST, Feature::Face, weights)));
    }
    for k in 0..3 {
        let j = (k + 1) % 3;
        if shape.least_along(&x[k], &x[j]) > within * ROUNDED_UP {
            continue;
        }
        let mut on_edge = |place: u32, t: f64| {
            if t > 0.0 && t < 1.0 {
                let mut weights = [0.0; 3];
                (weights[k], weights[j]) = (1.0 - t, t);
                visit((INSIDE + ON_EDGE * k as u32 + place, Feature::Edge(k), weights));
            }
        };
        for (place, end) in (0..).zip(ends) {
            on_edge(place, segment_parameter(end, &x[k], &x[j]));
        }
        // A ball has no other place than that nearest to its centre.
        if ends.len() != 1 {
            on_edge(NEAREST, shape.nearest_on_segment(&x[k], &x[j]));
        }
    }
}

fn offer(
    pair: &SoftRigid,
    near: &Near,
    (r, part): (u32, &PlacedShape),
    (place, feature, weights): Place,
    found: Distance,
    touches: &mut Touches,
) {
    let normal = part.pose_SP.vector(&found.gradient);
    if outward(pair, near, feature).dot(&normal) < 0.0 {
        let key = [KEY_SEGMENT | (SPREAD * r * PLACES + place), near.index];
        let (triangle, gap) = (near.index, found.value);
        touches.offer(Touch { key, triangle, weights, sharp: None, normal, gap });
    }
}

/// Offers the contact at which the triangle first comes within the margin of a line of balls.
fn arrive_at_line(
    pair: &SoftRigid,
    near: &Near,
    r: u32,
    part: &PlacedShape,
    (line, radius): &([Vec3; 2], f64),
    touches: &mut Touches,
) {
    let line = line.map(|p| part.pose_SP.point(&p));
    let at = |p: &Vec3| {
        let t = segment_parameter(p, &line[0], &line[1]);
        line[0] + t * (line[1] - line[0])
    };
    let mut c = at(&((near.x[0] + near.x[1] + near.x[2]) / 3.0));
    for _ in 0..NEAREST_ROUNDS {
        c = at(&near.closest(&c).point);
    }
    let closest = near.closest(&c);
    // What is near now is a corner: a contact of its own.
    if closest.distance_squared.sqrt() <= radius + pair.margin {
        return;
    }
    if let Some(Arrival { weights, normal, gap, .. }) =
        near.arrival_from(&c, *radius, pair.margin, closest, 1.0)
    {
        let key = [KEY_SEGMENT | (SPREAD * r * PLACES), near.index];
        touches.offer(Touch { key, triangle: near.index, weights, sharp: None, normal, gap });
    }
}

/// Offers the contact at which the triangle's place that is nearest now comes within the margin of
/// a curved part.
fn arrive(
    pair: &SoftRigid,
    near: &Near,
    r: u32,
    part: &PlacedShape,
    x: &[Vec3; 3],
    touches: &mut Touches,
) {
    let weights = part.shape.nearest_on_triangle(x);
    let p = point(x, &weights);
    if part.shape.distance(&p).value <= pair.margin {
        return;
    }
    let u_P = part.pose_SP.inverse_vector(&near.motion(&weights));
    if let Some(found) = approach(&part.shape, &p, &u_P, 0.0, pair.margin) {
        offer(pair, near, (r, part), (0, Feature::Face, weights), found, touches);
    }
}

/// View of an edge of the part from place `p` of a triangle, in the frame of the part.
fn blunted_on(
    pair: &SoftRigid,
    near: &Near,
    part: &PlacedShape,
    (p, weights): (&Vec3, &[f64; 3]),
    now: Distance,
) -> Distance {
    if !has_edges(&part.shape) {
        return now;
    }
    let outward = || {
        let outward_W = pair.surface.mean_normal(near.index, weights, pair.state.positions);
        part.pose_SP.inverse_vector(&pair.placed.rotation.tr_mul(&outward_W))
    };
    blunted(&part.shape, p, outward, pair.surface.edge_within(near.index, weights), now)
}

/// Distance that corners and straight edges see of a rim or a tip at distance `now` from a place of
/// smooth flesh: its normal is that of the surface there. `None` where the surface has an edge of
/// its own. All of it counts from where the blunted direction begins to turn: passed over to by
/// degrees, it made forces jump more often under rims drawn over skin.
fn rounded(
    pair: &SoftRigid,
    near: &Near,
    part: &PlacedShape,
    (feature, weights): (Feature, &[f64; 3]),
    now: Distance,
) -> Option<Distance> {
    if let Feature::Edge(k) = feature
        && pair.surface.is_crease(near.index, k)
    {
        return None;
    }
    let smooth_W = pair.surface.smooth_normal(near.index, weights, pair.state.positions);
    let gradient = -part.pose_SP.inverse_vector(&pair.placed.rotation.tr_mul(&smooth_W));
    (gradient != Vec3::zeros()).then_some(Distance { gradient, ..now })
}

/// Outward normal of the soft surface, in the shape frame.
fn outward(pair: &SoftRigid, near: &Near, feature: Feature) -> Vec3 {
    let outward_W = pair.surface.pseudonormal(near.index, feature, pair.state.positions);
    pair.placed.rotation.tr_mul(&outward_W)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::area::TOUCHING;
    use crate::contact::tests::{Scene, cube};
    use crate::contact::{Contact, Site};
    use crate::math::{Pose, Quat};
    use crate::model::Motion;

    /// Points around a place are equally far from it, and it lies between them; next to a corner
    /// they stay within.
    #[test]
    fn points_around_a_place_hold_it_between_them() {
        let x = [Vec3::zeros(), Vec3::x() * 0.01, Vec3::new(0.004, 0.0, 0.009)];
        let places = [[0.2, 0.5, 0.3], [0.3, 0.0, 0.7], [0.001, 0.998, 0.001]];
        for held in places {
            let p = point(&x, &held);
            let mut back = Vec3::zeros();
            let (mut sum, mut count) = (0.0, 0);
            for (k, weights) in around(held, &x, Some(1e-4)) {
                let (away, to_corner) = (point(&x, &weights) - p, (x[k as usize] - p).norm());
                assert!((away.norm() - 1e-4_f64.min(0.5 * to_corner)).abs() < 1e-12, "{held:?}");
                assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
                assert!(weights.iter().zip(held).all(|(w, h)| *w >= 0.0 && (h > 0.0 || *w == 0.0)));
                // Σ w_k (x_k - p) = 0, so that these weights, all positive, give the place itself.
                let weight = held[k as usize] * to_corner / away.norm();
                back += point(&x, &weights) * weight;
                (sum, count) = (sum + weight, count + 1);
            }
            assert_eq!(count, held.iter().filter(|w| **w > 0.0).count());
            assert!((back / sum - p).norm() < 1e-12, "{held:?}: {back} {p}");
        }
        let alone: Vec<_> = around(places[0], &x, None).collect();
        assert_eq!(alone, [(0, places[0])]);
    }

    const RADIUS: f64 = 0.012;
    const SLOPE: f64 = 0.1;

    /// A tin whose rim touches a face of flesh, 80 mm wide, that slopes down to this side.
    fn under_a_slope(azimuth: f64) -> Vec<Contact> {
        let mut scene = Scene::new();
        let tin = Shape::Cylinder { radius: RADIUS, half_length: 0.01 };
        let (sin, cos) = azimuth.sin_cos();
        scene.rigid(Motion::Dynamic, tin, Pose::identity());
        let (mut points, triangles) = cube(0.08, 1);
        let tilt = Quat::from_scaled_axis(SLOPE.atan() * Vec3::new(sin, 0.0, -cos));
        // The lowest place of the rim's neighbourhood is where the face has just come down to it.
        let up = Vec3::y() * (0.01 + SLOPE * RADIUS);
        points.iter_mut().for_each(|p| *p = tilt * (*p + Vec3::y() * 0.04) + up);
        scene.soft((points, triangles));
        scene.find(1e-3)
    }

    /// While the slope turns by 1° its lowest place goes 0.2 mm along the rim. What holds it stays,
    /// so that its force goes over from point to point, and no point between two is deeper than
    /// what counts as touching.
    #[test]
    fn a_rim_holds_a_slope_at_points_that_stay() {
        let places = |azimuth: f64| -> Vec<(u64, Vec3, f64)> {
            let contacts = under_a_slope(azimuth);
            // Inside of the face's two triangles; the edge between them crosses the rim besides.
            let is_inside = |c: &Contact| match &c.a {
                Site::Soft(point) => point.weights.iter().all(|w| *w > 0.0),
                Site::Rigid { .. } => false,
            };
            let near = contacts.into_iter().filter(|c| c.gap < 1e-4 && is_inside(c));
            near.map(|c| (c.key, c.position_W, c.gap)).collect()
        };
        for k in 0..40 {
            let azimuth = 0.3 + 0.01 * f64::from(k);
            let [a, b] = [places(azimuth), places(azimuth + 1_f64.to_radians())];
            for (key, place, _) in &b {
                if let Some((_, before, _)) = a.iter().find(|(other, ..)| other == key) {
                    assert!((place - before).norm() < 1e-12, "{before} {place}");
                }
            }
            let least = a.iter().map(|(.., gap)| *gap).fold(f64::INFINITY, f64::min);
            assert!((0.0..TOUCHING).contains(&(least + 1e-9)), "{least}");
            // Beside the lowest place on the rim, on both sides.
            assert!(a.len() >= 2, "{a:?}");
        }
    }
}
