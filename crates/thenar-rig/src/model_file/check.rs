//! Checks of decoded models: whatever passes can be simulated.

use crate::RigError;
use crate::lattice::tet;
use crate::object::{RigidModel, SoftModel};
use crate::size::{bounds, sensible_size};
use thenar_core::model::{
    Binding, Bone, BoneNode, BoneSolid, CouplingKind, EmbeddedSurface, Flesh, HandModel, JointDesc,
    JointKind, Law, OGDEN_ALPHA,
};
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Pose, Vec3};

type Check = Result<(), RigError>;

/// Sums of weights may be off by this.
const SUM_TOLERANCE: f64 = 1e-9;

/// Errs unless every index is in range, every number is finite and positive where it must be.
pub(crate) fn hand(hand: &HandModel) -> Check {
    ensure(!hand.bones.is_empty(), || "the hand has no bones".into())?;
    for (i, bone) in hand.bones.iter().enumerate() {
        check_bone(i, bone)?;
    }
    let joints = hand.bones.len() - 1;
    ensure(hand.joints.len() == joints, || {
        format!("{} joints for {} bones, expected one less", hand.joints.len(), hand.bones.len())
    })?;
    for (j, joint) in hand.joints.iter().enumerate() {
        check_joint(j, joint, &hand.bones)?;
    }

    flesh(&hand.flesh)?;
    let nodes = hand.flesh.nodes.len();
    ensure(hand.bindings.len() == nodes && hand.node_volumes.len() == nodes, || {
        format!("{nodes} nodes need as many bindings and volumes")
    })?;
    for (i, binding) in hand.bindings.iter().enumerate() {
        check_binding(i, binding, &hand.bones)?;
    }
    numbers("node volume", hand.node_volumes.iter().copied(), |v| v >= 0.0)?;
    check_bone_nodes(&hand.bone_nodes, hand)?;
    check_bone_nodes(&hand.nail_nodes, hand)?;
    let unheld = hand.coupling == CouplingKind::Bone && hand.bone_nodes.is_empty();
    ensure(!unheld, || "the flesh is held in bone, but no node stands for bone".into())?;
    let (regions, triangles) = (hand.regions.len(), hand.flesh.collision.triangles.len());
    ensure(regions == 0 || regions == triangles, || {
        format!("{regions} regions for {triangles} triangles that touch")
    })?;
    surface("render surface", &hand.render, hand.flesh.tets.len())?;
    let vertices = hand.flesh.collision.vertices.len();
    ensure(hand.collision_digits.len() == vertices, || {
        format!("{vertices} collision vertices need as many digits")
    })?;
    check_solids(&hand.solids, &hand.bones)?;
    let (axes, bending) = (hand.axes().count(), hand.bending.len());
    ensure(bending == 0 || bending == axes * axes, || {
        format!(
            "{bending} stiffnesses of the flesh for {axes} axes of joints, expected their square"
        )
    })?;
    numbers("stiffness of the flesh", hand.bending.iter().copied(), |_| true)?;
    numbers("hand length", [hand.length], |l| l > 0.0)
}

/// Checks a deformable body.
pub(super) fn flesh(flesh: &Flesh) -> Check {
    ensure(!flesh.tets.is_empty(), || "the body has no tetrahedra".into())?;
    ensure(flesh.materials.len() == flesh.tets.len(), || {
        format!("{} materials for {} tetrahedra", flesh.materials.len(), flesh.tets.len())
    })?;
    numbers("node position", flesh.nodes.iter().flat_map(|x| x.iter().copied()), |_| true)?;
    sensible_size(bounds(&flesh.nodes))?;
    for (t, nodes) in flesh.tets.iter().enumerate() {
        let all = nodes.iter().all(|&n| (n as usize) < flesh.nodes.len());
        ensure(all, || format!("tetrahedron {t} names a node that is not there"))?;
        let volume = tet::volume(&nodes.map(|n| flesh.nodes[n as usize]));
        ensure(volume > 0.0, || format!("tetrahedron {t} has volume {volume:e} m³"))?;
    }
    for material in &flesh.materials {
        numbers("Young's modulus", [material.young], |x| x > 0.0)?;
        numbers("Poisson's ratio", [material.poisson], |x| x > -1.0 && x < 0.5)?;
        numbers("density", [material.density], |x| x > 0.0)?;
        if let Law::Ogden { alpha } = material.law {
            let [least, most] = OGDEN_ALPHA;
            numbers("Ogden's exponent", [alpha], |x| (least..=most).contains(&x))?;
            numbers("Poisson's ratio of Ogden's law", [material.poisson], |x| x >= 0.0)?;
        }
    }
    let relaxations = flesh.relaxation.len();
    ensure(relaxations == 0 || relaxations == flesh.tets.len(), || {
        format!("{relaxations} relaxations for {} tetrahedra", flesh.tets.len())
    })?;
    let rest = [flesh.mass_damping, flesh.stiffness_damping, flesh.friction];
    numbers("damping or friction", rest, |x| x >= 0.0)?;
    let fixed = flesh.fixed.iter().all(|f| (f.node as usize) < flesh.nodes.len());
    ensure(fixed, || "a held node is not there".into())?;
    surface("collision surface", &flesh.collision, flesh.tets.len())
}

