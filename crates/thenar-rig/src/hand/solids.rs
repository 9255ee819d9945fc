//! The solids of bones: what of a bone touches other bodies when flesh is crushed.
//!
//! The solid of a moving bone is the capsule whose mass and inertia it has; that of the palm is a box
//! around its metacarpals. Neither is thicker than the flesh over it anywhere: a capsule's radius is at
//! most half the least distance from its axis to the skin, and the box is made smaller until the skin
//! is nowhere nearer than half its thickness.

use super::digits::DigitRig;
use crate::mesh::Bvh;
use thenar::model::{Bone, BoneSolid};
use thenar::shape::Shape;
use thenar::{Pose, Quat, Vec3};

/// Places along a capsule's axis, and along each edge of a box, where the flesh is measured: at most
/// 3 mm apart on a hand of 190 mm.
const SAMPLES: usize = 16;
/// The box shrinks by this in each attempt.
const SHRINK: f64 = 0.97;

/// A solid and the flesh over it.
pub(super) struct Covered {
    pub solid: BoneSolid,
    /// Twice the radius of a capsule, the least edge of a box \[m\].
    pub thickness: f64,
    /// Least distance from its surface to the skin \[m\].
    pub flesh: f64,
}

/// The solids of all bones, in their order: the palm, then three per digit.
pub(super) fn solids(bones: &[Bone], digits: &[DigitRig], surface: &Bvh) -> Vec<Covered> {
    let moving = bones.iter().skip(1).map(|bone| capsule(bone, surface));
    bones.iter().take(1).map(|bone| palm(bone, digits, surface)).chain(moving).collect()
}

/// The capsule between a bone's ends.
fn capsule(bone: &Bone, surface: &Bvh) -> Covered {
    let [a, b] = bone.ends_B;
    let length = (b - a).norm();
    // The caps lie within the joints, as those of its mass do.
    let inset = bone.radius.min(0.4 * length);
    let half_length = 0.5 * length - inset;
    let share = |k: usize| (inset + 2.0 * half_length * fraction(k)) / length;
    let places = (0..SAMPLES).map(|k| bone.pose_MB.point(&a.lerp(&b, share(k))));
    let least = places.map(|p| -surface.signed_distance(&p)).fold(f64::INFINITY, f64::min);
    let radius = bone.radius.min(0.5 * least);
    let turn = Quat::rotation_between(&Vec3::y(), &(b - a)).unwrap_or_else(Quat::identity);
    let pose_BS = Pose::new((a + b) / 2.0, turn);
    Covered {
        solid: BoneSolid { shape: Shape::Capsule { radius, half_length }, pose_BS },
        thickness: 2.0 * radius,
        flesh: least - radius,
    }
}

/// The box around the four metacarpals, in the plane that runs between them.
fn palm(bone: &Bone, digits: &[DigitRig], surface: &Bvh) -> Covered {
    let rays: Vec<[Vec3; 2]> =
        digits[1..].iter().map(|rig| [rig.base, rig.joints[0].position]).collect();
    let center = rays.iter().map(|[a, b]| (a + b) / 2.0).sum::<Vec3>() / rays.len() as f64;
    let along = rays.iter().map(|[a, b]| b - a).sum::<Vec3>();
    let middle = |ray: &[Vec3; 2]| (ray[0] + ray[1]) / 2.0;
    let across = middle(&rays[rays.len() - 1]) - middle(&rays[0]);
    let turn = Quat::face_towards(&along, &along.cross(&across));
    let pose_MS = Pose::new(center, turn);
    let extent = |axis: &Vec3| {
        let reach = rays.iter().flatten().map(|p| pose_MS.inverse_point(p).dot(axis).abs());
        reach.fold(0.0, f64::max)
    };
    let whole = Vec3::new(extent(&Vec3::x()), bone.radius, extent(&Vec3::z()));
    let flesh = |half: &Vec3| {
        let places = box_places(half).map(|p| -surface.signed_distance(&pose_MS.point(&p)));
        places.fold(f64::INFINITY, f64::min)
    };
    let sizes = std::iter::successors(Some(whole), |half| Some(half * SHRINK));
    // A hundred attempts leave a twentieth, which lies within any palm that has flesh at all.
    let half = sizes.take(100).find(|half| flesh(half) >= half.y).unwrap_or(whole * 0.05);
    Covered {
        solid: BoneSolid {
            shape: Shape::Cuboid { half },
            pose_BS: bone.pose_MB.inverse() * pose_MS,
        },
        thickness: 2.0 * half.min(),
        flesh: flesh(&half),
    }
}

/// Places on the surface of a box.
fn box_places(half: &Vec3) -> impl Iterator<Item = Vec3> + '_ {
    let grid = (0..SAMPLES).flat_map(|i| (0..SAMPLES).map(move |j| (i, j)));
    grid.flat_map(move |(i, j)| {
        let [s, t] = [i, j].map(|k| 2.0 * fraction(k) - 1.0);
        [-1.0, 1.0].into_iter().flat_map(move |side| {
            [Vec3::new(side, s, t), Vec3::new(s, side, t), Vec3::new(s, t, side)]
        })
    })
    .map(|p| half.component_mul(&p))
}

fn fraction(k: usize) -> f64 {
    k as f64 / (SAMPLES - 1) as f64
}
