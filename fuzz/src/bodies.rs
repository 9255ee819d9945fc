//! From the bytes of a file to two simulated steps, for every kind of body that a file can hold.
//!
//! The fuzz targets call these with what the fuzzer makes up, and
//! `crates/thenar-rig/tests/all/fuzz_builders.rs` with damaged copies of good files. Each returns
//! whether a body was made and stepped; a panic, a state that is not finite or an endless loop is
//! what they look for. Bodies are coarse, so that one takes milliseconds.

use thenar_core::model::{
    HandModel, HandPlacement, Law, Material, Motion, RigidDesc, Side, Skinning, SoftDesc, WorldDesc,
};
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Pose, Quat, Vec3, World};
use thenar_rig::embed::{EmbedOptions, embed};
use thenar_rig::export::{GlbMesh, Skeleton, VertexSkin, glb};
use thenar_rig::hand::asset;
use thenar_rig::mesh::{GridOptions, decimate, read_obj, read_stl, weld};
use thenar_rig::object::{ImportOptions, RigidModel, SoftModel, Weight, rigid_from_mesh};
use thenar_rig::{HandOptions, Model, RigError, TriMesh, build_hand};

/// Meshes of more triangles than this are not built: a fuzzer learns nothing from waiting.
const TRIANGLES_MAX: usize = 3000;

/// Reads a mesh; the kind of file is told as the program tells it, but for OBJ.
pub fn mesh(bytes: &[u8]) -> Result<TriMesh, RigError> {
    let mesh = match bytes {
        [b'g', b'l', b'T', b'F', ..] => thenar_rig::glb::read_glb(bytes),
        [b'v' | b'#' | b'f' | b'o' | b'm', ..] => read_obj(bytes),
        _ => read_stl(bytes),
    }?;
    match mesh.triangles.len() {
        0..=TRIANGLES_MAX => Ok(mesh),
        many => Err(RigError::invalid(format!("{many} triangles"))),
    }
}

/// The mesh in a file as a rigid body that falls.
pub fn rigid(bytes: &[u8]) -> Result<bool, RigError> {
    rigid_model(bytes).map(|model| falls(&Model::Rigid(model)))
}

/// The mesh in a file as a rigid body.
pub fn rigid_model(bytes: &[u8]) -> Result<RigidModel, RigError> {
    let grid = GridOptions { cells: 8, values_max: 3000, ..GridOptions::default() };
    let options = ImportOptions { grid, points_max: 200, ..ImportOptions::default() };
    let (model, report) = rigid_from_mesh("x", &mesh(bytes)?, Weight::Density(1000.0), &options)?;
    assert!(report.volume > 0.0 && report.grid_values <= 3000, "{report:?}");
    assert!(model.inertia.symmetric_eigenvalues().min() > 0.0, "{model:?}");
    Ok(model)
}

/// The mesh in a file as a soft body that falls.
pub fn soft(bytes: &[u8]) -> Result<bool, RigError> {
    let mesh = mesh(bytes)?;
    let [low, high] = mesh.bounds();
    let mut mesh = weld(&mesh, 1e-6 * (high - low).norm()).mesh.compacted();
    mesh.orient()?;
    let material = Material { law: Law::Corotational, young: 5e4, poisson: 0.4, density: 1000.0 };
    let options = EmbedOptions { tets: 40, collision_triangles: 60, ..EmbedOptions::default() };
    Ok(falls(&Model::Soft(embed(&mesh, &options, |_| material)?.into_model("x"))))
}

/// The skinned mesh in a file as a hand that falls.
pub fn hand(bytes: &[u8]) -> Result<bool, RigError> {
    hand_model(bytes).map(|model| falls(&Model::Hand(model)))
}

/// The skinned mesh in a file as a hand.
pub fn hand_model(bytes: &[u8]) -> Result<HandModel, RigError> {
    let coarse = HandOptions { tets: 100, collision_triangles: 150, ..HandOptions::paper() };
    build_hand(bytes, &HandOptions { render_triangles: 100, ..coarse })
}

