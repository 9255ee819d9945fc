//! Scenes in the making.

use crate::Simulation;
use crate::entry::value_of;
use std::collections::BTreeSet;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use thenar_core::Vec3;
use thenar_scene::SceneError;
use thenar_scene::session::{Session, builtin, builtins, read_scene};
use toml::{Table, Value};

/// Time step of a scene made in code \[s\].
const TIME_STEP: f64 = 5e-3;

/// Parts that a scene takes: [`Hand`](crate::Hand), [`Rigid`](crate::Rigid) and
/// [`Soft`](crate::Soft).
pub trait Part: Sealed {
    /// Handle by which a simulation is asked about it.
    type Id;

    #[doc(hidden)]
    fn id(place: usize) -> Self::Id;
}

/// Form of a part in a scene file.
pub trait Sealed {
    /// The list that it belongs to.
    const KEY: &'static str;
    /// Name of a part that is given none, before its number.
    fn usual_name(&self) -> &str;
    /// Keys of the part.
    fn into_table(self) -> Table;
}

/// Hands, objects and settings, from which a [`Simulation`] is built. Whatever is wrong with them
/// is said by [`Scene::build`].
#[derive(Clone, Debug)]
pub struct Scene {
    /// Text as it was opened, without what was added since.
    text: String,
    added: Vec<Added>,
    /// Names the scene in messages; paths in it start at its folder.
    file: PathBuf,
    overrides: Vec<String>,
}

/// A part that was added. Parts without a name get theirs when the scene is written, after all
/// names that were given.
#[derive(Clone, Debug)]
struct Added {
    /// The list that it belongs to, and its place there.
    list: &'static str,
    place: usize,
    /// Beginning of a name that no one gave.
    usual: String,
    keys: Table,
}

/// Scenes are the same that are written the same.
impl PartialEq for Scene {
    fn eq(&self, other: &Self) -> bool {
        (&self.file, &self.overrides) == (&other.file, &other.overrides)
            && self.written() == other.written()
    }
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}

impl Scene {
    /// An empty scene: gravity along -y, steps of 5 ms. Relative paths start at the working
    /// directory.
    pub fn new() -> Self {
        Self::from_toml(&format!("version = 1\ntime_step = {TIME_STEP:?}\n"))
    }

    /// A scene as it stands in a scene file. Relative paths start at the working directory.
    pub fn from_toml(text: &str) -> Self {
        Self::opened(text.to_owned(), "scene.toml".into())
    }

    /// A scene file. Relative paths in it start at its folder.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn from_file(file: impl AsRef<Path>) -> Result<Self, SceneError> {
        let file = file.as_ref();
        Ok(Self::opened(read_scene(file)?, file.into()))
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
        Ok(Self::opened(scene.text.into(), format!("{name}.toml").into()))
    }

    fn opened(text: String, file: PathBuf) -> Self {
        Self { text, added: Vec::new(), file, overrides: Vec::new() }
    }

    /// Adds a hand or an object, and returns the handle by which the simulation knows it. What has
    /// no name gets one that is free when the scene is built: `sphere-2` for the second rigid body
    /// of a scene, or the next number if any part, added before or after, was given this name. In a
    /// scene from a file, lists stand as `[[rigid]]`; to one that is written in line
    /// (`rigid = [...]`) nothing can be added, which [`Scene::build`] says.
    pub fn add<P: Part>(&mut self, part: P) -> P::Id {
        // Text that cannot be read has no parts; `build` says what is wrong with it.
        let opened = self.text.parse::<Table>().unwrap_or_default();
        let before = opened.get(P::KEY).and_then(Value::as_array).map_or(0, Vec::len);
        let place = before + self.added.iter().filter(|added| added.list == P::KEY).count();
        let usual = part.usual_name().to_owned();
        self.added.push(Added { list: P::KEY, place, usual, keys: part.into_table() });
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

    /// Sets any key of the scene, with a value as it stands in a scene file:
    /// `("solver.cone", "linearised")`, `("rigid.0.mass", 2.5)`; a step into a list is a number or
    /// a name.
    pub fn set(&mut self, key: &str, value: impl Display) -> &mut Self {
        self.overrides.push(format!("{key}={value}"));
        self
    }

    /// The scene as a scene file, which gives the same simulation. Comments of a file that was
    /// opened stay unless [`Scene::set`] or its likes have changed something.
    pub fn to_toml(&self) -> String {
        let text = self.written();
        let Ok(mut whole) = text.parse::<Table>().map(Value::Table) else {
            return text;
        };
        if self.overrides.is_empty() {
            return text;
        }
        for (steps, value) in self.changes() {
            assign(&mut whole, &steps, value);
        }
        whole.as_table().map(ToString::to_string).unwrap_or_default()
    }

    /// Builds all bodies, ready to be stepped. A hand that comes with the program takes a second
    /// the first time.
    ///
    /// # Errors
    /// Something in the scene is wrong: says what, and where.
    pub fn build(&self) -> Result<Simulation, SceneError> {
        Session::from_text(&self.written(), &self.file, &self.overrides).map(Simulation::new)
    }

    /// Changes by [`Scene::set`]: the steps to each key, and its value.
    fn changes(&self) -> impl Iterator<Item = (Vec<&str>, Value)> {
        let given = self.overrides.iter().filter_map(|given| given.split_once('='));
        given.map(|(key, value)| (key.split('.').map(str::trim).collect(), value_of(value.trim())))
    }

    /// The scene before [`Scene::set`] and its likes change it: as it was opened, and then what was
    /// added, with its names.
    fn written(&self) -> String {
        let mut text = self.text.clone();
        let mut taken = self.given_names();
        for added in &self.added {
            let mut keys = added.keys.clone();
            let name = keys.remove("name").unwrap_or_else(|| {
                let free = free_name(&taken, &added.usual, added.place + 1);
                taken.insert(free.clone());
                Value::String(free)
            });
            let mut table = Table::new();
            table.insert("name".into(), name);
            table.extend(keys);
            let list = Value::Array(vec![Value::Table(table)]);
            let part: Table = [(added.list.to_owned(), list)].into_iter().collect();
            text.push('\n');
            text.push_str(&part.to_string());
        }
        text
    }

    /// Names that bodies and joints of the scene were given.
    fn given_names(&self) -> BTreeSet<String> {
        let opened = self.text.parse::<Table>().unwrap_or_default();
        let lists = ["hand", "rigid", "soft", "figure", "joint"].into_iter();
        let opened = lists.filter_map(|list| opened.get(list)?.as_array()).flatten();
        let opened = opened.filter_map(|part| part.get("name").cloned());
        let added = self.added.iter().filter_map(|added| added.keys.get("name").cloned());
        let changed = self.changes().filter(|(steps, _)| steps.last() == Some(&"name"));
        let all = opened.chain(added).chain(changed.map(|(_, value)| value));
        all.filter_map(|name| name.as_str().map(str::to_owned)).collect()
    }
}

/// A name of this kind that is not taken, with the first number from `from` that makes it so.
fn free_name(taken: &BTreeSet<String>, kind: &str, from: usize) -> String {
    let mut names = (from..).map(|number| format!("{kind}-{number}"));
    names.find(|name| !taken.contains(name)).unwrap_or_default()
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
