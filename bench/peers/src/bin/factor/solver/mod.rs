//! The core's factor, compiled from the core's own files: it has no public name there.

pub mod monolithic;

pub use thenar_core::kernels::BlockMatrix;
