//! Rigid bodies.

use super::shape::{self, Solid};
use super::{Built, Files, inertia, place};
use crate::format::{MotionWord, Rigid, Scene, Shape as Table};
use crate::math::{Mat3, Pose, Vec3};
use crate::text::Fault;
use thenar_core::model::{Motion, RigidDesc};
use thenar_core::shape::Shape;
use thenar_rig::TriMesh;
use thenar_rig::object::{Car, ColourRun, Weight};

/// Appearance of a rigid body.
#[derive(Clone, Debug)]
pub struct RigidAppearance {
    /// Red, green, blue from 0 to 1, if the scene says.
    pub colour: Option<[f64; 3]>,
    /// Mesh in the body's frame, with its colours, of a body made from a mesh.
    pub mesh: Option<(TriMesh, Vec<ColourRun>)>,
    /// The body's frame in the frame M that its shape was drawn in, which the scene places.
    pub pose_MB: Pose,
}

/// Adds all rigid bodies.
pub fn add_all(built: &mut Built, scene: &Scene, files: &Files) -> Result<(), Fault> {
    for rigid in &scene.rigid {
        built.names.add_rigid(&rigid.name, built.world.rigids.len() as u32)?;
        let (desc, look) = describe(rigid, files)?;
        built.memory.take_shape(desc.shape.as_ref(), |problem| rigid.name.fault(problem))?;
        built.world.add_rigid(desc);
        built.looks.push(look);
    }
    Ok(())
}

fn describe(rigid: &Rigid, files: &Files) -> Result<(RigidDesc, RigidAppearance), Fault> {
    let dynamic = rigid.motion == MotionWord::Dynamic;
    let weight = weight(rigid, dynamic)?;
    let solid = rigid.shape.as_ref().map(|s| shape::solid(s, weight.meshes, files)).transpose()?;
    if dynamic && matches!(solid, Some(Solid { shape: Shape::HalfSpace, .. })) {
        let problem = "a plane cannot be dynamic; set motion = \"fixed\" or \"scripted\"";
        return Err(rigid.name.fault(problem));
    }
    let still = rigid.velocity == Vec3::zeros() && rigid.angular_velocity == Vec3::zeros();
    if rigid.motion == MotionWord::Fixed && !still {
        return Err(rigid.name.fault("a fixed body has no velocity; set motion = \"scripted\""));
    }
    let frame = place::frame(rigid.shape_frame.as_ref())?;
    let (mass, inertia) = match dynamic {
        true => mass(rigid, &weight, solid.as_ref(), &frame)?,
        false => (rigid.mass.unwrap_or(0.0), Mat3::zeros()),
    };
    let position = rigid.position.as_ref().map_or(Vec3::zeros(), |p| p.value);
    let pose_WM = Pose::new(position, place::rotation(rigid.rotation.as_ref())?);
    let here = Pose::identity();
    let pose_MB = solid.as_ref().map_or(here, |s| s.pose_MB);
    let desc = RigidDesc {
        name: rigid.name.value.clone(),
        motion: if dynamic { Motion::Dynamic } else { Motion::Prescribed },
        mass,
        inertia,
        pose_WB: pose_WM * pose_MB,
        velocity_W: rigid.velocity,
        angular_velocity_W: rigid.angular_velocity,
        pose_BS: frame * solid.as_ref().map_or(here, |s| s.pose_BS),
        shape: solid.as_ref().map(|s| s.shape.clone()),
        friction: rigid.friction,
    };
    Ok((desc, RigidAppearance { colour: rigid.colour, mesh: solid.and_then(|s| s.look), pose_MB }))
}

/// Mass or density of a body, if its table gives them.
struct MassSpec {
    mass: Option<f64>,
    density: Option<f64>,
    /// For shapes from meshes, which are weighed when they are made.
    meshes: Weight,
}

fn weight(rigid: &Rigid, dynamic: bool) -> Result<MassSpec, Fault> {
    let (mass, density) = (rigid.mass, rigid.density);
    let built = rigid
        .shape
        .as_ref()
        .is_some_and(|s| matches!(&s.value, Table::Mesh(m) if m.file.value.ends_with(".thenar")));
    if built && (mass.is_some() || density.is_some()) {
        return Err(rigid
            .name
            .fault("a model file has its own mass: leave `mass` and `density` out"));
    }
    let toy = rigid.shape.as_ref().is_some_and(|s| matches!(s.value, Table::Car(_)));
    let meshes = match (mass, density) {
        (Some(m), None) => Weight::Mass(m),
        (None, Some(rho)) => Weight::Density(rho),
        (Some(_), Some(_)) => {
            return Err(rigid.name.fault("give `mass` or `density`, not both"));
        }
        (None, None) if toy => Weight::Mass(Car::default().mass),
        (None, None) if dynamic && !built => {
            return Err(rigid.name.fault("a dynamic body needs `mass` or `density`"));
        }
        (None, None) => Weight::Density(1000.0), // does not matter
    };
    Ok(MassSpec { mass, density, meshes })
}

/// Mass and inertia about the centre of mass, in B.
fn mass(
    rigid: &Rigid,
    given: &MassSpec,
    solid: Option<&Solid>,
    frame: &Pose,
) -> Result<(f64, Mat3), Fault> {
    let name = &rigid.name;
    let own = rigid.inertia.as_ref().map(inertia::from_numbers).transpose()?;
    if let Some((mass, inertia)) = solid.and_then(|s| s.weighed) {
        return match rigid.shape_frame {
            None => Ok((mass, own.unwrap_or(inertia))),
            Some(_) => {
                Err(name.fault("a shape from a mesh has its own frame: leave `shape_frame` out"))
            }
        };
    }
    let moments = solid.and_then(|s| s.moments);
    let mass = match (given.mass, given.density, moments) {
        (Some(mass), _, _) => mass,
        (None, Some(rho), Some((volume, _))) => rho * volume,
        _ => return Err(name.fault("`density` needs a shape with a volume; give `mass`")),
    };
    if let Some(inertia) = own {
        return Ok((mass, inertia));
    }
    let Some((volume, unit)) = moments else {
        return Err(name.fault("a dynamic body without a shape needs `inertia`"));
    };
    if frame.position.norm() > 1e-9 {
        let problem = "the shape's centre of mass is not the body's origin: give `inertia`, or no `shape_frame.position`";
        return Err(name.fault(problem));
    }
    let turn = frame.rotation.to_rotation_matrix();
    Ok((mass, turn.matrix() * unit * turn.matrix().transpose() * (mass / volume)))
}
