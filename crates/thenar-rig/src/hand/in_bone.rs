//! The nodes of the flesh that stand for bone, and how much of it each has.
//!
//! Springs spread through a bone, of so much stiffness per volume, make the matrix `κ ∫ Nᵢ Nⱼ dV`
//! of the nodes' shape functions. What stands for it here is its diagonal, scaled so that the whole
//! stays `κ V`: every inside point of the lattice that lies in a bone's solid gives to the four
//! nodes of its tetrahedron by the squares of its barycentric weights (for masses: Hinton, Rock and
//! Zienkiewicz 1976). Given by the weights themselves, a far corner of an element that a bone only
//! touches would be held nearly as one in its middle: an index pad in cubes of 6.7 mm sank by 1.25
//! mm at 1 N, by squares it sinks by 1.45 mm, and in cubes of 2.7 mm by 1.63 mm. A node follows the
//! bone whose volume it has, or two adjacent bones by their shares. There is no threshold: what has
//! no bone is free. The whole falls short of the solid's volume by what is left free below, and by
//! what a node that has a share of more than two bones loses of the others, which the report tells
//! (`bound` beside `volume`).
//!
//! A node with shares of bones of two digits is left free. Held by one of them it would stand a
//! fraction of an element from nodes that the other holds, and a finger could not be bent beside a
//! straight one: its knuckle is 0.02 to 0.05 N m/rad stiffer with such nodes. (A bone of which a
//! coarse mesh would hold less than half keeps them.) A node that follows one bone alone is left
//! free where the utmost bend of a joint at either end carries it to the other side of the plane
//! that halves the bend. Nodes reach as far past a solid as the mesh is coarse, and in the bend of
//! a fist those of two bones would pass each other there, with the flesh between them inside out.

use crate::lattice::{Lattice, tet};
use crate::weights::pair;
use std::collections::BTreeMap;
use thenar_core::model::{Binding, Bone, BoneNode, BoneSolid, Digit, JointDesc, JointKind};
use thenar_core::shape::{PlacedShape, Shape};
use thenar_core::{Pose, Quat, Vec3};

/// Volume of each bone that a node stands for \[m³\].
pub(crate) type Shares = BTreeMap<u32, f64>;

/// Least part of its solid's volume by which a bone is held when nodes that tie digits are freed.
const HELD_MIN: f64 = 0.5;

/// The nodes that stand for bone, ascending.
pub(super) fn bone_nodes(
    lattice: &Lattice,
    bones: &[Bone],
    joints: &[JointDesc],
    solids: &[BoneSolid],
) -> Vec<BoneNode> {
    let points = points_in_solids(lattice, bones, solids);
    let volumes: Vec<f64> = solids.iter().map(|solid| volume(&solid.shape)).collect();
    let shares = shares(lattice, &points, &volumes);
    let bends: Vec<BentJoint> = joints.iter().filter_map(BentJoint::utmost).collect();
    let held = held(&shares, bones);
    let carried = |held: &BoneNode| {
        let x = &lattice.nodes[held.node as usize];
        bends.iter().any(|bend| bend.carries_across(&held.binding, x, bones))
    };
    let ties = |held: &BoneNode| ties_digits(&shares[held.node as usize], bones);
    // Volume by which each bone is held without the nodes that tie digits: of a coarse mesh that
    // may be too little.
    let mut without = vec![0.0; bones.len()];
    for held in held.iter().filter(|held| !ties(held) && !carried(held)) {
        for (bone, weight) in held.binding.bones.iter().zip(held.binding.weights) {
            without[*bone as usize] += weight * held.volume;
        }
    }
    let does_without = |b: u32| without[b as usize] > HELD_MIN * volume(&solids[b as usize].shape);
    let stays = |held: &BoneNode| {
        let freed = ties(held) && held.binding.bones.iter().all(|&bone| does_without(bone));
        !freed && !carried(held)
    };
    // A bone of a mesh so coarse that all of its nodes would go keeps them.
    let mut kept = vec![false; bones.len()];
    for held in held.iter().filter(|held| stays(held)) {
        held.binding.bones.iter().for_each(|&bone| kept[bone as usize] = true);
    }
    held.into_iter().filter(|held| stays(held) || !kept[held.binding.bones[0] as usize]).collect()
}

