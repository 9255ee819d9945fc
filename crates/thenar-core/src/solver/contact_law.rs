//! The contact law, for the solvers of a step and for touch between two frames.
//!
//! A contact sees the velocity d of its two sides against each other (in touch: their distance) in
//! its own frame, the normal first, less what is wanted there. An impulse λ changes it by `W λ`,
//! where W is the contact's own response: `d = b + W λ`. The law asks for
//!
//! ```text
//!   0 ≤ λ_n  ⊥  d_n ≥ 0           push only, and only where surfaces meet
//!   |λ_t| ≤ μ λ_n                 Coulomb's disc
//!   d_t = -s λ_t,  s ≥ 0          stick (s = 0), or slide against friction,
//!   s (μ λ_n - |λ_t|) = 0         which is then on the rim of the disc
//! ```
//!
//! The linearised cone of the paper puts a square in place of the disc: see [`project`]. Solvers
//! visit contacts one after another, each with all others as they are, and there are two ways to
//! visit:
//!
//! - [`project`] makes one cheap update from the present impulse. Only its fixed point obeys the
//!   law. The two-step scheme, the dense reference and touch use it.
//! - [`Response::impulse`] finds the impulse that obeys the law at once. The monolithic solver uses
//!   it.
//!
//! No target is above zero, so that zero velocity obeys all rows and contacts cannot contradict
//! each other: what overlaps is kept from going deeper, and moved apart by a second solve in which
//! rows stand for what they wish of a pseudo-velocity (`solver::push_out`).
//! [`ContactRow::projected`] and [`ContactRow::resolved`] visit a row in either way. [`is_on_rim`]
//! tells whether a contact slides.

use crate::math::{Mat3, Vec3};
use crate::model::Cone;
use crate::solver::ContactRow;
use sliding::Sliding;

/// A direction that yields less than this part of the others does not move at all: both sides are
/// held there, and no impulse can do anything.
const IMMOVABLE: f64 = 1e-12;
/// A force on the rim of the cone within this part of its radius slides.
const RIM: f64 = 1e-6;
/// Beyond the rim by this part of its radius is on it: impulses are turned from frame to frame
/// between steps.
const BEYOND: f64 = 1e-12;
/// Alternations between normal and tangential part within one visit of a sliding contact.
const ALTERNATIONS: usize = 4;
/// Bisections and Newton steps that find the impulse on the rim of the friction disc, to this part
/// of its radius.
const RIM_STEPS: usize = 30;
const ON_RIM: f64 = 1e-13;

/// Responses are rounded to single precision: a pivot below ten times that, of the trace, may be
/// none.
pub(super) const PIVOT_LEAST: f64 = 10.0 * f32::EPSILON as f64;

/// True when a symmetric response is positive definite beyond its round-off, by elimination with
/// the largest pivot first.
fn is_definite(W: &Mat3) -> bool {
    let least = PIVOT_LEAST * W.trace();
    let mut m = *W;
    for k in 0..3 {
        let largest = (k..3).fold(k, |best, i| if m[(i, i)] > m[(best, best)] { i } else { best });
        m.swap_rows(k, largest);
        m.swap_columns(k, largest);
        if m[(k, k)].is_nan() || m[(k, k)] <= least {
            return false;
        }
        for i in k + 1..3 {
            let part = m[(i, k)] / m[(k, k)];
            for j in k + 1..3 {
                m[(i, j)] -= part * m[(k, j)];
            }
        }
    }
    true
}

/// True when neither side can move along the normal.
pub(super) fn is_immovable(W: &Mat3) -> bool {
    W.m11.is_nan() || W.m11 <= IMMOVABLE * W.trace()
}

