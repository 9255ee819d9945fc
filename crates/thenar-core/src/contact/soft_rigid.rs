//! A deformable surface against a rigid shape.

use crate::capacity_vec::CapacityVec;
use crate::contact::approach::{LastSide, approach_from, keep_side};
use crate::contact::blunt::{blunted, has_edges};
use crate::contact::collector::{Collector, feature_key};
use crate::contact::rigid_body::{Placed, RigidBody};
use crate::contact::sides::Sight;
use crate::contact::soft_feature::{self, FeatureScratch};
use crate::contact::surface::Surface;
use crate::contact::triangle::ROUNDED_UP;
use crate::contact::{Contact, Distance, Shape, Site, SurfacePoint, SurfaceState};
use crate::math::Vec3;
use std::cell::Cell;

/// Kinds of contact, as they enter the key.
pub(crate) const KEY_VERTEX: u32 = 1 << 24;
pub(crate) const KEY_POINT: u32 = 2 << 24;
pub(crate) const KEY_SEGMENT: u32 = 3 << 24;
pub(crate) const KEY_RIGID: u32 = 4 << 24;
pub(crate) const KEY_SOFT_SOFT: u32 = 5 << 24;
pub(crate) const KEY_CROSSING: u32 = 6 << 24;
pub(crate) const KEY_INSIDE: u32 = 7 << 24;
pub(crate) const KEY_PIERCED: u32 = 8 << 24;
pub(crate) const KEY_EDGE: u32 = 9 << 24;

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
    /// True when the body may be inside the surface; the surface's tree is then up to date.
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
    pub near: CapacityVec<u32>,
    /// Per vertex of all surfaces, what is known of the last search.
    guesses: Vec<Guess>,
}

/// Place of a vertex near a mesh at the last search: spares much of the next search, and does not
/// change its result.
#[derive(Clone, Debug)]
struct Guess {
    /// The triangle that it was nearest to.
    item: Cell<u32>,
    /// The body to which the vertex was no nearer than `far` \[m\] when it was at this place in its
    /// frame.
    rigid: u32,
    place: Vec3,
    far: f64,
}

impl Guess {
    fn none() -> Self {
        let place = Vec3::zeros();
        Self { item: Cell::new(u32::MAX), rigid: u32::MAX, place, far: f64::NEG_INFINITY }
    }

    /// The distance to `shape` of body `rigid` from `p`, that moves by `u` in this step, if it is
    /// below `reach`.
    fn within(
        &mut self,
        shape: &Shape,
        rigid: u32,
        (p, u): (&Vec3, f64),
        reach: f64,
    ) -> Option<Distance> {
        if !shape.is_solid_mesh() {
            return shape.distance_within(p, reach);
        }
        let is_far = |at: &Self| at.far - (p - at.place).norm() * ROUNDED_UP >= reach;
        if self.rigid == rigid && is_far(self) {
            return None;
        }
        let found = shape.distance_within_near(p, reach, &self.item);
        let farther = BEYOND * reach;
        if found.is_none() && SEARCH_INTERVAL * u <= farther - reach {
            let there = shape.distance_within(p, farther);
            let far = there.map_or(farther, |d| d.value);
            (self.rigid, self.place, self.far) = (rigid, *p, far);
        }
        found
    }
}

/// Distance at which vertices out of reach are looked for, in parts of the reach, where they stay
/// there for some steps: less far is soon looked for again, and farther costs more. What is found
/// does not depend on this.
const BEYOND: f64 = 1.5;
/// Steps for which a vertex out of reach is not looked for again: a search farther out, once in
/// eight steps, costs each of them an eighth.
const SEARCH_INTERVAL: f64 = 8.0;
/// A third more than 1/√3, the distance of an equilateral triangle's corners from its middle in
/// edges, for stretching.
const TO_CORNER: f64 = 0.77;

