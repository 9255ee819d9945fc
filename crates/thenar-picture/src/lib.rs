//! Pictures without a screen: a small software renderer.
//!
//! A [`Scene3d`] of triangle meshes is drawn by rasterisation into a visibility buffer, then
//! shaded once per pixel and surface: one key light with soft shadows, a sky and a ground as
//! ambient light, and ambient occlusion. The same scene gives the same bytes on every machine
//! of one build, whatever the number of threads.
//!
//! World units are metres. Colours are linear unless their name says sRGB.

mod actors;
mod ambient;
mod assemble;
mod bodies;
mod camera;
mod clip;
mod colour;
mod draw;
mod encode;
mod from_session;
mod image;
mod layers;
mod normals;
mod pattern;
mod portrait;
mod raster;
mod render;
mod scene3d;
mod shade;
mod shadow;
mod shapes;
mod skin;
mod stage;
mod surface;
mod tile;

pub use actors::{HandActor, Soft};
pub use camera::Camera;
pub use encode::{EncodeError, Movie, write_png};
pub use from_session::{camera, draw};
pub use image::Image;
pub use layers::Layers;
pub use portrait::portrait;
pub use render::{Quality, render};
pub use scene3d::{Backdrop, Ground, Material, Pattern};
pub use shapes::of_shape;
pub use stage::{Scales, Stage};

/// A vector in single precision, relative to the camera's target.
type V = nalgebra::Vector3<f32>;

#[cfg(test)]
mod tests;
