//! The pairs of shapes, and where they are put.

use crate::truth;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;
use thenar_core::shape::{MeshShape, Shape};
use thenar_core::{Pose, Quat, Vec3};
use thenar_rig::TriMesh;
use thenar_rig::mesh::{Bvh, GridOptions, Inside, distance_grid};

/// Placements of each kind.
const COUNT: usize = 1000;
/// Shapes are put from so far apart to so deep \[m\].
const NEAR: f64 = 0.5e-3;
/// How far a placement is moved to see whether the points stay \[m\].
const MOVE: f64 = 10e-6;

/// Two shapes, and how they lie.
pub struct Kind {
    pub name: String,
    pub shapes: [Shape; 2],
    level: bool,
}

/// Poses of A and B in the world: as placed, and with A moved.
pub struct Placement {
    pub poses: [[Pose; 2]; 2],
}

/// Each pair anyhow, and with faces or lines level.
pub fn kinds() -> Vec<Kind> {
    let cuboid = || Shape::Cuboid { half: Vec3::new(0.01, 0.015, 0.02) };
    let capsule = || Shape::Capsule { radius: 0.008, half_length: 0.012 };
    let cylinder = || Shape::Cylinder { radius: 0.012, half_length: 0.016 };
    let ball = || Shape::Sphere { radius: 0.012 };
    let cone = || Shape::Cone { radius: 0.015, height: 0.03 };
    let mesh = mesh_ball(0.015);
    let pairs = [
        ("box, box", cuboid(), cuboid()),
        ("box, capsule", capsule(), cuboid()),
        ("capsule, capsule", capsule(), capsule()),
        ("box, cylinder", cylinder(), cuboid()),
        ("cylinder, cylinder", cylinder(), cylinder()),
        ("ball, cone", ball(), cone()),
        ("box, cone", cuboid(), cone()),
        ("box, mesh of 80", cuboid(), mesh.clone()),
        ("two such meshes", mesh.clone(), mesh),
    ];
    let both = |(name, a, b): (&str, Shape, Shape)| {
        [false, true].map(|level| Kind {
            name: format!("{name}{}", if level { ", level" } else { "" }),
            shapes: [a.clone(), b.clone()],
            level,
        })
    };
    pairs.into_iter().flat_map(both).collect()
}

impl Kind {
    pub fn placements(&self) -> Vec<Placement> {
        let mut random = Random(7);
        let one = |_| {
            let start = if self.level { self.laid(&mut random) } else { self.put(&mut random) };
            let [a, b] = start;
            let moved = Pose::new(a.position + MOVE * random.direction(), a.rotation);
            Placement { poses: [[a, b], [moved, b]] }
        };
        (0..COUNT).map(one).collect()
    }

    /// Turned anyhow, A brought to the wanted distance along some way.
    fn put(&self, random: &mut Random) -> [Pose; 2] {
        let gap = NEAR * random.signed();
        loop {
            let way = random.direction();
            let b = Pose::new(Vec3::zeros(), random.rotation());
            let mut a = Pose::new(0.06 * way, random.rotation());
            for _ in 0..8 {
                let (now, normal) = truth::roughly(self, &[a, b]);
                a.position += (gap - now) / normal.dot(&way).max(0.3) * way;
            }
            if (truth::roughly(self, &[a, b]).0 - gap).abs() < 0.1 * NEAR {
                return [a, b];
            }
        }
    }

    /// A lies on B, turned about the normal, with the whole turned anyhow.
    fn laid(&self, random: &mut Random) -> [Pose; 2] {
        let [a, b] = &self.shapes;
        let is_line = |s: &Shape| matches!(s, Shape::Capsule { .. });
        let yaw = if is_line(a) && is_line(b) { 0.0 } else { TAU * random.unit() };
        let turned = Quat::from_scaled_axis(Vec3::y() * yaw);
        let (on, under) = (turned * resting(a, 1.0), resting(b, -1.0));
        let aside = match is_line(b) {
            true => Vec3::x() * 0.01 * random.signed(),
            false => 0.005 * Vec3::new(random.signed(), 0.0, random.signed()),
        };
        let low = truth::height(a, &on, &-Vec3::y());
        let high = truth::height(b, &under, &Vec3::y());
        let at = aside + Vec3::y() * (high + low + NEAR * random.signed());
        let all = random.rotation();
        [Pose::new(all * at, all * on), Pose::new(Vec3::zeros(), all * under)]
    }
}

/// How a shape lies with a face or a line below (`up` 1) or above (-1).
fn resting(shape: &Shape, up: f64) -> Quat {
    match shape {
        Shape::Capsule { .. } => Quat::from_scaled_axis(Vec3::z() * FRAC_PI_2),
        Shape::Cone { .. } if up < 0.0 => Quat::from_scaled_axis(Vec3::x() * PI),
        Shape::Mesh(mesh) => {
            let [a, b, c] = mesh.triangles[0].map(|v| mesh.points[v as usize]);
            let normal = (b - a).cross(&(c - a));
            Quat::rotation_between(&normal, &(-up * Vec3::y())).unwrap_or_else(Quat::identity)
        }
        _ => Quat::identity(),
    }
}

/// An icosahedron whose faces are divided in four: 80 faces, convex.
fn mesh_ball(radius: f64) -> Shape {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut points = Vec::new();
    for (i, j) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        points.extend([Vec3::new(0.0, i, j), Vec3::new(i, j, 0.0), Vec3::new(j, 0.0, i)]);
    }
    let near = |p: &Vec3, q: &Vec3| ((p - q).norm() - 2.0).abs() < 1e-9;
    let mut triangles = Vec::new();
    let corners = points.clone();
    let mut middle = |i: usize, j: usize| {
        let p: Vec3 = (corners[i] + corners[j]).normalize() * corners[i].norm();
        let known = points.iter().position(|q| (p - q).norm() < 1e-9);
        known.unwrap_or_else(|| {
            points.push(p);
            points.len() - 1
        })
    };
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [p, q, r] = [i, j, k].map(|v| corners[v]);
                if !near(&p, &q) || !near(&q, &r) || !near(&r, &p) {
                    continue;
                }
                let outward = (q - p).cross(&(r - p)).dot(&p) > 0.0;
                let [i, j, k] = if outward { [i, j, k] } else { [i, k, j] };
                let [a, b, c] = [middle(j, k), middle(k, i), middle(i, j)];
                triangles.extend([[i, c, b], [j, a, c], [k, b, a], [a, b, c]]);
            }
        }
    }
    let scale = radius / corners[0].norm();
    let points: Vec<Vec3> = points.iter().map(|p| p * scale).collect();
    let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| v as u32)).collect();
    let surface = TriMesh { positions: points.clone(), triangles: triangles.clone() };
    let bvh = Bvh::new(&surface);
    let grid = distance_grid(&surface, &bvh, Inside::Winding, &GridOptions::default());
    Shape::Mesh(Arc::new(MeshShape::new(points, triangles, grid.expect("a closed ball"))))
}

/// A sequence of numbers (Knuth's linear congruence).
pub struct Random(pub u64);

impl Random {
    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = Vec3::new(self.signed(), self.signed(), self.signed());
            if v.norm() > 0.1 && v.norm() < 1.0 {
                return v.normalize();
            }
        }
    }

    fn rotation(&mut self) -> Quat {
        Quat::from_scaled_axis(self.direction() * PI * self.unit())
    }
}
