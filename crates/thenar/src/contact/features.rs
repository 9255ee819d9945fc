//! The sharp or small features of a rigid shape that soft vertices could miss.

use crate::contact::aabb::Aabb;
use crate::contact::bvh::Bvh;
use crate::contact::triangle::area_vector;
use crate::contact::{MeshShape, Part, Shape};
use crate::math::Vec3;

/// A straight edge (or the axis of a capsule) in the shape frame.
pub(crate) type Segment = [Vec3; 2];

/// Sample points around a rim by default: the chord between two bends off the rim by 0.5 % of its
/// radius.
pub(crate) const RIM_SAMPLES: usize = 32;
/// Samples of a mesh lie at most this part of its longest side apart, ...
const MESH_SPACING: f64 = 1.0 / 14.0;
/// ... unless they would be more than about so many.
const MESH_SAMPLES_MAX: usize = 2000;

/// Fixed points and segments of a shape, in its frame; each stands for a ball of `radius`.
///
/// | shape | points | segments |
/// |---|---|---|
/// | sphere | its centre | |
/// | capsule | | its axis |
/// | cuboid | 8 corners | 12 edges |
/// | cylinder | 32 on each rim | |
/// | cone | apex, 32 on the rim | |
/// | ellipsoid, half-space | | |
/// | mesh | corners and samples at most 1/14 of its size apart | |
/// | compound | those of its parts | those of its parts |
///
/// Segments are whole: who needs points along them chooses the spacing. [`Features::with_spacing`]
/// refines rims and meshes.
#[derive(Clone, Debug)]
pub(crate) struct Features {
    pub points: Vec<Vec3>,
    pub segments: Vec<Segment>,
    pub radius: f64,
    pub tree: Bvh,
}

impl Features {
    /// Features at the default spacing.
    pub fn of(shape: &Shape) -> Self {
        Self::with_spacing(shape, f64::INFINITY)
    }

    /// Features with points on rims and meshes at most `spacing` \[m\] apart, and never farther than
    /// by default. Of a compound of round parts of several radii, only sharp parts give any.
    pub fn with_spacing(shape: &Shape, spacing: f64) -> Self {
        let (mut points, mut segments) = (Vec::new(), Vec::new());
        let mut radius = 0.0;
        match shape {
            Shape::Sphere { radius: r } => {
                points.push(Vec3::zeros());
                radius = *r;
            }
            Shape::Capsule { radius: r, half_length } => {
                segments.push(capsule_axis(*half_length));
                radius = *r;
            }
            _ => sharp(shape, spacing, &mut points, &mut segments),
        }
        let boxes: Vec<Aabb> = points.iter().map(|p| Aabb { min: *p, max: *p }).collect();
        Self { tree: Bvh::build(&boxes), points, segments, radius }
    }

    pub fn is_empty(&self) -> bool {
        self.points.is_empty() && self.segments.is_empty()
    }
}

/// Cosine of the bend from which an edge of a mesh counts as sharp, 20°.
const SHARP: f64 = 0.939_692_620_785_908_4;

impl Shape {
    /// The sharp edges in the shape frame, for sampling along them: of a cuboid, of a mesh where its
    /// faces bend outward by more than 20° or end, of a cylinder or cone its rims as chords (`chords` to
    /// each, which lie within `radius (1 - cos(π/chords))` of it), of a compound those of its parts.
    pub fn sharp_edges(&self, chords: usize) -> Vec<[Vec3; 2]> {
        let ring = |radius: f64, y: f64| {
            let points: Vec<Vec3> = rim(radius, y, chords.max(3)).collect();
            let next = points.iter().cycle().skip(1);
            points.iter().zip(next).map(|(a, b)| [*a, *b]).collect::<Vec<_>>()
        };
        match self {
            Self::Cuboid { half } => edges(half).to_vec(),
            Self::Cylinder { radius, half_length } => {
                [ring(*radius, -half_length), ring(*radius, *half_length)].concat()
            }
            Self::Cone { radius, height } => ring(*radius, -0.25 * height),
            Self::Mesh(mesh) => {
                let sharp = mesh.index.edges.iter().filter(|e| {
                    e.normals[0] == e.normals[1] || e.normals[0].dot(&e.normals[1]) < SHARP
                });
                sharp.map(|e| e.vertices.map(|v| mesh.points[v as usize])).collect()
            }
            Self::Compound(parts) => {
                let placed = |part: &Part| {
                    let edges = part.shape.sharp_edges(chords);
                    let moved = edges.into_iter().map(|e| e.map(|p| part.pose_SP.point(&p)));
                    moved.collect::<Vec<_>>()
                };
                parts.iter().flat_map(placed).collect()
            }
            Self::Sphere { .. }
            | Self::Capsule { .. }
            | Self::Ellipsoid { .. }
            | Self::HalfSpace => Vec::new(),
        }
    }
}

