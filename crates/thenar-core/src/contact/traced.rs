//! All ends of a fast body, each along its own way.
//!
//! Where two bodies meet first one of them may be stopped, and turns its other ends through within
//! the same step. So each corner, end or rim of a body that is fast is followed to where it arrives
//! at the other (conservative advancement, Mirtich, 1996); the contact is the tangent plane there.
//! Edges of boxes are followed to where they cross others': of thin boxes that meet across each
//! other no corner arrives.

use crate::contact::Shape;
use crate::contact::aabb::Aabb;
use crate::contact::edge::{self, Edge, FOLLOWED};
use crate::contact::features::corners;
use crate::contact::manifold::{Manifold, ManifoldPoint};
use crate::contact::mesh_pair::{Pair, mesh_of};
use crate::contact::rigid_body::Piece;
use crate::contact::rigid_pair::{Reach, RigidSide, reversed};
use crate::contact::support::inradius;
use crate::contact::sweep::{MEETING, MovingPiece};
use crate::math::Vec3;

/// Most advances of one end. Where they end early, the end is not followed: the body is held where
/// it meets the other.
const ADVANCES_MAX: usize = 64;
/// Constraints along lines nearer to each other than this part of the inradius, and turned by less
/// than it \[rad\], are one: two would hold the same end twice.
const SAME: f64 = 1e-4;
/// Places on one ball whose lines are nearer to each other than this part of its radius are one:
/// what the line of a capsule that nearly lies offers of its end, and the ball there, whose heights
/// differ by a thousandth of the radius. Two constraints so much alike pass load back and forth.
const ON_BALL: f64 = 0.05;
/// Features: the side that has the point, its piece and its number.
const TRACED: u32 = 6 << 16;
const OF_B: u32 = 1 << 15;
/// Set in the feature of two edges that cross, which 8 bits name.
const EDGES: u32 = 1 << 14;

/// Adds the points of A and of B that arrive at the other, of bodies that meet (so that `manifold`
/// has points) and are fast.
pub(crate) fn find(a: RigidSide, b: RigidSide, reach: Reach, manifold: &mut Manifold) {
    let Some(met) = manifold.points().iter().min_by(|p, q| p.gap.total_cmp(&q.gap)) else { return };
    let normal_W = met.normal_W;
    let [whole_a, whole_b] = [a, b].map(|side| MovingPiece { side, piece: &side.body.pieces[0] });
    let fast = whole_a.travel(&whole_b, reach.h) > reach.margin;
    let has_mesh = |of: &RigidSide| of.body.pieces.iter().any(|p| mesh_of(&p.shape).is_some());
    // Straight ways are no likeness of the ways of bodies that are led round.
    let led_round = whole_a.is_turned_fast(reach) || whole_b.is_turned_fast(reach);
    if !fast || led_round || has_mesh(&a) || has_mesh(&b) {
        return;
    }
    points_of(a, &whole_b, reach, &-normal_W, TRACED, manifold);
    reversed(manifold, |m| points_of(b, &whole_a, reach, &normal_W, TRACED | OF_B, m));
    for (i, piece_a) in a.body.pieces.iter().enumerate() {
        for (j, piece_b) in b.body.pieces.iter().enumerate() {
            let movers =
                [MovingPiece { side: a, piece: piece_a }, MovingPiece { side: b, piece: piece_b }];
            let of_pair = ((i * 4096 + j) as u32).wrapping_mul(0x9E37_79B1);
            edges(&movers, reach, of_pair, manifold);
        }
    }
}

