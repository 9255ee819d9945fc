//! Deformable surfaces that have got into each other: where they are entangled.
//!
//! In contact surfaces overlap by the solver's tolerance. A start that overlaps, or a step that
//! could not be held, leaves parts deeper inside than the search near the surface looks. They are
//! found from where the surfaces cut each other: an edge that pierces a triangle has an end inside,
//! and from there the inside spreads along the edges of its own surface. What hangs together by
//! triangles that cut each other is one *region*.
//!
//! A region that is pressed in has come through the faces nearest to it, against its own normals:
//! each vertex goes back to its nearest place. Where bodies were put into each other, most vertices
//! are nearest to a face that they never came through, as those of a side wall are to the wall
//! beside it; such a region leaves as one, along one direction: see `soft_way`.
//!
//! ```text
//!      ┌────────┐          ○ vertices inside, × places where an edge goes through a face: by both is
//!   ┌──×────────×──┐       judged which way a region leaves, and led out are vertices, and places of
//!   │  ○────○───○  │       edges between outer ends
//! ```

mod lead_out;

use crate::capacity_vec::CapacityVec;
use crate::contact::sides::Sight;
use crate::contact::soft_soft::{SoftSide, SoftSoft};
use crate::contact::soft_way::Way;
use crate::contact::surface::Surface;
use crate::contact::triangle::{Closest, Feature, area_vector, closest_on_triangle};
use crate::contact::union_find::UnionFind;
use crate::math::Vec3;
use std::ops::Range;

pub(super) const NONE: u32 = u32::MAX;

/// Length of a way out, in depths of the deepest vertex, beyond which what touched before does not
/// leave as one: that would be a needle, in farther than three times its width; it is a seam, along
/// which edges go through each other.
const SLENDER: f64 = 6.0;

/// A vertex has come through its nearest face if the way back goes against its normal within 60°
/// (cosine). At an even corner of a cube the mean normal stands at 54.7° to those of its faces, and
/// counts; that of a wall stands at 90° to the way in along the wall, and does not. Unit tests hold
/// from 0.2 to 0.8.
const OPPOSED: f64 = 0.5;

/// An edge of side `side` that goes through triangle `through` of the other.
#[derive(Clone, Copy, Debug)]
struct EdgePiercing {
    side: usize,
    edge: (u32, usize),
    /// Part of the edge before that.
    at: f64,
    through: u32,
}

/// A point of one surface inside the other, or where it goes through.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    region: u32,
    pub side: usize,
    /// A vertex; `NONE` for a place on an edge.
    pub vertex: u32,
    /// Triangle and weights of its own surface.
    pub triangle: u32,
    pub weights: [f64; 3],
    /// For a place on an edge the triangle of the other surface through which it goes.
    pub through: u32,
    /// Between outer ends: no vertex leads the edge out.
    alone: bool,
    /// Position of the place; on an edge as far inside as counts.
    pub p: Vec3,
    /// Against the outward normal here, by area: the way that makes the common volume smaller.
    pub inward: Vec3,
    /// To the nearest place of the other surface, and its triangle and weights.
    pub out: Vec3,
    nearest: (u32, [f64; 3]),
}

impl Place {
    /// True when the vertex has come in through its nearest face.
    fn is_opposed(&self) -> bool {
        let least = OPPOSED * self.inward.norm() * self.out.norm();
        self.vertex != NONE && self.inward.dot(&self.out) > least
    }
}

/// Places `start..end` leave by `way`.
#[derive(Clone, Copy, Debug)]
struct Region {
    root: u32,
    start: usize,
    end: usize,
    way: Option<Way>,
    /// Most of it, by area, has come in through the nearest faces: so deep it is by these \[m\].
    pressed: Option<f64>,
    /// The region leaves as one, from deeper than the search near the surface looks.
    deep: bool,
}

/// Vertices of one side that are, or may be, inside the other.
#[derive(Clone, Debug, Default)]
struct FloodFill {
    queue: CapacityVec<u32>,
    /// Marks the vertices that have been in the queue.
    queued: Vec<bool>,
    /// Marks the vertices that are inside.
    inside: Vec<bool>,
}

impl FloodFill {
    fn with_size(vertices: usize) -> Self {
        let no = vec![false; vertices];
        Self { queue: CapacityVec::with_capacity(vertices), queued: no.clone(), inside: no }
    }

    /// Each vertex is looked at once.
    fn add(&mut self, v: u32) {
        if !std::mem::replace(&mut self.queued[v as usize], true) {
            self.queue.push(v);
        }
    }

    fn clear(&mut self) {
        for v in self.queue.drain(..) {
            self.queued[v as usize] = false;
            self.inside[v as usize] = false;
        }
    }
}

