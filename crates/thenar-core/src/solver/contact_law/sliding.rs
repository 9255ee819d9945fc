//! The impulse of one contact that slides.
//!
//! Friction is on the rim, `λ_t = μ λ_n e` with a unit vector e, and the contact stays closed: with
//! w the response of the tangents to the normal impulse and T their own,
//!
//! ```text
//!   d_n = b_n + λ_n δ = 0,   δ = W_nn + μ w·e > 0
//!   d_t = b_t + λ_n (w + μ T e) = -s e,   s ≥ 0
//! ```
//!
//! so that `v = δ d_t = δ b_t - b_n (w + μ T e)` must be opposite to e. What of it is across e is a
//! trigonometric polynomial of degree two in the angle of e, equivalent to the quartic of Bonnefon
//! and Daviet, *Quartic formulation of Coulomb 3D frictional contact* (2011). For a positive
//! definite response it has a root that obeys the law wherever the contact neither opens nor
//! sticks. On a long lever there may be others: Newton's method from where friction points already
//! finds one near it, or else the nearest is taken.

use crate::math::Mat3;

/// Newton steps from where friction points already.
const STEPS: usize = 8;
/// A step as small as this [rad] has arrived.
const ARRIVED: f64 = 1e-13;
/// A response along the normal below this part of the frictionless one is none: the impulse would
/// run away.
const DENOMINATOR_LEAST: f64 = 1e-6;
/// Each half of the circle is searched a little beyond its ends, where round-off may give the same
/// value either sign.
const END: f64 = 1.0 + 1e-6;
/// Bisections that find a root to the last bit of a number.
const BISECTIONS: usize = 52;

/// One contact that slides: its response, and the velocity without its impulse.
pub(super) struct Sliding {
    normal: f64,
    w: [f64; 2],
    tangents: [f64; 3],
    b: [f64; 3],
    friction: f64,
    /// The part of v across e: `k + a·(cos, sin)(θ) + c·(cos, sin)(2θ)`.
    constant: f64,
    single: [f64; 2],
    double: [f64; 2],
}

impl Sliding {
    /// A contact of response W with velocity b [m/s] but for its own impulse; `b_n < 0`.
    pub fn new(W: &Mat3, b: [f64; 3], friction: f64) -> Self {
        let (normal, w, tangents) = (W.m11, [W.m21, W.m31], [W.m22, W.m23, W.m33]);
        let [bn, b1, b2] = b;
        let half = 0.5 * friction;
        Self {
            normal,
            w,
            tangents,
            b,
            friction,
            constant: half * (b2 * w[0] - b1 * w[1]),
            single: [normal * b2 - bn * w[1], bn * w[0] - normal * b1],
            double: [
                half * (b1 * w[1] + b2 * w[0]) - friction * bn * tangents[1],
                half * (b2 * w[1] - b1 * w[0]) - half * bn * (tangents[2] - tangents[0]),
            ],
        }
    }

    /// The impulse (normal, two tangents), near friction along `start`; `None` where round-off
    /// hides it.
    pub fn impulse(&self, start: [f64; 2]) -> Option<[f64; 3]> {
        // Without a start as if friction did not change the normal impulse.
        let start = unit(start).or_else(|| unit([self.single[1], -self.single[0]]))?;
        let e = self.newton(start).or_else(|| self.search(start))?;
        let normal = -self.b[0] / self.denominator(e);
        let rim = self.friction * normal;
        Some([normal, rim * e[0], rim * e[1]])
    }

    /// The part of v across e, and its derivative by the angle.
    fn across(&self, e: [f64; 2]) -> (f64, f64) {
        let [c, s] = e;
        let (c2, s2) = (c * c - s * s, 2.0 * s * c);
        let ([a, b], [p, q]) = (self.single, self.double);
        let value = self.constant + a * c + b * s + p * c2 + q * s2;
        (value, b * c - a * s + 2.0 * (q * c2 - p * s2))
    }

