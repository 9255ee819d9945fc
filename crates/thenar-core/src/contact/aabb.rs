//! Axis-aligned bounding boxes.

use crate::math::{Mat3, Vec3};

/// An axis-aligned box; empty when `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aabb {
    pub min: Vec3,
    pub max: Vec3,
}

impl Aabb {
    pub const EMPTY: Self = Self {
        min: Vec3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        max: Vec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };
    pub const EVERYTHING: Self = Self { min: Self::EMPTY.max, max: Self::EMPTY.min };

    pub fn of_points<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| b.with(p))
    }

    pub fn symmetric(half: Vec3) -> Self {
        Self { min: -half, max: half }
    }

    #[inline]
    pub fn with(self, p: &Vec3) -> Self {
        Self { min: lower(&self.min, p), max: upper(&self.max, p) }
    }

    #[inline]
    pub fn union(self, other: &Self) -> Self {
        Self { min: lower(&self.min, &other.min), max: upper(&self.max, &other.max) }
    }

    #[inline]
    pub fn inflate(self, by: f64) -> Self {
        let by = Vec3::repeat(by);
        Self { min: self.min - by, max: self.max + by }
    }

    #[inline]
    pub fn translate(self, by: &Vec3) -> Self {
        Self { min: self.min + by, max: self.max + by }
    }

    #[inline]
    pub fn overlaps(&self, other: &Self) -> bool {
        // Without branches: which axis tells boxes apart is anybody's guess.
        let along = |k: usize| (self.min[k] <= other.max[k]) & (other.min[k] <= self.max[k]);
        along(0) & along(1) & along(2)
    }

    #[inline]
    pub fn contains(&self, p: &Vec3) -> bool {
        let along = |k: usize| (self.min[k] <= p[k]) & (p[k] <= self.max[k]);
        along(0) & along(1) & along(2)
    }

    pub fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }

    pub fn center(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    pub fn half(&self) -> Vec3 {
        0.5 * (self.max - self.min)
    }

    /// Squared distance from `p` to the box, zero inside.
    #[inline]
    pub fn distance_squared(&self, p: &Vec3) -> f64 {
        let beyond = upper(&(self.min - p), &(p - self.max));
        upper(&beyond, &Vec3::zeros()).norm_squared()
    }

    /// Returns the distance of the box from the plane through `p` with this unit normal \[m\];
    /// negative where the plane cuts it.
    #[inline]
    pub fn distance_to_plane(&self, p: &Vec3, normal: &Vec3) -> f64 {
        normal.dot(&(self.center() - p)).abs() - normal.abs().dot(&self.half())
    }

    /// Returns the distance from `p` along `d`, in lengths of `d`, at which a ray meets the box;
    /// zero from inside.
    pub fn met_by_ray(&self, p: &Vec3, d: &Vec3) -> Option<f64> {
        let (mut from, mut to) = (0.0_f64, f64::INFINITY);
        for k in 0..3 {
            if d[k] == 0.0 {
                if p[k] < self.min[k] || p[k] > self.max[k] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((self.min[k] - p[k]) / d[k], (self.max[k] - p[k]) / d[k]);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        (from <= to).then_some(from)
    }

    /// The box around this (finite) box turned by `rotation` and then moved by `offset`.
    pub fn moved(&self, rotation: &Mat3, offset: &Vec3) -> Self {
        let center = rotation * self.center() + offset;
        let half = rotation.abs() * self.half();
        Self { min: center - half, max: center + half }
    }
}

/// The lower of each two components; what is not a number in `b` is passed over. One instruction
/// each, where the general minimum of two numbers takes four.
#[inline(always)]
fn lower(a: &Vec3, b: &Vec3) -> Vec3 {
    let pick = |a: f64, b: f64| if b < a { b } else { a };
    Vec3::new(pick(a.x, b.x), pick(a.y, b.y), pick(a.z, b.z))
}

/// Likewise the higher.
#[inline(always)]
fn upper(a: &Vec3, b: &Vec3) -> Vec3 {
    let pick = |a: f64, b: f64| if b > a { b } else { a };
    Vec3::new(pick(a.x, b.x), pick(a.y, b.y), pick(a.z, b.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Quat;

    #[test]
    fn moved_box_holds_its_corners_tightly() {
        let b = Aabb { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(2.0, 1.0, 5.0) };
        let q = Quat::from_euler_angles(0.3, -1.1, 2.0);
        let offset = Vec3::new(10.0, -3.0, 0.5);
        let corners: Vec<Vec3> = (0..8)
            .map(|i| {
                let pick = |k: usize| if i >> k & 1 == 0 { b.min[k] } else { b.max[k] };
                q * Vec3::new(pick(0), pick(1), pick(2)) + offset
            })
            .collect();
        let tight = Aabb::of_points(&corners);
        let moved = b.moved(q.to_rotation_matrix().matrix(), &offset);
        assert!((moved.min - tight.min).norm() < 1e-12);
        assert!((moved.max - tight.max).norm() < 1e-12);
    }

    #[test]
    fn distance_to_a_box() {
        let b = Aabb::symmetric(Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(b.distance_squared(&Vec3::new(0.5, 1.0, -2.0)), 0.0);
        assert_eq!(b.distance_squared(&Vec3::new(4.0, -6.0, 0.0)), 9.0 + 16.0);
        assert!(Aabb::EMPTY.is_empty() && !b.is_empty());
        assert!(!b.overlaps(&Aabb::EMPTY) && b.overlaps(&Aabb::EVERYTHING));
    }
}
