//! Which points touch: shapes, distances, broad and narrow phase.

mod shape;

pub use shape::{DistanceGrid, MeshShape, Shape};
