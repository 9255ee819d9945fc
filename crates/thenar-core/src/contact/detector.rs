//! Broad phase, and the order in which everything is tested.

mod search;
mod two_rigid;

use crate::contact::aabb::Aabb;
use crate::contact::apart::SeparateTriangles;
use crate::contact::area::{self, AreaScratch, Skin};
use crate::contact::area_between::between_soft;
use crate::contact::collector::{Collector, KnownDepths};
use crate::contact::deepening::{Clusters, Displacements, RigidMove, Since};
use crate::contact::manifold::{DELIVERED_MAX, Manifold};
use crate::contact::pairs::PairTable;
use crate::contact::rigid_body::{Placed, RigidBody};
use crate::contact::rigid_pair::Reach;
use crate::contact::sides::{SeenSides, Sight};
use crate::contact::soft_feature::FeatureScratch;
use crate::contact::soft_pairs::{
    SoftPair, neighbors_at_rest, regions, soft_rigid_pairs, soft_soft_pairs,
};
use crate::contact::soft_rigid::VertexScratch;
use crate::contact::soft_soft::PairScratch;
use crate::contact::surface::Surface;
use crate::contact::{Contact, RigidPlace, SearchReport, Site, SurfaceState};
use crate::math::Vec3;
use crate::model::WorldDesc;

/// Finds contacts. Holds the constant part of the world's surfaces and shapes, and all work space;
/// what it must remember from step to step is in [`SeenSides`].
#[derive(Clone, Debug)]
pub struct Detector {
    pairs: PairTable,
    bodies: Vec<Option<RigidBody>>,
    surfaces: Vec<Surface>,
    soft_rigid: Vec<SoftPair>,
    soft_soft: Vec<SoftPair>,
    /// Per surface, its neighbouring parts, if it touches itself.
    apart: Vec<Option<SeparateTriangles>>,
    clusters: Vec<Clusters>,
    capacity: usize,
    /// Least thickness of a rigid body \[m\].
    thinnest: f64,
    scratch: Scratch,
}

/// Refilled in every search.
#[derive(Clone, Debug)]
struct Scratch {
    placed: Vec<Placed>,
    moves: Vec<RigidMove>,
    /// Rigid bodies with a shape, by where their boxes begin along x.
    order: Vec<u32>,
    bounds: Vec<SurfaceBounds>,
    vertices: VertexScratch,
    features: FeatureScratch,
    pair: PairScratch,
    manifold: Manifold,
    area: AreaScratch,
}

/// Box around a surface during the step, and the surface's motion.
#[derive(Clone, Copy, Debug)]
struct SurfaceBounds {
    swept: Aabb,
    drift: Vec3,
    spread: f64,
    refitted: bool,
}

impl SurfaceBounds {
    const EMPTY: Self =
        Self { swept: Aabb::EMPTY, drift: Vec3::new(0.0, 0.0, 0.0), spread: 0.0, refitted: false };

    fn new(state: &SurfaceState, h: f64) -> Self {
        let moved = state.positions.iter().zip(state.velocities).map(|(p, v)| p + h * v);
        let swept = moved.fold(Aabb::of_points(state.positions), |b, p| b.with(&p));
        let count = state.velocities.len().max(1) as f64;
        let drift = state.velocities.iter().sum::<Vec3>() / count;
        let spread = state.velocities.iter().map(|v| (v - drift).norm_squared());
        let spread = spread.fold(0.0, f64::max).sqrt();
        Self { swept, drift, spread, refitted: false }
    }
}

