//! The surface of what is gripped, whatever it is: samples of it, the way through it, places that
//! move with it.

use serde::{Deserialize, Serialize};
use thenar_core::model::BodyId;
use thenar_core::shape::Shape;
use thenar_core::{Pose, Vec3, World};

/// Most samples of a surface.
pub const SAMPLES_MAX: usize = 700;
/// Least cells across the thinnest extent: a rod that is sampled from fewer has no two places that
/// face each other but at a slant.
const ACROSS: f64 = 5.0;
/// Rounds in which a point finds the surface by its distance.
const ROUNDS: usize = 24;
/// A point is on the surface when it is this near \[m\].
const NEAR: f64 = 1e-6;
/// Least step on the way through a body \[m\].
const WAY_MIN: f64 = 1e-4;
/// Longest way through a body that is looked for \[m\].
const WAY_MAX: f64 = 3.0;

/// A place of a surface that moves with its body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Anchor {
    /// A place of a rigid body \[m\] and the outward normal, in its frame B.
    Rigid {
        /// Number of the body.
        body: u32,
        /// Place on its surface, in its frame \[m\].
        point_B: Vec3,
        /// Outward normal there, in its frame.
        normal_B: Vec3,
    },
    /// A place of a triangle of a soft body's collision surface.
    Soft {
        /// Number of the body.
        body: u32,
        /// Corners of the triangle.
        vertices: [u32; 3],
        /// Barycentric weights.
        weights: [f64; 3],
    },
}

/// A place of a surface now, world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Place in the world \[m\].
    pub point: Vec3,
    /// Outward normal.
    pub normal: Vec3,
    /// This place on the body.
    pub anchor: Anchor,
}

impl Anchor {
    /// Returns its present place and outward normal, world.
    pub fn now(&self, world: &World) -> (Vec3, Vec3) {
        match self {
            Self::Rigid { body, point_B, normal_B } => {
                let pose = world.rigid_pose(*body);
                (pose.point(point_B), pose.vector(normal_B))
            }
            Self::Soft { body, vertices, weights } => {
                let all = world.collision_vertices(*body);
                let corners = vertices.map(|v| all[v as usize]);
                let point = (0..3).map(|k| corners[k] * weights[k]).sum();
                (point, normal(&corners))
            }
        }
    }

    /// True if it is a place of this world.
    pub fn fits(&self, world: &World) -> bool {
        match self {
            Self::Rigid { body, .. } => (*body as usize) < world.model().rigids.len(),
            Self::Soft { body, vertices, .. } => {
                let softs = &world.desc().softs;
                let count = softs.get(*body as usize).map(|s| s.flesh.collision.vertices.len());
                count.is_some_and(|n| vertices.iter().all(|v| (*v as usize) < n))
            }
        }
    }
}

fn normal([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a)).try_normalize(1e-300).unwrap_or_else(Vec3::y)
}

/// Fills `out` with places of the surface of a body within `radius` of `centre`, world \[m\],
/// evenly spread.
pub fn sample(world: &World, of: BodyId, centre: &Vec3, radius: f64, out: &mut Vec<Sample>) {
    out.clear();
    match of {
        BodyId::Rigid(body) => sample_rigid(world, body, centre, radius, out),
        BodyId::Soft(body) => sample_soft(world, body, centre, radius, out),
    }
}

/// Returns the place where a line from a place of the surface, inwards along `way` (a unit vector),
/// leaves the body again.
pub fn through(world: &World, from: &Sample, way: &Vec3) -> Option<Sample> {
    match from.anchor {
        Anchor::Rigid { body, .. } => through_rigid(world, body, &from.point, way),
        Anchor::Soft { body, .. } => through_soft(world, body, &from.point, way),
    }
}

/// The place of the surface of a body that is nearest to a point, world.
pub fn nearest(world: &World, of: BodyId, point: &Vec3) -> Option<Sample> {
    match of {
        BodyId::Rigid(body) => {
            let solid = Solid::of(world, body)?;
            Some(solid.on_surface(&solid.pose_WS.inverse_point(point)))
        }
        BodyId::Soft(body) => {
            let (triangles, x) = skin(world, body);
            let found = triangles.iter().map(|t| centroid(body, t, x));
            found.min_by(|a, b| {
                (a.point - point).norm_squared().total_cmp(&(b.point - point).norm_squared())
            })
        }
    }
}

