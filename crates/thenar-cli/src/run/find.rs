//! Which scene is meant.

use crate::error::CliError;
use std::path::{Path, PathBuf};
use thenar_scene::session::{Session, builtin, builtins};

/// Opens a scene: a file, or `NAME` for `scenes/NAME.toml` here, or for the built-in scene.
///
/// # Errors
/// There is no such scene, or it is wrong.
pub fn open(scene: &Path, overrides: &[String]) -> Result<Session, CliError> {
    let bare = scene.extension().is_none() && scene.components().count() == 1;
    if !bare || scene.is_file() {
        return Ok(Session::load(scene, overrides)?);
    }
    let beside = PathBuf::from("scenes").join(scene).with_extension("toml");
    if beside.is_file() {
        return Ok(Session::load(&beside, overrides)?);
    }
    let name = scene.to_string_lossy();
    match builtin(&name) {
        Some(known) => Ok(Session::from_text(known.text, &beside, overrides)?),
        None => {
            let known: Vec<_> = builtins().iter().map(|s| s.name).collect();
            let known = known.join(", ");
            Err(thenar_scene::SceneError::Unknown { name: name.into(), known }.into())
        }
    }
}