impl Detector {
    /// Prepares for a (valid) world.
    pub fn new(desc: &WorldDesc) -> Self {
        let mut surfaces = Vec::with_capacity(desc.softs.len());
        let mut vertices = 0;
        for (i, soft) in desc.softs.iter().enumerate() {
            let regions = regions(desc, i).of_vertex;
            surfaces.push(Surface::new(i as u32, &soft.flesh, vertices, &regions));
            vertices += soft.flesh.collision.vertices.len();
        }
        // Two points within each triangle that an edge may cross.
        let edges = surfaces.iter().map(|s| s.edge_mean).filter(|edge| *edge > 0.0);
        let spacing = 0.5 * edges.fold(f64::INFINITY, f64::min);
        let bodies: Vec<_> = desc.rigids.iter().map(|r| RigidBody::new(r, spacing)).collect();
        let pairs = PairTable::new(desc);
        let soft_rigid = soft_rigid_pairs(&pairs, &surfaces, &bodies);
        let apart = neighbors_at_rest(desc, &surfaces);
        let soft_soft = soft_soft_pairs(&pairs, &surfaces, &apart);
        let shaped = bodies.iter().flatten().count();
        let capacity = 3 * vertices + 4 * DELIVERED_MAX * shaped;
        Self {
            clusters: surfaces.iter().map(Clusters::new).collect(),
            capacity,
            thinnest: bodies.iter().flatten().map(|b| b.thickness).fold(f64::INFINITY, f64::min),
            scratch: Scratch::new(&bodies, &surfaces, capacity),
            pairs,
            bodies,
            surfaces,
            soft_rigid,
            soft_soft,
            apart,
        }
    }

    /// Takes over friction and pair rules from a description of the same bodies, and remembers
    /// what it did.
    pub fn retune(&mut self, desc: &WorldDesc) {
        for (body, rigid) in self.bodies.iter_mut().zip(&desc.rigids) {
            if let Some(body) = body {
                body.friction = rigid.friction;
            }
        }
        for (surface, soft) in self.surfaces.iter_mut().zip(&desc.softs) {
            surface.friction = soft.flesh.friction;
        }
        let wanted = |(i, apart): (usize, &Option<SeparateTriangles>)| {
            apart.is_some() == desc.self_contact.contains(&(i as u32))
        };
        if !self.apart.iter().enumerate().all(wanted) {
            self.apart = neighbors_at_rest(desc, &self.surfaces);
        }
        self.pairs = PairTable::new(desc);
        self.soft_rigid = soft_rigid_pairs(&self.pairs, &self.surfaces, &self.bodies);
        self.soft_soft = soft_soft_pairs(&self.pairs, &self.surfaces, &self.apart);
    }

    /// Most contacts ever delivered: three per surface vertex and 48 per rigid body with a shape.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Finds what touches, or may touch within the step, and puts it into `out`.
    ///
    /// A contact is made where the gap is below the margin, or where the given velocities close it
    /// to below the margin within the step; best given are the velocities expected without contact,
    /// which include this step's forces. `rigids` has one entry per rigid body; `surfaces` holds
    /// the collision vertices of all deformable bodies, one after another. `out` is emptied, and
    /// allocates only if its capacity is below [`Detector::capacity`]. `before` are the sides seen
    /// in the step before (empty when bodies were put elsewhere instead of moving there), `now`
    /// receives those of this one.
    pub fn find(
        &mut self,
        reach: Reach,
        rigids: &[RigidPlace],
        surfaces: SurfaceState<'_>,
        before: &SeenSides,
        now: &mut SeenSides,
        out: &mut Vec<Contact>,
    ) -> SearchReport {
        debug_assert_eq!(rigids.len(), self.bodies.len(), "places, rigid bodies");
        let vertices = self.surfaces.iter().map(Surface::vertex_count).sum();
        let given = [surfaces.positions.len(), surfaces.velocities.len()];
        debug_assert_eq!(given, [vertices; 2], "places and velocities, vertices of surfaces");
        debug_assert!(reach.h >= 0.0 && reach.h.is_finite(), "a look ahead by {} s", reach.h);
        now.clear();
        let mut collector = Collector::into(out, self.capacity);
        let mut sight = Sight { before, now: Some(now) };
        self.search(reach, rigids, surfaces, None, &mut sight, &mut collector);
        now.sort();
        collector.finish()
    }

    /// Returns the least thickness of a rigid body \[m\].
    pub(crate) fn thinnest(&self) -> f64 {
        self.thinnest
    }

