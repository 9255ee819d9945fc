//! Test of whether a point that a convex shape offers against a mesh lies along a mesh normal.

use crate::contact::mesh_pair::Pair;
use crate::contact::{Distance, Shape};
use crate::math::Vec3;

/// Points nearer to each other than this part of the shape are one: a tenth of what places of
/// contacts are good for (10 µm, of shapes of a centimetre), so that none is let go that says more.
pub(super) const SAME: f64 = 1e-4;

/// A flat face of a shape that stands on a mesh may lean by this much from the mesh's normals
/// \[rad\], while it settles: a distance off the mesh is a thousandth shorter then.
pub(super) const STANDING: f64 = 0.045;

impl Pair<'_> {
    /// True when mesh B, which holds the surface point `q_W`, is nearest there to what lies off it
    /// by `gap` \[m\] (or at least a little) along `n_W`: when `n_W` leans by no more than `lean`
    /// \[rad\] from one of the mesh's normals there, to round-off.
    pub fn is_normal(&self, q_W: &Vec3, gap: f64, n_W: &Vec3, lean: f64) -> bool {
        self.seen_off(q_W, gap, n_W).is_within(lean)
    }

    /// Mesh B, seen from a little off its surface point `q_W`.
    pub fn seen_off(&self, q_W: &Vec3, gap: f64, n_W: &Vec3) -> SeenOff {
        let off = gap.max(self.same);
        let Distance { value, gradient } = self.b.distance(&(q_W + off * n_W));
        let sizes = self.movers[0].side.body.radius + self.movers[1].side.body.radius;
        let round_off = 8.0 * f64::EPSILON * (q_W.norm() + sizes);
        SeenOff { off, nearer: (value - off).abs(), gradient_W: gradient, round_off }
    }

    /// Mesh B, seen from its surface point `q_W` along the way to A, which is `n_W` or, where the
    /// distance would differ by no more than what is not known of it anyway (`unknown` \[m\]),
    /// upright on B. On what is round the place is known.
    pub fn seen_upright(&self, q_W: &Vec3, gap: f64, n_W: Vec3, unknown: f64) -> (Vec3, SeenOff) {
        let seen = self.seen_off(q_W, gap, &n_W);
        let upright_W = seen.gradient_W;
        let shorter = 0.5 * (n_W - upright_W).norm_squared() * gap.abs();
        let is_known = || !matches!(self.straight(&n_W), StraightDirections::All);
        if seen.is_within(SAME) || shorter > unknown || is_known() {
            return (n_W, seen);
        }
        (upright_W, self.seen_off(q_W, gap, &upright_W))
    }

    /// [`Pair::is_normal`] of a point of a triangle. A shape that is round touches the triangle
    /// beside the nearest one at its border, a little aside and so a little aslant. Where the two
    /// are level such a point holds nothing: it leans by as many radians as it lies radii aside,
    /// [`SAME`] at most. Along a line on which it is straight, and on what is flat, a shape may
    /// stand.
    pub fn is_normal_beside(&self, seen: &SeenOff, n_W: &Vec3) -> bool {
        if seen.is_within(SAME) {
            return true;
        }
        match self.straight(n_W) {
            StraightDirections::Nowhere => false,
            StraightDirections::All => seen.is_within(STANDING),
            StraightDirections::Along(line_W) => {
                let leans = seen.gradient_W - n_W.dot(&seen.gradient_W) * n_W;
                let across = leans - leans.dot(&line_W) * line_W;
                across.norm() <= SAME && seen.is_within(STANDING)
            }
        }
    }

    /// Returns the directions in which A is straight beside the point from which `n_W` leads
    /// inwards.
    fn straight(&self, n_W: &Vec3) -> StraightDirections {
        let axis_W = self.a.rotation.column(1).into_owned();
        let along = -n_W.dot(&axis_W);
        // How much the normals of its straight lines, and of its flat ends, look along the axis.
        let (side, ends): (f64, &[f64]) = match self.a.shape {
            Shape::Sphere { .. } | Shape::Ellipsoid { .. } => return StraightDirections::Nowhere,
            Shape::Capsule { .. } => (0.0, &[]),
            Shape::Cylinder { .. } => (0.0, &[-1.0, 1.0]),
            Shape::Cone { radius, height } => (radius / radius.hypot(*height), &[-1.0]),
            Shape::Cuboid { .. } | Shape::HalfSpace | Shape::Mesh(_) | Shape::Compound(_) => {
                return StraightDirections::All;
            }
        };
        if (along - side).abs() <= STANDING {
            return StraightDirections::Along((axis_W + along * n_W).normalize());
        }
        let is_end = |end: &f64| (along - end).abs() <= 0.5 * STANDING * STANDING;
        if ends.iter().any(is_end) { StraightDirections::All } else { StraightDirections::Nowhere }
    }
}

/// Mesh B from a point off its surface: how far that is by what it should be, how much nearer or
/// farther it is, and which way leads off B.
pub(super) struct SeenOff {
    off: f64,
    nearer: f64,
    gradient_W: Vec3,
    round_off: f64,
}

impl SeenOff {
    /// The way from the surface leans by no more than this from one of its normals \[rad\].
    pub fn is_within(&self, lean: f64) -> bool {
        self.nearer <= 0.5 * lean * lean * self.off + self.round_off
    }
}

/// Directions in which a surface is straight.
enum StraightDirections {
    Nowhere,
    Along(Vec3),
    All,
}