/// From a point, world, to the surface of a body \[m\]; of a rigid one negative inside.
pub fn clearance(world: &World, of: BodyId, point: &Vec3) -> f64 {
    match of {
        BodyId::Rigid(body) => Solid::of(world, body).map_or(f64::INFINITY, |solid| {
            solid.shape.distance(&solid.pose_WS.inverse_point(point)).value
        }),
        BodyId::Soft(_) => {
            nearest(world, of, point).map_or(f64::INFINITY, |place| (place.point - point).norm())
        }
    }
}

/// A rigid body's shape in its place.
struct Solid<'a> {
    body: u32,
    shape: &'a Shape,
    pose_BS: Pose,
    pose_WS: Pose,
}

impl<'a> Solid<'a> {
    fn of(world: &'a World, body: u32) -> Option<Self> {
        let desc = &world.desc().rigids[body as usize];
        let shape = desc.shape.as_ref()?;
        let pose_WS = world.rigid_pose(body) * desc.pose_BS;
        Some(Self { body, shape, pose_BS: desc.pose_BS, pose_WS })
    }

    /// The place of the surface that is nearest to a point of the shape's frame, nearly.
    fn on_surface(&self, p_S: &Vec3) -> Sample {
        let mut at = *p_S;
        let mut distance = self.shape.distance(&at);
        for _ in 0..ROUNDS {
            if distance.value.abs() < NEAR {
                break;
            }
            at -= distance.gradient * distance.value;
            distance = self.shape.distance(&at);
        }
        let anchor = Anchor::Rigid {
            body: self.body,
            point_B: self.pose_BS.point(&at),
            normal_B: self.pose_BS.vector(&distance.gradient),
        };
        let (point, normal) = (self.pose_WS.point(&at), self.pose_WS.vector(&distance.gradient));
        Sample { point, normal, anchor }
    }
}

/// Half the extents of a box around a shape, and its middle, in the shape's frame \[m\].
pub fn bounds(shape: &Shape) -> [Vec3; 2] {
    let about = |half: Vec3| [Vec3::zeros(), half];
    match shape {
        Shape::Sphere { radius } => about(Vec3::repeat(*radius)),
        Shape::Capsule { radius, half_length } => {
            about(Vec3::new(*radius, half_length + radius, *radius))
        }
        Shape::Cuboid { half } | Shape::Ellipsoid { half } => about(*half),
        Shape::Cylinder { radius, half_length } => about(Vec3::new(*radius, *half_length, *radius)),
        Shape::Cone { radius, height } => {
            [Vec3::y() * (0.25 * height), Vec3::new(*radius, 0.5 * height, *radius)]
        }
        Shape::HalfSpace => about(Vec3::repeat(f64::INFINITY)),
        Shape::Mesh(mesh) => between(mesh.points.iter().copied()),
        Shape::Compound(parts) => between(parts.iter().flat_map(|part| {
            let [middle, half] = bounds(&part.shape);
            (0..8).map(move |k| {
                let sign = |bit: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
                let corner = Vec3::new(sign(0), sign(1), sign(2)).component_mul(&half);
                part.pose_SP.point(&(middle + corner))
            })
        })),
    }
}

fn between(points: impl Iterator<Item = Vec3>) -> [Vec3; 2] {
    let none = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
    let [low, high] = points.fold(none, |[low, high], p| [low.inf(&p), high.sup(&p)]);
    [(low + high) * 0.5, (high - low) * 0.5]
}

