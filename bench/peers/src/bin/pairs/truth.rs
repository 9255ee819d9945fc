//! How far two convex shapes are apart, or how deep they overlap, from their extents alone: along
//! any direction the gap between their extents is a lower bound, and the largest of all directions
//! is the distance. Directions are searched densely and then refined by ever smaller random steps,
//! which shares no method with any engine.

use crate::placements::{Kind, Random};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat, Vec3};

/// Directions of a dense search, and of one for placing.
const DENSE: usize = 800;
const SPARSE: usize = 150;
/// Best directions that are refined, and the first and last step \[rad\].
const REFINED: usize = 10;
const STEPS: [f64; 2] = [0.1, 1e-11];
const STEP_SPARSE: f64 = 1e-4;

/// The signed distance of A from B \[m\]. `normals` are tried, too.
pub fn separation(kind: &Kind, poses: &[Pose; 2], normals: impl Iterator<Item = Vec3>) -> f64 {
    search(kind, poses, DENSE, REFINED, STEPS[1], normals).0
}

/// The same, roughly, and its direction.
pub fn roughly(kind: &Kind, poses: &[Pose; 2]) -> (f64, Vec3) {
    search(kind, poses, SPARSE, 2, STEP_SPARSE, std::iter::empty())
}

/// The greatest extent of a turned shape along unit vector `n` \[m\].
pub fn height(shape: &Shape, rotation: &Quat, n: &Vec3) -> f64 {
    let d = rotation.inverse_transform_vector(n);
    let aside = d.x.hypot(d.z);
    match shape {
        Shape::Sphere { radius } => *radius,
        Shape::Capsule { radius, half_length } => half_length * d.y.abs() + radius,
        Shape::Cuboid { half } => half.dot(&d.abs()),
        Shape::Cylinder { radius, half_length } => half_length * d.y.abs() + radius * aside,
        Shape::Cone { radius, height } => {
            (0.75 * height * d.y).max(radius * aside - 0.25 * height * d.y)
        }
        Shape::Mesh(mesh) => mesh.points.iter().map(|p| p.dot(&d)).fold(f64::MIN, f64::max),
        _ => unreachable!("no such pair"),
    }
}

fn search(
    kind: &Kind,
    [a, b]: &[Pose; 2],
    count: usize,
    refined: usize,
    last: f64,
    normals: impl Iterator<Item = Vec3>,
) -> (f64, Vec3) {
    let between = a.position - b.position;
    let gap = |n: &Vec3| {
        let [of_a, of_b] = &kind.shapes;
        n.dot(&between) - height(of_a, &a.rotation, &-n) - height(of_b, &b.rotation, n)
    };
    let axes = [a, b].map(|pose| pose.rotation.to_rotation_matrix().into_inner());
    let mut tried: Vec<Vec3> = normals.collect();
    tried.extend(between.try_normalize(0.0));
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        let (u, v) = (axes[0].column(i).into_owned(), axes[1].column(j).into_owned());
        tried.extend([u, v].into_iter().chain(u.cross(&v).try_normalize(1e-9)));
    }
    for k in 0..count {
        let y = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let (sin, cos) = (k as f64 * 2.399963229728653).sin_cos();
        let r = (1.0 - y * y).sqrt();
        tried.push(Vec3::new(r * cos, y, r * sin));
    }
    let mut found: Vec<(f64, Vec3)> =
        tried.iter().flat_map(|n| [*n, -n]).map(|n| (gap(&n), n)).collect();
    found.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut random = Random(1);
    let mut best = found[0];
    for start in found.into_iter().take(refined) {
        let (mut at, mut step, mut failed) = (start, STEPS[0], 0);
        while step > last {
            let n = (at.1 + step * random.direction()).normalize();
            let value = gap(&n);
            if value > at.0 {
                (at, step, failed) = ((value, n), 1.5 * step, 0);
            } else if failed == 12 {
                (step, failed) = (0.5 * step, 0);
            } else {
                failed += 1;
            }
        }
        if at.0 > best.0 {
            best = at;
        }
    }
    best
}