/// Workspace of the search for entangled regions.
#[derive(Clone, Debug, Default)]
pub(super) struct DeepScratch {
    floods: [FloodFill; 2],
    pierces: CapacityVec<EdgePiercing>,
    places: CapacityVec<Place>,
    regions: CapacityVec<Region>,
    /// Triangles of A, then of B.
    groups: UnionFind,
    triangles: usize,
    /// No more places are kept.
    most: usize,
}

impl DeepScratch {
    /// Room for surfaces of up to this many vertices and triangles.
    pub fn with_size(vertices: usize, triangles: usize) -> Self {
        let most = 2 * vertices + triangles;
        Self {
            floods: [0, 1].map(|_| FloodFill::with_size(vertices)),
            pierces: CapacityVec::with_capacity(most),
            places: CapacityVec::with_capacity(most),
            regions: CapacityVec::with_capacity(most),
            groups: UnionFind::with_size(2 * triangles),
            triangles,
            most,
        }
    }

    /// True when an entangled region leads out vertex `v` of side `i`.
    pub fn leads(&self, i: usize, v: u32, surface: &Surface) -> bool {
        self.floods[i].inside[v as usize] && self.is_deep(i, surface.around(v)[0])
    }

    /// True when triangle `t` of side `i` belongs to a region that is led out as one.
    pub fn is_deep(&self, i: usize, t: u32) -> bool {
        if self.regions.is_empty() {
            return false;
        }
        let root = self.groups.find(self.node(i, t));
        let at = self.regions.binary_search_by_key(&root, |region| region.root);
        at.is_ok_and(|at| self.regions[at].deep)
    }

    fn places(&self, range: Range<usize>) -> &[Place] {
        &self.places[range]
    }

    fn node(&self, i: usize, t: u32) -> u32 {
        (i * self.triangles) as u32 + t
    }

    fn clear(&mut self) {
        self.floods.iter_mut().for_each(FloodFill::clear);
        self.pierces.clear();
        self.places.clear();
        self.regions.clear();
        self.groups.clear();
    }
}