/// Share of each bone's volume \[m³\] that each node has; `points` are the bones' inside points.
pub(crate) fn shares(lattice: &Lattice, points: &[Vec<usize>], volumes: &[f64]) -> Vec<Shares> {
    let mut shares: Vec<Shares> = vec![Shares::new(); lattice.nodes.len()];
    for (b, (points, volume)) in points.iter().zip(volumes).enumerate() {
        let of_points = points.iter().map(|&i| weights(lattice, i).map(|w| w * w));
        let whole: f64 = of_points.clone().flatten().sum();
        let each = volume / whole;
        for (&i, weights) in points.iter().zip(of_points) {
            let nodes = lattice.tets[lattice.sample_tet(i) as usize];
            for (node, weight) in nodes.iter().zip(weights) {
                *shares[*node as usize].entry(b as u32).or_insert(0.0) += each * weight;
            }
        }
    }
    shares
}

/// The nodes that have shares, ascending.
pub(crate) fn held(shares: &[Shares], bones: &[Bone]) -> Vec<BoneNode> {
    let nodes = shares.iter().enumerate();
    nodes.filter_map(|(n, shares)| bone_node(n as u32, shares, bones)).collect()
}

/// True if a node has shares of bones of two digits.
fn ties_digits(shares: &Shares, bones: &[Bone]) -> bool {
    let digits = shares.keys().map(|&b| bones[b as usize].digit);
    let mut digits = digits.filter(|digit| *digit != Digit::Palm);
    digits.next().is_some_and(|first| digits.any(|other| other != first))
}

/// A joint bent to the end of its range.
struct BentJoint<'a> {
    joint: &'a JointDesc,
    /// Frame K of the child in J, fully bent.
    pose_JK: Pose,
    /// Along the straight digit, away from the parent.
    along_J: Vec3,
    /// Normal of the plane that halves the bend, away from the parent.
    halving_J: Vec3,
}

impl<'a> BentJoint<'a> {
    /// None of a joint that has no range.
    fn utmost(joint: &'a JointDesc) -> Option<Self> {
        let flexion = match joint.kind {
            JointKind::Hinge => &joint.axes[0],
            JointKind::Universal => &joint.axes[1],
            _ => return None,
        };
        let turn = Quat::from_axis_angle(&Vec3::x_axis(), flexion.limit?.max);
        // The child lies along z of K, or against it.
        let along_J = Vec3::z() * joint.pose_CK.inverse_point(&Vec3::zeros()).z.signum();
        let halving_J = (along_J + turn * along_J).try_normalize(f64::EPSILON)?;
        Some(Self { joint, pose_JK: Pose::new(Vec3::zeros(), turn), along_J, halving_J })
    }

    /// True if a place \[m\] of the rest pose that follows one of the joint's two bones alone is on
    /// that bone's side when the joint is straight and on the other's when it is bent. Only what
    /// lies within half the child's length of the joint meets it there.
    fn carries_across(&self, binding: &Binding, x_M: &Vec3, bones: &[Bone]) -> bool {
        let [bone, other] = binding.bones;
        if bone != other {
            return false;
        }
        let x_B = bones[bone as usize].pose_MB.inverse_point(x_M);
        let [a, b] = bones[self.joint.child as usize].ends_B;
        let swept = 0.5 * (b - a).norm();
        let along =
            |x_J: &Vec3, normal: &Vec3| if x_J.norm() < swept { normal.dot(x_J) } else { 0.0 };
        if Some(bone) == self.joint.parent {
            let x_J = self.joint.pose_PJ.inverse_point(&x_B);
            along(&x_J, &self.along_J) < 0.0 && along(&x_J, &self.halving_J) > 0.0
        } else if bone == self.joint.child {
            let x_K = self.joint.pose_CK.inverse_point(&x_B);
            let x_J = self.pose_JK.point(&x_K);
            along(&x_K, &self.along_J) > 0.0 && along(&x_J, &self.halving_J) < 0.0
        } else {
            false
        }
    }
}