    /// Returns the distance that a rigid body's shape reaches from its centre of mass \[m\]; zero
    /// without a shape, and for a half-space.
    pub(crate) fn radius(&self, rigid: usize) -> f64 {
        self.bodies[rigid].as_ref().map_or(0.0, |body| body.radius)
    }

    /// Most sides worth keeping, and most places: a vertex is rarely near more than four bodies.
    pub fn sides_max(&self) -> usize {
        4 * self.surfaces.iter().map(Surface::vertex_count).sum::<usize>()
    }

    /// Deepest penetration of this state \[m\] over the same pairs; zero when nothing overlaps.
    pub fn penetration(
        &mut self,
        rigids: &[RigidPlace],
        surfaces: SurfaceState<'_>,
        before: &SeenSides,
    ) -> f64 {
        self.measure(rigids, surfaces, before, KnownDepths::default(), None).penetration
    }

    /// Deepest penetration \[m\] of those that are not known of their bodies; zero when none is.
    /// Looked for where something near has moved since by more than the slack past something else.
    pub(crate) fn deepening(
        &mut self,
        rigids: &[RigidPlace],
        surfaces: SurfaceState<'_>,
        before: &SeenSides,
        known: KnownDepths<'_>,
        moved: Displacements<'_>,
    ) -> f64 {
        self.measure(rigids, surfaces, before, known, Some(moved)).penetration
    }

    /// Looks for overlaps: of all pairs or, with `moved`, of those that may have got deeper.
    pub(super) fn measure(
        &mut self,
        rigids: &[RigidPlace],
        surfaces: SurfaceState<'_>,
        before: &SeenSides,
        known: KnownDepths<'_>,
        moved: Option<Displacements<'_>>,
    ) -> SearchReport {
        let mut collector = Collector::measuring(known);
        let mut sight = Sight { before, now: None };
        let reach = Reach { h: 0.0, margin: 0.0 };
        let mut moves = std::mem::take(&mut self.scratch.moves);
        let since = moved.map(|moved| {
            for (i, body) in self.bodies.iter().enumerate() {
                if let Some(body) = body {
                    moves[i] = RigidMove::new(body, &moved.poses_WB[i], &rigids[i].pose_WB);
                }
            }
            Since {
                rigids: &moves,
                ends: (moved.poses_WB, rigids),
                vertices: moved.vertices,
                known,
            }
        });
        self.search(reach, rigids, surfaces, since, &mut sight, &mut collector);
        self.scratch.moves = moves;
        collector.finish()
    }

    /// The area \[m²\] over which each of these contacts touches with bodies where they are now:
    /// see [`area`]. Zero between rigid bodies, and where surfaces do not touch, unless the contact
    /// bore load: `force_W` gives each contact's force on its first side \[N\].
    pub fn areas(
        &mut self,
        rigids: &[RigidPlace],
        positions: &[Vec3],
        contacts: &[Contact],
        areas: &mut [f64],
        force_W: impl Fn(usize) -> Vec3,
    ) {
        let Self { bodies, surfaces, scratch, .. } = self;
        let skin = |soft: u32| {
            let surface = &surfaces[soft as usize];
            let vertices = surface.first_vertex..surface.first_vertex + surface.vertex_count();
            Skin { surface, x: &positions[vertices] }
        };
        for run in area::runs(contacts) {
            let bears = |i: usize| force_W(run.start + i) != Vec3::zeros();
            let (of, areas) = (&contacts[run.clone()], &mut areas[run.clone()]);
            match (&of[0].a, &of[0].b) {
                (Site::Soft(a), Site::Rigid { body: i, .. }) => {
                    let Some(body) = &bodies[*i as usize] else { continue };
                    let placed = body.place(&rigids[*i as usize], 0.0);
                    let body = (body, &placed);
                    area::with_rigid(skin(a.soft), body, of, areas, bears, &mut scratch.area);
                }
                (Site::Soft(a), Site::Soft(b)) => {
                    let gap = |c: &Contact| {
                        let at = |site: &Site| match site {
                            Site::Soft(point) => point.interpolate(skin(point.soft).x),
                            Site::Rigid { .. } => Vec3::zeros(),
                        };
                        c.normal_W.dot(&(at(&c.a) - at(&c.b)))
                    };
                    let skins = [skin(a.soft), skin(b.soft)];
                    between_soft(skins, of, gap, areas, bears, &mut scratch.area);
                    let skins = if a.soft == b.soft { &skins[..1] } else { &skins };
                    let load = |i: usize| of[i].normal_W.dot(&force_W(run.start + i));
                    scratch.area.patches.stand_for(skins, of, areas, load);
                }
                (Site::Rigid { .. }, _) => areas.fill(0.0),
            }
        }
    }

