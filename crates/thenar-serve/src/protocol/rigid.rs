//! Rigid bodies in a model message.

use super::arrays::{Array, Arrays, seven};
use serde::Serialize;
use thenar_core::model::{Motion, RigidDesc};
use thenar_core::shape::{PlacedShape, Shape};
use thenar_core::{Mat3, Pose, Vec3};
use thenar_rig::TriMesh;
use thenar_rig::object::ColourRun;
use thenar_scene::build::RigidAppearance;

/// A rigid body.
#[derive(Debug, Serialize)]
pub struct Rigid {
    name: String,
    kind: &'static str,
    fixed: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    radius: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    half_length: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    half: Option<[f64; 3]>,
    pose_BS: [f64; 7],
    colour: Option<[f64; 3]>,
    mesh: Option<Mesh>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    parts: Vec<Rigid>,
}

/// A mesh that is seen.
#[derive(Debug, Serialize)]
pub struct Mesh {
    positions: Array,
    triangles: Array,
    colours: Option<Array>,
}

/// Describes a body. `scripted` bodies are led along a path, so that prescribed motion does not
/// mean they never move.
pub fn rigid(
    desc: &RigidDesc,
    look: Option<&RigidAppearance>,
    bone: bool,
    scripted: bool,
    arrays: &mut Arrays,
) -> Rigid {
    let (mut kind, mut radius, mut half_length, mut half) = ("none", None, None, None);
    match &desc.shape {
        _ if bone => kind = "bone",
        None => {}
        Some(Shape::HalfSpace) => kind = "plane",
        Some(Shape::Sphere { radius: r }) => (kind, radius) = ("sphere", Some(*r)),
        Some(Shape::Capsule { radius: r, half_length: l }) => {
            (kind, radius, half_length) = ("capsule", Some(*r), Some(*l));
        }
        Some(Shape::Cuboid { half: h }) => (kind, half) = ("box", Some([h.x, h.y, h.z])),
        Some(Shape::Mesh(_)) => kind = "mesh",
        Some(Shape::Cylinder { radius: r, half_length: l }) => {
            (kind, radius, half_length) = ("cylinder", Some(*r), Some(*l));
        }
        Some(Shape::Ellipsoid { half: h }) => (kind, half) = ("ellipsoid", Some([h.x, h.y, h.z])),
        Some(Shape::Cone { radius: r, height: h }) => {
            (kind, radius, half_length) = ("cone", Some(*r), Some(0.5 * h));
        }
        Some(Shape::Compound(_)) => kind = "compound",
    }
    let colour = look.and_then(|look| look.colour);
    let mesh = match (look.and_then(|look| look.mesh.as_ref()), &desc.shape) {
        (Some((mesh, paint)), _) => {
            // A colour that the scene gives goes over the mesh's own.
            let paint: &[ColourRun] = if colour.is_some() { &[] } else { paint };
            Some(drawn(mesh, paint, arrays))
        }
        (None, Some(Shape::Mesh(shape))) => {
            let points: Vec<_> = shape.points.iter().map(|p| desc.pose_BS.point(p)).collect();
            Some(Mesh {
                positions: arrays.points(&points),
                triangles: arrays.triangles(&shape.triangles),
                colours: None,
            })
        }
        (None, _) => None,
    };
    Rigid {
        name: desc.name.clone(),
        kind,
        fixed: desc.motion == Motion::Prescribed && !scripted,
        radius,
        half_length,
        half,
        pose_BS: seven(&desc.pose_BS),
        colour,
        mesh,
        parts: match &desc.shape {
            Some(Shape::Compound(parts)) if !bone => {
                parts.iter().map(|part| self::part(part, &desc.pose_BS, arrays)).collect()
            }
            _ => Vec::new(),
        },
    }
}

/// A part of a compound, as a body of its own in the compound's frame.
fn part(part: &PlacedShape, pose_BS: &Pose, arrays: &mut Arrays) -> Rigid {
    let desc = RigidDesc {
        name: String::new(),
        motion: Motion::Dynamic,
        mass: 0.0,
        inertia: Mat3::zeros(),
        pose_WB: Pose::identity(),
        velocity_W: Vec3::zeros(),
        angular_velocity_W: Vec3::zeros(),
        shape: Some(part.shape.clone()),
        pose_BS: *pose_BS * part.pose_SP,
        friction: 0.0,
    };
    rigid(&desc, None, false, false, arrays)
}

pub(super) fn drawn(mesh: &TriMesh, paint: &[ColourRun], arrays: &mut Arrays) -> Mesh {
    Mesh {
        positions: arrays.points(&mesh.positions),
        triangles: arrays.triangles(&mesh.triangles),
        colours: (!paint.is_empty())
            .then(|| arrays.u8(4, painted(mesh, paint).into_iter().flatten())),
    }
}

/// Colours of a mesh's vertices; its parts share none.
fn painted(mesh: &TriMesh, paint: &[ColourRun]) -> Vec<[u8; 4]> {
    let mut colours = vec![[204, 204, 204, 255]; mesh.positions.len()];
    for (k, part) in paint.iter().enumerate() {
        let end = paint.get(k + 1).map_or(mesh.triangles.len(), |next| next.first as usize);
        let triangles = mesh.triangles.get(part.first as usize..end).unwrap_or_default();
        let [r, g, b] = part.colour.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8);
        for vertex in triangles.iter().flatten() {
            colours[*vertex as usize] = [r, g, b, 255];
        }
    }
    colours
}