impl SoftSoft<'_> {
    /// The side that a triangle of B counts for: of one surface there is but one.
    fn second(&self) -> usize {
        usize::from(self.apart.is_none())
    }

    /// Notes where the edges of two triangles pierce the other one, over whose plane their corners
    /// have these heights (`Facet::heights`).
    pub(super) fn pierce(&self, [s, t]: [u32; 2], heights: &[[f64; 3]; 2], deep: &mut DeepScratch) {
        let [a, b] = [&self.a, &self.b];
        self.pierce_from((0, a, s), &heights[0], (b, t), deep);
        self.pierce_from((self.second(), b, t), &heights[1], (a, s), deep);
    }

    fn pierce_from(
        &self,
        (side, own, s): (usize, &SoftSide, u32),
        height: &[f64; 3],
        (other, t): (&SoftSide, u32),
        deep: &mut DeepScratch,
    ) {
        if height.iter().all(|h| *h > 0.0) || height.iter().all(|h| *h <= 0.0) {
            return;
        }
        let (p, x) = (own.corners(s), other.corners(t));
        let area = other.surface.facets[t as usize].area;
        let corners = own.surface.triangles[s as usize];
        let entered = -other.surface.entered() * area.norm();
        for k in 0..3 {
            let (i, j) = (k, (k + 1) % 3);
            let (inner, outer) = if height[i] < height[j] { (i, j) } else { (j, i) };
            if height[inner] > entered
                || height[outer] <= 0.0
                || !own.surface.owns(s, Feature::Edge(k))
                || self.is_neighbor(own, s, k, t)
            {
                continue;
            }
            let at = height[i] / (height[i] - height[j]);
            let cut = p[i] + at * (p[j] - p[i]);
            let is_inside = |k: usize| {
                let edge = x[(k + 1) % 3] - x[k];
                area.dot(&edge.cross(&(cut - x[k]))) >= 0.0
            };
            if (0..3).all(is_inside) {
                deep.floods[side].add(corners[inner]);
                if deep.pierces.len() < deep.most {
                    deep.pierces.push(EdgePiercing { side, edge: (s, k), at, through: t });
                }
            }
        }
    }

    /// Finds what is entangled and how it leaves.
    pub(super) fn entangle(&self, sight: &Sight, deep: &mut DeepScratch) {
        let sides = 0..=self.second();
        if self.apart.is_none() && deep.pierces.is_empty() {
            sides.clone().for_each(|i| self.swallow(i, deep));
        }
        if deep.floods.iter().all(|flood| flood.queue.is_empty()) {
            return;
        }
        sides.for_each(|i| self.flood(i, deep));
        self.tie(deep);
        if self.apart.is_some() {
            self.keep_entangled(deep);
        }
        let DeepScratch { places, groups, triangles, .. } = deep;
        for place in places.iter_mut() {
            place.region = groups.find((place.side * *triangles) as u32 + place.triangle);
        }
        // Of each region the deepest first.
        let key = |p: &Place| (p.region, p.side, p.vertex, p.triangle, p.through);
        places.sort_unstable_by(|a, b| {
            let deeper = b.out.norm_squared().total_cmp(&a.out.norm_squared());
            a.region.cmp(&b.region).then(deeper).then(key(a).cmp(&key(b)))
        });
        let mut start = 0;
        while start < deep.places.len() {
            let root = deep.places[start].region;
            let count = deep.places[start..].iter().take_while(|p| p.region == root).count();
            let end = start + count;
            let region = self.region(root, start..end, sight, deep);
            deep.regions.push(region);
            start = end;
        }
    }

    /// Keeps, of one surface in itself, the places whose nearest face is cut: what lies inside a
    /// fold of its own part is nearest to a face that nothing cuts, and that is no way back.
    fn keep_entangled(&self, deep: &mut DeepScratch) {
        let DeepScratch { floods: [flood, _], pierces, places, .. } = deep;
        let entered = |t: u32| {
            let mut corners = self.a.surface.triangles[t as usize].into_iter();
            corners.any(|v| flood.inside[v as usize]) || pierces.iter().any(|p| p.through == t)
        };
        places.retain(|place| place.vertex == NONE || entered(place.nearest.0));
        flood.inside.fill(false);
        let kept = places.iter().filter(|place| place.vertex != NONE);
        kept.for_each(|place| flood.inside[place.vertex as usize] = true);
    }

    fn region(&self, root: u32, range: Range<usize>, sight: &Sight, deep: &DeepScratch) -> Region {
        let places = deep.places(range.clone());
        let opposed = || places.iter().filter(|p| p.is_opposed());
        let area = |p: &Place| p.inward.norm();
        let vertices = places.iter().filter(|p| p.vertex != NONE);
        let is_pressed = 2.0 * opposed().map(area).sum::<f64>() > vertices.map(area).sum();
        let deepest = opposed().map(|p| p.out.norm()).fold(0.0, f64::max);
        let pressed = is_pressed.then_some(deepest);
        let all_opposed = is_pressed && opposed().count() == places.len();
        // Parts of one surface only go back where they came in.
        let as_one = !all_opposed && self.apart.is_none() && self.was_put(places, sight);
        let way = if as_one { self.way(places, sight) } else { None };
        let way = way.filter(|way| !self.is_seam(places, way, sight));
        let deep = !is_pressed && way.is_some_and(|way| way.relative > 1.0);
        Region { root, start: range.start, end: range.end, way, pressed, deep }
    }

    /// True when places that would leave by a way belong to a seam: some touched before, and
    /// vertices are inside, but none far. A region without a vertex inside is a seam if each of its
    /// edges has an end that touched before.
    fn is_seam(&self, places: &[Place], way: &Way, sight: &Sight) -> bool {
        let inside = |p: &Place| p.out.norm() / self.depth(self.facing(p.side)[1]);
        let deepest = places.iter().map(inside).fold(0.0, f64::max);
        let mut touched = places.iter().map(|p| self.has_touched(p, sight));
        if deepest > 0.0 {
            way.relative > SLENDER * deepest && touched.any(|touched| touched)
        } else {
            touched.all(|touched| touched)
        }
    }

    /// True when a vertex, or an end of an edge, saw the other surface in the step before.
    fn has_touched(&self, place: &Place, sight: &Sight) -> bool {
        let [own, other] = self.facing(place.side);
        let corners = own.surface.triangles[place.triangle as usize];
        let ends = corners.into_iter().zip(place.weights).filter(|(_, weight)| *weight > 0.0);
        let seen = |v: u32| sight.recall(own.surface.first_vertex + v as usize, other.id);
        ends.into_iter().any(|(v, _)| seen(v).is_some())
    }

    /// A whole surface inside the other cuts nothing.
    fn swallow(&self, i: usize, deep: &mut DeepScratch) {
        let [own, other] = self.facing(i);
        let (inner, outer) = (own.surface.tree.bounds(), other.surface.tree.bounds());
        if !inner.is_empty() && outer.contains(&inner.min) && outer.contains(&inner.max) {
            deep.floods[i].add(0);
        }
    }

    /// Looks at all that may be inside, from neighbour to neighbour.
    fn flood(&self, i: usize, deep: &mut DeepScratch) {
        let [own, other] = self.facing(i);
        let mut next = 0;
        while next < deep.floods[i].queue.len() {
            let v = deep.floods[i].queue[next];
            next += 1;
            let Some((out, nearest)) = self.inside(own, other, v) else { continue };
            let around = own.surface.around(v);
            let root = deep.node(i, around[0]);
            around.iter().for_each(|&t| deep.groups.union(root, (i * deep.triangles) as u32 + t));
            deep.floods[i].inside[v as usize] = true;
            own.surface.neighbors_of(v, |w| deep.floods[i].add(w));
            let mut weights = [0.0; 3];
            let corners = own.surface.triangles[around[0] as usize];
            corners.iter().zip(&mut weights).for_each(|(&w, part)| *part = f64::from(w == v));
            deep.places.push(Place {
                region: 0,
                side: i,
                vertex: v,
                triangle: around[0],
                weights,
                through: NONE,
                alone: false,
                p: own.state.positions[v as usize],
                inward: -own.surface.vertex_normal(v, own.state.positions),
                out,
                nearest,
            });
        }
    }

    /// The way of a vertex that has got in to the nearest place of the other surface, and this;
    /// `None` outside.
    fn inside(&self, own: &SoftSide, other: &SoftSide, v: u32) -> Option<(Vec3, (u32, [f64; 3]))> {
        let p = own.state.positions[v as usize];
        let (t, nearest) = nearest_on(other, &p, f64::INFINITY, |t| !self.are_neighbors(v, t))?;
        let least = other.surface.entered();
        let depth = depth(other.surface, &p, t, &nearest, other.state.positions);
        if depth < least || !self.has_got_in(other, v, &p, (t, &nearest), depth) {
            return None;
        }
        Some((nearest.point - p, (t, nearest.weights)))
    }

    /// Joins what cuts each other, and adds the places where edges go through.
    fn tie(&self, deep: &mut DeepScratch) {
        let DeepScratch { floods, pierces, places, groups, triangles, most, .. } = deep;
        for &EdgePiercing { side, edge: (s, k), at, through } in pierces.iter() {
            let [own, other] = self.facing(side);
            let node = |i: usize, t: u32| (i * *triangles) as u32 + t;
            let across = own.surface.across(s, k);
            across.iter().for_each(|&u| groups.union(node(side, s), node(side, u)));
            if self.apart.is_none() {
                groups.union(node(side, s), node(1 - side, through));
            }
            let corners = own.surface.triangles[s as usize];
            let ends = [corners[k], corners[(k + 1) % 3]];
            if places.len() == *most {
                continue;
            }
            let x = own.state.positions;
            let mut weights = [0.0; 3];
            (weights[k], weights[(k + 1) % 3]) = (1.0 - at, at);
            let area = area_vector(&other.surface.corners(through, other.state.positions));
            let within =
                area.try_normalize(0.0).unwrap_or_else(Vec3::zeros) * other.surface.entered();
            let p: Vec3 = (0..3).map(|j| x[corners[j] as usize] * weights[j]).sum();
            let faces = [Some(s), across].into_iter().flatten();
            let inward: Vec3 = faces.map(|t| -area_vector(&own.surface.corners(t, x))).sum();
            places.push(Place {
                region: 0,
                side,
                vertex: NONE,
                triangle: s,
                weights,
                through,
                alone: ends.iter().all(|&v| !floods[side].inside[v as usize]),
                p: p - within,
                inward,
                out: Vec3::zeros(),
                nearest: (through, {
                    let x = other.surface.corners(through, other.state.positions);
                    closest_on_triangle(&p, &x).weights
                }),
            });
        }
    }
}

/// The nearest of those triangles within `reach` that `wanted` admits.
pub(super) fn nearest_on(
    side: &SoftSide,
    p: &Vec3,
    reach: f64,
    wanted: impl Fn(u32) -> bool,
) -> Option<(u32, Closest)> {
    let mut best: Option<(u32, Closest)> = None;
    side.surface.tree.nearest(0, p, reach * reach, |t| {
        if !wanted(t) {
            return f64::INFINITY;
        }
        let found = closest_on_triangle(p, &side.surface.corners(t, side.state.positions));
        let squared = found.distance_squared;
        // Of equally near triangles the lowest index.
        let is_nearest = best.is_none_or(|(u, b)| (squared, t) < (b.distance_squared, u));
        if is_nearest && squared <= reach * reach {
            best = Some((t, found));
        }
        squared
    });
    best
}

/// Returns the depth of `p` inside \[m\].
fn depth(surface: &Surface, p: &Vec3, t: u32, closest: &Closest, x: &[Vec3]) -> f64 {
    let outward = surface.pseudonormal(t, closest.feature, x);
    let distance = closest.distance_squared.sqrt();
    if outward.dot(&(p - closest.point)) < 0.0 { distance } else { -distance }
}
