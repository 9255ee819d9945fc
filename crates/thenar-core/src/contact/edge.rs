//! Straight edges of two bodies: where they cross, and where they come to cross within a step.

use crate::contact::features;
use crate::contact::mesh_normals::STANDING;
use crate::math::Vec3;

/// Ways are followed for this many steps: an edge as far from the centre of mass as the one that is
/// stopped is whipped to at most twice its speed (`2 v` less what the centre of mass loses).
pub(super) const FOLLOWED: f64 = 2.0;

/// Largest lean (sine, 45°) of a normal out of the cone of either edge where edges meet on their
/// ways: a body that is stopped at one edge turns the others level within the step, as a tilted
/// plate that falls on another does. Edges that leave each other have normals that point the other
/// way.
const TURNING: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// A sharp edge: its ends, and the outward normals of the faces beside it (twice the same at a
/// border).
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub ends: [Vec3; 2],
    pub normals: [Vec3; 2],
}

/// Crossing of edges A and B: the part of the step after which they cross, the points of both that
/// are nearest to each other then, as they are now, and the normal from B to A then.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossed {
    pub when: f64,
    pub p: Vec3,
    pub q: Vec3,
    pub n: Vec3,
}

impl Crossed {
    /// Distance along the normal, negative where the edges have passed each other \[m\].
    pub fn gap(&self) -> f64 {
        (self.p - self.q).dot(&self.n)
    }
}

/// Axes of the twelve edges of a cuboid.
const AXES: [usize; 12] = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2];

/// The edges of a cuboid of these half edges, in its frame.
pub(super) fn of_cuboid(half: &Vec3) -> [Edge; 12] {
    let ends = features::edges(half);
    std::array::from_fn(|i| {
        let (ends, axis) = (ends[i], AXES[i]);
        let out = |k: usize| Vec3::ith(k, 1.0_f64.copysign(ends[0][k]));
        Edge { ends, normals: [out((axis + 1) % 3), out((axis + 2) % 3)] }
    })
}

impl Edge {
    fn along(&self) -> Vec3 {
        self.ends[1] - self.ends[0]
    }

    /// The nearest points of both lines if they lie within the edges, and the normal if it is
    /// outward of both, of bodies that turn by `turn` \[rad\] against each other in the step.
    pub fn cross(&self, b: &Self, turn: f64) -> Option<Crossed> {
        let (s, t, n) = self.place(b, (STANDING + FOLLOWED * turn).min(TURNING))?;
        let at = |edge: &Self, t: f64| edge.ends[0] + t * edge.along();
        Some(Crossed { when: 0.0, p: at(self, s), q: at(b, t), n })
    }

    /// The parts of both edges at which their lines are nearest, and the normal from B, which may
    /// lean out of the cone of normals of either by `lean` (sine).
    fn place(&self, b: &Self, lean: f64) -> Option<(f64, f64, Vec3)> {
        let (da, db) = (self.along(), b.along());
        let normal = da.cross(&db);
        let square = normal.norm_squared();
        if square <= 1e-6 * da.norm_squared() * db.norm_squared() {
            return None;
        }
        let between = b.ends[0] - self.ends[0];
        let s = between.cross(&db).dot(&normal) / square;
        let t = between.cross(&da).dot(&normal) / square;
        let inside = |x: f64| x > 1e-9 && x < 1.0 - 1e-9;
        if !inside(s) || !inside(t) {
            return None;
        }
        let n = normal / square.sqrt();
        let out = b.normals[0] + b.normals[1] - self.normals[0] - self.normals[1];
        let n = n * 1.0_f64.copysign(n.dot(&out));
        (b.looks(&n, lean) && self.looks(&-n, lean)).then_some((s, t, n))
    }

    /// True when a normal lies between those of the faces beside the edge, or no farther out than
    /// `lean` (sine). Where it leans by [`STANDING`] the other edge is nearest to the face, by a
    /// thousandth less than to this edge: of two plates laid across each other all four crossings
    /// count before they are level, not the lowest alone.
    fn looks(&self, n: &Vec3, lean: f64) -> bool {
        let [n1, n2] = self.normals;
        if n1 == n2 {
            return true;
        }
        // From the edge into each face.
        let into = |own: &Vec3, other: &Vec3| {
            let t = self.along().cross(own).normalize();
            t * -1.0_f64.copysign(t.dot(other))
        };
        n.dot(&into(&n1, &n2)) < lean && n.dot(&into(&n2, &n1)) < lean
    }

    /// The points of both edges that meet first within [`FOLLOWED`] steps, where they are now, if
    /// the ends of this edge go straight on by `ways` in a step, seen from B: when the lines lie in
    /// one plane,
    ///
    /// ```text
    ///   ((d_a + s (w_1 - w_0)) × d_b) · (b_0 - a_0 - s w_0) = 0
    /// ```
    pub fn arrival(&self, ways: &[Vec3; 2], b: &Self) -> Option<Crossed> {
        let (da, db, bends) = (self.along(), b.along(), ways[1] - ways[0]);
        let between = b.ends[0] - self.ends[0];
        let (still, turned) = (da.cross(&db), bends.cross(&db));
        let c = [
            still.dot(&between),
            turned.dot(&between) - still.dot(&ways[0]),
            -turned.dot(&ways[0]),
        ];
        roots(c).into_iter().flatten().find_map(|when| {
            if !(when > 0.0 && when <= FOLLOWED) {
                return None;
            }
            let there = [0, 1].map(|k| self.ends[k] + when * ways[k]);
            let (s, t, n) = Self { ends: there, ..*self }.place(b, TURNING)?;
            let way = ways[0] + s * bends;
            let met = Crossed { when, p: self.ends[0] + s * da, q: b.ends[0] + t * db, n };
            (way.dot(&n) < 0.0 && met.gap() > 0.0).then_some(met)
        })
    }
}

/// The real roots of `c_0 + c_1 s + c_2 s²`, the smaller first.
fn roots(c: [f64; 3]) -> [Option<f64>; 2] {
    let square = c[1] * c[1] - 4.0 * c[0] * c[2];
    if square < 0.0 || square.is_nan() {
        return [None; 2];
    }
    // The form that does not cancel; where c_2 is none the other root is far away.
    let q = -0.5 * (c[1] + square.sqrt().copysign(c[1]));
    let found = [c[0] / q, q / c[2]];
    let found =
        if found[0] <= found[1] || found[1].is_nan() { found } else { [found[1], found[0]] };
    found.map(|s| s.is_finite().then_some(s))
}

#[cfg(test)]
mod tests;