/// One projected Gauss-Seidel update of the impulse `lambda` = (normal, two tangents) of a point
/// whose constraint value is `d` and whose own response is `W` (d changes by `W Δλ`).
///
/// At a fixed point the normal impulse is complementary to `d_n`; the tangential one lies in the
/// disc of radius `μ λ_n` (or, linearised, in the square inscribed in it, so that friction falls
/// short of Coulomb's by up to 1 - cos 45° and never exceeds it), and where it lies on the rim,
/// sliding opposes it. Where neither side can move, the impulse is zero.
pub fn project(cone: Cone, friction: f64, W: &Mat3, d: &Vec3, lambda: &Vec3) -> Vec3 {
    debug_assert!(friction >= 0.0, "a friction coefficient of {friction}, below 0");
    let least = IMMOVABLE * W.trace();
    if is_immovable(W) {
        return Vec3::zeros();
    }
    let normal = (lambda.x - d.x / W.m11).max(0.0);
    let bound = friction * normal;
    if bound == 0.0 {
        return Vec3::new(normal, 0.0, 0.0);
    }
    let dn = normal - lambda.x;
    let slide = [d.y + W.m21 * dn, d.z + W.m31 * dn];
    let from = |t: f64, slide: f64, stiff: f64| if stiff > least { t - slide / stiff } else { 0.0 };
    match cone {
        Cone::Circular => {
            // Larger eigenvalue of the tangential block: the step that surely does not overshoot.
            let mean = 0.5 * (W.m22 + W.m33);
            let stiff = mean + (0.25 * (W.m22 - W.m33).powi(2) + W.m23 * W.m32).sqrt();
            let t = [from(lambda.y, slide[0], stiff), from(lambda.z, slide[1], stiff)];
            let length = t[0].hypot(t[1]);
            let scale = if length > bound { bound / length } else { 1.0 };
            Vec3::new(normal, t[0] * scale, t[1] * scale)
        }
        Cone::Linearised => {
            let bound = bound * std::f64::consts::FRAC_1_SQRT_2;
            let t1 = from(lambda.y, slide[0], W.m22).max(-bound).min(bound);
            let slide2 = slide[1] + W.m32 * (t1 - lambda.y);
            let t2 = from(lambda.z, slide2, W.m33).max(-bound).min(bound);
            Vec3::new(normal, t1, t2)
        }
    }
}

/// Response of one contact to its own impulse, prepared for many visits.
#[derive(Clone, Copy, Debug, Default)]
pub struct Response {
    /// The response, symmetric \[1/kg\].
    pub W: Mat3,
    /// Inverse of the response \[kg\], where there is one.
    pub inverse: Option<Mat3>,
    /// Surely positive definite.
    definite: bool,
    /// Eigenvalues of the tangential part of the response \[1/kg\], the larger first.
    high: f64,
    low: f64,
    /// Direction of the larger one.
    cos: f64,
    sin: f64,
}

impl Response {
    /// Prepares visits.
    pub fn new(W: &Mat3) -> Self {
        let (mean, half) = (0.5 * (W.m22 + W.m33), 0.5 * (W.m22 - W.m33));
        let spread = half.hypot(W.m23);
        let (sin, cos) = (0.5 * W.m23.atan2(half)).sin_cos();
        // Below its round-off a response may be any or none. One of that size gives a contact that
        // hardly moves across the other direction an impulse in proportion; none at all would turn
        // friction by round-off.
        let (high, low) = (mean + spread, (mean - spread).max(PIVOT_LEAST * (mean + spread)));
        Self { W: *W, inverse: W.try_inverse(), definite: is_definite(W), high, low, cos, sin }
    }

