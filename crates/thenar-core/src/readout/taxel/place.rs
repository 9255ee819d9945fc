//! Place of a taxel on a surface.

use crate::contact::{closest_on_triangle, cut_by_ray};
use crate::math::Vec3;
use crate::model::Flesh;

/// A place of a collision surface and a direction along it; both stay where they are on the skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaxelPlace {
    /// Corners of the triangle, by collision vertex.
    pub vertices: [u32; 3],
    /// Barycentric weights of the place, of sum 1.
    pub weights: [f64; 3],
    /// First shear axis, as a combination of the edges from the first corner to the second and to
    /// the third.
    pub along: [f64; 2],
}

/// The surface of a deformable body at rest, on which taxels are placed.
#[derive(Clone, Debug)]
pub struct TaxelSkin<'a> {
    flesh: &'a Flesh,
    /// Part of each collision vertex; empty when the body is one.
    parts: Vec<u8>,
    /// Collision vertices in the model frame M.
    rest: Vec<Vec3>,
}

impl<'a> TaxelSkin<'a> {
    /// The surface of this flesh; `parts` gives the part of each collision vertex, and is empty
    /// when the body is one.
    pub fn new(flesh: &'a Flesh, parts: Vec<u8>) -> Self {
        let mut rest = vec![Vec3::zeros(); flesh.collision.vertices.len()];
        flesh.collision.positions(&flesh.tets, &flesh.nodes, &mut rest);
        Self { flesh, parts, rest }
    }

    /// The place that is nearest to a point, among triangles with all corners in `part`. `along_M`
    /// is laid along the surface as the first shear axis. `None` when the part has no triangle.
    pub fn nearest(&self, part: u8, point_M: &Vec3, along_M: &Vec3) -> Option<TaxelPlace> {
        let is_in = |v: u32| self.parts.get(v as usize).copied().unwrap_or(0) == part;
        let own = self.flesh.collision.triangles.iter().filter(|t| t.iter().all(|v| is_in(*v)));
        let found = own.map(|t| (t, closest_on_triangle(point_M, &self.corners(t))));
        let nearest = found.min_by(|a, b| a.1.distance_squared.total_cmp(&b.1.distance_squared));
        nearest.map(|(vertices, closest)| TaxelPlace {
            vertices: *vertices,
            weights: closest.weights,
            along: combination(&self.corners(vertices), along_M),
        })
    }

    /// Returns the distance from a point to the surface in a direction, in lengths of that; `None`
    /// where the ray misses it.
    pub fn way(&self, from_M: &Vec3, direction_M: &Vec3) -> Option<f64> {
        let triangles = self.flesh.collision.triangles.iter();
        let ways = triangles.filter_map(|t| cut_by_ray(from_M, direction_M, &self.corners(t)));
        ways.map(|(way, _)| way).min_by(f64::total_cmp)
    }

    fn corners(&self, triangle: &[u32; 3]) -> [Vec3; 3] {
        triangle.map(|v| self.rest[v as usize])
    }
}

impl TaxelPlace {
    /// The place, with collision vertices there.
    pub fn on(&self, vertices: &[Vec3]) -> Vec3 {
        (0..3).map(|k| vertices[self.vertices[k] as usize] * self.weights[k]).sum()
    }

    /// The first shear axis with collision vertices there, of any length.
    pub(super) fn along_on(&self, vertices: &[Vec3]) -> Vec3 {
        let [a, b, c] = self.vertices.map(|v| vertices[v as usize]);
        (b - a) * self.along[0] + (c - a) * self.along[1]
    }

    /// The corner that it is nearest to, by weight.
    pub(super) fn nearest_vertex(&self) -> u32 {
        let most = (0..3).max_by(|a, b| self.weights[*a].total_cmp(&self.weights[*b]));
        self.vertices[most.unwrap_or(0)]
    }

    /// True when it is on one of these triangles.
    pub(super) fn is_on(&self, triangles: &[[u32; 3]]) -> bool {
        let sum: f64 = self.weights.iter().sum();
        let inside = self.weights.iter().all(|w| (-1e-9..=1.0 + 1e-9).contains(w));
        inside
            && (sum - 1.0).abs() < 1e-9
            && self.along.iter().all(|a| a.is_finite())
            && triangles.contains(&self.vertices)
    }
}

/// A direction in a triangle's plane as a combination of its edges from corner 0; the first edge
/// where it has none.
fn combination(corners: &[Vec3; 3], direction: &Vec3) -> [f64; 2] {
    let (e, f) = (corners[1] - corners[0], corners[2] - corners[0]);
    let (ee, ef, ff) = (e.norm_squared(), e.dot(&f), f.norm_squared());
    let (de, df) = (direction.dot(&e), direction.dot(&f));
    let area = ee * ff - ef * ef;
    let found = [(ff * de - ef * df) / area, (ee * df - ef * de) / area];
    let is_one = found.iter().all(|x| x.is_finite()) && found != [0.0; 2];
    if is_one { found } else { [1.0, 0.0] }
}