/// Checks an embedded surface.
pub(super) fn surface(what: &str, surface: &EmbeddedSurface, tets: usize) -> Check {
    for (i, vertex) in surface.vertices.iter().enumerate() {
        let sum: f64 = vertex.weights.iter().sum();
        let whole =
            vertex.weights.iter().all(|w| w.is_finite()) && (sum - 1.0).abs() < SUM_TOLERANCE;
        ensure((vertex.tet as usize) < tets && whole, || {
            format!("{what}: vertex {i} is not embedded in a tetrahedron")
        })?;
    }
    let count = surface.vertices.len();
    let inside = surface.triangles.iter().flatten().all(|&v| (v as usize) < count);
    ensure(inside, || format!("{what}: a triangle names a vertex that is not there"))
}

/// Checks a deformable body without bones.
pub(super) fn soft(soft: &SoftModel) -> Check {
    flesh(&soft.flesh)?;
    surface("render surface", &soft.render, soft.flesh.tets.len())
}

/// Checks a rigid body; one that cannot move may have neither mass nor inertia.
pub(super) fn rigid(rigid: &RigidModel) -> Check {
    let name = &rigid.name;
    numbers("mass", [rigid.mass], |m| m >= 0.0)?;
    numbers("inertia", rigid.inertia.iter().copied(), |_| true)?;
    ensure(rigid.mass == 0.0 || definite(&rigid.inertia), || {
        format!("{name}: its inertia is not symmetric positive definite")
    })?;
    ensure(placement(&rigid.pose_MB) && placement(&rigid.pose_BS), || {
        format!("{name}: its pose is not a placement")
    })?;
    numbers("friction", [rigid.friction], |f| f >= 0.0)?;
    shape(&rigid.shape)?;

    let triangles = &rigid.render.triangles;
    check_triangles("render surface", &rigid.render.positions, triangles)?;
    let runs = rigid.paint.windows(2).all(|w| w[0].first < w[1].first)
        && rigid.paint.iter().all(|p| (p.first as usize) < triangles.len());
    ensure(runs, || format!("{name}: its colours are out of order or beyond the triangles"))?;
    let colours = rigid.paint.iter().flat_map(|p| p.colour.map(f64::from));
    numbers("colour", colours, |c| (0.0..=1.0).contains(&c))
}

fn shape(shape: &Shape) -> Check {
    match shape {
        Shape::Sphere { radius } => numbers("sphere radius", [*radius], |r| r > 0.0),
        Shape::Capsule { radius, half_length } => {
            numbers("capsule radius", [*radius], |r| r > 0.0)?;
            numbers("capsule length", [*half_length], |l| l >= 0.0)
        }
        Shape::Cuboid { half } => numbers("half edge", half.iter().copied(), |h| h > 0.0),
        Shape::HalfSpace => Ok(()),
        Shape::Cylinder { radius, half_length } => {
            numbers("cylinder radius or length", [*radius, *half_length], |x| x > 0.0)
        }
        Shape::Ellipsoid { half } => numbers("half axis", half.iter().copied(), |h| h > 0.0),
        Shape::Cone { radius, height } => {
            numbers("cone radius or height", [*radius, *height], |x| x > 0.0)
        }
        Shape::Compound(parts) => {
            ensure(!parts.is_empty(), || "a compound has no parts".into())?;
            parts.iter().try_for_each(|part| {
                let nested = matches!(part.shape, Shape::HalfSpace | Shape::Compound(_));
                ensure(!nested, || "a compound holds a plane or a compound".into())?;
                ensure(placement(&part.pose_SP), || "a part's pose is not a placement".into())?;
                self::shape(&part.shape)
            })
        }
        Shape::Mesh(mesh) => {
            check_triangles("contact mesh", &mesh.points, &mesh.triangles)?;
            sensible_size(bounds(&mesh.points))?;
            let grid = &mesh.grid;
            numbers("grid spacing", [grid.cell], |c| c > 0.0)?;
            numbers("grid origin", grid.origin.iter().copied(), |_| true)?;
            let count = grid.dims.iter().try_fold(1_usize, |n, &d| n.checked_mul(d as usize));
            ensure(count == Some(grid.values.len()) && grid.dims.iter().all(|&d| d >= 2), || {
                format!("a grid of {:?} does not hold {} values", grid.dims, grid.values.len())
            })?;
            numbers("distance", grid.values.iter().map(|&v| f64::from(v)), |_| true)
        }
    }
}

fn check_triangles(what: &str, positions: &[Vec3], triangles: &[[u32; 3]]) -> Check {
    numbers(what, positions.iter().flat_map(|x| x.iter().copied()), |_| true)?;
    let inside = triangles.iter().flatten().all(|&v| (v as usize) < positions.len());
    ensure(inside, || format!("{what}: a triangle names a vertex that is not there"))
}

