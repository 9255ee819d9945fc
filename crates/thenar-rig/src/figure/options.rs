//! Options of figures.

use crate::RigError;
use crate::error::positive;
use thenar_core::Vec3;
use thenar_core::model::{AngleLimit, JointKind, Law, Material};

/// Options for building a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureOptions {
    /// Name of the figure.
    pub name: String,
    /// Factor on all lengths of the file.
    pub scale: f64,
    /// Thickness of the flesh around bones \[m\], of files without a skin.
    pub thickness: Option<f64>,
    /// Wanted number of tetrahedra.
    pub tets: usize,
    /// Material of the flesh.
    pub material: Material,
    /// Rayleigh damping, mass-proportional \[1/s\].
    pub mass_damping: f64,
    /// Rayleigh damping, stiffness-proportional \[s\].
    pub stiffness_damping: f64,
    /// Coulomb friction coefficient of the skin.
    pub friction: f64,
    /// Wanted number of triangles of the surface that touches.
    pub collision_triangles: usize,
    /// Wanted number of triangles of the surface that is drawn.
    pub render_triangles: usize,
    /// Changes to joints, one after the other.
    pub joints: Vec<JointChange>,
    /// Names of the skinned meshes that are the body, where a file is read; none: the one that
    /// encloses most.
    pub meshes: Vec<String>,
}

impl Default for FigureOptions {
    /// Flesh as that of hands, in a thousand tetrahedra; but nothing damps its motion as a whole,
    /// so that what floats keeps its momentum.
    fn default() -> Self {
        Self {
            name: "figure".into(),
            scale: 1.0,
            thickness: None,
            tets: 1000,
            material: Material {
                law: Law::Corotational,
                young: 50e3,
                poisson: 0.43,
                density: 1080.0,
            },
            mass_damping: 0.0,
            stiffness_damping: 1e-3,
            friction: 0.6,
            collision_triangles: 1500,
            render_triangles: 12_000,
            joints: Vec::new(),
            meshes: Vec::new(),
        }
    }
}

impl FigureOptions {
    /// Errs on the first number that makes no sense.
    pub(super) fn check(&self) -> Result<(), RigError> {
        positive("figure scale", self.scale)?;
        positive("Young's modulus", self.material.young)?;
        positive("density", self.material.density)?;
        let poisson = self.material.poisson;
        if !(poisson > -1.0 && poisson < 0.5) {
            let expected = "above -1 and below 0.5";
            return Err(RigError::Parameter { name: "Poisson's ratio", expected, value: poisson });
        }
        for (name, value) in [
            ("mass damping", self.mass_damping),
            ("stiffness damping", self.stiffness_damping),
            ("friction coefficient", self.friction),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                let expected = "finite and not negative";
                return Err(RigError::Parameter { name, expected, value });
            }
        }
        Ok(())
    }
}

/// Changes to joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointChange {
    /// Name of the joint or of its bone; a `*` at the end stands for any ending.
    pub name: String,
    /// Another kind, with an axis in M for a hinge, or two at right angles for a universal joint
    /// (first the parent's). A fixed joint and a ball need none.
    pub kind: Option<(JointKind, Vec<Vec3>)>,
    /// Smallest and largest value of each angle \[rad\].
    pub ranges: Vec<AngleLimit>,
    /// Spring of each angle \[N m/rad\]; of a ball one.
    pub stiffness: Vec<f64>,
    /// Damper of each angle \[N m s/rad\]; of a ball one.
    pub damping: Vec<f64>,
}