/// Inside points in the solid of each bone; where it lies between all of them, the one nearest to
/// its middle.
fn points_in_solids(lattice: &Lattice, bones: &[Bone], solids: &[BoneSolid]) -> Vec<Vec<usize>> {
    let poses: Vec<Pose> =
        bones.iter().zip(solids).map(|(bone, solid)| bone.pose_MB * solid.pose_BS).collect();
    let mut points = vec![Vec::new(); solids.len()];
    let mut nearest = vec![(f64::INFINITY, 0); solids.len()];
    for i in 0..lattice.sample_count() {
        let x = lattice.sample_position(i);
        for (b, pose) in poses.iter().enumerate() {
            let distance = (x - pose.position).norm();
            if distance < nearest[b].0 {
                nearest[b] = (distance, i);
            }
            if contains(&solids[b].shape, &pose.inverse_point(&x)) {
                points[b].push(i);
            }
        }
    }
    for (points, (_, i)) in points.iter_mut().zip(nearest) {
        if points.is_empty() {
            points.push(i);
        }
    }
    points
}

/// Barycentric weights of inside point `i`. Where its own tetrahedron was left out as nearly empty,
/// it may lie outside the one that took it over: the place in that one that has no negative
/// weights.
fn weights(lattice: &Lattice, i: usize) -> [f64; 4] {
    let corners = lattice.corners(lattice.sample_tet(i) as usize);
    let inside = tet::barycentric(&corners, &lattice.sample_position(i)).map(|w| w.max(0.0));
    let sum: f64 = inside.iter().sum();
    inside.map(|w| w / sum)
}

/// The bone, or the two adjacent ones, of which the node has most.
fn bone_node(node: u32, shares: &Shares, bones: &[Bone]) -> Option<BoneNode> {
    let share = |b: u32| shares.get(&b).copied().unwrap_or(0.0);
    let with_parent = shares.keys().map(|&b| match bones[b as usize].parent {
        Some(parent) => (b, parent, share(b) + share(parent)),
        None => (b, b, share(b)),
    });
    // Of equals the first.
    let most = with_parent.reduce(|best, next| if next.2 > best.2 { next } else { best });
    let (bone, parent, volume) = most.filter(|(_, _, volume)| *volume > 0.0)?;
    let own = if bone == parent { 1.0 } else { share(bone) / volume };
    Some(BoneNode { node, binding: pair(parent, bone, own), volume })
}

/// True if a point of the solid's frame lies in it.
fn contains(shape: &Shape, p: &Vec3) -> bool {
    match *shape {
        Shape::Capsule { radius, half_length } => {
            let axis = Vec3::y() * p.y.clamp(-half_length, half_length);
            (p - axis).norm_squared() <= radius * radius
        }
        Shape::Cuboid { half } => (0..3).all(|d| p[d].abs() <= half[d]),
        Shape::Compound(ref parts) => {
            parts.iter().any(|part| contains(&part.shape, &part.pose_SP.inverse_point(p)))
        }
        ref other => unreachable!("the solid of a bone is a {other:?}"),
    }
}

/// Volume of a bone's solid \[m³\].
pub(super) fn volume(shape: &Shape) -> f64 {
    match *shape {
        Shape::Capsule { radius, half_length } => {
            std::f64::consts::PI * radius * radius * (2.0 * half_length + radius * 4.0 / 3.0)
        }
        Shape::Cuboid { half } => 8.0 * half.x * half.y * half.z,
        Shape::Compound(ref parts) => union_volume(parts),
        ref other => unreachable!("the solid of a bone is a {other:?}"),
    }
}

/// Volume of two parallel capsules of one size side by side, less what both have \[m³\].
fn union_volume(parts: &[PlacedShape]) -> f64 {
    let [a, b] = parts else { unreachable!("the solid of a bone is of {} parts", parts.len()) };
    let Shape::Capsule { radius: r, half_length } = a.shape else {
        unreachable!("the solid of a bone is of a {:?}", a.shape)
    };
    let d = (b.pose_SP.position - a.pose_SP.position).norm().min(2.0 * r);
    let circles = 2.0 * r * r * (0.5 * d / r).acos() - 0.5 * d * (4.0 * r * r - d * d).sqrt();
    let balls = std::f64::consts::PI * (4.0 * r + d) * (2.0 * r - d).powi(2) / 12.0;
    2.0 * volume(&a.shape) - 2.0 * half_length * circles - balls
}