/// The edges of box A that arrive at edges of box B; `of_pair` stands for the pieces.
fn edges([a, b]: &[MovingPiece; 2], reach: Reach, of_pair: u32, manifold: &mut Manifold) {
    let (Shape::Cuboid { half: half_a }, Shape::Cuboid { half: half_b }) =
        (&a.piece.shape, &b.piece.shape)
    else {
        return;
    };
    let pair = Pair::new(a, b, reach);
    let ahead = pair.around_a().inflate((FOLLOWED - 1.0) * pair.travel);
    if !ahead.overlaps(&Aabb::symmetric(*half_b)) {
        return;
    }
    let turn = pair.b.rotation.tr_mul(&pair.a.rotation);
    let others = edge::of_cuboid(half_b);
    for (i, own) in edge::of_cuboid(half_a).into_iter().enumerate() {
        let ends_W = own.ends.map(|p| pair.a.world_point(&p));
        let ways = ends_W.map(|p_W| pair.way(&p_W));
        let ends = ends_W.map(|p_W| pair.b.shape_point(&p_W));
        let own = Edge { ends, normals: own.normals.map(|n| turn * n) };
        for (j, other) in others.iter().enumerate() {
            let Some(met) = own.arrival(&ways, other) else { continue };
            let (gap, normal_W) = (met.gap(), pair.b.rotation * met.n);
            let same = SAME * inradius(&a.piece.shape);
            // Both bodies end there: an edge along a seam of pieces is none.
            let there_W = b.at(met.when, reach.h).world_point(&met.q);
            let off = reach.margin.max(same);
            let ends = |m: &MovingPiece, way: f64| {
                let beyond = there_W + way * off * normal_W;
                m.whole_at(met.when, reach.h).distance(&beyond).value > 0.5 * off
            };
            if !ends(a, -1.0) || !ends(b, 1.0) {
                continue;
            }
            let position_W = pair.b.world_point(&(met.p - 0.5 * gap * met.n));
            let feature = (TRACED | EDGES | (i * 12 + j) as u32) ^ of_pair;
            offer(ManifoldPoint { feature, position_W, normal_W, gap }, same, manifold);
        }
    }
}

/// The points of all pieces of A that arrive at B, which lies towards `towards_W`.
fn points_of(
    a: RigidSide,
    b: &MovingPiece,
    reach: Reach,
    towards_W: &Vec3,
    flag: u32,
    manifold: &mut Manifold,
) {
    for (i, piece) in a.body.pieces.iter().enumerate() {
        let a = MovingPiece { side: a, piece };
        let trace = Trace { a: &a, b, reach, travel: a.travel(b, reach.h) };
        let towards = a.at(0.0, reach.h).rotation.tr_mul(towards_W);
        let mut next = flag | (i as u32) << 20;
        ends(piece, &towards, |p, radius| {
            if let Some(point) = trace.contact(next, &p, radius) {
                let same = (SAME * inradius(&piece.shape)).max(ON_BALL * radius);
                offer(point, same, manifold);
            }
            next += 1;
        });
    }
}

/// Offers a point unless another holds the same line at least as near; takes the place of one that
/// holds it less near.
fn offer(point: ManifoldPoint, same: f64, manifold: &mut Manifold) {
    let on_line = |p: &ManifoldPoint| {
        let between = p.position_W - point.position_W;
        let across = between - between.dot(&point.normal_W) * point.normal_W;
        across.norm() <= same && (p.normal_W - point.normal_W).norm() <= SAME
    };
    if manifold.points().iter().any(|p| on_line(p) && p.gap <= point.gap) {
        return;
    }
    manifold.retain_from(0, |p| !on_line(p));
    manifold.offer(point);
}

