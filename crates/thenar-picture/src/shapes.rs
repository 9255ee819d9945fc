//! Simple closed solids as triangle meshes.

use super::scene3d::{Material, Mesh};
use std::f64::consts::{PI, TAU};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Vec3};

/// Vertices and outward triangles.
#[derive(Clone, Debug, Default)]
pub struct Solid {
    /// Vertices \[m\].
    pub positions: Vec<Vec3>,
    /// Vertex indices.
    pub triangles: Vec<[u32; 3]>,
}

impl Solid {
    /// Moves it.
    pub fn placed(mut self, pose: &Pose) -> Self {
        for p in &mut self.positions {
            *p = pose.point(p);
        }
        self
    }

    /// Adds another solid beside this one.
    pub fn join(&mut self, other: &Self) {
        let first = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
    }

    /// Returns the solid as a mesh of this material.
    pub fn mesh(self, material: Material) -> Mesh<'static> {
        Mesh::new(self.positions, self.triangles, material)
    }
}

/// A surface of revolution about the axis `axis` through `origin`: rings of (height, radius) from
/// the bottom up. Closed by its first and last ring, of radius 0.
fn revolve(origin: Vec3, axis: Vec3, rings: &[[f64; 2]], sides: usize) -> Solid {
    let axis = axis.try_normalize(1e-12).unwrap_or_else(Vec3::y);
    let (e1, e2) = thenar_core::math::tangents(&axis);
    let mut solid = Solid::default();
    let mut first = Vec::with_capacity(rings.len());
    for [height, radius] in rings {
        first.push(solid.positions.len() as u32);
        // A ring without radius is one vertex.
        for k in 0..if *radius > 0.0 { sides } else { 1 } {
            let (sin, cos) = (TAU * k as f64 / sides as f64).sin_cos();
            solid.positions.push(origin + axis * *height + (e1 * cos + e2 * sin) * *radius);
        }
    }
    let at = |r: usize, k: usize| first[r] + if rings[r][1] > 0.0 { (k % sides) as u32 } else { 0 };
    for ring in 0..rings.len() - 1 {
        for k in 0..sides {
            let quad = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            if rings[ring][1] > 0.0 {
                solid.triangles.push([quad[0], quad[1], quad[2]]);
            }
            if rings[ring + 1][1] > 0.0 {
                solid.triangles.push([quad[0], quad[2], quad[3]]);
            }
        }
    }
    solid
}

/// A ball; `detail` segments round its equator.
pub fn sphere(centre: Vec3, radius: f64, detail: usize) -> Solid {
    capsule(centre, centre, radius, detail)
}

/// A segment from `a` to `b`, rounded.
pub fn capsule(a: Vec3, b: Vec3, radius: f64, detail: usize) -> Solid {
    let sides = detail.max(6);
    let half = sides.div_ceil(4);
    let length = (b - a).norm();
    let step = PI / 2.0 / half as f64;
    let ring = |i: usize| [radius * (i as f64 * step).sin(), radius * (i as f64 * step).cos()];
    let mut rings = vec![[-radius, 0.0]];
    rings.extend((0..half).rev().map(|i| [-ring(i)[0], ring(i)[1]]));
    let skip = usize::from(length < 1e-12);
    rings.extend((skip..half).map(|i| [length + ring(i)[0], ring(i)[1]]));
    rings.push([length + radius, 0.0]);
    revolve(a, b - a, &rings, sides)
}

/// A cone frustum from `a` to `b` with these radii, closed by discs.
pub fn cylinder(a: Vec3, b: Vec3, radii: [f64; 2], sides: usize) -> Solid {
    let length = (b - a).norm();
    // The rims are doubled so that the discs stay flat.
    let rings = [
        [0.0, 0.0],
        [0.0, radii[0]],
        [0.0, radii[0]],
        [length, radii[1]],
        [length, radii[1]],
        [length, 0.0],
    ];
    revolve(a, b - a, &rings, sides.max(3))
}

