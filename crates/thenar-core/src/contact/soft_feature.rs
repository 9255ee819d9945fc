//! Features of a rigid shape that come between the vertices of a deformable surface: its sharp
//! points, its straight edges (`soft_edge`), and, where it is round, its centre line.
//!
//! Every contact made here stands for a point of one surface and its true distance to the other, so
//! none holds what does not meet. A sharp point touches the triangle that is nearest to it; one
//! within a straight edge does so when it arrives, or when the edge has got in. A round part
//! touches *every* triangle near it, each at its own nearest point: contacts then move along with
//! the bodies, and a large ball does not rest on one triangle after another.

use crate::contact::aabb::Aabb;
use crate::contact::blunt::way_to;
use crate::contact::collector::{Collector, feature_key};
use crate::contact::near::{Arrival, Near};
use crate::contact::sharp_blocks::Prism;
use crate::contact::sides::Sight;
use crate::contact::soft_edge::meet_edges;
use crate::contact::soft_rigid::{KEY_POINT, SoftRigid, VertexScratch};
use crate::contact::soft_round::{ROUND_PLACES, Touches, meet_round};
use crate::contact::triangle::{ROUNDED_UP, area_vector};
use crate::contact::{Contact, Site, SurfacePoint};
use crate::math::Vec3;
use std::cell::Cell;

const NONE: u32 = u32::MAX;
/// Places nearer to each other than this part of an edge are one: round-off, even of coordinates of
/// a million edges.
const ROUND_OFF: f64 = 1e-9;

/// Work space of the search.
#[derive(Debug, Default)]
pub(crate) struct FeatureScratch {
    /// Per sharp point the nearest triangle, and the one that arrives first.
    meets: Vec<NearTriangles>,
    /// Points with an entry in `meets`, in the order they were met.
    met: Vec<u32>,
    /// Per triangle, the round in which it was last visited.
    visited: Vec<u32>,
    round: u32,
    /// Contacts of edges and round parts.
    touches: Vec<Touch>,
}

/// Triangles that come near to a sharp point.
#[derive(Clone, Copy, Debug)]
struct NearTriangles {
    /// Squared distance \[m²\] and triangle.
    nearest: (f64, u32),
    /// Part of the step and triangle.
    arriving: (f64, u32),
}

const UNMET: NearTriangles =
    NearTriangles { nearest: (f64::INFINITY, NONE), arriving: (f64::INFINITY, NONE) };

/// Nothing in it outlives a search; a clone has as much room.
impl Clone for FeatureScratch {
    fn clone(&self) -> Self {
        Self::with_size(self.meets.len(), self.visited.len())
    }
}

impl FeatureScratch {
    pub fn with_size(points: usize, triangles: usize) -> Self {
        Self {
            meets: vec![UNMET; points],
            met: Vec::with_capacity(points),
            visited: vec![0; triangles],
            round: 0,
            touches: Vec::with_capacity(touches_max(triangles)),
        }
    }
}

/// A point of the surface that touches, in the shape frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    /// Kind and number of the feature.
    pub key: [u32; 2],
    pub triangle: u32,
    pub weights: [f64; 3],
    /// The sharp point, if it is one.
    pub sharp: Option<Vec3>,
    /// From the shape to the surface.
    pub normal: Vec3,
    pub gap: f64,
}

/// Returns the largest depth at which a feature counts as having come through the triangle \[m\]:
/// the vertices lead out what is deeper.
pub(crate) fn depth_max(pair: &SoftRigid) -> f64 {
    pair.margin + pair.surface.depth_max()
}

/// Adds the contacts of sharp points and of the round part.
pub(crate) fn find(
    pair: &SoftRigid,
    sight: &mut Sight,
    vertices: &VertexScratch,
    scratch: &mut FeatureScratch,
    out: &mut Collector,
) {
    scratch.round = scratch.round.wrapping_add(1);
    scratch.touches.clear();
    let most = touches_max(scratch.visited.len());
    let mut dropped = 0;
    for &v in &vertices.near {
        for &t in pair.surface.around(v) {
            if std::mem::replace(&mut scratch.visited[t as usize], scratch.round) == scratch.round {
                continue;
            }
            let near = Near::new(pair, t);
            meet_sharp(pair, &near, scratch);
            let kept = &mut scratch.touches;
            meet_edges(pair, &near, &mut Touches { kept, most, dropped: &mut dropped });
            for (r, round) in (0..).zip(&pair.body.sharp.rounds) {
                if !near.may_touch(round, pair.margin) {
                    continue;
                }
                let mut touches =
                    Touches { kept: &mut scratch.touches, most, dropped: &mut dropped };
                meet_round(pair, &near, (r, round), sight, &mut touches);
            }
        }
    }
    settle_sharp(pair, scratch, out);
    settle_touches(pair, scratch, out);
    out.count_dropped(dropped);
}

// Sharp points.

