//! A hand-sized deformable surface over a plane, in contact with a second, softer body and nine
//! rigid ones: the sizes of the paper's hand (1441 collision triangles) and a loaf.

use thenar_core::kernels::RigidPlace;
use thenar_core::model::{
    EmbeddedSurface, Flesh, Motion, RigidDesc, SoftDesc, SurfaceVertex, WorldDesc,
};
use thenar_core::shape::{DistanceGrid, MeshShape, Shape};
use thenar_core::{Mat3, Pose, Quat, Vec3};

/// A world and its state.
pub struct ContactScene {
    pub desc: WorldDesc,
    pub places: Vec<RigidPlace>,
    pub positions: Vec<Vec3>,
    pub velocities: Vec<Vec3>,
}

type Surface = (Vec<Vec3>, Vec<[u32; 3]>);

/// A closed ellipsoid of `rings × around + 2` vertices.
fn ellipsoid(center: Vec3, half: Vec3, rings: u32, around: u32) -> Surface {
    let mut points = vec![center + Vec3::new(0.0, 0.0, half.z)];
    for i in 1..=rings {
        let latitude = std::f64::consts::PI * f64::from(i) / f64::from(rings + 1);
        for j in 0..around {
            let longitude = std::f64::consts::TAU * f64::from(j) / f64::from(around);
            let (s, c) = latitude.sin_cos();
            let direction = Vec3::new(s * longitude.cos(), s * longitude.sin(), c);
            points.push(center + half.component_mul(&direction));
        }
    }
    points.push(center - Vec3::new(0.0, 0.0, half.z));
    let at = |i: u32, j: u32| 1 + (i - 1) * around + j % around;
    let last = points.len() as u32 - 1;
    let mut triangles = Vec::new();
    for j in 0..around {
        triangles.push([0, at(1, j), at(1, j + 1)]);
        for i in 1..rings {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
        triangles.push([at(rings, j), last, at(rings, j + 1)]);
    }
    (points, triangles)
}

fn join(parts: Vec<Surface>) -> Surface {
    let mut whole: Surface = Default::default();
    for (points, triangles) in parts {
        let first = whole.0.len() as u32;
        whole.0.extend(points);
        whole.1.extend(triangles.iter().map(|t| t.map(|v| v + first)));
    }
    whole
}

/// Five fingers and a palm, 722 vertices.
fn hand() -> Surface {
    let finger =
        |x: f64| ellipsoid(Vec3::new(x, 0.009, -0.08), Vec3::new(0.008, 0.009, 0.04), 9, 12);
    let palm = ellipsoid(Vec3::new(0.0, 0.014, 0.0), Vec3::new(0.045, 0.014, 0.05), 14, 12);
    join([-0.036, -0.018, 0.0, 0.018, 0.036].map(finger).into_iter().chain([palm]).collect())
}

/// An ellipsoid as a mesh with a distance grid (distance to first order).
fn mesh_shape(half: Vec3) -> Shape {
    let (points, triangles) = ellipsoid(Vec3::zeros(), half, 24, 25);
    let (n, reach) = (40u32, 1.4 * half.max());
    let (origin, cell) = (Vec3::repeat(-reach), 2.0 * reach / f64::from(n - 1));
    let mut values = Vec::new();
    for k in 0..n * n * n {
        let index = Vec3::new(f64::from(k % n), f64::from(k / n % n), f64::from(k / (n * n)));
        let p = origin + cell * index;
        let (f, slope) =
            (p.component_div(&half).norm(), p.component_div(&half.component_mul(&half)));
        values.push((f * (f - 1.0) / slope.norm().max(1e-9)) as f32);
    }
    let grid = DistanceGrid { origin, cell, dims: [n; 3], values };
    Shape::Mesh(std::sync::Arc::new(MeshShape::new(points, triangles, grid)))
}

impl ContactScene {
    fn rigid(&mut self, motion: Motion, shape: Shape, pose_WB: Pose) {
        let zero = Vec3::zeros();
        self.places.push(RigidPlace { pose_WB, velocity_W: zero, angular_velocity_W: zero });
        self.desc.add_rigid(RigidDesc {
            name: format!("rigid {}", self.places.len()),
            motion,
            mass: 1.0,
            inertia: Mat3::identity(),
            pose_WB,
            velocity_W: zero,
            angular_velocity_W: zero,
            shape: Some(shape),
            pose_BS: Pose::identity(),
            friction: 0.5,
        });
    }

    fn soft(&mut self, (points, triangles): Surface) {
        let vertex = |i| SurfaceVertex { tet: i, weights: [1.0, 0.0, 0.0, 0.0] };
        let count = points.len() as u32;
        self.positions.extend(&points);
        self.velocities.extend(points.iter().map(|p| Vec3::new(0.0, -0.05, 0.3 * p.x)));
        self.desc.add_soft(SoftDesc {
            name: format!("soft {count}"),
            flesh: Flesh {
                nodes: points,
                tets: (0..count).map(|i| [i; 4]).collect(),
                materials: Vec::new(),
                relaxation: Vec::new(),
                mass_damping: 0.0,
                stiffness_damping: 0.0,
                fixed: Vec::new(),
                collision: EmbeddedSurface {
                    vertices: (0..count).map(vertex).collect(),
                    triangles,
                },
                friction: 0.8,
            },
            pose_WM: Pose::identity(),
            velocity_W: Vec3::zeros(),
            coupling: None,
        });
    }

    /// The scene; without `loaf` only one deformable body.
    pub fn new(loaf: bool) -> Self {
        let mut scene = Self {
            desc: WorldDesc::default(),
            places: Vec::new(),
            positions: Vec::new(),
            velocities: Vec::new(),
        };
        scene.rigid(Motion::Prescribed, Shape::HalfSpace, Pose::identity());
        let car = mesh_shape(Vec3::new(0.02, 0.012, 0.035));
        scene.rigid(Motion::Dynamic, car, Pose::translation(0.0, 0.0295, -0.08));
        let small = Shape::Cuboid { half: Vec3::repeat(0.006) };
        scene.rigid(Motion::Dynamic, small.clone(), Pose::translation(0.027, 0.0065, -0.03));
        scene.rigid(Motion::Dynamic, small.clone(), Pose::translation(0.06, 0.006, 0.0));
        scene.rigid(Motion::Dynamic, small.clone(), Pose::translation(0.06, 0.018, 0.0));
        scene.rigid(Motion::Dynamic, small, Pose::translation(0.06, 0.03, 0.0));
        let pen = Shape::Capsule { radius: 0.004, half_length: 0.05 };
        let lying = Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_2);
        scene.rigid(Motion::Dynamic, pen, Pose::new(Vec3::new(0.0, 0.031, 0.0), lying));
        let ball = Shape::Sphere { radius: 0.01 };
        scene.rigid(Motion::Dynamic, ball.clone(), Pose::translation(-0.056, 0.01, 0.0));
        scene.rigid(Motion::Dynamic, ball, Pose::translation(-0.03, 0.03, 0.01));
        let wall = Shape::Cuboid { half: Vec3::new(0.1, 0.1, 0.01) };
        scene.rigid(Motion::Prescribed, wall, Pose::translation(0.0, 0.1, -0.1305));
        scene.soft(hand());
        if loaf {
            let half = Vec3::new(0.05, 0.03, 0.03);
            scene.soft(ellipsoid(Vec3::new(0.0, 0.054, 0.02), half, 20, 20));
        }
        scene
    }

    /// The place after `step` small steps of a to-and-fro motion.
    pub fn advance(&mut self, step: u32, h: f64) {
        let sign = if (step / 10).is_multiple_of(2) { 1.0 } else { -1.0 };
        for (p, v) in self.positions.iter_mut().zip(&self.velocities) {
            *p += h * sign * v;
        }
    }
}