/// A box with these half edges, its faces cut into `cells`² squares.
pub fn cuboid(pose: &Pose, half: Vec3, cells: usize) -> Solid {
    let n = cells.max(1);
    let mut solid = Solid::default();
    for face in 0..6 {
        let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let first = solid.positions.len() as u32;
        for i in 0..=n {
            for j in 0..=n {
                let mut p = Vec3::zeros();
                p[axis] = sign * half[axis];
                p[u] = (2.0 * i as f64 / n as f64 - 1.0) * half[u];
                p[v] = (2.0 * j as f64 / n as f64 - 1.0) * half[v];
                solid.positions.push(pose.point(&p));
            }
        }
        for i in 0..n as u32 {
            for j in 0..n as u32 {
                let at = |i: u32, j: u32| first + i * (n as u32 + 1) + j;
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                if sign > 0.0 {
                    solid.triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    solid.triangles.extend([[a, c, b], [a, d, c]]);
                }
            }
        }
    }
    solid
}

/// An ellipsoid with these half axes; `detail` segments round it.
pub fn ellipsoid(half: Vec3, detail: usize) -> Solid {
    let mut solid = sphere(Vec3::zeros(), 1.0, detail);
    solid.positions.iter_mut().for_each(|p| p.component_mul_assign(&half));
    solid
}

/// The outline of a contact shape in its own frame; of a half-space nothing. `detail` segments go
/// round round shapes, the faces of a box have `cells`² squares.
pub fn of_shape(shape: &Shape, detail: usize, cells: usize) -> Option<Solid> {
    let up = |y: f64| Vec3::y() * y;
    Some(match shape {
        Shape::Sphere { radius } => sphere(Vec3::zeros(), *radius, detail),
        Shape::Capsule { radius, half_length } => {
            capsule(up(-half_length), up(*half_length), *radius, detail)
        }
        Shape::Cuboid { half } => cuboid(&Pose::identity(), *half, cells),
        Shape::Cylinder { radius, half_length } => {
            cylinder(up(-half_length), up(*half_length), [*radius; 2], detail)
        }
        Shape::Ellipsoid { half } => ellipsoid(*half, detail),
        Shape::Cone { radius, height } => {
            cylinder(up(-0.25 * height), up(0.75 * height), [*radius, 0.0], detail)
        }
        Shape::Mesh(mesh) => {
            Solid { positions: mesh.points.clone(), triangles: mesh.triangles.clone() }
        }
        Shape::Compound(parts) => {
            let mut whole = Solid::default();
            for part in parts.iter() {
                if let Some(solid) = of_shape(&part.shape, detail, cells) {
                    whole.join(&solid.placed(&part.pose_SP));
                }
            }
            whole
        }
        Shape::HalfSpace => return None,
    })
}

/// An eight-faced spindle from `a` to `b`, widest a fifth of the way: the usual sign for a bone.
pub fn spindle(a: Vec3, b: Vec3, radius: f64) -> Solid {
    let length = (b - a).norm();
    revolve(a, b - a, &[[0.0, 0.0], [0.2 * length, radius], [length, 0.0]], 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six times the volume enclosed, by the divergence theorem.
    fn volume(solid: &Solid) -> f64 {
        let p = |i: u32| solid.positions[i as usize];
        solid.triangles.iter().map(|t| p(t[0]).dot(&p(t[1]).cross(&p(t[2])))).sum::<f64>() / 6.0
    }

    #[test]
    fn solids_enclose_their_volume() {
        let (a, b) = (Vec3::new(0.1, -0.2, 0.3), Vec3::new(0.5, 0.1, 0.3));
        let close = |solid: Solid, expected: f64| {
            let got = volume(&solid);
            assert!((got / expected - 1.0).abs() < 0.01, "{got} {expected}");
        };
        close(sphere(a, 0.2, 96), 4.0 / 3.0 * PI * 0.008);
        close(capsule(a, b, 0.2, 96), PI * 0.04 * 0.5 + 4.0 / 3.0 * PI * 0.008);
        close(cylinder(a, b, [0.2, 0.2], 96), PI * 0.04 * 0.5);
        close(cylinder(a, b, [0.2, 0.0], 96), PI * 0.04 * 0.5 / 3.0);
        close(ellipsoid(Vec3::new(0.1, 0.2, 0.3), 96), 4.0 / 3.0 * PI * 0.006);
        let cone = of_shape(&Shape::Cone { radius: 0.2, height: 0.3 }, 96, 1);
        close(cone.unwrap_or_default(), PI * 0.04 * 0.1);
        close(cuboid(&Pose::identity(), Vec3::new(0.1, 0.2, 0.3), 3), 0.048);
        // Two square pyramids of base 2 r² over the length 0.5.
        close(spindle(a, b, 0.1), 2.0 * 0.01 * 0.5 / 3.0);
    }
}
