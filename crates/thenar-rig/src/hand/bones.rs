//! Bones: frames, mass and inertia from anatomical size and density.
//!
//! A bone is a capsule around the line between its joints. Its radius is a fixed part of the
//! thickness of the flesh around that line, so it scales with the hand and follows its build.

use super::digits::DigitRig;
use super::names;
use crate::mesh::Bvh;
use thenar_core::model::{Bone, Digit};
use thenar_core::{Mat3, Pose, Quat, Vec3};
use thenar_input::quoted;

/// Density of a whole fresh bone, cortical shell and trabecular core together \[kg/m³\].
pub(crate) const BONE_DENSITY: f64 = 1900.0;
/// Mean radius of a phalanx relative to the distance from its axis to the skin (8 mm: 3.8 mm).
const RADIUS: f64 = 0.45;
/// Mean radius of a metacarpal, which lies deeper, relative to the distance from its axis to the
/// skin.
const METACARPAL_RADIUS: f64 = 0.36;
/// Thickness of the carpus relative to the length of the hand (13 mm of 190).
const CARPUS_THICKNESS: f64 = 0.068;

/// A body with its inertia about its own centre of mass, axes of M.
#[derive(Clone, Copy)]
struct Mass {
    mass: f64,
    centre: Vec3,
    inertia: Mat3,
}

impl Mass {
    /// A solid capsule from `a` to `b`; the caps are centred on the ends.
    fn capsule(a: &Vec3, b: &Vec3, radius: f64) -> Self {
        let length = (b - a).norm();
        let axis = (b - a) / length;
        let area = std::f64::consts::PI * radius * radius;
        let cylinder = BONE_DENSITY * area * length;
        let caps = BONE_DENSITY * area * radius * 4.0 / 3.0;
        let along = cylinder * radius * radius / 2.0 + caps * radius * radius * 0.4;
        // Two half balls: 83/320 m r² about their own centre of mass, 3/8 r beyond the ends.
        let half_balls =
            caps * (83.0 / 320.0 * radius * radius + (length / 2.0 + 0.375 * radius).powi(2));
        let across = cylinder * (radius * radius / 4.0 + length * length / 12.0) + half_balls;
        let outer = axis * axis.transpose();
        Self {
            mass: cylinder + caps,
            centre: (a + b) / 2.0,
            inertia: outer * along + (Mat3::identity() - outer) * across,
        }
    }

    /// A solid box with these full edge lengths along the axes of `pose`.
    fn cuboid(pose: &Pose, edges: &Vec3) -> Self {
        let mass = BONE_DENSITY * edges.x * edges.y * edges.z;
        let squares = edges.component_mul(edges);
        let sum = squares.sum();
        let local = Mat3::from_diagonal(&(Vec3::repeat(sum) - squares)) * (mass / 12.0);
        let r = pose.rotation.to_rotation_matrix();
        Self { mass, centre: pose.position, inertia: r * local * r.transpose() }
    }

    /// All of them as one body (Steiner).
    fn sum(parts: &[Self]) -> Self {
        let mass: f64 = parts.iter().map(|p| p.mass).sum();
        let centre = parts.iter().map(|p| p.centre * p.mass).sum::<Vec3>() / mass;
        let inertia = parts
            .iter()
            .map(|p| {
                let d = p.centre - centre;
                p.inertia + (Mat3::identity() * d.norm_squared() - d * d.transpose()) * p.mass
            })
            .sum();
        Self { mass, centre, inertia }
    }
}

