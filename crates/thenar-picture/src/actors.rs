//! Surfaces and colours to draw bodies with, which a world does not know.

use super::colour::Rgb;
use super::scene3d::Material;
use std::ops::Range;
use thenar_core::model::{EmbeddedSurface, HandModel};
use thenar_rig::TriMesh;
use thenar_rig::object::ColourRun;

/// A hand in a picture.
pub struct HandActor<'a> {
    /// Model of the hand.
    pub model: &'a HandModel,
    /// Bones of the hand among the rigid bodies.
    pub bones: Range<u32>,
    /// Joints of the hand among the world's joints.
    pub joints: Range<u32>,
}

/// A deformable body.
pub struct Soft<'a> {
    /// Index among the deformable bodies.
    pub index: u32,
    /// Surface to draw.
    pub render: &'a EmbeddedSurface,
    /// Material of the surface.
    pub material: Material,
    /// Colours per vertex of `render`, multiplied with the material's.
    pub colours: Option<Vec<Rgb>>,
    /// The hand that it is the flesh of.
    pub hand: Option<&'a HandModel>,
}

/// Look of a rigid body. The default draws its contact shape in a colour of its own.
#[derive(Clone, Copy, Default)]
pub struct Rigid<'a> {
    /// Colour, if one was chosen.
    pub colour: Option<Rgb>,
    /// A mesh in the body's frame \[m\], finer than the contact shape, and the colours of its
    /// parts.
    pub mesh: Option<(&'a TriMesh, &'a [ColourRun])>,
}