/// Adds the sharp features of a shape; round ones have none.
fn sharp(shape: &Shape, spacing: f64, points: &mut Vec<Vec3>, segments: &mut Vec<Segment>) {
    match shape {
        Shape::Sphere { .. }
        | Shape::Capsule { .. }
        | Shape::Ellipsoid { .. }
        | Shape::HalfSpace => {}
        Shape::Cuboid { half } => {
            points.extend(corners(half));
            segments.extend(edges(half));
        }
        Shape::Cylinder { radius, half_length } => {
            for y in [-half_length, *half_length] {
                points.extend(rim(*radius, y, rim_samples(*radius, spacing)));
            }
        }
        Shape::Cone { radius, height } => {
            points.push(Vec3::y() * (0.75 * height));
            points.extend(rim(*radius, -0.25 * height, rim_samples(*radius, spacing)));
        }
        Shape::Mesh(mesh) => points.extend(mesh_samples(mesh, spacing)),
        Shape::Compound(parts) => {
            for part in parts.iter() {
                let (p, s) = (points.len(), segments.len());
                sharp(&part.shape, spacing, points, segments);
                points[p..].iter_mut().for_each(|x| *x = part.pose_SP.point(x));
                segments[s..].iter_mut().flatten().for_each(|x| *x = part.pose_SP.point(x));
            }
        }
    }
}

fn rim_samples(radius: f64, spacing: f64) -> usize {
    let needed = (std::f64::consts::TAU * radius / spacing).ceil() as usize;
    needed.clamp(RIM_SAMPLES, 1 << 16)
}

/// Points evenly around the circle of `radius` at height `y`, the first at +x, towards +z.
pub(crate) fn rim(radius: f64, y: f64, count: usize) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |k| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
        Vec3::new(radius * cos, y, radius * sin)
    })
}

/// Vertices of the triangles, and points on triangles that are longer than the spacing.
fn mesh_samples(mesh: &MeshShape, spacing: f64) -> Vec<Vec3> {
    let used = mesh.triangles.iter().flatten();
    let sound = |v: &&u32| (**v as usize) < mesh.points.len();
    let mut vertices: Vec<u32> = used.filter(sound).copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let size = 2.0 * Aabb::of_points(&mesh.points).half().max();
    let corners = |t: &u32| mesh.triangles[*t as usize].map(|v| mesh.points[v as usize]);
    let triangles = &mesh.index.items;
    let area: f64 = triangles.iter().map(|t| area_vector(&corners(t)).norm()).sum();
    let by_count = (1.5 * area / MESH_SAMPLES_MAX as f64).sqrt();
    let wanted = spacing.min((MESH_SPACING * size).max(by_count));
    // Fine meshes give every n-th vertex.
    let most = (area / (wanted * wanted)).ceil().max(MESH_SAMPLES_MAX as f64) as usize;
    let every = vertices.len().div_ceil(most).max(1);
    let mut points: Vec<Vec3> =
        vertices.iter().step_by(every).map(|&v| mesh.points[v as usize]).collect();
    for t in triangles {
        let x = corners(t);
        let longest = (0..3).map(|k| (x[(k + 1) % 3] - x[k]).norm()).fold(0.0, f64::max);
        let n = ((longest / wanted).ceil() as u32).clamp(1, 64);
        for i in 0..=n {
            for j in 0..=n - i {
                let corner = [i, j, n - i - j].contains(&n);
                // Of the two triangles at an edge, one has it as its first or second.
                let shared = i == 0
                    && mesh.triangles[*t as usize][1] > mesh.triangles[*t as usize][2]
                    || j == 0 && mesh.triangles[*t as usize][2] > mesh.triangles[*t as usize][0]
                    || i + j == n
                        && mesh.triangles[*t as usize][0] > mesh.triangles[*t as usize][1];
                if !corner && !shared {
                    let w = [i, j, n - i - j].map(|w| f64::from(w) / f64::from(n));
                    points.push(x[0] * w[0] + x[1] * w[1] + x[2] * w[2]);
                }
            }
        }
    }
    points
}

