//! A triangle of a soft surface near a rigid shape, seen from the shape.

use crate::contact::PlacedShape;
use crate::contact::aabb::Aabb;
use crate::contact::soft_rigid::SoftRigid;
use crate::contact::triangle::{Closest, ROUNDED_UP, closest_on_triangle};
use crate::math::Vec3;

/// Most places at which a ball is looked for along the way of a triangle.
const ADVANCES_MAX: usize = 32;

/// A triangle and its motion in this step relative to the shape, in the shape frame.
pub(crate) struct Near {
    pub index: u32,
    pub x: [Vec3; 3],
    /// Motions of the corners in this step \[m\].
    pub u: [Vec3; 3],
    /// The largest of them \[m\].
    pub travel: f64,
}

/// First touch of a triangle and a ball.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrival {
    /// Part of the step until then.
    pub at: f64,
    pub weights: [f64; 3],
    /// Unit direction from the ball's centre to the triangle then.
    pub normal: Vec3,
    /// Distance that the triangle's point has to go along the normal to touch, from its place now
    /// \[m\].
    pub gap: f64,
}

impl Near {
    pub fn new(pair: &SoftRigid, index: u32) -> Self {
        let [a, b, c] = pair.surface.triangles[index as usize];
        let (x0, u0) = pair.in_shape(a as usize);
        let (x1, u1) = pair.in_shape(b as usize);
        let (x2, u2) = pair.in_shape(c as usize);
        Self::moving(index, [x0, x1, x2], [u0, u1, u2])
    }

    /// A triangle whose corners move so far in this step.
    pub fn moving(index: u32, x: [Vec3; 3], u: [Vec3; 3]) -> Self {
        let squared = |k: usize| u[k].norm_squared();
        let travel = squared(0).max(squared(1)).max(squared(2)).sqrt();
        Self { index, x, u, travel }
    }

    /// Box around the triangle during the step.
    pub fn swept(&self) -> Aabb {
        let [a, b, c] = self.x;
        let now = Aabb { min: a, max: a }.with(&b).with(&c);
        now.with(&(a + self.u[0])).with(&(b + self.u[1])).with(&(c + self.u[2]))
    }

    /// True when any point of the triangle can come within `margin` \[m\] of a convex part in this
    /// step.
    pub fn may_touch(&self, part: &PlacedShape, margin: f64) -> bool {
        let x = self.x.map(|p| part.pose_SP.inverse_point(&p));
        part.shape.least_over(&x) <= margin + self.travel
    }

    /// Returns the displacement in this step of the point with these weights \[m\].
    pub fn motion(&self, weights: &[f64; 3]) -> Vec3 {
        Vec3::zeros() + self.u[0] * weights[0] + self.u[1] * weights[1] + self.u[2] * weights[2]
    }

    /// The point of the triangle nearest to `p`.
    pub fn closest(&self, p: &Vec3) -> Closest {
        closest_on_triangle(p, &self.x)
    }

    /// Follows the triangle to where it first comes within `margin` of a ball about `c` and nears
    /// it, if it does so in this step: one that passes by is behind its tangent plane there,
    /// outside though it is (conservative advancement: no point of it moves farther than `travel`).
    pub fn arrival(&self, c: &Vec3, radius: f64, margin: f64) -> Option<Arrival> {
        self.arrival_from(c, radius, margin, self.closest(c), 1.0)
    }

    /// Follows the triangle like [`Near::arrival`], with the place nearest now known; `None` if it
    /// comes later than after the part `latest` of the step.
    pub fn arrival_from(
        &self,
        c: &Vec3,
        radius: f64,
        margin: f64,
        now: Closest,
        latest: f64,
    ) -> Option<Arrival> {
        let reach = radius + margin;
        if self.travel <= 0.0 || !may_arrive(c, &now, reach, |k| self.u[k] * latest) {
            return None;
        }
        let (mut at, mut closest) = (0.0, now);
        for _ in 0..ADVANCES_MAX {
            let distance = closest.distance_squared.sqrt();
            let normal = (closest.point - c).try_normalize(0.0)?;
            let nears = self.motion(&closest.weights).dot(&normal) < 0.0;
            if distance - radius <= margin && nears {
                let now: Vec3 = (0..3).map(|k| self.x[k] * closest.weights[k]).sum();
                let gap = normal.dot(&(now - c)) - radius;
                return Some(Arrival { at, weights: closest.weights, normal, gap });
            }
            at += (distance - radius - 0.5 * margin).max(0.5 * margin) / self.travel;
            if at > latest {
                return None;
            }
            let x = |k: usize| self.x[k] + at * self.u[k];
            closest = closest_on_triangle(c, &[x(0), x(1), x(2)]);
        }
        None
    }
}

/// True when a triangle whose corners move by `motion` past `c` may come within `reach` \[m\] of
/// it: all of the triangle lies beyond the plane through its nearest place, square to the way
/// there, which comes no faster than the fastest corner.
pub(crate) fn may_arrive(
    c: &Vec3,
    nearest: &Closest,
    reach: f64,
    motion: impl Fn(usize) -> Vec3,
) -> bool {
    let away = nearest.point - c;
    let comes = |k: usize| -away.dot(&motion(k));
    let fastest = comes(0).max(comes(1)).max(comes(2)).max(0.0);
    let squared = nearest.distance_squared;
    squared <= (fastest + reach * squared.sqrt()) * ROUNDED_UP
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Whatever comes near is let through; what flies away, or past at a distance, mostly not.
    #[test]
    fn what_comes_within_reach_may_arrive() {
        let mut random = Random::new(5);
        let (reach, mut near, mut passed) = (2e-3, 0, 0);
        for _ in 0..20_000 {
            let (at, way) = (random.vector(0.02), random.vector(0.03));
            let corners = [0; 3].map(|_| at + random.vector(0.006));
            let ways = [0; 3].map(|_| way + random.vector(0.01));
            let c = random.vector(0.005);
            let now = closest_on_triangle(&c, &corners);
            if now.distance_squared <= reach * reach {
                continue;
            }
            let least = (0..=100).map(|i| {
                let at = f64::from(i) / 100.0;
                let x = [0, 1, 2].map(|k| corners[k] + at * ways[k]);
                closest_on_triangle(&c, &x).distance_squared
            });
            let comes = least.fold(f64::INFINITY, f64::min) <= reach * reach;
            let may = may_arrive(&c, &now, reach, |k| ways[k]);
            assert!(may || !comes, "{corners:?} {ways:?} {c}");
            near += u32::from(comes);
            passed += u32::from(!may);
        }
        assert!(near > 500 && passed > 5000, "{near} {passed}");
    }

    /// Triangles that fly past a ball and triangles that hit it, spinning ones too: that of one
    /// outside now never says that it is inside.
    #[test]
    fn no_triangle_outside_is_told_to_be_inside() {
        let mut noise = Random::new(7);
        let (radius, margin) = (0.01, 1e-3);
        let mut arrived = 0;
        for _ in 0..30_000 {
            let mut vector = |size: f64| noise.vector(size);
            let (at, way) = (vector(0.04), vector(0.05));
            let corners = [0; 3].map(|_| at + vector(0.006));
            let near = Near::moving(0, corners, [0; 3].map(|_| way + vector(0.01)));
            let c = vector(0.005);
            if near.closest(&c).distance_squared.sqrt() <= radius + margin {
                continue;
            }
            let Some(arrival) = near.arrival(&c, radius, margin) else { continue };
            arrived += 1;
            assert!(arrival.gap > 0.0, "{arrival:?}");
        }
        assert!(arrived > 1000, "{arrived}");
    }
}
