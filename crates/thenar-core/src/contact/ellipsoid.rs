//! Signed distance to an ellipsoid.
//!
//! The nearest surface point `x` to `p` has `p - x` along the normal: `x_i = e_i² p_i/(t + e_i²)`
//! with `Σ (e_i p_i/(t + e_i²))² = 1` for the largest root `t` (Eberly, Distance from a Point to an
//! Ellipse, an Ellipsoid, or a Hyperellipsoid, 2013). Measured from the pole of the shortest axis,
//! `w = t/e_min² + 1`, the root keeps all its digits wherever `p` lies.

use crate::contact::Distance;
use crate::math::Vec3;

/// Each iteration at least halves the number of digits between the bounds, or is Newton's.
const ITERATIONS_MAX: usize = 100;
/// Coordinates below this part of an axis count as this: points of symmetry get one side.
const ASIDE: f64 = 1e-30;

/// Signed distance of `p` to the ellipsoid of half axes `half`; exact to round-off.
pub(crate) fn distance(p: &Vec3, half: &Vec3) -> Distance {
    let shortest = half.min();
    // Squared axes in units of the shortest, less one, and the point in units of the axes.
    let excess = half.map(|e| (e - shortest) * (e + shortest) / (shortest * shortest));
    let z = p.abs().component_div(half).map(|z| z.max(ASIDE));
    let w = root(&z, &excess);
    let x = Vec3::from_fn(|k, _| {
        let nearest = (excess[k] + 1.0) * z[k] / (w + excess[k]) * half[k];
        nearest.copysign(p[k])
    });
    let gradient = x.component_div(&half.component_mul(half)).normalize();
    Distance { value: gradient.dot(&(p - x)), gradient }
}

/// Solves `F(w) = Σ ((1 + a_i) z_i/(w + a_i))² = 1` for `w > 0`; F falls and is convex.
fn root(z: &Vec3, a: &Vec3) -> f64 {
    let b = z.component_mul(&a.add_scalar(1.0));
    let value = |w: f64| (0..3).map(|k| (b[k] / (w + a[k])).powi(2)).sum::<f64>();
    let slope = |w: f64| (0..3).map(|k| 2.0 * b[k] * b[k] / (w + a[k]).powi(3)).sum::<f64>();
    // One term alone is 1 at `low`, all together are below 1 at `high`.
    let (mut low, mut high) = ((b - a).max(), b.norm());
    for _ in 0..ITERATIONS_MAX {
        let f = value(low);
        // Newton's step for 1/√F = 1, which is nearly linear.
        let next = low + 2.0 * f * (f.sqrt() - 1.0) / slope(low);
        if f <= 1.0 || next <= low {
            break;
        }
        low = next.min(high);
        if high > 4.0 * low {
            let middle = (low * high).sqrt();
            *(if value(middle) >= 1.0 { &mut low } else { &mut high }) = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// A point put off the surface along its normal, as far as no other point is nearer, is as far
    /// from it as it was put.
    #[test]
    fn points_along_a_normal_are_as_far_as_they_were_put() {
        let mut random = Random::new(4);
        let halves = [
            Vec3::new(0.03, 0.02, 0.01),
            Vec3::new(0.001, 0.1, 0.1),
            Vec3::new(0.1, 0.1, 0.0005),
            Vec3::repeat(0.02),
        ];
        for half in halves {
            let (least, most) = (half.min(), half.max());
            // The least radius of curvature.
            let curvature = least * least / most;
            for i in 0..2000 {
                let mut direction = random.vector(1.0).normalize();
                if i % 5 == 0 {
                    direction[i / 5 % 3] = 0.0;
                }
                let x = half.component_mul(&direction.normalize());
                let normal = x.component_div(&half.component_mul(&half)).normalize();
                for off in [-0.999 * curvature, -1e-9, 0.0, 1e-12, 1e-6, 0.5 * most, 30.0 * most] {
                    let d = distance(&(x + off * normal), &half);
                    let error = (d.value - off).abs();
                    assert!(error < 2e-14 * (most + off.abs()), "{half} {off}: {error:e}");
                    assert!((d.gradient - normal).norm() < 1e-6);
                }
            }
        }
    }
}