/// Balls (of radius zero: points) whose hull is the piece or nearly so, in its frame: of rims the
/// points that look along unit vector `d`, against it, and across.
fn ends(piece: &Piece, d: &Vec3, mut each: impl FnMut(Vec3, f64)) {
    let rim = |radius: f64, y: f64, each: &mut dyn FnMut(Vec3, f64)| {
        let out = Vec3::new(d.x, 0.0, d.z).try_normalize(1e-9).unwrap_or_else(Vec3::x);
        for aside in [out, -out, Vec3::new(-out.z, 0.0, out.x), Vec3::new(out.z, 0.0, -out.x)] {
            each(Vec3::y() * y + radius * aside, 0.0);
        }
    };
    match &piece.shape {
        Shape::Sphere { radius } => each(Vec3::zeros(), *radius),
        Shape::Capsule { radius, half_length } => {
            [-half_length, *half_length].into_iter().for_each(|y| each(Vec3::y() * y, *radius));
        }
        Shape::Cuboid { half } => corners(half).into_iter().for_each(|p| each(p, 0.0)),
        Shape::Cylinder { radius, half_length } => {
            [-half_length, *half_length].into_iter().for_each(|y| rim(*radius, y, &mut each));
        }
        Shape::Cone { radius, height } => {
            each(Vec3::y() * (0.75 * height), 0.0);
            rim(*radius, -0.25 * height, &mut each);
        }
        Shape::Ellipsoid { half } => {
            for k in 0..3 {
                // The ball of the sharper curvature at the end of an axis, if it lies inside.
                let least = half[(k + 1) % 3].min(half[(k + 2) % 3]);
                let radius = least * least / half[k];
                if radius < half[k] {
                    for side in [-1.0, 1.0] {
                        let mut p = Vec3::zeros();
                        p[k] = side * (half[k] - radius);
                        each(p, radius);
                    }
                }
            }
        }
        Shape::HalfSpace | Shape::Mesh(_) | Shape::Compound(_) => {}
    }
}

/// A piece of A on its way to the whole of B.
struct Trace<'a> {
    a: &'a MovingPiece<'a>,
    b: &'a MovingPiece<'a>,
    reach: Reach,
    /// Upper bound of the motion of points against each other in the step \[m\].
    travel: f64,
}

impl Trace<'_> {
    /// The part of the step after which the ball about `p` arrives at B, its centre then, its gap
    /// and the outward normal of B. What is near already has been found where it is.
    fn arrival(&self, p: &Vec3, radius: f64) -> Option<(f64, Vec3, f64, Vec3)> {
        let h = self.reach.h;
        let near = MEETING * self.reach.margin;
        let mut s = 0.0;
        for _ in 0..ADVANCES_MAX {
            let center = self.a.at(s, h).world_point(p);
            let there = self.b.whole_at(s, h).distance(&center);
            let gap = there.value - radius;
            if gap <= near {
                return (s > 0.0).then_some((s, center, gap, there.gradient));
            }
            s += (gap - 0.5 * near) / self.travel;
            if s > FOLLOWED {
                return None;
            }
        }
        None
    }

    /// The contact of the ball about `p` (in the frame of the piece) with the tangent plane where
    /// it arrives. To first order in the turning of bodies that move by forces; what arrives only
    /// after the step is not held up by it unless something else makes it faster.
    fn contact(&self, feature: u32, p: &Vec3, radius: f64) -> Option<ManifoldPoint> {
        let (a, b, h) = (self.a, self.b, self.reach.h);
        let (s, center, gap, normal) = self.arrival(p, radius)?;
        let met_b = center - (radius + gap) * normal;
        let normal_W = b.turned(&normal, (1.0 - s) * h);
        let now = a.at(0.0, h).world_point(p);
        let end_a = match a.side.body.dynamic {
            true => now + h * a.side.placed.velocity_at(&now),
            false => a.at(1.0, h).world_point(p),
        };
        let end_b = b.carried(&met_b, s, 1.0, h);
        let (place, side) = match a.has_lever(b, &now) {
            true => (now - radius * normal_W, -0.5),
            false => (b.carried(&met_b, s, 0.0, h), 0.5),
        };
        let closing = h * normal_W
            .dot(&(b.side.placed.velocity_at(&place) - a.side.placed.velocity_at(&place)));
        let gap = normal_W.dot(&(end_a - end_b)) - radius + closing;
        let gap = if s > 1.0 { gap.max(closing) } else { gap };
        let position_W = place + side * gap * normal_W;
        Some(ManifoldPoint { feature, position_W, normal_W, gap })
    }
}
