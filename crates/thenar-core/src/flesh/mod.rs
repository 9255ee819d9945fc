//! Finite elements for flesh (Sec. 3.2): linear tetrahedra with a choice of constitutive law.

mod assemble;
mod crush;
mod eight;
mod eight_principal;
mod element;
mod foresight;
mod lanes;
mod living;
mod membrane;
mod memory;
mod ogden;
mod patch;
mod patch_lanes;
mod polar;
mod principal;
mod principal_lanes;
mod rotations;

pub use assemble::{FleshModel, Tally};
pub use element::{PAIRS, Response, RestTet, respond};
pub(crate) use lanes::transposed;
pub use membrane::Membranes;
pub use memory::Faded;
pub use patch::Patches;
pub use polar::{rotation_of, signed_svd};