    /// The impulse λ so that `d = b + W λ` obeys the contact law: `0 ≤ λ_n ⊥ d_n ≥ 0`,
    /// `|λ_t| ≤ μ λ_n`, and on the rim of that disc λ_t opposes d_t. Of several such impulses (to
    /// open, to stick, to slide where friction does not lift the contact off) it is the one nearest
    /// to `start`, so that one that obeys the law so is left as it is: one that went from sticking
    /// to sliding and back at each visit kept a joint at its limit from coming to rest. Where the
    /// response is not positive definite, a sliding contact comes nearer with each visit.
    pub fn impulse(&self, cone: Cone, friction: f64, b: &Vec3, start: &Vec3) -> Vec3 {
        debug_assert!(friction >= 0.0, "a friction coefficient of {friction}, below 0");
        let W = &self.W;
        let ambiguous = cone == Cone::Circular && start.x > 0.0 && self.is_ambiguous(friction);
        if is_immovable(W) || b.x >= 0.0 && !ambiguous {
            return Vec3::zeros();
        }
        if cone == Cone::Linearised {
            let mut lambda = *start;
            for _ in 0..ALTERNATIONS {
                lambda = project(cone, friction, W, &(b + W * lambda), &lambda);
            }
            return lambda;
        }
        let found = if ambiguous {
            let opens = (b.x >= 0.0).then(Vec3::zeros);
            let all = [opens, self.sticking(friction, b), self.sliding(friction, b, start)];
            let away = |lambda: &Vec3| (lambda - start).norm_squared();
            all.into_iter().flatten().min_by(|p, q| away(p).total_cmp(&away(q)))
        } else {
            self.sticking(friction, b).or_else(|| self.sliding(friction, b, start))
        };
        found.unwrap_or_else(|| self.alternated(friction, b, start))
    }

    /// True when more than one impulse may obey the law: friction all to one side would lift the
    /// contact off by itself, `μ |W_tn| ≥ W_nn` (in a plane the law is then a complementarity
    /// problem without a P-matrix; Painlevé 1895). Levers as long belong to what is jammed. In
    /// space one random lever in some thousands has two impulses without being as long (tests).
    fn is_ambiguous(&self, friction: f64) -> bool {
        friction * self.W.m21.hypot(self.W.m31) >= self.W.m11
    }

    /// The impulse that holds the contact where it is, if friction can.
    fn sticking(&self, friction: f64, b: &Vec3) -> Option<Vec3> {
        let stick = -(self.inverse.as_ref()? * b);
        let bound = friction * stick.x;
        let holds = stick.x >= 0.0 && stick.y * stick.y + stick.z * stick.z <= bound * bound;
        holds.then_some(stick)
    }

    /// The impulse of the contact as it slides, near friction as it is in `start`.
    fn sliding(&self, friction: f64, b: &Vec3, start: &Vec3) -> Option<Vec3> {
        if !(self.definite && friction > 0.0 && b.x < 0.0) {
            return None;
        }
        let sliding = Sliding::new(&self.W, (*b).into(), friction);
        sliding.impulse([start.y, start.z]).map(Vec3::from)
    }

    /// The normal impulse and friction in turn, some times.
    fn alternated(&self, friction: f64, b: &Vec3, start: &Vec3) -> Vec3 {
        let W = &self.W;
        let mut t = [start.y, start.z];
        let mut normal = 0.0;
        for _ in 0..ALTERNATIONS {
            normal = (-(b.x + W.m12 * t[0] + W.m13 * t[1]) / W.m11).max(0.0);
            let pull = [b.y + W.m21 * normal, b.z + W.m31 * normal];
            t = self.in_disc(pull, friction * normal);
        }
        Vec3::new(normal, t[0], t[1])
    }

