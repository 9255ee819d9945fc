//! Contact per vertex of deformable surfaces.

use crate::World;
use crate::contact::{Site, stands_for};
use crate::math::Vec3;
use crate::readout::SlipState;
use crate::world::ContactPoint;
use std::ops::Range;

/// Contact that presses on one surface vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VertexContact {
    /// Force on it, world \[N\]: its share of the points near it.
    pub force_W: Vec3,
    /// Sum of its shares of normal forces \[N\].
    pub normal: f64,
    /// Mean direction in which they push, world; zero when nothing does.
    pub normal_W: Vec3,
    /// Surface that it stands for, a third of the triangles around it, seen along the normal
    /// \[m²\]; zero when nothing presses.
    pub area: f64,
    /// Normal force over area \[Pa\].
    pub pressure: f64,
    /// Tangential velocity against what it touches, mean by load, world \[m/s\].
    pub slip_W: Vec3,
    /// State of friction at the vertex.
    pub state: SlipState,
}

/// All surfaces of a world, with the triangles around each vertex.
#[derive(Clone, Debug)]
pub(super) struct Surfaces {
    ranges: Vec<Range<usize>>,
    vertices: Vec<VertexContact>,
    /// Load on sliding points at each vertex \[N\].
    slipping: Vec<f64>,
    /// Vertices with load.
    pressed: Vec<u32>,
    /// Corners of all triangles, numbered through.
    triangles: Vec<[u32; 3]>,
    /// Triangles around each vertex: where they begin in `around`; one more at the end.
    first: Vec<u32>,
    around: Vec<u32>,
    /// Load and direction at each vertex in the patch whose peak is sought, and the vertices with
    /// some.
    peak: Vec<(f64, Vec3)>,
    peak_vertices: Vec<u32>,
}

impl Surfaces {
    pub fn new(world: &World) -> Self {
        let mut ranges = Vec::new();
        let (mut start, mut triangles) = (0, Vec::new());
        for soft in &world.desc().softs {
            let surface = &soft.flesh.collision;
            ranges.push(start..start + surface.vertices.len());
            triangles.extend(surface.triangles.iter().map(|t| t.map(|v| v + start as u32)));
            start += surface.vertices.len();
        }
        let mut first = vec![0; start + 1];
        triangles.iter().flatten().for_each(|v| first[*v as usize + 1] += 1);
        (0..start).for_each(|v| first[v + 1] += first[v]);
        let mut next = first.clone();
        let mut around = vec![0; 3 * triangles.len()];
        for (t, corners) in (0..).zip(&triangles) {
            for v in corners {
                around[next[*v as usize] as usize] = t;
                next[*v as usize] += 1;
            }
        }
        Self {
            ranges,
            vertices: vec![VertexContact::default(); start],
            slipping: vec![0.0; start],
            pressed: Vec::with_capacity(start),
            triangles,
            first,
            around,
            peak: vec![(0.0, Vec3::zeros()); start],
            peak_vertices: Vec::with_capacity(start),
        }
    }

    pub fn vertices(&self, soft: u32) -> &[VertexContact] {
        &self.vertices[self.ranges[soft as usize].clone()]
    }

    pub fn read(&mut self, world: &World) {
        for v in self.pressed.drain(..) {
            self.vertices[v as usize] = VertexContact::default();
            self.slipping[v as usize] = 0.0;
        }
        for (contact, point) in world.contact_sites() {
            for (side, site) in [&contact.a, &contact.b].into_iter().enumerate() {
                self.add(site, point, side);
            }
        }
        for i in 0..self.pressed.len() {
            let v = self.pressed[i] as usize;
            let (slipping, mut vertex) = (self.slipping[v], self.vertices[v]);
            vertex.normal_W = direction(&vertex.normal_W);
            vertex.slip_W /= vertex.normal;
            vertex.area = self.area(world, v, &vertex.normal_W);
            vertex.pressure = if vertex.area > 0.0 { vertex.normal / vertex.area } else { 0.0 };
            vertex.state = SlipState::of(vertex.normal, slipping);
            self.vertices[v] = vertex;
        }
    }

    fn add(&mut self, site: &Site, point: &ContactPoint, side: usize) {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let normal = point.force_W.dot(&point.normal_W);
        for (v, share) in shares(&self.ranges, site).filter(|_| normal > 0.0) {
            let vertex = &mut self.vertices[v];
            if vertex.normal == 0.0 {
                self.pressed.push(v as u32);
            }
            let load = normal * share;
            vertex.force_W += point.force_W * (sign * share);
            vertex.normal += load;
            vertex.normal_W += point.normal_W * (sign * load);
            vertex.slip_W += point.slip_W * (sign * load);
            self.slipping[v] += if point.slips { load } else { 0.0 };
        }
    }

    /// Begins the search for the largest pressure of a patch.
    pub fn begin_peak(&mut self) {
        for v in self.peak_vertices.drain(..) {
            self.peak[v as usize] = (0.0, Vec3::zeros());
        }
    }

    /// Adds a point of the patch.
    pub fn add_peak(&mut self, site: &Site, point: &ContactPoint, side: usize) {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let normal = point.force_W.dot(&point.normal_W);
        for (v, share) in shares(&self.ranges, site).filter(|_| normal > 0.0) {
            if self.peak[v].0 == 0.0 {
                self.peak_vertices.push(v as u32);
            }
            self.peak[v].0 += normal * share;
            self.peak[v].1 += point.normal_W * (sign * normal * share);
        }
    }

    /// The largest pressure of the patch \[Pa\].
    pub fn peak(&self, world: &World) -> f64 {
        let pressure = |&v: &u32| {
            let (load, push_W) = self.peak[v as usize];
            let area = self.area(world, v as usize, &direction(&push_W));
            if area > 0.0 { load / area } else { 0.0 }
        };
        self.peak_vertices.iter().map(pressure).fold(0.0, f64::max)
    }

    /// A third of the triangles around a vertex that is pushed along `push_W`, as seen along it;
    /// all of them where none faces it.
    fn area(&self, world: &World, v: usize, push_W: &Vec3) -> f64 {
        let x = world.all_collision_vertices();
        let around = &self.around[self.first[v] as usize..self.first[v + 1] as usize];
        let corners = |t: &u32| self.triangles[*t as usize].map(|i| x[i as usize]);
        stands_for(around.iter().map(corners), push_W)
    }
}

/// The vertices that share a contact on a deformable side, and their shares.
fn shares<'a>(
    ranges: &'a [Range<usize>],
    site: &'a Site,
) -> impl Iterator<Item = (usize, f64)> + 'a {
    let point = match site {
        Site::Soft(point) => Some(point),
        Site::Rigid { .. } => None,
    };
    point.into_iter().flat_map(|point| {
        let first = ranges[point.soft as usize].start;
        let shares = point.vertices.iter().zip(point.weights);
        shares.filter(|(_, w)| *w != 0.0).map(move |(v, w)| (first + *v as usize, w))
    })
}

fn direction(sum_W: &Vec3) -> Vec3 {
    sum_W.try_normalize(1e-300).unwrap_or_else(Vec3::zeros)
}
