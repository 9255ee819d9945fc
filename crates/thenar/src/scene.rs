//! Scenes in the making.

use crate::Simulation;
use crate::entry::value_of;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use thenar_core::Vec3;
use thenar_scene::SceneError;
use thenar_scene::session::{Session, builtin, builtins, read_scene};
use toml::{Table, Value};

/// Time step of a scene made in code \[s\].
const TIME_STEP: f64 = 5e-3;

/// What a scene takes: [`Hand`](crate::Hand), [`Rigid`](crate::Rigid) and [`Soft`](crate::Soft).
pub trait Part: Sealed {
    /// Handle by which a simulation is asked about it.
    type Id;

    #[doc(hidden)]
    fn id(place: usize) -> Self::Id;
}

/// What a part is in a scene file.
pub trait Sealed {
    /// The list that it belongs to.
    const KEY: &'static str;
    /// Name of a part that is given none, before its number.
    fn usual_name(&self) -> &str;
    /// Keys of the part.
    fn into_table(self) -> Table;
}

/// Hands, objects and settings, from which a [`Simulation`] is built. Whatever is wrong with them is said by [`Scene::build`].
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    text: String,
    /// Names the scene in messages; paths in it start at its folder.
    file: PathBuf,
    overrides: Vec<String>,
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}

impl Scene {
    /// An empty scene: gravity along -y, steps of 5 ms. Relative paths start at the working directory.
    pub fn new() -> Self {
        Self::from_toml(&format!("version = 1\ntime_step = {TIME_STEP:?}\n"))
    }

    /// A scene as it stands in a scene file. Relative paths start at the working directory.
    pub fn from_toml(text: &str) -> Self {
        Self { text: text.to_owned(), file: "scene.toml".into(), overrides: Vec::new() }
    }

    /// A scene file. Relative paths in it start at its folder.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn from_file(file: impl AsRef<Path>) -> Result<Self, SceneError> {
        let file = file.as_ref();
        Ok(Self { text: read_scene(file)?, file: file.into(), overrides: Vec::new() })
    }

    /// A scene that comes with the program, such as `bread-grasp`; `thenar scenes` lists them.
    ///
    /// # Errors
    /// No scene has this name.
    pub fn named(name: &str) -> Result<Self, SceneError> {
        let unknown = || {
            let known: Vec<&str> = builtins().iter().map(|scene| scene.name).collect();
            SceneError::Unknown { name: name.into(), known: known.join(", ") }
        };
        let scene = builtin(name).ok_or_else(unknown)?;
        let file = PathBuf::from(format!("{name}.toml"));
        Ok(Self { text: scene.text.into(), file, overrides: Vec::new() })
    }

    /// Adds a hand or an object, and returns the handle by which the simulation knows it. What has no name gets one that is free. In a
    /// scene from a file, lists stand as `[[rigid]]`; to one that is written in line (`rigid = [...]`) nothing can be added, which
    /// [`Scene::build`] says.
    pub fn add<P: Part>(&mut self, part: P) -> P::Id {
        // Text that cannot be read has no parts; `build` says what is wrong with it.
        let whole = self.text.parse::<Table>().unwrap_or_default();
        let place = whole.get(P::KEY).and_then(Value::as_array).map_or(0, Vec::len);
        let usual = free_name(&whole, part.usual_name(), place + 1);
        let mut keys = part.into_table();
        let mut table = Table::new();
        let name = keys.remove("name").unwrap_or(Value::String(usual));
        table.insert("name".into(), name);
        table.extend(keys);
        let list = Value::Array(vec![Value::Table(table)]);
        let added: Table = [(P::KEY.to_owned(), list)].into_iter().collect();
        self.text.push('\n');
        self.text.push_str(&added.to_string());
        P::id(place)
    }

    /// Sets the time step \[s\].
    pub fn time_step(&mut self, h: f64) -> &mut Self {
        self.set("time_step", format!("{h:?}"))
    }

    /// Sets gravity, world \[m/s²\].
    pub fn gravity(&mut self, gravity: impl Into<Vec3>) -> &mut Self {
        let [x, y, z] = gravity.into().into();
        self.set("gravity", format!("[{x:?}, {y:?}, {z:?}]"))
    }

    /// Sets any key of the scene, with a value as it stands in a scene file: `("solver.cone", "linearised")`,
    /// `("rigid.0.mass", 2.5)`; a step into a list is a number or a name.
    pub fn set(&mut self, key: &str, value: impl Display) -> &mut Self {
        self.overrides.push(format!("{key}={value}"));
        self
    }

    /// The scene as a scene file, which gives the same simulation. Comments of a file that was opened stay unless [`Scene::set`] or its
    /// likes have changed something.
    pub fn to_toml(&self) -> String {
        let Ok(mut whole) = self.text.parse::<Table>().map(Value::Table) else {
            return self.text.clone();
        };
        if self.overrides.is_empty() {
            return self.text.clone();
        }
        for (key, value) in self.overrides.iter().filter_map(|given| given.split_once('=')) {
            let steps: Vec<&str> = key.split('.').map(str::trim).collect();
            assign(&mut whole, &steps, value_of(value.trim()));
        }
        whole.as_table().map(ToString::to_string).unwrap_or_default()
    }

    /// Builds all bodies, ready to be stepped. A hand that comes with the program takes a second the first time.
    ///
    /// # Errors
    /// Something in the scene is wrong: says what, and where.
    pub fn build(&self) -> Result<Simulation, SceneError> {
        Session::from_text(&self.text, &self.file, &self.overrides).map(Simulation::new)
    }
}

/// A name of this kind that no body of the scene has.
fn free_name(whole: &Table, kind: &str, from: usize) -> String {
    let parts = ["hand", "rigid", "soft", "figure", "joint"].into_iter();
    let parts = parts.filter_map(|list| whole.get(list)?.as_array()).flatten();
    let taken: Vec<&str> = parts.filter_map(|part| part.get("name")?.as_str()).collect();
    let mut names = (from..).map(|number| format!("{kind}-{number}"));
    names.find(|name| !taken.contains(&name.as_str())).unwrap_or_default()
}

/// Writes a value into a scene; a step into a list is a number or the name of an element.
fn assign(at: &mut Value, steps: &[&str], value: Value) {
    let Some((step, rest)) = steps.split_first() else {
        *at = value;
        return;
    };
    match at {
        Value::Table(table) => {
            let inner = table.entry(*step).or_insert_with(|| Value::Table(Table::new()));
            assign(inner, rest, value);
        }
        Value::Array(list) => {
            let named = |part: &Value| part.get("name").and_then(Value::as_str) == Some(step);
            let place = step.parse().ok().or_else(|| list.iter().position(named));
            if let Some(part) = place.and_then(|k: usize| list.get_mut(k)) {
                assign(part, rest, value);
            }
        }
        _ => {}
    }
}
