//! Rigid bodies.

use super::shape::{self, Solid};
use super::{Built, inertia, place};
use crate::format::{MotionWord, Rigid, Scene};
use crate::math::{Mat3, Pose, Vec3};
use crate::text::Fault;
use std::path::Path;
use thenar::contact::Shape;
use thenar::model::{Motion, RigidDesc};

/// How a rigid body looks.
#[derive(Clone, Debug, Default)]
pub struct RigidLook {
    /// Red, green, blue from 0 to 1, if the scene says.
    pub colour: Option<[f64; 3]>,
    /// A mesh finer than the contact shape, in the body's frame.
    pub mesh: Option<LookMesh>,
}

/// Triangles to draw.
#[derive(Clone, Debug)]
pub struct LookMesh {
    /// Vertices in the body's frame \[m\].
    pub positions: Vec<Vec3>,
    /// Triangles, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Adds all rigid bodies.
pub fn add_all(built: &mut Built, scene: &Scene, folder: &Path) -> Result<(), Fault> {
    for rigid in &scene.rigid {
        built.names.add_rigid(&rigid.name, built.world.rigids.len() as u32)?;
        let (desc, look) = describe(rigid, folder)?;
        built.world.add_rigid(desc);
        built.looks.push(look);
    }
    Ok(())
}

fn describe(rigid: &Rigid, folder: &Path) -> Result<(RigidDesc, RigidLook), Fault> {
    let solid = rigid.shape.as_ref().map(|s| shape::solid(s, folder)).transpose()?;
    let pose_BS = place::frame(rigid.shape_frame.as_ref())?;
    let dynamic = rigid.motion == MotionWord::Dynamic;
    if dynamic && matches!(solid, Some(Solid { shape: Shape::HalfSpace, .. })) {
        return Err(rigid
            .name
            .fault("a plane cannot be dynamic; set motion = \"fixed\" or \"scripted\""));
    }
    let (mass, inertia) = if dynamic {
        mass(rigid, solid.as_ref(), &pose_BS)?
    } else {
        (rigid.mass.unwrap_or(0.0), Mat3::zeros())
    };
    let still = rigid.velocity == Vec3::zeros() && rigid.angular_velocity == Vec3::zeros();
    if rigid.motion == MotionWord::Fixed && !still {
        return Err(rigid.name.fault("a fixed body has no velocity; set motion = \"scripted\""));
    }
    let position = rigid.position.as_ref().map_or(Vec3::zeros(), |p| p.value);
    let (shape, mesh) = solid.map_or((None, None), |s| (Some(s.shape), s.look));
    let desc = RigidDesc {
        name: rigid.name.value.clone(),
        motion: if dynamic { Motion::Dynamic } else { Motion::Prescribed },
        mass,
        inertia,
        pose_WB: Pose::new(position, place::rotation(rigid.rotation.as_ref())?),
        velocity_W: rigid.velocity,
        angular_velocity_W: rigid.angular_velocity,
        shape,
        pose_BS,
        friction: rigid.friction,
    };
    let mesh = mesh.map(|m| LookMesh {
        positions: m.positions.iter().map(|p| pose_BS.point(p)).collect(),
        triangles: m.triangles,
    });
    Ok((desc, RigidLook { colour: rigid.colour, mesh }))
}

/// Mass and inertia about the centre of mass, in B.
fn mass(rigid: &Rigid, solid: Option<&Solid>, pose_BS: &Pose) -> Result<(f64, Mat3), Fault> {
    let name = &rigid.name;
    let homogeneous = solid.and_then(|s| s.moments);
    let mass = match (rigid.mass, rigid.density, homogeneous) {
        (Some(m), None, _) => m,
        (None, Some(rho), Some((volume, _))) => rho * volume,
        (None, Some(_), None) => {
            return Err(name.fault("`density` needs a shape with a volume; give `mass`"));
        }
        (Some(_), Some(_), _) => return Err(name.fault("give `mass` or `density`, not both")),
        (None, None, _) => return Err(name.fault("a dynamic body needs `mass` or `density`")),
    };
    if let Some(numbers) = &rigid.inertia {
        return Ok((mass, inertia::from_numbers(numbers)?));
    }
    let Some((volume, unit)) = homogeneous else {
        return Err(name.fault("a dynamic body without a shape needs `inertia`"));
    };
    let centre = pose_BS.position + pose_BS.rotation * solid.map_or(Vec3::zeros(), |s| s.centre);
    if centre.norm() > 1e-9 {
        let problem = "the shape's centre of mass is not the body's origin: give `inertia`, or no `shape_frame.position`";
        return Err(name.fault(problem));
    }
    let turn = pose_BS.rotation.to_rotation_matrix();
    Ok((mass, turn.matrix() * unit * turn.matrix().transpose() * (mass / volume)))
}
