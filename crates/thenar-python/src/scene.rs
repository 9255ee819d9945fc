//! Scenes, read and checked.

use crate::error;
use crate::world::World;
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use thenar_scene::SceneError;
use thenar_scene::build::Files;
use thenar_scene::session::{Session, Source, builtin, builtins, read, read_scene};

/// A scene that was read: its text is sound, its bodies are not built yet.
#[pyclass(frozen, module = "thenar._thenar")]
#[derive(Debug)]
pub struct Scene {
    source: Source,
    title: Option<String>,
    description: Option<String>,
    duration: f64,
    time_step: f64,
    files: Vec<String>,
}

impl Scene {
    fn of(text: &str, file: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        let locate = |fault: thenar_scene::text::Fault| fault.locate(file, text, overrides);
        let scene = read(text, overrides).map_err(locate)?;
        Ok(Self {
            source: Source::new(text, file, overrides),
            files: scene.files().into_iter().map(String::from).collect(),
            title: scene.title,
            description: scene.description,
            duration: scene.duration,
            time_step: scene.time_step,
        })
    }
}

impl Scene {
    /// Source that the scene's sessions are made from.
    pub fn source(&self) -> &Source {
        &self.source
    }
}

/// Names of the bundled scenes.
#[pyfunction]
pub fn scene_names() -> Vec<&'static str> {
    builtins().iter().map(|scene| scene.name).collect()
}

#[pymethods]
impl Scene {
    /// From a scene's text. `file` names it in messages; relative paths start at its folder.
    #[staticmethod]
    fn from_text(text: &str, file: PathBuf, overrides: Vec<String>) -> PyResult<Self> {
        Self::of(text, &file, &overrides).map_err(|e| error::scene(&e))
    }

    /// From a scene file.
    #[staticmethod]
    fn from_file(file: PathBuf, overrides: Vec<String>) -> PyResult<Self> {
        let read = read_scene(&file).and_then(|text| Self::of(&text, &file, &overrides));
        read.map_err(|e| error::scene(&e))
    }

    /// A scene that comes along, by name.
    #[staticmethod]
    fn named(name: &str, overrides: Vec<String>) -> PyResult<Self> {
        let Some(scene) = builtin(name) else {
            let known = scene_names().join(", ");
            return Err(error::scene(&SceneError::Unknown { name: name.into(), known }));
        };
        let file = Path::new("scenes").join(name).with_extension("toml");
        Self::of(scene.text, &file, &overrides).map_err(|e| error::scene(&e))
    }

    /// Builds the bodies. Other threads run meanwhile.
    fn world(&self, py: Python<'_>) -> PyResult<World> {
        let files = Files::beside(&self.source.file);
        let session = py.detach(|| Session::open(&self.source, files));
        Ok(World::new(session.map_err(|e| error::scene(&e))?, &self.source))
    }

    /// Title, if the scene has one.
    #[getter]
    fn title(&self) -> Option<&str> {
        self.title.as_deref()
    }

    /// Description, if the scene has one.
    #[getter]
    fn description(&self) -> Option<&str> {
        self.description.as_deref()
    }

    /// Simulated time of a run [s].
    #[getter]
    fn duration(&self) -> f64 {
        self.duration
    }

    /// Time step [s].
    #[getter]
    fn time_step(&self) -> f64 {
        self.time_step
    }

    /// The scene's text.
    #[getter]
    fn text(&self) -> &str {
        &self.source.text
    }

    /// Files that it names, as it calls them; relative paths start at its own folder.
    #[getter]
    fn files(&self) -> Vec<String> {
        self.files.clone()
    }

    /// The file that names it in messages.
    #[getter]
    fn file(&self) -> String {
        self.source.file.display().to_string()
    }
}