fn definite(inertia: &Mat3) -> bool {
    let asymmetry = (inertia - inertia.transpose()).norm();
    asymmetry <= 1e-9 * inertia.norm() && inertia.cholesky().is_some()
}

fn check_bone(i: usize, bone: &Bone) -> Check {
    let what = || format!("bone {i} ({})", bone.name);
    let parent = match (i, bone.parent) {
        (0, None) => true,
        (0, Some(_)) | (_, None) => false,
        (i, Some(parent)) => (parent as usize) < i,
    };
    ensure(parent, || format!("{}: its parent must come before it", what()))?;
    ensure(placement(&bone.pose_MB) && placement(&bone.pose_BT), || {
        format!("{}: its pose is not a placement", what())
    })?;
    numbers("bone mass", [bone.mass], |m| m > 0.0)?;
    numbers("bone radius", [bone.radius], |r| r >= 0.0)?;
    numbers("bone end", bone.ends_B.iter().flat_map(Vec3::iter).copied(), |_| true)?;
    numbers("bone inertia", bone.inertia.iter().copied(), |_| true)?;
    ensure(definite(&bone.inertia), || {
        format!("{}: its inertia is not symmetric positive definite", what())
    })
}

fn check_solids(solids: &[BoneSolid], bones: &[Bone]) -> Check {
    ensure(solids.is_empty() || solids.len() == bones.len(), || {
        format!("{} solids for {} bones", solids.len(), bones.len())
    })?;
    solids.iter().zip(bones).enumerate().try_for_each(|(i, (solid, bone))| {
        let what = || format!("bone {i} ({})", bone.name);
        let valid = placement(&solid.pose_BS) && solid.shape != Shape::HalfSpace;
        ensure(valid, || format!("{}: its solid is not placed in it", what()))?;
        shape(&solid.shape).map_err(|e| RigError::invalid(format!("{}: {e}", what())))
    })
}

fn check_joint(j: usize, joint: &JointDesc, bones: &[Bone]) -> Check {
    let what = || format!("joint {j} ({})", joint.name);
    let child = j + 1;
    ensure(joint.child as usize == child && joint.parent == bones[child].parent, || {
        format!("{}: must join bone {child} to its parent", what())
    })?;
    ensure(joint.kind != JointKind::Free, || format!("{}: leaves its bone loose", what()))?;
    ensure(placement(&joint.pose_PJ) && placement(&joint.pose_CK), || {
        format!("{}: its frame is not a placement", what())
    })?;
    let springs = joint.axes.iter().flat_map(|a| [a.stiffness, a.damping]);
    let springs = springs.chain([joint.limit_stiffness, joint.limit_damping]);
    numbers("joint stiffness or damping", springs, |x| x >= 0.0)?;
    numbers("joint rest angle", joint.axes.iter().map(|a| a.rest_angle), |_| true)?;
    for limit in joint.axes.iter().filter_map(|a| a.limit) {
        numbers("joint range", [limit.max - limit.min], |x| x >= 0.0)?;
    }
    Ok(())
}

fn check_binding(i: usize, binding: &Binding, bones: &[Bone]) -> Check {
    let [a, b] = binding.bones;
    let there = binding.bones.iter().all(|&bone| (bone as usize) < bones.len());
    ensure(there, || format!("node {i} is bound to a bone that is not there"))?;
    let adjacent =
        a == b || bones[a as usize].parent == Some(b) || bones[b as usize].parent == Some(a);
    ensure(adjacent, || format!("node {i} is bound to bones {a} and {b}, which do not meet"))?;
    let sum = binding.weights[0] + binding.weights[1];
    let valid = binding.weights.iter().all(|&w| w >= 0.0) && (sum - 1.0).abs() < SUM_TOLERANCE;
    ensure(valid, || format!("node {i} has the weights {:?}", binding.weights))
}

fn check_bone_nodes(nodes: &[BoneNode], hand: &HandModel) -> Check {
    let ascending = nodes.windows(2).all(|pair| pair[0].node < pair[1].node);
    let last = nodes.last().is_none_or(|n| (n.node as usize) < hand.flesh.nodes.len());
    ensure(ascending && last, || "the nodes in bone are not in order, or not there".into())?;
    for bone_node in nodes {
        check_binding(bone_node.node as usize, &bone_node.binding, &hand.bones)?;
    }
    numbers("volume of bone", nodes.iter().map(|n| n.volume), |v| v > 0.0)
}

fn placement(pose: &Pose) -> bool {
    pose.is_finite() && (pose.rotation.coords.norm() - 1.0).abs() < 1e-9
}

fn numbers(what: &str, values: impl IntoIterator<Item = f64>, ok: impl Fn(f64) -> bool) -> Check {
    values
        .into_iter()
        .find(|&x| !x.is_finite() || !ok(x))
        .map_or(Ok(()), |x| Err(RigError::invalid(format!("the {what} {x} is not valid"))))
}

fn ensure(ok: bool, what: impl FnOnce() -> String) -> Check {
    if ok { Ok(()) } else { Err(RigError::invalid(what())) }
}