/// Content of a model file, once its checksum is made to agree.
pub fn model(bytes: &[u8]) -> Result<bool, RigError> {
    Ok(falls(&Model::from_bytes(&sealed(bytes))?))
}

/// The bytes with length and checksum (FNV-1a) of a model file's header made right.
pub fn sealed(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if let Some(body) = bytes.get(32..) {
        let step = |h: u64, &b: &u8| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3);
        let checksum = body.iter().fold(0xcbf2_9ce4_8422_2325_u64, step);
        let length = body.len() as u64;
        bytes[16..24].copy_from_slice(&length.to_le_bytes());
        bytes[24..32].copy_from_slice(&checksum.to_le_bytes());
    }
    bytes
}

/// Puts a body over a floor and makes two steps; false when the world refuses it.
pub fn falls(model: &Model) -> bool {
    let mut desc = WorldDesc { time_step: 0.005, ..WorldDesc::default() };
    desc.add_rigid(floor());
    match model {
        Model::Rigid(rigid) => {
            desc.add_rigid(rigid.placed(&Pose::identity(), Motion::Dynamic));
        }
        Model::Soft(SoftModel { flesh, .. }) => {
            desc.add_soft(SoftDesc {
                name: "soft".into(),
                flesh: flesh.clone(),
                pose_WM: Pose::identity(),
                velocity_W: Vec3::zeros(),
                coupling: None,
            });
        }
        Model::Hand(hand) => {
            desc.add_hand(hand, &placement());
        }
    }
    let Ok(mut world) = World::new(desc) else { return false };
    let (input, sound) = (world.input(), world.state().is_sound());
    for _ in 0..2 {
        // A step whose numbers are not finite is taken back and told.
        let report = world.step(&input, &mut ());
        assert_eq!(world.state().is_sound(), sound, "{report:?}");
        assert!(sound || report.failure.is_some(), "{report:?}");
    }
    true
}

/// A floor that begins a little above the lowest point of most bodies, so that they touch it.
fn floor() -> RigidDesc {
    RigidDesc {
        name: "floor".into(),
        motion: Motion::Prescribed,
        mass: 0.0,
        inertia: Mat3::zeros(),
        pose_WB: Pose::new(Vec3::y() * -0.01, Quat::identity()),
        velocity_W: Vec3::zeros(),
        angular_velocity_W: Vec3::zeros(),
        shape: Some(Shape::HalfSpace),
        pose_BS: Pose::identity(),
        friction: 0.5,
    }
}

/// A hand that nothing drives; stiffness and damping as scenes have them.
fn placement() -> HandPlacement {
    HandPlacement {
        name: "hand".into(),
        pose_WM: Pose::identity(),
        coupling: thenar_core::model::CouplingKind::Uniform,
        coupling_stiffness: 2e9,
        coupling_damping_time: 0.01,
        skinning: Skinning::Linear,
        root_drive: None,
        bone_drive: None,
        solid_bones: true,
        nails: false,
    }
}

/// The shipped hand's skin with few triangles and all its joints, as a GLB file: a start for the
/// fuzzer.
pub fn small_hand() -> Result<Vec<u8>, RigError> {
    let rig = thenar_rig::glb::read_skinned_glb(asset(Side::Right))?;
    let skin = decimate(&weld(&rig.mesh, 1e-5).mesh.compacted(), 400)?;
    let skeleton = Skeleton {
        names: rig.joints.iter().map(|joint| joint.name.as_str()).collect(),
        parents: rig.joints.iter().map(|_| None).collect(),
        poses: rig.joints.iter().map(|joint| joint.pose).collect(),
    };
    let wrist = VertexSkin { bones: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
    let surface = GlbMesh {
        name: "skin",
        positions: &skin.positions,
        triangles: &skin.triangles,
        colour: [0.5; 3],
        skin: Some(&vec![wrist; skin.positions.len()]),
    };
    glb(&[surface], Some(&skeleton))
}