/// A lattice in the part of the shape's box that is near, brought to the surface along its
/// gradient.
fn sample_rigid(world: &World, body: u32, centre: &Vec3, radius: f64, out: &mut Vec<Sample>) {
    let Some(solid) = Solid::of(world, body) else { return };
    let [middle, half] = bounds(solid.shape);
    let centre_S = solid.pose_WS.inverse_point(centre);
    let low = (middle - half).sup(&centre_S.add_scalar(-radius));
    let high = (middle + half).inf(&centre_S.add_scalar(radius));
    let extent = high - low;
    if !extent.iter().all(|e| *e >= 0.0 && e.is_finite()) {
        return;
    }
    // As many cells along each edge as give about the number of samples wanted.
    let mut cell = extent.max() / 24.0;
    let count = |cell: f64| extent.map(|e| (e / cell).ceil().max(ACROSS));
    while count(cell).product() > SAMPLES_MAX as f64 {
        cell *= 1.05;
    }
    let n = count(cell);
    for k in 0..n.z as usize {
        for j in 0..n.y as usize {
            for i in 0..n.x as usize {
                let at = |i: usize, n: f64| (i as f64 + 0.5) / n;
                let u = Vec3::new(at(i, n.x), at(j, n.y), at(k, n.z));
                let found = solid.on_surface(&(low + extent.component_mul(&u)));
                if (found.point - centre).norm() <= radius && out.len() < SAMPLES_MAX {
                    out.push(found);
                }
            }
        }
    }
}

/// Steps as long as the depth allows.
fn through_rigid(world: &World, body: u32, from: &Vec3, way: &Vec3) -> Option<Sample> {
    let solid = Solid::of(world, body)?;
    let (at, way) = (solid.pose_WS.inverse_point(from), solid.pose_WS.inverse_vector(way));
    let mut s = WAY_MIN;
    while s < WAY_MAX {
        let distance = solid.shape.distance(&(at + way * s));
        if distance.value >= 0.0 {
            return Some(solid.on_surface(&(at + way * s)));
        }
        s += (-distance.value).max(WAY_MIN);
    }
    None
}

fn skin(world: &World, body: u32) -> (&[[u32; 3]], &[Vec3]) {
    let triangles = &world.desc().softs[body as usize].flesh.collision.triangles;
    (triangles, world.collision_vertices(body))
}

fn centroid(body: u32, triangle: &[u32; 3], x: &[Vec3]) -> Sample {
    let corners = triangle.map(|v| x[v as usize]);
    let anchor = Anchor::Soft { body, vertices: *triangle, weights: [1.0 / 3.0; 3] };
    Sample { point: corners.iter().sum::<Vec3>() / 3.0, normal: normal(&corners), anchor }
}

/// Middles of triangles at a regular stride.
fn sample_soft(world: &World, body: u32, centre: &Vec3, radius: f64, out: &mut Vec<Sample>) {
    let (triangles, x) = skin(world, body);
    let is_near = |s: &Sample| (s.point - centre).norm() <= radius;
    let all = || triangles.iter().map(|t| centroid(body, t, x)).filter(is_near);
    let every = all().count().div_ceil(SAMPLES_MAX).max(1);
    out.extend(all().step_by(every).take(SAMPLES_MAX));
}

/// The first triangle behind that the line leaves through.
fn through_soft(world: &World, body: u32, from: &Vec3, way: &Vec3) -> Option<Sample> {
    let (triangles, x) = skin(world, body);
    let cut = |t: &[u32; 3]| {
        let corners = t.map(|v| x[v as usize]);
        let (s, weights) = cut(from, way, &corners)?;
        let leaves = normal(&corners).dot(way) > 0.0 && s > WAY_MIN && s < WAY_MAX;
        leaves.then_some((s, weights, *t, corners))
    };
    let first = triangles.iter().filter_map(cut).min_by(|a, b| a.0.total_cmp(&b.0));
    first.map(|(s, weights, vertices, corners)| Sample {
        point: from + way * s,
        normal: normal(&corners),
        anchor: Anchor::Soft { body, vertices, weights },
    })
}

/// Cuts a triangle with a line: parameter along the line, and barycentric weights [Möller and
/// Trumbore 1997].
fn cut(from: &Vec3, way: &Vec3, [a, b, c]: &[Vec3; 3]) -> Option<(f64, [f64; 3])> {
    let (e, f) = (b - a, c - a);
    let p = way.cross(&f);
    let det = e.dot(&p);
    if det.abs() < 1e-300 {
        return None;
    }
    let to = from - a;
    let u = to.dot(&p) / det;
    let q = to.cross(&e);
    let v = way.dot(&q) / det;
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    inside.then(|| (f.dot(&q) / det, [1.0 - u - v, u, v]))
}
