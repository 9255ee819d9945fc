//! Vertices of one deformable surface against triangles of another.

use crate::contact::aabb::Aabb;
use crate::contact::approach::Seen;
use crate::contact::collector::{Collector, feature_key};
use crate::contact::sides::Sight;
use crate::contact::soft_rigid::KEY_SOFT_SOFT;
use crate::contact::surface::Surface;
use crate::contact::triangle::{Closest, Feature, area_vector, closest_on_triangle};
use crate::contact::{Contact, Site, SurfacePoint, SurfaceState};
use crate::math::Vec3;

const NONE: u32 = u32::MAX;

/// One of two surfaces.
#[derive(Clone, Copy)]
pub(crate) struct SoftSide<'a> {
    pub soft: u32,
    /// Number of the body among all bodies.
    pub id: u32,
    pub surface: &'a Surface,
    pub state: SurfaceState<'a>,
    /// Mean velocity, and the largest deviation of a vertex from it.
    pub drift: Vec3,
    pub spread: f64,
    /// Box around the surface during the step.
    pub swept: Aabb,
}

/// Vertices of `a` against triangles of `b` in one step.
pub(crate) struct SoftSoft<'a> {
    pub h: f64,
    pub margin: f64,
    pub a: SoftSide<'a>,
    pub b: SoftSide<'a>,
    pub friction: f64,
}

impl SoftSoft<'_> {
    /// Adds at most one contact per vertex of A. `touched[v]` receives the triangle of B that
    /// vertex v of A touches; `mirrored` holds the same of the opposite search, and a vertex
    /// pair already in contact there is left out.
    pub fn find(
        &self,
        sight: &mut Sight,
        touched: &mut [u32],
        mirrored: Option<&[u32]>,
        out: &mut Collector,
    ) {
        let around = self.b.swept.inflate(self.margin);
        for v in 0..self.a.state.positions.len() {
            touched[v] = NONE;
            let (p, velocity) = (self.a.state.positions[v], self.a.state.velocities[v]);
            if !around.inflate(velocity.norm() * self.h).contains(&p) {
                continue;
            }
            let slip = (velocity - self.b.drift).norm() + self.b.spread;
            if let Some(t) = self.vertex(v, slip * self.h, sight, mirrored, out) {
                touched[v] = t;
            }
        }
    }

    fn vertex(
        &self,
        v: usize,
        travel: f64,
        sight: &mut Sight,
        mirrored: Option<&[u32]>,
        out: &mut Collector,
    ) -> Option<u32> {
        let p = self.a.state.positions[v];
        let depth_max = 0.5 * self.b.surface.edge_mean;
        let reach = (self.margin + travel).max(depth_max);
        let slot = self.a.surface.first_vertex + v;
        let seen = sight.recall(slot, self.b.id);
        let (t, closest) = self.nearest_triangle(&p, reach, seen)?;
        let (normal, gap) = self.signed(&p, t, &closest)?;

        let triangle = self.b.surface.triangles[t as usize];
        let point =
            SurfacePoint { soft: self.b.soft, vertices: triangle, weights: closest.weights };
        let slip = self.a.state.velocities[v] - point.interpolate(self.b.state.velocities);
        let closing = (-slip.dot(&normal)).max(0.0) * self.h;
        if gap > self.margin + closing || gap < -depth_max {
            return None;
        }
        if mirrored.is_some_and(|m| self.is_mirrored(v as u32, &p, &triangle, m)) {
            return None;
        }
        sight.note(slot, self.b.id, Seen { normal, place: p });
        out.push(Contact {
            key: feature_key([KEY_SOFT_SOFT, self.a.soft, self.b.soft, v as u32]),
            a: Site::Soft(SurfacePoint::vertex(self.a.soft, v as u32)),
            b: Site::Soft(point),
            position_W: p - 0.5 * gap * normal,
            normal_W: normal,
            gap,
            friction: self.friction,
            area: 0.5 * self.a.surface.vertex_area(v as u32, &normal, self.a.state.positions),
        });
        Some(t)
    }

    /// The nearest triangle of B; for a vertex that was in contact, among those that face it.
    fn nearest_triangle(&self, p: &Vec3, reach: f64, seen: Option<Seen>) -> Option<(u32, Closest)> {
        let mut best: Option<(u32, Closest)> = None;
        self.b.surface.tree.nearest(p, reach * reach, |t, bound| {
            let x = self.b.surface.corners(t, self.b.state.positions);
            let closest = closest_on_triangle(p, &x);
            let facing = seen.is_none_or(|s| s.normal.dot(&area_vector(&x)) > 0.0);
            if !facing || closest.distance_squared > bound {
                return bound;
            }
            // Of equally near triangles (a shared edge) the lowest index, whatever the tree.
            let ties =
                best.is_some_and(|b| b.1.distance_squared == closest.distance_squared && b.0 < t);
            if !ties {
                best = Some((t, closest));
            }
            closest.distance_squared
        });
        best
    }

    /// Normal of B at the nearest point, and the signed distance along it.
    fn signed(&self, p: &Vec3, t: u32, closest: &Closest) -> Option<(Vec3, f64)> {
        let outward = self.b.surface.pseudonormal(t, closest.feature, self.b.state.positions);
        if outward == Vec3::zeros() {
            return None;
        }
        let to_p = p - closest.point;
        let gap = closest.distance_squared.sqrt().copysign(to_p.dot(&outward));
        let on_face = closest.feature == Feature::Face || gap.abs() < 1e-9;
        Some((if on_face { outward } else { to_p / gap }, gap))
    }

    /// Whether a vertex of `triangle` (of B) close to `p` already touches a triangle at v.
    fn is_mirrored(&self, v: u32, p: &Vec3, triangle: &[u32; 3], mirrored: &[u32]) -> bool {
        let near = 0.25 * self.a.surface.edge_mean.min(self.b.surface.edge_mean);
        triangle.iter().any(|&w| {
            let t = mirrored[w as usize];
            t != NONE
                && self.a.surface.triangles[t as usize].contains(&v)
                && (self.b.state.positions[w as usize] - p).norm_squared() < near * near
        })
    }
}
