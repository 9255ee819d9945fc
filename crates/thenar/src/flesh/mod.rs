//! Finite elements for flesh (Sec. 3.2): linear tetrahedra with a choice of constitutive law.

mod assemble;
mod element;
mod polar;
mod principal;

pub use assemble::{FleshModel, Tally};
pub use element::{PAIRS, Response, RestTet, respond};
pub use polar::{rotation_of, signed_svd};
