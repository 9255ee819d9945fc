//! Builds simulation-ready hands and objects from meshes.
//!
//! Units are SI (m, kg, s, N, Pa). Nothing here knows about scenes or devices, and no input,
//! however malformed, makes it panic: it returns a [`RigError`] that names the thing and the cause.

mod error;
pub mod mesh;

pub use error::RigError;
pub use mesh::TriMesh;