/// Offers a triangle to every sharp point around it.
fn meet_sharp(pair: &SoftRigid, near: &Near, scratch: &mut FeatureScratch) {
    let reach = depth_max(pair);
    let normal = area_vector(&near.x).try_normalize(1e-300).unwrap_or_else(Vec3::zeros);
    // What hardly moves comes to nothing that is not near already.
    let (around, comes) = match near.travel > pair.margin {
        true => (near.swept(), (pair.margin + near.travel) * ROUNDED_UP),
        false => (Aabb::of_points(&near.x), f64::NEG_INFINITY),
    };
    let around = around.inflate(reach);
    let farthest = (reach * ROUNDED_UP).max(comes);
    let is_near = |of: &Aabb| of.distance_to_plane(&near.x[0], &normal) <= farthest * ROUNDED_UP;
    let prism = Prism::new(&near.x, &normal);
    let sharp = &pair.body.sharp;
    sharp.blocks.tree.overlapping_near(&around, is_near, |b| {
        let block = &sharp.blocks.list[b as usize];
        let least = prism.least_squared(block);
        for lane in (0..block.count).filter(|&lane| least[lane] <= farthest * farthest * ROUNDED_UP)
        {
            let (i, least) = (block.points[lane], least[lane]);
            offer_to_sharp(pair, (near, &prism, &around), i, least, comes, scratch);
        }
    });
}

/// Offers a triangle to sharp point `i`, which it is no nearer to than its square root
/// `least_squared`. Points out of the box `around` it do not touch it, and those farther than
/// `comes` do not in this step.
fn offer_to_sharp(
    pair: &SoftRigid,
    (near, prism, around): (&Near, &Prism, &Aabb),
    i: u32,
    least_squared: f64,
    comes: f64,
    scratch: &mut FeatureScratch,
) {
    let reach = depth_max(pair);
    let p = &pair.body.sharp.points[i as usize];
    let NearTriangles { mut nearest, mut arriving } = scratch.meets[i as usize];
    let is_farther = least_squared > nearest.0.min(reach * reach) * ROUNDED_UP;
    let may_come =
        comes > 0.0 && least_squared <= comes * comes && prism.may_come(p, &near.u, pair.margin);
    if is_farther && !may_come || !around.contains(p) {
        return;
    }
    let closest = near.closest(p);
    let squared = closest.distance_squared;
    if squared <= reach * reach {
        // Of equally near triangles the lowest index.
        nearest = least(nearest, (squared, near.index));
    }
    if may_come
        && squared > pair.margin * pair.margin
        && let Some(arrival) = near.arrival_from(p, 0.0, pair.margin, closest, arriving.0.min(1.0))
    {
        arriving = least(arriving, (arrival.at, near.index));
    }
    let known = scratch.meets[i as usize];
    if known.nearest.1 == NONE && known.arriving.1 == NONE {
        if nearest.1 == NONE && arriving.1 == NONE {
            return;
        }
        scratch.met.push(i);
    }
    scratch.meets[i as usize] = NearTriangles { nearest, arriving };
}

fn least(a: (f64, u32), b: (f64, u32)) -> (f64, u32) {
    if b < a { b } else { a }
}

/// Turns what each point met into a contact, in the order of the points.
fn settle_sharp(pair: &SoftRigid, scratch: &mut FeatureScratch, out: &mut Collector) {
    scratch.met.sort_unstable();
    for m in 0..scratch.met.len() {
        let i = scratch.met[m];
        let NearTriangles { nearest, arriving } =
            std::mem::replace(&mut scratch.meets[i as usize], UNMET);
        let p = pair.body.sharp.points[i as usize];
        // Within an edge, what has not got in touches as a part of the edge.
        let is_corner = (i as usize) < pair.body.sharp.corners;
        let stands = |touch: &Touch| is_corner || pair.surface.is_deep(-touch.gap);
        let touch = match sharp_at_nearest(pair, &p, i, nearest.1) {
            Some(touch) => stands(&touch).then_some(touch),
            None => sharp_that_arrives(pair, &p, i, arriving.1),
        };
        touch.iter().for_each(|touch| out.push(contact(pair, touch)));
    }
    scratch.met.clear();
}

/// The contact of a sharp point with its nearest triangle, if that is within the margin or the
/// point has come in through it. A deep point is inside by winding number: the normal of a fold
/// says the wrong side.
fn sharp_at_nearest(pair: &SoftRigid, p: &Vec3, i: u32, t: u32) -> Option<Touch> {
    if t == NONE {
        return None;
    }
    let near = Near::new(pair, t);
    let closest = near.closest(p);
    let x = pair.state.positions;
    let to_shape = |normal_W: Vec3| pair.placed.rotation.tr_mul(&normal_W);
    let outward = to_shape(pair.surface.pseudonormal(t, closest.feature, x));
    let distance = closest.distance_squared.sqrt();
    let gap = distance.copysign((p - closest.point).dot(&outward));
    let is_outside = !pair.surface.holds_behind(&pair.placed.world_point(p), -gap, x);
    let gap = if is_outside { distance } else { gap };
    if gap > pair.margin || is_free(pair, &closest.point, distance, gap) {
        return None;
    }
    let smooth = to_shape(pair.surface.smooth_normal(t, &closest.weights, x));
    let outward = if smooth == Vec3::zeros() { outward } else { smooth };
    let edge = pair.surface.edge_within(t, &closest.weights);
    let way = closest.point - p;
    // The outer side of a fold looks inward.
    let normal = if is_outside { way / distance } else { way_to(&way, gap, &outward, edge) };
    (normal != Vec3::zeros()).then_some(Touch {
        key: [KEY_POINT, i],
        triangle: t,
        weights: closest.weights,
        sharp: Some(*p),
        normal,
        gap,
    })
}

