//! A hand as plain JSON, for programs that simulate it with other means.
//!
//! SI units, model frame M (y up). A pose is `{"position": [x, y, z], "rotation": [x, y, z, w]}`;
//! a matrix is a list of rows. Two values are derived, so that no reader has to repeat the
//! assembly: the volume of each tetrahedron, and the mass lumped at each node.

use super::hand::check;
use super::write_whole;
use crate::RigError;
use serde_json::{Value, json};
use std::path::Path;
use thenar_core::model::{Bone, EmbeddedSurface, Flesh, HandModel, JointDesc};
use thenar_core::{Mat3, Pose, Vec3};

/// The hand as JSON: `bones`, `joints`, `flesh` (nodes, tetrahedra, materials, bindings to bones)
/// and the surface that touches.
///
/// # Errors
/// When the model is not consistent.
pub fn hand_json(hand: &HandModel) -> Result<String, RigError> {
    check(hand)?;
    let document = json!({
        "format": "thenar-hand",
        "version": 1,
        "name": hand.name,
        "length": hand.length,
        "bones": hand.bones.iter().map(bone).collect::<Vec<_>>(),
        "joints": hand.joints.iter().map(joint).collect::<Vec<_>>(),
        "flesh": flesh(hand),
        "collision": surface(&hand.flesh.collision),
    });
    Ok(document.to_string())
}

/// Writes [`hand_json`] to a file.
///
/// # Errors
/// As there, and when the file cannot be written.
pub fn write_hand_json(path: &Path, hand: &HandModel) -> Result<(), RigError> {
    write_whole(path, hand_json(hand)?.as_bytes())
}

fn bone(bone: &Bone) -> Value {
    json!({
        "name": bone.name,
        "parent": bone.parent,
        "pose": pose(&bone.pose_MB),
        "mass": bone.mass,
        "inertia": rows(&bone.inertia),
        "ends": bone.ends_B.map(|p| xyz(&p)),
        "radius": bone.radius,
    })
}

fn joint(joint: &JointDesc) -> Value {
    let axes = joint.axes[..joint.kind.angles()].iter().map(|axis| {
        json!({
            "stiffness": axis.stiffness,
            "damping": axis.damping,
            "rest_angle": axis.rest_angle,
            "limit": axis.limit.map(|limit| [limit.min, limit.max]),
        })
    });
    json!({
        "name": joint.name,
        "kind": format!("{:?}", joint.kind).to_lowercase(),
        "parent": joint.parent,
        "child": joint.child,
        "pose_in_parent": pose(&joint.pose_PJ),
        "pose_in_child": pose(&joint.pose_CK),
        "axes": axes.collect::<Vec<_>>(),
        "limit_stiffness": joint.limit_stiffness,
        "limit_damping": joint.limit_damping,
    })
}

fn flesh(hand: &HandModel) -> Value {
    let flesh = &hand.flesh;
    let volumes: Vec<f64> = flesh.tets.iter().map(|tet| volume(flesh, tet)).collect();
    let mut masses = vec![0.0; flesh.nodes.len()];
    for ((tet, material), volume) in flesh.tets.iter().zip(&flesh.materials).zip(&volumes) {
        for &node in tet {
            masses[node as usize] += material.density * volume / 4.0;
        }
    }
    let mut flesh_json = json!({
        "nodes": flesh.nodes.iter().map(xyz).collect::<Vec<_>>(),
        "node_masses": masses,
        "node_volumes": hand.node_volumes,
        "tets": flesh.tets,
        "tet_volumes": volumes,
        "young": flesh.materials.iter().map(|m| m.young).collect::<Vec<_>>(),
        "poisson": flesh.materials.iter().map(|m| m.poisson).collect::<Vec<_>>(),
        "density": flesh.materials.iter().map(|m| m.density).collect::<Vec<_>>(),
        "mass_damping": flesh.mass_damping,
        "stiffness_damping": flesh.stiffness_damping,
        "friction": flesh.friction,
        "binding_bones": hand.bindings.iter().map(|b| b.bones).collect::<Vec<_>>(),
        "binding_weights": hand.bindings.iter().map(|b| b.weights).collect::<Vec<_>>(),
    });
    if !flesh.relaxation.is_empty() {
        flesh_json["relaxation"] = json!(flesh.relaxation);
    }
    flesh_json
}

fn surface(surface: &EmbeddedSurface) -> Value {
    json!({
        "tets": surface.vertices.iter().map(|v| v.tet).collect::<Vec<_>>(),
        "weights": surface.vertices.iter().map(|v| v.weights).collect::<Vec<_>>(),
        "triangles": surface.triangles,
    })
}

fn volume(flesh: &Flesh, tet: &[u32; 4]) -> f64 {
    let [a, b, c, d] = tet.map(|i| flesh.nodes[i as usize]);
    Mat3::from_columns(&[b - a, c - a, d - a]).determinant() / 6.0
}

fn pose(pose: &Pose) -> Value {
    let q = pose.rotation.coords;
    json!({ "position": xyz(&pose.position), "rotation": [q.x, q.y, q.z, q.w] })
}

fn xyz(v: &Vec3) -> [f64; 3] {
    [v.x, v.y, v.z]
}

fn rows(m: &Mat3) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| m[(r, c)]))
}
