//! From the tables of a scene to the description of a world, and to what acts on it and is
//! measured in it, all by index.

mod assets;
mod drivers;
mod figure;
mod figure_motors;
mod files;
mod grip;
mod hand;
mod hand_cache;
mod hand_joints;
mod hand_store;
mod inertia;
mod joint;
mod lattice;
mod load;
mod memory;
mod mesh_cache;
mod motion;
mod motor;
mod names;
mod pair;
mod place;
mod pose_offsets;
mod preset;
mod recent;
mod rigid;
mod select;
mod shape;
mod soft;
mod solver;
mod tissue;
mod train;

pub use drivers::{Driver, Follow, PoseTrack};
pub use figure::{BuiltFigure, figure_joints};
pub use files::Files;
pub use hand::{BuiltHand, HandParts};
pub use hand_joints::change_by_file;
pub use hand_store::keep_hands_in;
pub use load::{ActiveLoad, Factor, LoadKind};
pub use memory::{BODIES_BYTES_MAX, Memory, TET_BYTES};
pub use motor::Motor;
pub use names::Names;
pub use preset::{USUAL as USUAL_PRESET, is_papers_by_solver, preset};
pub use rigid::RigidAppearance;
pub use select::{Face, Mesh};
pub use soft::SoftBuild;
pub use train::Train;

use crate::format::Scene;
use crate::grip::GripHand;
use crate::math::Vec3;
use crate::text::Fault;
use thenar_core::model::WorldDesc;

/// A scene made ready: all names resolved, all files read.
#[derive(Debug)]
pub struct Built {
    /// The world's description.
    pub world: WorldDesc,
    /// Indices that the scene's names stand for.
    pub names: Names,
    /// Hands, in the order of the file.
    pub hands: Vec<BuiltHand>,
    /// Figures, in the order of the file.
    pub figures: Vec<BuiltFigure>,
    /// Motors of joints.
    pub motors: Vec<Motor>,
    /// Motors that joints share with others that mimic them.
    pub trains: Vec<Train>,
    /// Soft bodies other than hands: figures, then the others, each in the order of the file.
    pub softs: Vec<SoftBuild>,
    /// Rest meshes for selectors, one for each deformable body of the world.
    pub meshes: Vec<Mesh>,
    /// Start positions of the nodes of each deformable body of the world where they differ from
    /// the rest shape, world \[m\].
    pub node_starts: Vec<Option<Vec<Vec3>>>,
    /// Scripted and driven rigid bodies.
    pub drivers: Vec<Driver>,
    /// Loads that act on bodies.
    pub loads: Vec<ActiveLoad>,
    /// Memory that the bodies take.
    pub memory: Memory,
    /// Appearance of rigid bodies, one entry per rigid body of the world.
    pub looks: Vec<RigidAppearance>,
    /// Grips of hands, one entry per hand; `None` for those whose scene asks for nothing.
    pub grips: Vec<Option<Box<GripHand>>>,
}

/// Memory that the bodies of a scene will take \[bytes\], as far as it says so itself: that of
/// files is not counted.
pub fn wanted_bytes(scene: &Scene) -> u64 {
    let softs = scene.soft.iter().filter_map(|soft| soft::tets_wanted(&soft.shape.value));
    let hands = scene.hand.iter().map(|hand| assets::tets_wanted(hand, preset(scene, hand)));
    let figures = scene.figure.iter().map(figure::tets_wanted);
    let tets = softs.chain(hands).chain(figures).fold(0, u64::saturating_add);
    tets.saturating_mul(TET_BYTES).saturating_add(memory::RIGID_BYTES * scene.rigid.len() as u64)
}

/// Builds a scene; `files` tells where those that it names are.
///
/// # Errors
/// A name, a file or a combination of values is wrong; the fault says which and where.
pub fn build(scene: &Scene, files: &Files) -> Result<Built, Fault> {
    let mut built = Built {
        world: WorldDesc {
            gravity: scene.gravity,
            time_step: scene.time_step,
            solver: solver::settings(scene.solver.as_ref()),
            ..WorldDesc::default()
        },
        names: Names::default(),
        hands: Vec::new(),
        figures: Vec::new(),
        motors: Vec::new(),
        trains: Vec::new(),
        softs: Vec::new(),
        meshes: Vec::new(),
        node_starts: Vec::new(),
        drivers: Vec::new(),
        loads: Vec::new(),
        looks: Vec::new(),
        grips: Vec::new(),
        memory: Memory::default(),
    };
    rigid::add_all(&mut built, scene, files)?;
    hand::add_all(&mut built, scene, files)?;
    figure::add_all(&mut built, scene, files)?;
    joint::add_all(&mut built, scene)?;
    soft::add_all(&mut built, scene, files)?;
    pair::add_all(&mut built, scene)?;
    drivers::add_all(&mut built, scene)?;
    figure::follow_all(&mut built, scene)?;
    load::add_all(&mut built, scene)?;
    grip::add_all(&mut built, scene)?;
    Ok(built)
}
