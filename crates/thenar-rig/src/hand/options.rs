//! Options for building a hand.

use super::layers::{self, Layer};
use super::names::NameMap;
use crate::RigError;
use thenar_core::model::{CouplingKind, Law, Material, Side};

/// Size to which a hand is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// Size in the file; where no hand is so long, in the unit that makes it one of people's.
    Own,
    /// The mesh times this.
    Scale(f64),
    /// So that wrist to middle fingertip measures this \[m\].
    Length(f64),
}

/// Source of the springs of joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Springs {
    /// From a table, beside what the bent flesh gives, whatever that is.
    Fixed,
    /// Remainder that the bent flesh leaves of the stiffness measured at the joints of the living;
    /// dampers by a damping ratio.
    Rest,
}

/// Options of [`build_hand`](super::build_hand).
#[derive(Clone, Debug)]
pub struct HandOptions {
    /// Name of the model.
    pub name: String,
    /// Side that the mesh must show; `None` takes what it shows.
    pub side: Option<Side>,
    /// Size of the hand.
    pub size: Size,
    /// Wanted number of tetrahedra, all of one size, where there is no `detail`.
    pub tets: usize,
    /// Detail of a graded mesh, from 0.25 to 1.5: at 1, on a hand of 190 mm, cubes of 4 mm at the
    /// pads of the fingers, 8 mm along the fingers and at the knuckles, 16 mm in palm and back; all
    /// are proportional to the hand's length and to 1/detail. The surface that touches is at least
    /// as fine.
    pub detail: Option<f64>,
    /// Flesh of a fully filled element. Its density is that of the whole hand, bones included;
    /// the flesh gets what the bones leave.
    pub material: Material,
    /// Young's modulus in the middle of a joint, relative to that elsewhere, in (0, 1]. Skin folds
    /// and slides over a joint; flesh of one modulus throughout would stiffen it several times.
    pub joint_softness: f64,
    /// Young's modulus, relative likewise, around the roots of the digits and in the webs between
    /// them, where fat is loose, in (0, 1].
    pub root_softness: f64,
    /// Source of the springs of joints.
    pub springs: Springs,
    /// Layers with materials of their own; `joint_softness` acts on them too.
    pub layers: Vec<Layer>,
    /// The flesh that the springs to the bones hold where a scene does not say.
    pub coupling: CouplingKind,
    /// Rayleigh damping of the flesh, mass-proportional \[1/s\].
    pub mass_damping: f64,
    /// Rayleigh damping of the flesh, stiffness-proportional \[s\].
    pub stiffness_damping: f64,
    /// Coulomb friction coefficient of the skin.
    pub friction: f64,
    /// Wanted number of triangles of the surface that touches.
    pub collision_triangles: usize,
    /// Smallest number of triangles of the surface that is drawn.
    pub render_triangles: usize,
    /// Names of the rig's joints where they differ from WebXR's.
    pub name_map: NameMap,
    /// Names of the skinned meshes that are the hand; none: the one that encloses most.
    pub meshes: Vec<String>,
}

/// Detail of the hand for touch. An index pad pressed on a plate at 30° sinks by 1.4 mm at 1 N with
/// cubes of 6.7 mm there.
const TOUCH_DETAIL: f64 = 0.6;

/// Flesh around the roots of the digits of a hand for touch: 5 kPa beside 50. Fat under the skin
/// has about 2 (0.53 kPa in shear, Sims et al. 2010, of pigs); skin and tendons in it are stiffer.
const TOUCH_ROOT: f64 = 0.1;

impl Default for HandOptions {
    /// For touch. Where `tets` is to count, start from [`HandOptions::paper`], whose mesh has no
    /// `detail`.
    fn default() -> Self {
        Self::touch()
    }
}

impl HandOptions {
    /// A hand for touch: pads finer than the palm, flesh that hangs on bone and is loose at the
    /// roots of the digits, and joints as stiff as those of the living; otherwise as the paper's.
    pub fn touch() -> Self {
        Self {
            detail: Some(TOUCH_DETAIL),
            coupling: CouplingKind::Bone,
            root_softness: TOUCH_ROOT,
            springs: Springs::Rest,
            ..Self::paper()
        }
    }

    /// The paper's mesh sizes and coupling, with the mesh as it is and flesh of 50 kPa.
    pub fn paper() -> Self {
        Self {
            name: "hand".into(),
            side: None,
            size: Size::Scale(1.0),
            tets: 600,
            detail: None,
            material: Material {
                law: Law::Corotational,
                young: 50e3,
                poisson: 0.43,
                density: 1080.0,
            },
            joint_softness: 0.2,
            root_softness: 1.0,
            springs: Springs::Fixed,
            layers: Vec::new(),
            coupling: CouplingKind::Uniform,
            mass_damping: 1.0,
            stiffness_damping: 1e-3,
            friction: 0.6,
            collision_triangles: 1441,
            render_triangles: 23_640,
            name_map: NameMap::new(),
            meshes: Vec::new(),
        }
    }
}

impl HandOptions {
    /// Errs on the first number that makes no sense.
    pub(super) fn check(&self) -> Result<(), RigError> {
        use crate::error::positive;
        match self.size {
            Size::Own => 1.0,
            Size::Scale(scale) => positive("hand scale", scale)?,
            Size::Length(length) => positive("hand length", length)?,
        };
        positive("Young's modulus", self.material.young)?;
        positive("density", self.material.density)?;
        for (name, value) in
            [("joint softness", self.joint_softness), ("root softness", self.root_softness)]
        {
            if !(value > 0.0 && value <= 1.0) {
                return Err(RigError::Parameter { name, expected: "above 0 and at most 1", value });
            }
        }
        non_negative("mass damping", self.mass_damping)?;
        non_negative("stiffness damping", self.stiffness_damping)?;
        non_negative("friction coefficient", self.friction)?;
        let poisson = self.material.poisson;
        if !(poisson > -1.0 && poisson < 0.5) {
            return Err(RigError::Parameter {
                name: "Poisson's ratio",
                expected: "above -1 and below 0.5",
                value: poisson,
            });
        }
        layers::check(self)?;
        for (name, count) in [
            ("collision triangles", self.collision_triangles),
            ("render triangles", self.render_triangles),
        ] {
            if !(100..=1_000_000).contains(&count) {
                return Err(RigError::invalid(format!(
                    "the number of {name} must be in 100..=1000000, not {count}"
                )));
            }
        }
        Ok(())
    }
}

fn non_negative(name: &'static str, value: f64) -> Result<f64, RigError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(RigError::Parameter { name, expected: "finite and not negative", value })
    }
}
