//! Which points touch: shapes, distances, broad and narrow phase.

mod contact_point;
mod shape;

pub use contact_point::*;
pub use shape::{DistanceGrid, MeshShape, Shape};

/// stub
#[derive(Clone, Debug)]
pub struct Detector;
impl Detector {
    /// stub
    pub fn new(_: &crate::model::WorldDesc) -> Self {
        Self
    }
    /// stub
    pub fn capacity(&self) -> usize {
        10
    }
    /// stub
    pub fn find(
        &mut self,
        _h: f64,
        _m: f64,
        _p: &[RigidPlace],
        _s: &[SurfaceState<'_>],
        _out: &mut Vec<Contact>,
    ) {
    }
}
