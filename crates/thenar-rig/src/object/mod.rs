//! Objects to grasp: rigid and deformable bodies, generated or made from meshes.

mod boundary;
mod bread;
mod car;
mod crust;
mod extent;
mod import;
mod lattice_box;
mod primitive;
mod rigid;
mod soft;
mod solids;

pub use boundary::boundary_surface;
pub use bread::{Bread, bread};
pub use car::{Car, toy_car};
pub use crust::crust;
pub use extent::{
    Extent, length_in_words, mass_in_words, size_in_words, unit_question, volume_in_words,
};
pub use import::{ImportOptions, Interior, MeshReport, Weight, rigid_from_mesh};
pub use lattice_box::{Cubes, graded, graded_block, lattice_box};
pub use primitive::{rigid_box, rigid_capsule, rigid_sphere, static_plane};
pub use rigid::{ColourRun, RigidModel};
pub use soft::{SoftModel, SoftOptions, SoftReport, check_material, soft_from_tets};
pub use solids::{Ball, ball};
