//! Search for the scene that is meant.

use crate::building::told;
use crate::error::CliError;
use std::path::{Path, PathBuf};
use thenar_scene::format::Scene;
use thenar_scene::session::{
    Builtin, Session, StartOverlap, builtin, builtins, live_overrides, read, read_scene,
};

/// Place of a scene.
#[derive(Debug)]
pub enum SceneLocation {
    /// In a file.
    File(PathBuf),
    /// In the program.
    Builtin(&'static Builtin),
}

/// Finds a scene: a file, or `NAME` for `scenes/NAME.toml` here, or for the built-in scene.
///
/// # Errors
/// There is no such built-in scene; files are not looked into.
pub fn find(scene: &Path) -> Result<SceneLocation, CliError> {
    let bare = scene.extension().is_none() && scene.components().count() == 1;
    if !bare || scene.is_file() {
        return Ok(SceneLocation::File(scene.into()));
    }
    let beside = PathBuf::from("scenes").join(scene).with_extension("toml");
    if beside.is_file() {
        return Ok(SceneLocation::File(beside));
    }
    known(&scene.to_string_lossy()).map(SceneLocation::Builtin)
}

/// The built-in scene of this name, whatever files are here.
///
/// # Errors
/// There is no such built-in scene.
pub fn known(name: &str) -> Result<&'static Builtin, CliError> {
    builtin(name).ok_or_else(|| {
        let known: Vec<_> = builtins().iter().map(|s| s.name).collect();
        let known = known.join(", ");
        thenar_scene::SceneError::Unknown { name: name.into(), known }.into()
    })
}

/// Opens a scene. No output of this command replaces a file that it is made from.
///
/// # Errors
/// There is no such scene, or it is wrong.
pub fn open(scene: &Path, overrides: &[String]) -> Result<Session, CliError> {
    open_with(scene, |_| overrides.to_vec(), |_| Ok(()))
}

/// Opens a scene that suits what is asked for: `check` sees it before anything is built.
///
/// # Errors
/// There is no such scene, it is wrong, or it does not pass the check.
pub fn open_checked(
    scene: &Path,
    overrides: &[String],
    check: impl Fn(&Scene) -> Result<(), CliError>,
) -> Result<Session, CliError> {
    open_with(scene, |_| overrides.to_vec(), check)
}

/// Opens a scene to run live: contact costs no step more than it may.
///
/// # Errors
/// There is no such scene, or it is wrong.
pub fn open_live(scene: &Path, overrides: &[String]) -> Result<Session, CliError> {
    open_with(scene, |text| live_overrides(text, overrides), |_| Ok(()))
}

fn open_with(
    scene: &Path,
    overrides: impl Fn(&str) -> Vec<String>,
    check: impl Fn(&Scene) -> Result<(), CliError>,
) -> Result<Session, CliError> {
    let found = find(scene)?;
    let session = told(|| {
        let (text, file) = match found {
            SceneLocation::File(path) => {
                thenar_output::protect(&path);
                (read_scene(&path)?, path)
            }
            SceneLocation::Builtin(known) => (known.text.to_string(), beside(known.name)),
        };
        let overrides = overrides(&text);
        // What is wrong with the text is told with its place when the session is made.
        if let Ok(scene) = read(&text, &overrides) {
            check(&scene)?;
        }
        Ok(Session::from_text(&text, &file, &overrides)?)
    })?;
    session.files().values().for_each(|file| thenar_output::protect(file));
    Ok(session)
}

/// Says on the error output what a person should know of a scene before it runs.
pub fn tell(session: &Session) {
    session.warnings().iter().for_each(|warning| eprintln!("warning: {warning}"));
    session.notes().iter().for_each(|note| eprintln!("note: {note}"));
    tell_overlaps(session.start_overlaps());
}

/// Most pairs of bodies that are named for overlapping: what a person reads.
const OVERLAPS_TOLD: usize = 20;

/// Says on the error output what overlaps at the start, a line for each pair of bodies, the deepest
/// first.
pub fn tell_overlaps(overlaps: &[StartOverlap]) {
    let (told, rest) = overlaps.split_at(overlaps.len().min(OVERLAPS_TOLD));
    told.iter().for_each(|overlap| eprintln!("warning: {overlap}"));
    if !rest.is_empty() {
        let pairs = if rest.len() == 1 { "pair" } else { "pairs" };
        let count = rest.len();
        eprintln!("warning: {count} more {pairs} of bodies overlap at the start, no deeper");
    }
}

/// The file that a scene is read from, or would be: relative paths in it start there.
///
/// # Errors
/// There is no such built-in scene; files are not looked into.
pub fn file(scene: &Path) -> Result<PathBuf, CliError> {
    Ok(match find(scene)? {
        SceneLocation::File(path) => path,
        SceneLocation::Builtin(known) => beside(known.name),
    })
}

fn beside(name: &str) -> PathBuf {
    PathBuf::from("scenes").join(name).with_extension("toml")
}
