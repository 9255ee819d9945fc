//! Time at which two convex shapes meet in a step: conservative advancement (Mirtich, 1996).
//!
//! Along the normal between the nearest points two convex bodies cannot close faster than their
//! centres of mass do, plus what turning adds at their farthest points. So time can be advanced by
//! distance over that rate again and again without passing a contact, however bodies turn.

use crate::contact::Shape;
use crate::contact::convex_pair::apart;
use crate::contact::rigid_body::{Piece, Placed};
use crate::contact::rigid_pair::{Reach, RigidSide};
use crate::contact::support::Solid;
use crate::math::{Mat3, Quat, Vec3};

/// Most advances of one search. Where they end early, the pair glances: the contact is looked for
/// where it has got to, and has its true gap there.
const ADVANCES_MAX: usize = 64;
/// Bodies meet where they come nearer than this part of the margin; passing farther they do not. An
/// advance goes at least half as far, which ends the search; a body that only passes is held up by
/// no more than this. Tests of fast bodies hold from 0.005 to 0.5.
pub(crate) const MEETING: f64 = 0.05;

/// A piece of a body that moves.
#[derive(Clone, Copy)]
pub(crate) struct MovingPiece<'a> {
    pub side: RigidSide<'a>,
    pub piece: &'a Piece,
}

impl<'a> MovingPiece<'a> {
    /// The piece after the part `s` of a step of length `h`.
    pub fn at(&self, s: f64, h: f64) -> Solid<'a> {
        let placed = self.side.placed;
        let (turned, origin) =
            if s > 0.0 { moved(placed, s * h) } else { (placed.rotation, placed.origin) };
        Solid {
            shape: &self.piece.shape,
            rotation: turned * self.piece.rotation,
            origin: origin + turned * self.piece.position,
        }
    }

    /// The whole body after the part `s` of a step of length `h`.
    pub fn whole_at(&self, s: f64, h: f64) -> Solid<'a> {
        let (rotation, origin) = moved(self.side.placed, s * h);
        Solid { shape: &self.side.body.shape, rotation, origin }
    }

    /// True when a contact with `other` at `p_W` has the lever of this body: that of the body that
    /// is met by the other, or moves faster.
    pub fn has_lever(&self, other: &MovingPiece, p_W: &Vec3) -> bool {
        let speed = |m: &MovingPiece| m.side.placed.velocity_at(p_W).norm();
        let dynamic = |m: &MovingPiece| m.side.body.dynamic;
        !dynamic(other) || (dynamic(self) && speed(self) >= speed(other))
    }

    /// Returns an upper bound of the distance that turning carries a point of the body in a step,
    /// as far as `other` reaches.
    fn turn(&self, other: &MovingPiece, h: f64) -> f64 {
        let placed = self.side.placed;
        if !matches!(self.piece.shape, Shape::HalfSpace) {
            return placed.turn;
        }
        let to = other.side.placed.center_of_mass - placed.center_of_mass;
        let reach = to.norm() + other.side.body.radius + h * other.side.placed.velocity.norm();
        h * placed.angular_velocity.norm() * reach
    }

    /// Returns an upper bound of the motion of points of the two against each other in a step of
    /// length `h` \[m\].
    pub fn travel(&self, other: &MovingPiece, h: f64) -> f64 {
        let between = (self.side.placed.velocity - other.side.placed.velocity) * h;
        between.norm() + self.turn(other, h) + other.turn(self, h)
    }

    /// Returns the place, after the part `t` of a step, of what touches at `p_W` after the part
    /// `s`: a point of a body that is led turns with it; a body that moves by forces touches with
    /// ever other points as it turns, and carries the place along.
    pub fn carried(&self, p_W: &Vec3, s: f64, t: f64, h: f64) -> Vec3 {
        let placed = self.side.placed;
        let center = |part: f64| placed.center_of_mass + part * h * placed.velocity;
        center(t) + self.turned(&(p_W - center(s)), (t - s) * h)
    }

    /// A normal of the body after `time`; of one that moves by forces it stays.
    pub fn turned(&self, d_W: &Vec3, time: f64) -> Vec3 {
        match self.side.body.dynamic {
            true => *d_W,
            false => Quat::from_scaled_axis(self.side.placed.angular_velocity * time) * d_W,
        }
    }

    /// True when turning leads points of the body off their tangent by as much as a meeting in the
    /// step.
    pub fn leaves_tangent(&self, reach: Reach) -> bool {
        let angle = self.side.placed.angular_velocity.norm() * reach.h;
        0.5 * angle * angle * self.side.body.radius > MEETING * reach.margin
    }

    /// True for a body that is led and whose turning leads points off their tangent, as in
    /// [`MovingPiece::leaves_tangent`].
    pub fn is_turned_fast(&self, reach: Reach) -> bool {
        !self.side.body.dynamic && self.leaves_tangent(reach)
    }
}

/// Rotation and origin of a shape frame after `time`.
fn moved(placed: &Placed, time: f64) -> (Mat3, Vec3) {
    let turn = Quat::from_scaled_axis(placed.angular_velocity * time);
    let turn = turn.to_rotation_matrix().into_inner();
    let center = placed.center_of_mass + time * placed.velocity;
    (turn * placed.rotation, center + turn * (placed.origin - placed.center_of_mass))
}

/// The part of the step after which the contact of A and B is to be looked for: 0 when they move
/// little, `None` when they pass or stay away.
pub(crate) fn meeting(a: &MovingPiece, b: &MovingPiece, reach: Reach) -> Option<f64> {
    let h = reach.h;
    if a.travel(b, h) <= reach.margin {
        return Some(0.0);
    }
    let between = (a.side.placed.velocity - b.side.placed.velocity) * h;
    let turn = a.turn(b, h) + b.turn(a, h);
    let near = MEETING * reach.margin;
    let mut s = 0.0;
    for _ in 0..ADVANCES_MAX {
        let apart = apart(&a.at(s, h), &b.at(s, h));
        if apart.gap <= near {
            return Some(s);
        }
        let rate = turn - apart.normal.dot(&between);
        if rate * (1.0 - s) < apart.gap - near {
            return None;
        }
        s += (apart.gap - 0.5 * near) / rate;
        if s > 1.0 {
            return None;
        }
    }
    // So slow an approach is a glancing one that has nearly met.
    Some(s)
}
