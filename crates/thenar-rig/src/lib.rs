//! Builds simulation-ready hands and objects from meshes.
//!
//! Units are SI (m, kg, s, N, Pa). Nothing here knows about scenes or devices, and no input,
//! however malformed, makes it panic: it returns a [`RigError`] that names the thing and the cause.

pub mod embed;
mod error;
pub mod export;
pub mod figure;
pub mod glb;
pub mod hand;
pub mod lattice;
pub mod mesh;
pub mod model_file;
pub mod object;
mod size;
mod united;
pub mod weights;
pub mod work;

pub use error::RigError;
pub use hand::{HandOptions, HandReport, build_hand, default_hand, uniform_hand};
pub use mesh::TriMesh;
pub use model_file::{Model, read_model, write_model};