    /// The t in the disc of this radius with the least `½ tᵀ W t + c·t`.
    fn in_disc(&self, c: [f64; 2], radius: f64) -> [f64; 2] {
        let size = (c[0] * c[0] + c[1] * c[1]).sqrt();
        if radius <= 0.0 || size == 0.0 {
            return [0.0; 2];
        }
        // In the axes of W.
        let Self { high, low, cos, sin, .. } = *self;
        let (p, q) = (c[0] * cos + c[1] * sin, c[1] * cos - c[0] * sin);
        let at = |s: f64| [-p / (high + s), -q / (low + s)];
        let length_of = |t: [f64; 2]| (t[0] * t[0] + t[1] * t[1]).sqrt();
        let mut t = at(0.0);
        if low > 0.0 && length_of(t) <= radius {
            return [t[0] * cos - t[1] * sin, t[0] * sin + t[1] * cos];
        }
        // On the rim: (W + s) t = -c. The length of t falls with s, and s lies between these.
        let mut least = (p.abs() / radius - high).max(q.abs() / radius - low).max(0.0);
        let mut most = size / radius - low;
        let mut s = least;
        for _ in 0..RIM_STEPS {
            t = at(s);
            let length = length_of(t);
            if (length - radius).abs() <= ON_RIM * radius {
                break;
            }
            *(if length > radius { &mut least } else { &mut most }) = s;
            // Newton on 1/|t| - 1/radius, which is nearly a straight line, and bends so that from
            // below each step ends below.
            let slope = (t[0] * t[0] / (high + s) + t[1] * t[1] / (low + s)) / length.powi(3);
            let next = (s - (1.0 / length - 1.0 / radius) / slope).min(most);
            s = if next > least { next } else { 0.5 * (least + most) };
        }
        // Wherever the steps end, friction stays within the disc.
        let length = length_of(t);
        let scale = if length > radius { radius / length } else { 1.0 };
        let t = t.map(|t| scale * t);
        [t[0] * cos - t[1] * sin, t[0] * sin + t[1] * cos]
    }
}

impl ContactRow {
    /// The impulse after one update by [`project`]; `value` is the velocity less the target.
    #[inline]
    pub fn projected(&self, cone: Cone, value: &Vec3) -> Vec3 {
        let W = &self.response;
        match &self.push {
            Some(push) => push.impulse(W, value.x - W.m11 * self.lambda.x),
            None => project(cone, self.friction, W, value, &self.lambda),
        }
    }

    /// The impulse by [`Response::impulse`]; `value` is the velocity less the target.
    #[inline]
    pub fn resolved(&self, cone: Cone, own: &Response, value: &Vec3) -> Vec3 {
        let b = value - own.W * self.lambda;
        match &self.push {
            Some(push) => push.impulse(&own.W, b.x),
            None => own.impulse(cone, self.friction, &b, &self.lambda),
        }
    }
}

impl ContactRow {
    /// Returns the deviation of the impulse from the law of the round cone at this velocity less
    /// the target \[m/s\], whatever the response: how fast a contact that does not press closes,
    /// one that presses opens or closes, one that sticks slides, and one that slides goes along or
    /// across friction instead of against it. Infinite where no velocity goes with the impulse.
    pub fn strays(&self, value: &Vec3) -> f64 {
        let lambda = &self.lambda;
        if *lambda == Vec3::zeros() {
            return if value.x >= 0.0 { 0.0 } else { -value.x };
        }
        if self.turns || self.friction == 0.0 {
            let pushes = lambda.x > 0.0 && lambda.y == 0.0 && lambda.z == 0.0;
            return if pushes { value.x.abs() } else { f64::INFINITY };
        }
        let (bound, length) = (self.friction * lambda.x, lambda.y.hypot(lambda.z));
        if lambda.x <= 0.0 || length > bound * (1.0 + BEYOND) {
            return f64::INFINITY;
        }
        let slip = [value.y, value.z];
        let along = (slip[0] * lambda.y + slip[1] * lambda.z) / length;
        let slides = length >= bound * (1.0 - RIM) && along < 0.0;
        let across = (slip[0] * lambda.z - slip[1] * lambda.y) / length;
        let tangential = if slides { across.abs() } else { slip[0].hypot(slip[1]) };
        value.x.abs().max(tangential)
    }
}

/// True when friction gives all it can to a contact that presses, so that it slides (or is about
/// to).
pub fn is_on_rim(cone: Cone, friction: f64, lambda: &Vec3) -> bool {
    let rim = friction * lambda.x * (1.0 - RIM);
    lambda.x > 0.0
        && match cone {
            Cone::Circular => lambda.y.hypot(lambda.z) >= rim,
            Cone::Linearised => {
                lambda.y.abs().max(lambda.z.abs()) >= rim * std::f64::consts::FRAC_1_SQRT_2
            }
        }
}

mod sliding;
#[cfg(test)]
mod tests;
