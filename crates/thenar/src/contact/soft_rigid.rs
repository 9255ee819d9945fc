//! A deformable surface against a rigid shape.

use crate::contact::approach::{Seen, approach_from, keep_side};
use crate::contact::blunt::{blunted, has_edges};
use crate::contact::collector::{Collector, feature_key};
use crate::contact::rigid_body::{Placed, RigidBody};
use crate::contact::sides::Sight;
use crate::contact::soft_feature::{self, FeatureScratch};
use crate::contact::surface::Surface;
use crate::contact::{Contact, Distance, Shape, Site, SurfacePoint, SurfaceState};
use crate::math::Vec3;

/// Kinds of contact, as they enter the key.
pub(crate) const KEY_VERTEX: u32 = 1 << 24;
pub(crate) const KEY_POINT: u32 = 2 << 24;
pub(crate) const KEY_SEGMENT: u32 = 3 << 24;
pub(crate) const KEY_RIGID: u32 = 4 << 24;
pub(crate) const KEY_SOFT_SOFT: u32 = 5 << 24;
pub(crate) const KEY_CROSSING: u32 = 6 << 24;
pub(crate) const KEY_INSIDE: u32 = 7 << 24;
pub(crate) const KEY_PIERCED: u32 = 8 << 24;

/// One surface and one rigid body, in one step.
pub(crate) struct SoftRigid<'a> {
    pub h: f64,
    pub margin: f64,
    /// Index of the deformable body.
    pub soft: u32,
    pub surface: &'a Surface,
    pub state: SurfaceState<'a>,
    /// No vertex travels farther than this in the step \[m\].
    pub travel: f64,
    /// Whether the body may be inside the surface; its tree is then up to date.
    pub may_be_inside: bool,
    /// Index of the rigid body.
    pub rigid: u32,
    pub body: &'a RigidBody,
    pub placed: &'a Placed,
    pub friction: f64,
}

/// Results of the vertices, for the search between them.
#[derive(Clone, Debug, Default)]
pub(crate) struct VertexScratch {
    /// The vertices within reach.
    pub near: Vec<u32>,
}

impl VertexScratch {
    pub fn with_size(vertices: usize) -> Self {
        Self { near: Vec::with_capacity(vertices) }
    }
}

impl SoftRigid<'_> {
    /// All contacts of the pair: first of the vertices, then of what they miss; while the body is inside
    /// the surface, those that lead it out.
    pub fn find(
        &self,
        sight: &mut Sight,
        vertices: &mut VertexScratch,
        features: &mut FeatureScratch,
        out: &mut Collector,
    ) {
        let has_features = !matches!(self.body.shape, Shape::HalfSpace);
        let around_W = self.placed.swept_W.inflate(self.margin + self.travel);
        vertices.near.clear();
        let is_inside = self.may_be_inside && self.lead_out(out);
        for v in 0..self.state.positions.len() {
            let feature_reach = if has_features { self.feature_reach(v) } else { 0.0 };
            if !around_W.inflate(feature_reach).contains(&self.state.positions[v]) {
                continue;
            }
            if self.vertex(v, feature_reach, is_inside, sight, out) {
                vertices.near.push(v as u32);
            }
        }
        if has_features && !is_inside && !vertices.near.is_empty() {
            soft_feature::find(self, vertices, features, out);
        }
    }

    /// A surface vertex and its motion in this step relative to the shape, in the shape frame.
    pub fn in_shape(&self, v: usize) -> (Vec3, Vec3) {
        let p_W = self.state.positions[v];
        let slip_W = self.state.velocities[v] - self.placed.velocity_at(&p_W);
        (self.placed.shape_point(&p_W), self.placed.rotation.tr_mul(&slip_W) * self.h)
    }

    /// A triangle that a feature could touch has a vertex within this distance of the shape:
    /// 1/√3 of its longest edge, with a third to spare for stretching.
    fn feature_reach(&self, v: usize) -> f64 {
        0.77 * self.surface.edge_around[v] + soft_feature::depth_max(self)
    }

    /// Tests one vertex; false when the shape is out of its reach.
    /// A vertex that looks away from a body inside the surface does not touch it.
    fn vertex(
        &self,
        v: usize,
        feature_reach: f64,
        is_inside: bool,
        sight: &mut Sight,
        out: &mut Collector,
    ) -> bool {
        let (p, u) = self.in_shape(v);
        let reach = feature_reach.max(self.margin + u.norm());
        if self.body.bounds_S.distance_squared(&p) > reach * reach {
            return false;
        }
        let shape = &self.body.shape;
        let Some(now) = shape.distance_within(&p, reach) else { return false };
        let slot = self.surface.first_vertex + v;
        let seen = sight.recall(slot, self.rigid);
        let sided = keep_side(shape, &p, &u, now, seen);
        let is_near = sided.value <= self.margin;
        let found = match is_near {
            true => Some(self.blunted(v, &p, now, sided)),
            false => approach_from(shape, &p, now, &u, 0.0, self.margin),
        };
        let looks_away = |normal: &Vec3| {
            let outward_W = self.surface.vertex_normal(v as u32, self.state.positions);
            outward_W.dot(&(self.placed.rotation * normal)) >= 0.0
        };
        if let Some(distance) = found.filter(|d| !(is_inside && looks_away(&d.gradient))) {
            // While a point is on the wrong side, where it came from stays the last good place.
            let corrected = sided.gradient != now.gradient;
            let place = seen.filter(|_| corrected).map_or(p, |s| s.place);
            // A side is that of the shape as it is, edges and all.
            let normal = if is_near { sided.gradient } else { distance.gradient };
            sight.note(slot, self.rigid, Seen { normal, place });
            out.push(self.vertex_contact(v as u32, distance));
        }
        sided.value < f64::INFINITY
    }

    /// A vertex at distance `now` does not feel how sharp an edge is, unless it was led out another way.
    fn blunted(&self, v: usize, p: &Vec3, now: Distance, sided: Distance) -> Distance {
        if sided.gradient != now.gradient || !has_edges(&self.body.shape) {
            return sided;
        }
        let outward = || {
            let outward_W = self.surface.mean_normal_at(v as u32, self.state.positions);
            self.placed.rotation.tr_mul(&outward_W)
        };
        blunted(&self.body.shape, p, outward, self.surface.edge_at(v as u32), sided)
    }

    fn vertex_contact(&self, v: u32, distance: Distance) -> Contact {
        let p_W = self.state.positions[v as usize];
        let normal_W = self.placed.rotation * distance.gradient;
        Contact {
            key: feature_key([KEY_VERTEX | self.soft, self.rigid, v, 0]),
            a: Site::Soft(SurfacePoint::vertex(self.soft, v)),
            b: Site::Rigid { body: self.rigid, offset_W: p_W - self.placed.center_of_mass },
            position_W: p_W,
            normal_W,
            gap: distance.value,
            friction: self.friction,
        }
    }
}
