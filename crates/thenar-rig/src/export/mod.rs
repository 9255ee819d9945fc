//! Models and moments for other programs: VTK files for ParaView, GLB files for everything that
//! reads glTF, JSON for other simulators.
//!
//! Lengths are metres in every file; axes are kept (y up). Files are complete or not there.

mod file;
mod gltf;
mod hand;
mod json;
mod pvd;
mod skinning;
mod vtk;

pub use file::write_whole;
pub use gltf::{GlbMesh, Skeleton, VertexSkin, glb};
pub use hand::{hand_glb, write_hand_glb, write_hand_vtk};
pub use json::{hand_json, write_hand_json};
pub use pvd::Series;
pub use skinning::{dominant_bone, vertex_skin};
pub use vtk::{Field, Values, flesh_cell_fields, lines, surface, tetrahedra};
