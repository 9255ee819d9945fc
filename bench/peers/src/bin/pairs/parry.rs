//! Contact manifolds of parry3d, in single precision, as Rapier has it, and in double. Some of its
//! tolerances are lengths, made for bodies of a metre: single precision is tried in centimetres,
//! too.

macro_rules! engine {
    ($module:ident, $name:literal, $parry:ident, $real:ty, $unit:literal) => {
        pub mod $module {
            use crate::placements::{Kind, Placement};
            use crate::{Engine, MARGIN, Touch};
            use thenar_core::Vec3;
            use thenar_core::shape::Shape;
            use $parry::math::{Pose, Rotation, Vector};
            use $parry::query::{
                ContactManifold, ContactManifoldsWorkspace, DefaultQueryDispatcher,
                PersistentQueryDispatcher,
            };
            use $parry::shape::{
                Ball, Capsule, Cone, ConvexPolyhedron, Cuboid, Cylinder, Shape as ParryShape,
            };

            /// One of its lengths \[m\].
            const UNIT: f64 = $unit;

            type Manifolds = Vec<ContactManifold<(), ()>>;

            pub struct Parry {
                shapes: [Box<dyn ParryShape>; 2],
                poses: Vec<[[Pose; 2]; 2]>,
                /// Poses of B in A.
                between: Vec<[Pose; 2]>,
                found: Vec<(Manifolds, Option<ContactManifoldsWorkspace>)>,
                moved: usize,
            }

            impl Parry {
                pub fn new(kind: &Kind, placements: &[Placement]) -> Self {
                    let [middle_a, middle_b] = [0, 1].map(|i| middle(&kind.shapes[i]));
                    let of = |pose: &thenar_core::Pose, up: f64| {
                        let p = pose.point(&(Vec3::y() * up));
                        let q = pose.rotation.coords.map(|x| x as $real);
                        Pose::from_parts(vector(&p), Rotation::from_xyzw(q.x, q.y, q.z, q.w))
                    };
                    let both = |[a, b]: &[thenar_core::Pose; 2]| [of(a, middle_a), of(b, middle_b)];
                    let poses: Vec<_> =
                        placements.iter().map(|p| [0, 1].map(|k| both(&p.poses[k]))).collect();
                    Self {
                        shapes: [0, 1].map(|i| shape(&kind.shapes[i])),
                        between: poses
                            .iter()
                            .map(|p: &[[Pose; 2]; 2]| [0, 1].map(|k| p[k][0].inv_mul(&p[k][1])))
                            .collect(),
                        found: placements.iter().map(|_| (Vec::new(), None)).collect(),
                        poses,
                        moved: 0,
                    }
                }
            }

            impl Engine for Parry {
                fn name(&self) -> &'static str {
                    $name
                }

                fn search(&mut self, moved: usize, kept: bool) {
                    self.moved = moved;
                    let [a, b] = &self.shapes;
                    for (between, (manifolds, workspace)) in
                        self.between.iter().zip(&mut self.found)
                    {
                        if !kept {
                            manifolds.clear();
                            *workspace = None;
                        }
                        DefaultQueryDispatcher
                            .contact_manifolds(
                                &between[moved],
                                &**a,
                                &**b,
                                (MARGIN / UNIT) as $real,
                                manifolds,
                                workspace,
                            )
                            .expect("a supported pair");
                    }
                }

                fn touches(&self, i: usize) -> Vec<Touch> {
                    let [a, b] = self.poses[i][self.moved];
                    let mut touches = Vec::new();
                    for manifold in &self.found[i].0 {
                        let normal = -back(a.transform_vector(manifold.local_n1)).normalize();
                        for point in &manifold.points {
                            // Rapier leaves out what is farther, too.
                            if UNIT * f64::from(point.dist) <= MARGIN {
                                touches.push(Touch {
                                    on_a: back(a.transform_point(point.local_p1)),
                                    on_b: back(b.transform_point(point.local_p2)),
                                    normal,
                                    gap: UNIT * f64::from(point.dist),
                                });
                            }
                        }
                    }
                    touches
                }
            }

            fn vector(p: &Vec3) -> Vector {
                let [x, y, z] = [p.x, p.y, p.z].map(|x| (x / UNIT) as $real);
                Vector::new(x, y, z)
            }

            fn back(p: Vector) -> Vec3 {
                UNIT * Vec3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z))
            }

            /// Height of the middle between base and apex, where a cone has its origin here \[m\].
            fn middle(shape: &Shape) -> f64 {
                if let Shape::Cone { height, .. } = shape { 0.25 * height } else { 0.0 }
            }

            fn shape(shape: &Shape) -> Box<dyn ParryShape> {
                let real = |x: f64| (x / UNIT) as $real;
                match shape {
                    Shape::Sphere { radius } => Box::new(Ball::new(real(*radius))),
                    Shape::Capsule { radius, half_length } => {
                        Box::new(Capsule::new_y(real(*half_length), real(*radius)))
                    }
                    Shape::Cuboid { half } => Box::new(Cuboid::new(vector(half))),
                    Shape::Cylinder { radius, half_length } => {
                        Box::new(Cylinder::new(real(*half_length), real(*radius)))
                    }
                    Shape::Cone { radius, height } => {
                        Box::new(Cone::new(real(0.5 * height), real(*radius)))
                    }
                    Shape::Mesh(mesh) => {
                        let points = mesh.points.iter().map(vector).collect();
                        let hull = ConvexPolyhedron::from_convex_mesh(points, &mesh.triangles);
                        Box::new(hull.expect("a convex mesh"))
                    }
                    _ => unreachable!("no such pair"),
                }
            }
        }
    };
}

engine!(single, "parry3d, f32", parry3d, f32, 1.0);
engine!(centimetres, "parry3d, f32, in cm", parry3d, f32, 0.01);
engine!(double, "parry3d, f64", parry3d_f64, f64, 1.0);