    /// Least areas of contacts of the first soft surface, with rigid bodies too.
    #[cfg(test)]
    pub fn stand_for(
        &mut self,
        x: &[Vec3],
        contacts: &[Contact],
        areas: &mut [f64],
        load: impl Fn(usize) -> f64,
    ) {
        let skin = Skin { surface: &self.surfaces[0], x };
        self.scratch.area.patches.stand_for(&[skin], contacts, areas, load);
    }

    /// Goes through all pairs or, with `since`, those that may be deeper in each other now.
    fn search(
        &mut self,
        reach: Reach,
        rigids: &[RigidPlace],
        surfaces: SurfaceState<'_>,
        since: Option<Since>,
        sight: &mut Sight,
        out: &mut Collector,
    ) {
        for (i, body) in self.bodies.iter().enumerate() {
            if let Some(body) = body {
                let placed = &mut self.scratch.placed[i];
                *placed = body.place(&rigids[i], reach.h);
                if let Some(since) = since.filter(|s| s.goes_farther(i as u32, self.thinnest)) {
                    placed.swept_W = since.swept(i as u32, body, placed);
                }
            }
        }
        for (bounds, surface) in self.scratch.bounds.iter_mut().zip(&self.surfaces) {
            *bounds = SurfaceBounds::new(&surface.own(surfaces), reach.h);
        }
        if let Some(since) = since {
            for (clusters, surface) in self.clusters.iter_mut().zip(&self.surfaces) {
                clusters.fit(surface.part(surfaces.positions), surface.part(since.vertices));
            }
        }
        self.rigid_rigid(reach, since, out);
        for i in 0..self.soft_rigid.len() {
            self.soft_rigid(self.soft_rigid[i], reach, surfaces, since, sight, out);
        }
        for i in 0..self.soft_soft.len() {
            self.soft_soft(self.soft_soft[i], reach, surfaces, since, sight, out);
        }
    }
}

impl Scratch {
    /// Builds a detector with room for `contacts` contacts.
    fn new(bodies: &[Option<RigidBody>], surfaces: &[Surface], contacts: usize) -> Self {
        let vertices = surfaces.iter().map(Surface::vertex_count).max().unwrap_or(0);
        let all = surfaces.iter().map(Surface::vertex_count).sum();
        let triangles = surfaces.iter().map(|s| s.triangles.len()).max().unwrap_or(0);
        let shaped = bodies.iter().enumerate().filter_map(|(i, b)| b.as_ref().map(|b| (i, b)));
        let points = shaped.clone().map(|(_, b)| b.sharp.points.len()).max().unwrap_or(0);
        Self {
            placed: vec![Placed::NOWHERE; bodies.len()],
            moves: vec![RigidMove::NONE; bodies.len()],
            order: shaped.map(|(i, _)| i as u32).collect(),
            bounds: vec![SurfaceBounds::EMPTY; surfaces.len()],
            vertices: VertexScratch::with_size(vertices, all),
            features: FeatureScratch::with_size(points, triangles),
            pair: PairScratch::with_size(vertices, triangles),
            manifold: Manifold::new(),
            area: AreaScratch::with_size(triangles, vertices, contacts),
        }
    }
}