/// A point that has come in through a place of the surface has taken that place: the shape is
/// there. Near the far side of a thin or folded part a point lies inside as well, but the place is
/// free: it lies outside the shape, not only beside the point (within 45° of the way there). What
/// lies on the surface to round-off has not come in.
///
/// The place lies `distance` from the point, which is on the shape.
pub(crate) fn is_free(pair: &SoftRigid, place: &Vec3, distance: f64, gap: f64) -> bool {
    let most = distance * ROUNDED_UP;
    let outside = |depth: f64| {
        let there = pair.body.shape.distance_near(place, most, &Cell::new(u32::MAX));
        there.value > depth
    };
    gap < -ROUND_OFF * pair.surface.edge_mean && outside(-gap * std::f64::consts::FRAC_1_SQRT_2)
}

fn sharp_that_arrives(pair: &SoftRigid, p: &Vec3, i: u32, t: u32) -> Option<Touch> {
    if t == NONE {
        return None;
    }
    let Arrival { weights, normal, gap, .. } = Near::new(pair, t).arrival(p, 0.0, pair.margin)?;
    let (key, sharp) = ([KEY_POINT, i], Some(*p));
    Some(Touch { key, triangle: t, weights, sharp, normal, gap })
}

// Edges and round parts.

/// Places of one triangle at which edges cross its own, but for finely ridged shapes: two for each
/// of its edges.
const CROSSINGS: usize = 6;
/// Room besides, for compounds of many round parts and such shapes.
const SPARE: usize = 1 << 14;

/// Most contacts of edges and round parts that are kept, with a surface of this many triangles.
fn touches_max(triangles: usize) -> usize {
    (CROSSINGS + ROUND_PLACES) * triangles + SPARE
}

/// Hands over the contacts of edges and round parts, in the order of the triangles.
fn settle_touches(pair: &SoftRigid, scratch: &mut FeatureScratch, out: &mut Collector) {
    scratch.touches.sort_unstable_by_key(|touch| (touch.triangle, touch.key));
    scratch.touches.iter().for_each(|touch| out.push(contact(pair, touch)));
}

fn contact(pair: &SoftRigid, touch: &Touch) -> Contact {
    let vertices = pair.surface.triangles[touch.triangle as usize];
    let point = SurfacePoint { soft: pair.soft, vertices, weights: touch.weights };
    let on_surface_W = point.interpolate(pair.state.positions);
    let position_W = touch.sharp.map_or(on_surface_W, |p| pair.placed.world_point(&p));
    let [kind, feature] = touch.key;
    Contact {
        key: feature_key([kind, pair.soft, pair.rigid, feature]),
        a: Site::Soft(point),
        b: Site::Rigid { body: pair.rigid, offset_W: on_surface_W - pair.placed.center_of_mass },
        position_W,
        normal_W: pair.placed.rotation * touch.normal,
        gap: touch.gap,
        friction: pair.friction,
    }
}

#[cfg(test)]
mod tests {
    use crate::contact::Shape;
    use crate::contact::tests::{Scene, boxed, cube};
    use crate::math::{Pose, Quat, Vec3};
    use crate::model::Motion;

    /// A side wall turned inside out, as crushed flesh has them, sees corners in front of it as
    /// behind it. None of them is held: within the margin as far away as it is, beyond not at all.
    #[test]
    fn corners_before_a_wall_turned_inside_out_are_not_in_it() {
        let cone = Shape::Cone { radius: 0.002, height: 0.003 };
        for shape in [boxed(0.001), cone] {
            for n in [2, 4, 7] {
                for away in [0.5e-3, 1.2e-3, 2e-3, 3e-3] {
                    let mut scene = Scene::new();
                    let at = Vec3::new(0.02 + away + 0.001, 1e-3, 0.0021);
                    scene.rigid(Motion::Dynamic, shape.clone(), Pose::new(at, Quat::identity()));
                    scene.soft(cube(0.04, n));
                    let points = &mut scene.surfaces[0].0;
                    points.iter_mut().filter(|p| p.x > 0.0199).for_each(|p| p.y *= -0.5);
                    let deep: Vec<f64> =
                        scene.find(1e-3).iter().map(|c| c.gap).filter(|gap| *gap < 0.0).collect();
                    assert!(deep.is_empty(), "{shape:?}, {n} cells, {away} m: {deep:?}");
                }
            }
        }
    }
}
