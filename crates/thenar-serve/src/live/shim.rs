//! Stands for what sessions cannot do yet: live poses and settings.

use super::source::Recipe;
use std::path::Path;
use thenar_scene::SceneError;
use thenar_scene::session::Session;

/// The scene with its own hands.
pub fn with_hands(
    text: &str,
    path: &Path,
    overrides: &[String],
    _: &Recipe,
) -> Result<Session, SceneError> {
    Session::from_text(text, path, overrides)
}

/// There are no settings yet.
pub type Setting = String;

/// None.
pub fn settings(_: &Session) -> Vec<Setting> {
    Vec::new()
}
