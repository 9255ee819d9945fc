//! Common parts of the fuzz targets that build things. Ordinary tests run the same code.

pub mod bodies;
pub mod profiles;
pub mod recordings;
pub mod scenes;