    fn denominator(&self, e: [f64; 2]) -> f64 {
        self.normal + self.friction * (self.w[0] * e[0] + self.w[1] * e[1])
    }

    /// True when a root obeys the law: the impulse pushes, and friction along e opposes what
    /// slides.
    fn obeys(&self, e: [f64; 2]) -> bool {
        let delta = self.denominator(e);
        let [t11, t12, t22] = self.tangents;
        let pull = t11 * e[0] * e[0] + 2.0 * t12 * e[0] * e[1] + t22 * e[1] * e[1];
        let [bn, b1, b2] = self.b;
        let across_w = self.w[0] * e[0] + self.w[1] * e[1];
        let along = delta * (b1 * e[0] + b2 * e[1]) - bn * (across_w + self.friction * pull);
        delta > DENOMINATOR_LEAST * self.normal && along <= 0.0
    }

    fn newton(&self, start: [f64; 2]) -> Option<[f64; 2]> {
        let mut e = start;
        for _ in 0..STEPS {
            let (value, slope) = self.across(e);
            let step = -value / slope;
            if step.is_nan() || step.abs() > 1.0 {
                return None;
            }
            e = unit([e[0] - step * e[1], e[1] + step * e[0]])?;
            if step.abs() <= ARRIVED {
                return self.obeys(e).then_some(e);
            }
        }
        None
    }

    /// The root that obeys the law nearest to a direction. With the tangent u of half the angle,
    /// what of v is across e is a quartic over (1 + u²)²; u from -1 to 1 is half the circle, and
    /// turned by π the other half.
    fn search(&self, start: [f64; 2]) -> Option<[f64; 2]> {
        let mut best: Option<(f64, [f64; 2])> = None;
        for side in [1.0, -1.0] {
            let (k, [a, b], [p, q]) = (self.constant, self.single.map(|x| side * x), self.double);
            let (even, odd) = (k + p, 2.0 * b);
            let quartic = [even + a, odd + 4.0 * q, 2.0 * k - 6.0 * p, odd - 4.0 * q, even - a];
            let (roots, count) = roots(&quartic);
            for u in &roots[..count] {
                let e = [1.0 - u * u, 2.0 * u].map(|x| side * x / (1.0 + u * u));
                let near = e[0] * start[0] + e[1] * start[1];
                if self.obeys(e) && best.is_none_or(|(nearest, _)| near > nearest) {
                    best = Some((near, e));
                }
            }
        }
        best.map(|(_, e)| e)
    }
}

/// The roots of a quartic `Σ c_k u^k` at which it changes its sign between -[`END`] and [`END`],
/// and how many. Between neighbouring roots of its derivative a polynomial has one at most, so
/// roots are found from the last derivative up.
fn roots(c: &[f64; 5]) -> ([f64; 4], usize) {
    let (mut found, mut count) = ([0.0; 4], 0);
    for degree in 1..=4 {
        // The derivative of this degree.
        let mut derived = *c;
        for _ in degree..4 {
            derived =
                std::array::from_fn(|k| derived.get(k + 1).map_or(0.0, |c| (k + 1) as f64 * c));
        }
        let value = |u: f64| derived.iter().rev().fold(0.0, |sum, c| sum * u + c);
        let (turns, turned) = (found, count);
        count = 0;
        let mut low = -END;
        for k in 0..=turned {
            let end = if k < turned { turns[k] } else { END };
            let positive = value(low) > 0.0;
            if positive != (value(end) > 0.0) {
                let (mut from, mut to) = (low, end);
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (from + to);
                    *(if (value(middle) > 0.0) == positive { &mut from } else { &mut to }) = middle;
                }
                found[count] = from;
                count += 1;
            }
            low = end;
        }
    }
    (found, count)
}

/// A vector of length one; `None` for none.
fn unit(v: [f64; 2]) -> Option<[f64; 2]> {
    let length = (v[0] * v[0] + v[1] * v[1]).sqrt();
    (length > 0.0).then(|| [v[0] / length, v[1] / length])
}