impl VertexScratch {
    /// Room for surfaces of up to this many vertices, `all` together.
    pub fn with_size(vertices: usize, all: usize) -> Self {
        Self { near: CapacityVec::with_capacity(vertices), guesses: vec![Guess::none(); all] }
    }
}

impl SoftRigid<'_> {
    /// All contacts of the pair: first of the vertices, then of what they miss; while the body is
    /// inside the surface, those that lead it out.
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
            let guess = &mut vertices.guesses[self.surface.first_vertex + v];
            if self.vertex(v, feature_reach, is_inside, guess, sight, out) {
                vertices.near.push(v as u32);
            }
        }
        if has_features && !is_inside && !vertices.near.is_empty() {
            soft_feature::find(self, sight, vertices, features, out);
        }
    }

    /// A surface vertex and its motion in this step relative to the shape, in the shape frame.
    pub fn in_shape(&self, v: usize) -> (Vec3, Vec3) {
        let p_W = self.state.positions[v];
        let slip_W = self.state.velocities[v] - self.placed.velocity_at(&p_W);
        (self.placed.shape_point(&p_W), self.placed.rotation.tr_mul(&slip_W) * self.h)
    }

    /// A triangle that a feature could touch has a vertex within this distance of the shape.
    fn feature_reach(&self, v: usize) -> f64 {
        TO_CORNER * self.surface.edge_around[v] + soft_feature::depth_max(self)
    }

    /// Tests one vertex; false when the shape is out of its reach.
    /// A vertex that looks away from a body inside the surface does not touch it.
    fn vertex(
        &self,
        v: usize,
        feature_reach: f64,
        is_inside: bool,
        guess: &mut Guess,
        sight: &mut Sight,
        out: &mut Collector,
    ) -> bool {
        let (p, u) = self.in_shape(v);
        let reach = feature_reach.max(self.margin + u.norm());
        if self.body.bounds_S.distance_squared(&p) > reach * reach {
            return false;
        }
        let shape = &self.body.shape;
        let Some(now) = guess.within(shape, self.rigid, (&p, u.norm()), reach) else {
            return false;
        };
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
            sight.note(slot, self.rigid, LastSide { normal, place });
            out.push(self.vertex_contact(v as u32, distance));
        }
        sided.value < f64::INFINITY
    }

    /// A vertex at distance `now` does not feel how sharp an edge is, unless it was led out another
    /// way.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::MeshShape;
    use crate::contact::grid::tests::grid_of;
    use crate::contact::tests::{boxed, cube};
    use crate::random::Random;
    use std::sync::Arc;

    /// Points that wander about a cube, slowly and in leaps: each time it is as if they were looked
    /// for anew, and what is far is mostly known to be.
    #[test]
    fn what_is_remembered_changes_nothing() {
        let (points, triangles) = cube(0.04, 3);
        let mesh = MeshShape::new(points, triangles, grid_of(&boxed(0.02), 0.03, 13));
        let shape = Shape::Mesh(Arc::new(mesh));
        let (mut random, reach) = (Random::new(12), 0.008);
        let (mut near, mut far, mut known) = (0, 0, 0);
        for _ in 0..40 {
            let (mut p, mut guess) = (random.vector(0.05), Guess::none());
            for step in 0..100 {
                let u = random.vector(if step % 30 == 0 { 0.02 } else { 3e-4 });
                p += u;
                let kept = (guess.place, guess.far);
                let found = guess.within(&shape, 3, (&p, u.norm()), reach);
                let anew = shape.distance_within(&p, reach);
                assert_eq!(found.map(|d| d.value), anew.map(|d| d.value));
                assert_eq!(found.map(|d| d.gradient), anew.map(|d| d.gradient));
                match found {
                    Some(_) => near += 1,
                    None => far += 1,
                }
                known += u32::from(found.is_none() && kept == (guess.place, guess.far));
            }
        }
        assert!(near > 500 && far > 500 && 4 * known > 3 * far, "{near} {far} {known}");
    }
}
