//! A deformable surface against a rigid shape.

use crate::contact::approach::{Seen, approach, keep_side};
use crate::contact::collector::{Collector, feature_key};
use crate::contact::memory::Memory;
use crate::contact::rigid_body::{Placed, RigidBody};
use crate::contact::soft_feature::{self, FeatureScratch};
use crate::contact::surface::Surface;
use crate::contact::{Contact, Distance, Site, SurfacePoint, SurfaceState};
use crate::math::Vec3;

/// Kinds of contact, as they enter the key.
pub(crate) const KEY_VERTEX: u32 = 1 << 24;
pub(crate) const KEY_POINT: u32 = 2 << 24;
pub(crate) const KEY_SEGMENT: u32 = 3 << 24;
pub(crate) const KEY_RIGID: u32 = 4 << 24;
pub(crate) const KEY_SOFT_SOFT: u32 = 5 << 24;

/// One surface and one rigid body, in one step.
pub(crate) struct SoftRigid<'a> {
    pub h: f64,
    pub margin: f64,
    /// Index of the deformable body.
    pub soft: u32,
    pub surface: &'a Surface,
    pub state: SurfaceState<'a>,
    /// Index of the rigid body.
    pub rigid: u32,
    pub body: &'a RigidBody,
    pub placed: &'a Placed,
    pub friction: f64,
}

/// Per-vertex results kept for the search between vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct VertexScratch {
    /// Place in the shape frame.
    pub places: Vec<Vec3>,
    /// Motion relative to the shape in this step, in its frame.
    pub motions: Vec<Vec3>,
    /// Distance to the shape; infinite when out of reach.
    pub gaps: Vec<f64>,
}

impl VertexScratch {
    pub fn with_size(vertices: usize) -> Self {
        Self {
            places: vec![Vec3::zeros(); vertices],
            motions: vec![Vec3::zeros(); vertices],
            gaps: vec![f64::INFINITY; vertices],
        }
    }
}

impl SoftRigid<'_> {
    /// All contacts of the pair: first of the vertices, then of what they miss.
    pub fn find(
        &self,
        memory: &mut Memory,
        remember: bool,
        vertices: &mut VertexScratch,
        features: &mut FeatureScratch,
        out: &mut Collector,
    ) {
        let has_features = !self.body.features.is_empty();
        // A triangle that a feature could touch has a vertex within this distance of the shape,
        // with a third to spare for stretching.
        let stretched = 0.77 * self.surface.edge_max + soft_feature::depth_max(self);
        let feature_reach = if has_features { stretched } else { 0.0 };
        let mut near = false;
        for v in 0..self.state.positions.len() {
            let gap = self.vertex(v, feature_reach, memory, remember, vertices, out);
            vertices.gaps[v] = gap;
            near |= gap < f64::INFINITY;
        }
        if has_features && near {
            soft_feature::find(self, vertices, features, out);
        }
    }

    /// Tests one vertex; returns its distance to the shape, infinite when out of reach.
    fn vertex(
        &self,
        v: usize,
        feature_reach: f64,
        memory: &mut Memory,
        remember: bool,
        scratch: &mut VertexScratch,
        out: &mut Collector,
    ) -> f64 {
        let p_W = self.state.positions[v];
        let p = self.placed.shape_point(&p_W);
        let slip_W = self.state.velocities[v] - self.placed.velocity_at(&p_W);
        let u = self.placed.rotation.tr_mul(&slip_W) * self.h;
        scratch.places[v] = p;
        scratch.motions[v] = u;
        let reach = feature_reach.max(self.margin + u.norm());
        if self.body.bounds_S.distance_squared(&p) > reach * reach {
            return f64::INFINITY;
        }
        let shape = &self.body.shape;
        let now = shape.distance(&p);
        let memory_index = self.surface.first_vertex + v;
        let seen = memory.recall(memory_index, self.rigid);
        let sided = keep_side(shape, &p, &u, now, seen);
        let found = if sided.value <= self.margin {
            Some(sided)
        } else {
            approach(shape, &p, &u, 0.0, self.margin)
        };
        if let Some(distance) = found {
            if remember {
                // While a point is on the wrong side, where it came from stays the last good place.
                let corrected = sided.gradient != now.gradient;
                let place = seen.filter(|_| corrected).map_or(p, |s| s.place);
                let normal = distance.gradient;
                memory.note(memory_index, self.rigid, Seen { normal, place });
            }
            out.push(self.vertex_contact(v as u32, p_W, distance));
        }
        sided.value
    }

    fn vertex_contact(&self, v: u32, p_W: Vec3, distance: Distance) -> Contact {
        let normal_W = self.placed.rotation * distance.gradient;
        Contact {
            key: feature_key([KEY_VERTEX | self.soft, self.rigid, v, 0]),
            a: Site::Soft(SurfacePoint::vertex(self.soft, v)),
            b: Site::Rigid { body: self.rigid, offset_W: p_W - self.placed.center_of_mass },
            position_W: p_W,
            normal_W,
            gap: distance.value,
            friction: self.friction,
            area: self.surface.vertex_area(v, &normal_W, self.state.positions),
        }
    }
}
