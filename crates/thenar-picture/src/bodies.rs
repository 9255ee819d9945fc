//! Rigid bodies, bones and joints as meshes.

use super::actors::{HandActor, Rigid};
use super::colour::{Rgb, from_srgb_triple, hex};
use super::draw::bone;
use super::scene3d::{Material, Mesh};
use super::shapes::{Solid, of_shape, sphere};
use thenar_core::model::{JointKind, Motion, RigidDesc};
use thenar_core::{Pose, Vec3, World};
use thenar_rig::TriMesh;
use thenar_rig::hand::cuff;
use thenar_rig::object::ColourRun;

/// Colours of bodies that were given none.
const PALETTE: [u32; 5] = [0xb3231f, 0x2a6fb0, 0x3f8f4f, 0xd08a1d, 0x6d4c9f];

/// A rigid body's look or contact shape; `None` for planes and bodies without shape.
pub fn rigid_mesh(desc: &RigidDesc, pose_WB: &Pose, look: &Rigid) -> Option<Mesh<'static>> {
    let material = Material::paint(look.colour.unwrap_or_else(|| colour_of(desc)));
    if let Some((mesh, paint)) = look.mesh {
        let positions: Vec<Vec3> = mesh.positions.iter().map(|p| pose_WB.point(p)).collect();
        let drawn = Mesh::new(positions, mesh.triangles.clone(), material);
        if paint.is_empty() || look.colour.is_some() {
            return Some(drawn);
        }
        let colours = Some(painted(mesh, paint).into());
        let white = Material { colour: [1.0; 3], ..Material::paint([1.0; 3]) };
        return Some(Mesh { colours, material: white, ..drawn });
    }
    let pose_WS = *pose_WB * desc.pose_BS;
    let solid = of_shape(desc.shape.as_ref()?, 64, 16)?;
    Some(solid.placed(&pose_WS).mesh(material))
}

/// Colours of a mesh's vertices; its parts share none.
fn painted(mesh: &TriMesh, paint: &[ColourRun]) -> Vec<Rgb> {
    let mut colours = vec![[0.8; 3]; mesh.positions.len()];
    for (k, part) in paint.iter().enumerate() {
        let end = paint.get(k + 1).map_or(mesh.triangles.len(), |next| next.first as usize);
        let triangles = mesh.triangles.get(part.first as usize..end).unwrap_or_default();
        for vertex in triangles.iter().flatten() {
            colours[*vertex as usize] = from_srgb_triple(part.colour.map(f64::from));
        }
    }
    colours
}

/// The cuff that a hand with flesh wears.
pub fn cuff_mesh(world: &World, hand: &HandActor) -> Option<Mesh<'static>> {
    let cuff = cuff(hand.model)?;
    let pose_WB = world.rigid_pose(hand.bones.start);
    let positions: Vec<Vec3> = cuff.positions.iter().map(|p| pose_WB.point(p)).collect();
    Some(Mesh::new(positions, cuff.triangles, Material { crease: Some(0.9), ..Material::cloth() }))
}

/// Fixed bodies look like furniture; others take the colour that belongs to their name.
fn colour_of(desc: &RigidDesc) -> Rgb {
    if desc.motion == Motion::Prescribed {
        return hex(0xa77f52);
    }
    let sum: usize = desc.name.bytes().map(usize::from).sum();
    hex(PALETTE[sum % PALETTE.len()])
}

/// The bones of a hand, and its joints: hinges blue, universal joints red (paper, Fig. 2).
pub fn bone_meshes(world: &World, hand: &HandActor) -> Vec<Mesh<'static>> {
    let mut bones = Solid::default();
    for (model, i) in hand.model.bones.iter().zip(hand.bones.clone()) {
        let pose = world.rigid_pose(i);
        bones.join(&bone(model.ends_B.map(|p| pose.point(&p)), 1.3 * model.radius));
    }
    let bone_look = Material { crease: Some(0.3), ..Material::bone() };
    let mut meshes = vec![bones.mesh(bone_look)];
    let kinds = [
        (vec![JointKind::Hinge], hex(0x2463c4)),
        (vec![JointKind::Universal], hex(0xcc2a22)),
        (vec![JointKind::Ball, JointKind::Fixed, JointKind::Free], hex(0x808080)),
    ];
    for (kind, colour) in kinds {
        let mut balls = Solid::default();
        for joint in hand.joints.clone().map(|j| &world.desc().joints[j as usize]) {
            if kind.contains(&joint.kind) {
                let place = (world.rigid_pose(joint.child) * joint.pose_CK).position;
                balls.join(&sphere(place, 0.0036, 20));
            }
        }
        if !balls.triangles.is_empty() {
            meshes.push(balls.mesh(Material { crease: None, ..Material::paint(colour) }));
        }
    }
    meshes
}
