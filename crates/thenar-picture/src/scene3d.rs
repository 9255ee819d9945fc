//! Contents of a picture: meshes, light, ground, backdrop.

use super::colour::{Rgb, hex};
use super::skin::SkinSite;
use std::borrow::Cow;
use thenar_core::Vec3;

/// Look of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Diffuse reflectance; multiplied by the vertex colour where the mesh has one.
    pub colour: Rgb,
    /// Reach of light round the terminator, per component, 0 to 1: flesh lets red through.
    pub wrap: Rgb,
    /// Strength of the highlight when seen straight on.
    pub specular: f32,
    /// Exponent of the highlight (10 dull, 200 polished).
    pub gloss: f32,
    /// Additional reflectance at grazing angles.
    pub rim: f32,
    /// 1 is opaque; below, only the nearest layer of the mesh is blended over what lies behind.
    pub opacity: f32,
    /// Shows its own colour whatever the light.
    pub unlit: bool,
    /// Casts a shadow and occludes.
    pub casts_shadow: bool,
    /// Drawn over everything that is not on top.
    pub on_top: bool,
    /// Faces that meet at more than this angle keep their edge \[rad\]; `None` smooths all.
    pub crease: Option<f64>,
}

impl Material {
    /// A dull surface.
    pub fn matte(colour: Rgb) -> Self {
        Self {
            colour,
            wrap: [0.0; 3],
            specular: 0.04,
            gloss: 18.0,
            rim: 0.04,
            opacity: 1.0,
            unlit: false,
            casts_shadow: true,
            on_top: false,
            crease: None,
        }
    }

    /// Human skin.
    pub fn skin() -> Self {
        Self {
            wrap: [0.42, 0.20, 0.14],
            specular: 0.10,
            gloss: 22.0,
            rim: 0.16,
            ..Self::matte(hex(0xe0a98c))
        }
    }

    /// Bread crust; darker where it is vertex-coloured so.
    pub fn crust() -> Self {
        Self { wrap: [0.15, 0.08, 0.04], specular: 0.05, gloss: 14.0, ..Self::matte(hex(0xd79a4e)) }
    }

    /// Soft plastic.
    pub fn rubber() -> Self {
        Self { wrap: [0.2; 3], specular: 0.12, ..Self::matte(hex(0x6f9fc8)) }
    }

    /// Cloth of a cuff.
    pub fn cloth() -> Self {
        Self { wrap: [0.12; 3], specular: 0.02, rim: 0.12, ..Self::matte(hex(0x39485a)) }
    }

    /// Material of bones.
    pub fn bone() -> Self {
        Self { wrap: [0.15; 3], specular: 0.12, gloss: 30.0, ..Self::matte(hex(0xefe6d0)) }
    }

    /// Car paint, or plastic.
    pub fn paint(colour: Rgb) -> Self {
        Self { specular: 0.55, gloss: 90.0, rim: 0.30, crease: Some(0.6), ..Self::matte(colour) }
    }

    /// A translucent overlay without shadow.
    pub fn ghost(colour: Rgb, opacity: f32) -> Self {
        Self { opacity, casts_shadow: false, rim: 0.35, wrap: [0.5; 3], ..Self::matte(colour) }
    }

    /// A colour without light: wires, labels.
    pub fn unlit(colour: Rgb) -> Self {
        Self { unlit: true, casts_shadow: false, ..Self::matte(colour) }
    }

    /// This material, drawn over everything else.
    pub fn over_everything(self) -> Self {
        Self { on_top: true, casts_shadow: false, ..self }
    }
}

/// A triangle mesh in the world.
#[derive(Clone, Debug)]
pub struct Mesh<'a> {
    /// Vertices, world \[m\].
    pub positions: Cow<'a, [Vec3]>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Cow<'a, [[u32; 3]]>,
    /// Unit normals per vertex; computed from the triangles when absent.
    pub normals: Option<Cow<'a, [Vec3]>>,
    /// Colours per vertex, multiplied with the material's.
    pub colours: Option<Cow<'a, [Rgb]>>,
    /// Place on a hand of each vertex; skin looks different from place to place.
    pub sites: Option<Vec<SkinSite>>,
    /// Material of the surface.
    pub material: Material,
    /// Both sides are drawn (open surfaces, wires).
    pub two_sided: bool,
}

impl<'a> Mesh<'a> {
    /// A closed mesh with computed normals and one colour.
    pub fn new(
        positions: impl Into<Cow<'a, [Vec3]>>,
        triangles: impl Into<Cow<'a, [[u32; 3]]>>,
        material: Material,
    ) -> Self {
        Self {
            positions: positions.into(),
            triangles: triangles.into(),
            normals: None,
            colours: None,
            sites: None,
            material,
            two_sided: false,
        }
    }

    /// This mesh with a colour per vertex.
    pub fn coloured(self, colours: impl Into<Cow<'a, [Rgb]>>) -> Self {
        Self { colours: Some(colours.into()), ..self }
    }
}

/// A colouring of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// One colour.
    Plain(Rgb),
    /// Squares of two colours with this edge length \[m\].
    Checker([Rgb; 2], f32),
    /// Planks of wood of this width \[m\].
    Wood(f32),
}

/// An infinite plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// A point of it \[m\].
    pub point: Vec3,
    /// Unit normal of the side that is seen.
    pub normal: Vec3,
    /// Pattern of colours.
    pub pattern: Pattern,
}

impl Ground {
    /// The horizontal plane at height `y` \[m\].
    pub fn horizontal(y: f64, pattern: Pattern) -> Self {
        Self { point: Vec3::new(0.0, y, 0.0), normal: Vec3::y(), pattern }
    }
}

/// The key light and the ambient light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Direction towards the key light.
    pub direction: Vec3,
    /// Colour and strength of the key light.
    pub key: Rgb,
    /// Apparent radius of the key light \[rad\]: softness of shadows.
    pub radius: f32,
    /// Ambient light from above.
    pub sky: Rgb,
    /// Ambient light from below.
    pub floor: Rgb,
}

impl Default for Light {
    fn default() -> Self {
        Self {
            direction: Vec3::new(-0.55, 1.0, 0.45),
            key: [0.86, 0.81, 0.74],
            radius: 0.09,
            sky: [0.40, 0.44, 0.50],
            floor: [0.20, 0.17, 0.15],
        }
    }
}

/// Colours behind everything else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Backdrop {
    /// At the horizon; the ground fades into it.
    pub horizon: Rgb,
    /// Colour overhead.
    pub zenith: Rgb,
}

impl Default for Backdrop {
    fn default() -> Self {
        Self { horizon: hex(0xe9edf1), zenith: hex(0xb4c3d2) }
    }
}

/// Everything in one picture.
#[derive(Clone, Debug, Default)]
pub struct Scene3d<'a> {
    /// Meshes; the translucent ones are drawn last, farthest first.
    pub meshes: Vec<Mesh<'a>>,
    /// Ground plane, if one is drawn.
    pub ground: Option<Ground>,
    /// Light of the scene.
    pub light: Light,
    /// Backdrop behind everything.
    pub backdrop: Backdrop,
}