/// The bone nearest to a place in M, for errors.
pub(crate) fn nearest(bones: &[Bone], p: &Vec3) -> Option<String> {
    let far = |bone: &Bone| {
        let [a, b] = bone.ends_B.map(|end| bone.pose_MB.point(&end));
        let along = b - a;
        let part = (p - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
        (a + along * part.clamp(0.0, 1.0) - p).norm()
    };
    let near = bones.iter().min_by(|a, b| far(a).total_cmp(&far(b)))?;
    Some(format!("bone {}", quoted(&near.name)))
}

/// All bones in order: the palm, then three per digit from the thumb on.
pub(super) fn bones(digits: &[DigitRig], surface: &Bvh, length: f64) -> Vec<Bone> {
    let mut bones = vec![palm(digits, surface, length)];
    for rig in digits {
        for k in 0..3 {
            let parent = if k == 0 { 0 } else { bones.len() as u32 - 1 };
            bones.push(moving_bone(rig, k, parent, surface));
        }
    }
    bones
}

fn moving_bone(rig: &DigitRig, k: usize, parent: u32, surface: &Bvh) -> Bone {
    let [a, b] = rig.bone(k);
    let radius = RADIUS * depth(&a, &b, surface);
    // The capsule's caps lie within the joints.
    let inset = rig.direction(k) * radius.min(0.4 * (b - a).norm());
    let mass = Mass::capsule(&(a + inset), &(b - inset), radius);
    let name = format!("{}-{}", rig.digit.name(), names::bone_names(rig.digit)[k]);
    let tracked = (rig.joint_names[k].clone(), rig.joints[k]);
    bone(name, rig.digit, Some(parent), mass, [a, b], radius, tracked)
}

/// The four metacarpals and the carpus as one bone.
fn palm(digits: &[DigitRig], surface: &Bvh, length: f64) -> Bone {
    let fingers = &digits[1..];
    let mut parts = Vec::new();
    let mut radius: f64 = 0.0;
    for rig in fingers {
        let (a, b) = (rig.base, rig.joints[0].position);
        let r = METACARPAL_RADIUS * depth(&a, &b, surface);
        let inset = rig.direction_before(0) * r;
        parts.push(Mass::capsule(&(a + inset), &(b - inset), r));
        radius = radius.max(r);
    }

    // The carpus: a box from the wrist to the bases of the metacarpals, as wide as they are.
    let middle = fingers.iter().map(|f| f.base).sum::<Vec3>() / 4.0;
    let across = fingers[3].base - fingers[0].base;
    let edges = Vec3::new(across.norm() + 2.0 * radius, CARPUS_THICKNESS * length, middle.norm());
    let frame = Quat::face_towards(&middle, &Vec3::y());
    parts.push(Mass::cuboid(&Pose::new(middle / 2.0, frame), &edges));

    let ends = [Vec3::zeros(), fingers[1].joints[0].position];
    let tracked = (names::WRIST.to_owned(), Pose::identity());
    bone("palm".into(), Digit::Palm, None, Mass::sum(&parts), ends, radius, tracked)
}

fn bone(
    name: String,
    digit: Digit,
    parent: Option<u32>,
    mass: Mass,
    ends: [Vec3; 2],
    radius: f64,
    (tracked_joint, pose_MT): (String, Pose),
) -> Bone {
    let pose_MB = Pose::new(mass.centre, pose_MT.rotation);
    let r = pose_MB.rotation.inverse().to_rotation_matrix();
    let inertia = r * mass.inertia * r.transpose();
    Bone {
        name,
        parent,
        pose_MB,
        mass: mass.mass,
        inertia: (inertia + inertia.transpose()) / 2.0,
        digit,
        ends_B: ends.map(|p| pose_MB.inverse_point(&p)),
        radius,
        tracked_joint: Some(tracked_joint),
        pose_BT: pose_MB.inverse() * pose_MT,
    }
}

/// Mean distance to the skin along the middle of a bone.
fn depth(a: &Vec3, b: &Vec3, surface: &Bvh) -> f64 {
    let places = [0.2, 0.35, 0.5, 0.65, 0.8];
    let sum: f64 = places.iter().map(|t| surface.closest(&a.lerp(b, *t)).distance).sum();
    sum / places.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mass, centre and inertia of a body given as an indicator function, by summing over a grid.
    fn sampled(inside: impl Fn(&Vec3) -> bool, half: f64, n: i32) -> Mass {
        let h = 2.0 * half / f64::from(n);
        let mut parts = Vec::new();
        for i in 0..n * n * n {
            let cell = [i % n, i / n % n, i / n / n].map(|c| (f64::from(c) + 0.5) * h - half);
            let p = Vec3::from(cell);
            if inside(&p) {
                parts.push(Mass::cuboid(&Pose::new(p, Default::default()), &Vec3::repeat(h)));
            }
        }
        Mass::sum(&parts)
    }

    #[test]
    fn capsule_inertia_agrees_with_summation() {
        let (a, b, radius) = (Vec3::new(-0.2, 0.1, -0.3), Vec3::new(0.3, -0.1, 0.4), 0.25);
        let inside = |p: &Vec3| {
            let t = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
            (p - a.lerp(&b, t)).norm() < radius
        };
        let (sum, exact) = (sampled(inside, 0.8, 80), Mass::capsule(&a, &b, radius));
        // Cells of 1/12 of the radius leave about half a percent.
        assert!((sum.mass / exact.mass - 1.0).abs() < 5e-3);
        assert!((sum.centre - exact.centre).norm() < 1e-3);
        assert!((sum.inertia - exact.inertia).norm() < 1e-2 * exact.inertia.norm());
    }
}
