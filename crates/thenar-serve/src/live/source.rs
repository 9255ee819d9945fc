//! Scenes that can be served, and how one is made ready.

use crate::hub::SceneName;
use crate::protocol::{self, Lengths};
use std::path::{Path, PathBuf};
use thenar_input::quoted;
use thenar_scene::SceneError;
use thenar_scene::build::Files;
use thenar_scene::hands::Hands;
use thenar_scene::session::{Session, Source, builtin, builtins, live_overrides, read, read_scene};

/// Source of the first scene.
#[derive(Clone, Debug)]
pub enum SceneSource {
    /// One that comes with the program.
    Builtin(String),
    /// A file.
    File(PathBuf),
}

/// All scenes that clients may ask for. Names from clients are only ever looked up here: none
/// becomes a path.
#[derive(Clone, Debug)]
pub struct Catalogue {
    own: Option<(String, PathBuf)>,
    /// The first scene, and what is set in it.
    first: (String, Vec<String>),
}

/// Description of a scene that is to be made ready.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSpec {
    /// Name of the scene.
    pub scene: String,
    /// The hands in the scene.
    pub hands: Hands,
    /// Lengths of the hands.
    pub lengths: Lengths,
}

/// A scene made ready.
#[derive(Debug)]
pub struct ReadyScene {
    /// From what.
    pub spec: SceneSpec,
    /// To be stepped.
    pub session: Session,
    /// Model message of the scene, of epoch 0.
    pub model: Vec<u8>,
}

/// Why a scene cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// No scene of that name.
    #[error("no scene is named {}", quoted(.0))]
    Unknown(String),
    /// Something is wrong with it.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Too large for a page.
    #[error(transparent)]
    Model(#[from] protocol::ModelError),
    /// The simulation's thread cannot be started.
    #[error("cannot start the simulation: {0}")]
    Thread(#[from] std::io::Error),
}

impl Catalogue {
    /// The built-in scenes and that of `source`; `overrides` act on the latter.
    ///
    /// # Errors
    /// There is no such built-in scene.
    pub fn new(source: &SceneSource, overrides: &[String]) -> Result<(Self, SceneSpec), LiveError> {
        let (own, scene) = match source {
            SceneSource::Builtin(name) if builtin(name).is_none() => {
                return Err(LiveError::Unknown(name.clone()));
            }
            SceneSource::Builtin(name) => (None, name.clone()),
            SceneSource::File(path) => {
                let stem = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy();
                (Some((stem.clone().into_owned(), path.clone())), stem.into_owned())
            }
        };
        let spec =
            SceneSpec { scene: scene.clone(), hands: Hands::Scene, lengths: Lengths::default() };
        Ok((Self { own, first: (scene, overrides.to_vec()) }, spec))
    }

    /// Names and titles, an own scene first.
    pub fn names(&self) -> Vec<SceneName> {
        let title = |text: &str| read(text, &[]).ok().and_then(|scene| scene.title);
        let own = self.own.iter().map(|(name, path)| SceneName {
            name: name.clone(),
            title: read_scene(path)
                .ok()
                .and_then(|text| title(&text))
                .unwrap_or_else(|| name.clone()),
        });
        let shipped = builtins().iter().map(|scene| SceneName {
            name: scene.name.into(),
            title: title(scene.text).unwrap_or_else(|| scene.name.into()),
        });
        let hidden = |name: &SceneName| self.own.as_ref().is_none_or(|own| own.0 != name.name);
        own.chain(shipped.filter(hidden)).collect()
    }

    /// True when there is such a scene.
    pub fn has(&self, name: &str) -> bool {
        self.own.as_ref().is_some_and(|own| own.0 == name) || builtin(name).is_some()
    }

    /// Makes a scene ready; takes seconds for one with a hand.
    ///
    /// # Errors
    /// There is no such scene, or something in it is wrong.
    pub fn make(&self, spec: &SceneSpec) -> Result<ReadyScene, LiveError> {
        let name = &spec.scene;
        let own = self.own.as_ref().filter(|own| own.0 == *name);
        let (text, path) = match (own, builtin(name)) {
            (Some((_, path)), _) => (read_scene(path)?, path.clone()),
            (None, Some(shipped)) => (shipped.text.into(), Path::new(name).with_extension("toml")),
            (None, None) => return Err(LiveError::Unknown(name.clone())),
        };
        let own = if self.first.0 == *name { &self.first.1[..] } else { &[] };
        let overrides = live_overrides(&text, own);
        let Lengths { left, right } = spec.lengths;
        let mut source = Source::new(&text, &path, &overrides);
        (source.hands, source.lengths) = (spec.hands, [left, right]);
        let session = Session::open(&source, Files::beside(&path))?;
        let model = protocol::model(&session, name, 0)?;
        Ok(ReadyScene { spec: spec.clone(), session, model })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn work_max(source: &SceneSource, overrides: &[String]) -> Option<f64> {
        let (catalogue, spec) = Catalogue::new(source, overrides).unwrap();
        let ready = catalogue.make(&spec).unwrap();
        assert_eq!(
            ready.session.world().desc().solver.contact_work_max,
            ready.session.scene().solver.as_ref().unwrap().contact_work_max.map(|most| most as u64)
        );
        ready.session.scene().solver.as_ref().unwrap().contact_work_max
    }

    /// 4e9 multiply-adds a second, in steps of 5 ms and of 1 ms, and what the wearer of a scene
    /// asks for.
    #[test]
    fn contact_of_live_scenes_is_bounded_unless_they_say_how() {
        let scene = SceneSource::Builtin("falling-box".into());
        let set = |text: &str| vec![text.to_string()];
        assert_eq!(work_max(&scene, &set("time_step=0.005")), Some(2e7));
        assert_eq!(work_max(&scene, &set("time_step=0.001")), Some(4e6));
        assert_eq!(work_max(&scene, &set("solver.contact_work_max=1e6")), Some(1e6));
    }
}