/// The ends of a capsule's axis.
pub(crate) fn capsule_axis(half_length: f64) -> Segment {
    [Vec3::new(0.0, -half_length, 0.0), Vec3::new(0.0, half_length, 0.0)]
}

/// Corner `i` has the sign of axis k in bit k (set: positive).
///
/// ```text
///    6----7      y
///   /|   /|      |
///  2----3 |      |__ x
///  | 4--|-5     /
///  |/   |/     z points away: bit 2 set is the far face
///  0----1
/// ```
pub(crate) fn corners(half: &Vec3) -> [Vec3; 8] {
    std::array::from_fn(|i| Vec3::from_fn(|k, _| if i >> k & 1 == 1 { half[k] } else { -half[k] }))
}

/// The twelve edges, four along each axis.
pub(crate) fn edges(half: &Vec3) -> [Segment; 12] {
    let corner = corners(half);
    std::array::from_fn(|e| {
        let (axis, which) = (e / 4, e % 4);
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let start = (which & 1) << j | (which >> 1) << k;
        [corner[start], corner[start | 1 << axis]]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::DistanceGrid;
    use crate::contact::tests::cube;
    use std::sync::Arc;

    /// A finely meshed cube has its twelve edges in pieces, and nothing on its faces.
    #[test]
    fn sharp_edges_are_those_of_the_shape() {
        let (points, triangles) = cube(0.02, 4);
        let grid = DistanceGrid {
            origin: Vec3::repeat(1e3),
            cell: 1.0,
            dims: [2; 3],
            values: vec![1.0; 8],
        };
        let mesh = Shape::Mesh(Arc::new(MeshShape::new(points, triangles, grid)));
        let length = |shape: &Shape| -> f64 {
            shape.sharp_edges(64).iter().map(|[a, b]| (b - a).norm()).sum()
        };
        assert_eq!(mesh.sharp_edges(64).len(), 48);
        assert!((length(&mesh) - 0.24).abs() < 1e-12);
        assert!((length(&Shape::Cuboid { half: Vec3::repeat(0.01) }) - 0.24).abs() < 1e-12);
        let cylinder = Shape::Cylinder { radius: 0.01, half_length: 0.02 };
        let chord = 2.0 * 0.01 * (std::f64::consts::PI / 64.0).sin();
        assert!((length(&cylinder) - 128.0 * chord).abs() < 1e-12);
        for shape in [&mesh, &cylinder] {
            for [a, b] in shape.sharp_edges(64) {
                assert!(
                    shape.distance(&a).value.abs() < 1e-15
                        && shape.distance(&b).value.abs() < 1e-15
                );
            }
        }
    }

    #[test]
    fn a_cuboid_has_twelve_different_edges_of_its_lengths() {
        let half = Vec3::new(1.0, 2.0, 3.0);
        let edges = edges(&half);
        for (e, [a, b]) in edges.iter().enumerate() {
            let mut along = Vec3::zeros();
            along[e / 4] = 2.0 * half[e / 4];
            assert_eq!(b - a, along);
            assert!(edges[..e].iter().all(|other| other[0] != *a || other[1] != *b));
        }
    }
}
