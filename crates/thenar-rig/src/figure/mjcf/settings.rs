//! Settings of the `<compiler>` element.

use super::{Element, RigError};
use std::path::{Path, PathBuf};
use thenar_core::Vec3;

/// Condition under which masses come from geoms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FromGeoms {
    Never,
    Auto,
    Always,
}

/// Settings of a file.
#[derive(Clone, Debug)]
pub(super) struct Settings {
    /// Radians in the file's unit of angle.
    pub angle: f64,
    /// Axes of the three Euler angles; true where an axis turns with the body.
    pub euler: [(Vec3, bool); 3],
    /// A range alone limits a joint.
    pub autolimits: bool,
    /// Folder of meshes.
    pub mesh_folder: PathBuf,
    /// Only the last part of a mesh's path counts.
    pub strip_path: bool,
    /// Condition under which masses come from geoms.
    pub from_geoms: FromGeoms,
    /// First and last group of geoms that have mass.
    pub mass_groups: [f64; 2],
}

impl Settings {
    /// The settings of all `<compiler>` elements, of which later ones count.
    pub fn read(root: Element<'_>, folder: &Path) -> Result<Self, RigError> {
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        let mut settings = Self {
            angle: 1.0_f64.to_radians(),
            euler: axes.map(|axis| (axis, true)),
            autolimits: true,
            mesh_folder: folder.to_owned(),
            strip_path: false,
            from_geoms: FromGeoms::Auto,
            mass_groups: [f64::NEG_INFINITY, f64::INFINITY],
        };
        for compiler in root.named("compiler") {
            settings.update(compiler, folder)?;
        }
        Ok(settings)
    }

    fn update(&mut self, compiler: Element<'_>, folder: &Path) -> Result<(), RigError> {
        let switch = |name: &str| -> Result<Option<bool>, RigError> {
            let word = compiler.get(name).map(|a| a.one_of(&["false", "true"])).transpose()?;
            Ok(word.map(|word| word == 1))
        };
        if let Some(angle) = compiler.get("angle") {
            let radian = angle.one_of(&["degree", "radian"])? == 1;
            self.angle = if radian { 1.0 } else { 1.0_f64.to_radians() };
        }
        if compiler.get("coordinate").is_some_and(|coordinate| coordinate.value != "local") {
            let what = "only local coordinates are read: save the model anew with MuJoCo";
            return Err(compiler.error(what));
        }
        if let Some(sequence) = compiler.get("eulerseq") {
            self.euler = euler(sequence.value)
                .ok_or_else(|| sequence.error("three of the letters x, y, z, X, Y, Z"))?;
        }
        self.autolimits = switch("autolimits")?.unwrap_or(self.autolimits);
        self.strip_path = switch("strippath")?.unwrap_or(self.strip_path);
        if let Some(directory) = compiler.get("meshdir").or(compiler.get("assetdir")) {
            self.mesh_folder = folder.join(directory.value);
        }
        if let Some(from) = compiler.get("inertiafromgeom") {
            let all = [FromGeoms::Never, FromGeoms::Always, FromGeoms::Auto];
            self.from_geoms = all[from.one_of(&["false", "true", "auto"])?];
        }
        if let Some(groups) = compiler.numbers::<2>("inertiagrouprange")? {
            self.mass_groups = groups;
        }
        Ok(())
    }
}

/// The axes of three letters, of which small ones turn with the body.
fn euler(letters: &str) -> Option<[(Vec3, bool); 3]> {
    let axis = |letter: char| match letter.to_ascii_lowercase() {
        'x' => Some(Vec3::x()),
        'y' => Some(Vec3::y()),
        'z' => Some(Vec3::z()),
        _ => None,
    };
    let read = |letter: char| Some((axis(letter)?, letter.is_ascii_lowercase()));
    let all: Option<Vec<_>> = letters.chars().take(4).map(read).collect();
    all?.try_into().ok()
}
