//! Files and built-in objects, through the rig.

use super::hand_cache::hand_of;
use super::mesh_cache::{car_of, rigid_of, soft_of};
use super::shape::Solid;
use super::{Files, tissue};
use crate::format::{
    BallShape, BreadShape, CarShape, ExplicitShape, FileShape, Hand, MeshNames, MeshShape,
    MeshSoftShape, PresetWord, SpringsWord,
};
use crate::text::{Cx, Fault, Located, Node, Read, nearest};
use std::path::{Path, PathBuf};
use thenar_core::math::Vec3;
use thenar_core::model::{HandModel, Law, Material, Side};
use thenar_input::quoted;
use thenar_rig::embed::{EmbedOptions, can_be_closed, closed_surface, embed};
use thenar_rig::glb::skinned_names;
use thenar_rig::hand::{HandOptions, Size, Springs, asset, graded_tets};
use thenar_rig::mesh::{load_mesh, read_file};
use thenar_rig::object::{
    Ball, Bread, Car, RigidModel, SoftModel, SoftOptions, Weight, ball as ball_of,
    bread as bread_of, soft_from_tets,
};
use thenar_rig::{Model, RigError, read_model};

/// Largest file with nodes and tetrahedra \[bytes\].
const TET_FILE_BYTES_MAX: u64 = 32 << 20;

/// The material of a shape that has none yet. Where the rig scales materials (elements filled in
/// part, crusts), what it gives is the scale.
pub fn unit() -> Material {
    Material { law: Law::Corotational, young: 1.0, poisson: 0.0, density: 1.0 }
}

/// The path of what a scene calls `file`.
pub fn path(files: &Files, file: &Located<String>) -> PathBuf {
    files.path(file)
}

/// Text of a file that a scene names.
pub fn read_text(files: &Files, file: &Located<String>, bytes_max: u64) -> Result<String, Fault> {
    let path = path(files, file);
    let fault = |problem: String| file.fault(format!("{}: {problem}", path.display()));
    thenar_input::read_text(&path, bytes_max).map_err(|e| fault(e.to_string()))
}

/// Nodes and tetrahedra from a TOML file.
pub fn tet_file(shape: &FileShape, files: &Files) -> Result<SoftModel, Fault> {
    let text = read_text(files, &shape.file, TET_FILE_BYTES_MAX)?;
    let inside = |fault: Fault| {
        let located = fault.locate(&path(files, &shape.file), &text, &[]);
        shape.file.fault(located.to_string())
    };
    let root = Node::parse(&text).map_err(inside)?;
    let table = ExplicitShape::read(&root, &Cx::root()).map_err(inside)?;
    explicit(&table, shape.scale).map_err(inside)
}

/// A body from nodes and tetrahedra that a user wrote out, in either orientation.
pub fn explicit(shape: &ExplicitShape, scale: f64) -> Result<SoftModel, Fault> {
    let nodes: Vec<Vec3> = shape.nodes.value.iter().map(|x| x * scale).collect();
    let mut tets = shape.tets.value.clone();
    for tet in &mut tets {
        if tet.iter().all(|n| (*n as usize) < nodes.len()) {
            let [a, b, c, d] = tet.map(|n| nodes[n as usize]);
            if (b - a).cross(&(c - a)).dot(&(d - a)) < 0.0 {
                tet.swap(1, 2);
            }
        }
    }
    soft_from_tets("tets", nodes, tets, vec![unit()], &SoftOptions::default())
        .map(|(model, _)| model)
        .map_err(|e| shape.tets.fault(e.to_string()))
}

/// A ball, perhaps hollow.
pub fn ball(shape: &BallShape, at: &Located<impl Sized>) -> Result<SoftModel, Fault> {
    let ball = Ball {
        outer: shape.radius,
        inner: shape.core_radius,
        frequency: shape.frequency,
        layers: shape.layers,
        growth: shape.growth,
        focus: shape.focus,
    };
    ball_of(&ball, |_| unit(), &SoftOptions::default()).map_err(|e| at.fault(e.to_string()))
}

/// The loaf that a table describes, with the crumb's own material.
pub fn loaf(shape: &BreadShape) -> Bread {
    let usual = Bread::loaf();
    Bread {
        size: shape.size.unwrap_or(usual.size),
        cells: shape.cells.unwrap_or(usual.cells),
        crust: shape.crust.unwrap_or(usual.crust),
        ..usual
    }
}

/// A loaf of bread.
pub fn bread(shape: &BreadShape, at: &Located<impl Sized>) -> Result<SoftModel, Fault> {
    bread_of(&Bread { crumb: unit(), ..loaf(shape) })
        .map(|(model, _)| model)
        .map_err(|e| at.fault(e.to_string()))
}

/// A closed mesh filled with tetrahedra.
pub fn soft_mesh(shape: &MeshSoftShape, files: &Files) -> Result<SoftModel, Fault> {
    let path = path(files, &shape.file);
    let fault = |problem: String| shape.file.fault(format!("{}: {problem}", path.display()));
    if shape.file.value.ends_with(".thenar") {
        if shape.scale != 1.0 {
            return Err(fault("a model has its own size: leave `scale` out".into()));
        }
        return match read_model(&path) {
            Ok(Model::Soft(model)) => Ok(model),
            Ok(_) => Err(fault("the file holds no soft body".into())),
            Err(e) => Err(shape.file.fault(e.to_string())),
        };
    }
    let mesh = load_mesh(&path, shape.scale).map_err(|e| shape.file.fault(e.to_string()))?;
    let mesh = match closed_surface(&mesh) {
        Ok(mesh) => mesh,
        Err(error) if can_be_closed(&mesh) => {
            return Err(fault(format!("{error}; {}", closes(shape))));
        }
        Err(error) => return Err(fault(error.to_string())),
    };
    let options = EmbedOptions { tets: shape.tets as usize, ..EmbedOptions::default() };
    soft_of(mesh, shape.tets, |mesh| {
        let embedded = embed(mesh, &options, |_| unit()).map_err(|e| fault(e.to_string()))?;
        Ok(SoftModel { name: String::new(), flesh: embedded.flesh, render: embedded.render })
    })
}

/// The command that makes a model of a mesh whose holes can be closed, and how the scene takes it.
fn closes(shape: &MeshSoftShape) -> String {
    let file = &shape.file.value;
    let stem = Path::new(file).with_extension("thenar");
    let model = stem.display();
    let scale = match shape.scale {
        1.0 => String::new(),
        scale => format!(" --scale {scale}"),
    };
    format!(
        "`thenar build {file} --soft{scale} --tets {} -o {model}` closes what is open; then write file = \"{model}\", without \
         `scale`",
        shape.tets
    )
}

/// The toy car.
pub fn car(car: &CarShape, weight: Weight, at: &Located<impl Sized>) -> Result<Solid, Fault> {
    let fault = |e: thenar_rig::RigError| at.fault(e.to_string());
    let mass = match weight {
        Weight::Mass(mass) => mass,
        Weight::Density(density) => {
            let unit = Car { length: car.length, mass: 1.0 };
            density * car_of(&unit).map_err(fault)?.1
        }
    };
    car_of(&Car { length: car.length, mass }).map(|(model, _)| Solid::from(model)).map_err(fault)
}

/// A rigid body from a mesh file.
pub fn rigid_mesh(mesh: &MeshShape, weight: Weight, files: &Files) -> Result<Solid, Fault> {
    let path = path(files, &mesh.file);
    if mesh.file.value.ends_with(".thenar") {
        return match read_model(&path) {
            Ok(Model::Rigid(model)) => Ok(Solid::from(model)),
            Ok(_) => {
                Err(mesh.file.fault(format!("{}: the file holds no rigid body", path.display())))
            }
            Err(e) => Err(mesh.file.fault(e.to_string())),
        };
    }
    let read = load_mesh(&path, mesh.scale).map_err(|e| mesh.file.fault(e.to_string()))?;
    rigid_of(read, mesh.grid, weight)
        .map(Solid::from)
        .map_err(|e| mesh.file.fault(format!("{}: {e}", path.display())))
}

impl From<RigidModel> for Solid {
    fn from(model: RigidModel) -> Self {
        Self {
            shape: model.shape,
            pose_BS: model.pose_BS,
            pose_MB: model.pose_MB,
            moments: None,
            weighed: Some((model.mass, model.inertia)),
            look: Some((model.render, model.paint)),
        }
    }
}

/// The model of a hand.
pub fn hand(hand: &Hand, preset: PresetWord, files: &Files) -> Result<HandModel, Fault> {
    let built_in = |side| {
        let options = HandOptions { side: Some(side), ..options(hand, preset)? };
        hand_of(asset(side), &options).map_err(|e| match e {
            RigError::Layer { layer, what } => tissue::layer_fault(hand, layer, &what),
            other => hand.name.fault(other.to_string()),
        })
    };
    let is_rig = hand.model.as_ref().is_some_and(|file| file.value.ends_with(".glb"));
    if let (Some(names), false) = (&hand.joint_names, is_rig) {
        return Err(names.fault(
            "only a rig has joints to be named: give `model` a .glb file, or leave `joint_names` out",
        ));
    }
    if let (Some(mesh), false) = (&hand.mesh, is_rig) {
        return Err(mesh.fault(
            "only a rig has meshes to choose from: give `model` a .glb file, or leave `mesh` out",
        ));
    }
    let Some(file) = &hand.model else { return built_in(Side::Right) };
    let path = || path(files, file);
    match file.value.as_str() {
        "right" => built_in(Side::Right),
        "left" => built_in(Side::Left),
        name if name.ends_with(".glb") => {
            let options = options(hand, preset)?;
            let bytes = read_file(&path()).map_err(|e| file.fault(e.to_string()))?;
            check_meshes(hand.mesh.as_ref(), &bytes)?;
            let built = hand_of(&bytes, &options).map_err(|e| e.in_file(path().display()));
            built.map_err(|e| file.fault(e.to_string()))
        }
        name if name.ends_with(".thenar") && tissue::is_layered(hand) => Err(tissue::layer_fault(
            hand,
            1,
            "layers are made when a hand is built from a mesh, and a model file is built already: give `model` \"right\", \"left\" or a .glb file",
        )),
        name if name.ends_with(".thenar") => match read_model(&path()) {
            Ok(Model::Hand(model)) => Ok(model),
            Ok(_) => Err(file.fault(format!("{} holds no hand", path().display()))),
            Err(e) => Err(file.fault(e.to_string())),
        },
        other => Err(file.fault(format!(
            "expected \"right\", \"left\", or the path of a .thenar or .glb file, got \"{other}\""
        ))),
    }
}

/// Errs when a file has no mesh of one of these names, and lists those that it has. What else is
/// wrong with the file, who builds from it says.
pub fn check_meshes(wanted: Option<&Located<MeshNames>>, bytes: &[u8]) -> Result<(), Fault> {
    let (Some(wanted), Ok(known)) = (wanted, skinned_names(bytes)) else { return Ok(()) };
    let Some(name) = wanted.value.0.iter().find(|name| !known.contains(name)) else {
        return Ok(());
    };
    let hint = nearest(name, known.iter().map(String::as_str))
        .map_or_else(String::new, |near| format!("; did you mean {}?", quoted(near)));
    let has: Vec<String> = known.iter().map(|known| quoted(known).to_string()).collect();
    Err(wanted.fault(format!(
        "the file has no skinned mesh {}; it has {}{hint}",
        quoted(name),
        has.join(", ")
    )))
}

fn options(hand: &Hand, preset: PresetWord) -> Result<HandOptions, Fault> {
    let usual = mesh(hand, preset);
    let options = HandOptions {
        name: hand.name.value.clone(),
        size: hand.length.map_or(Size::Scale(1.0), Size::Length),
        springs: match hand.springs {
            Some(SpringsWord::Fixed) => Springs::Fixed,
            Some(SpringsWord::Rest) => Springs::Rest,
            None => usual.springs,
        },
        name_map: hand.joint_names.as_ref().map(|names| names.value.clone()).unwrap_or_default(),
        meshes: hand.mesh.as_ref().map(|mesh| mesh.value.0.clone()).unwrap_or_default(),
        ..usual
    };
    tissue::layered(hand, options)
}

/// Fineness of a hand's mesh: what the scene says, else its preset.
fn mesh(hand: &Hand, preset: PresetWord) -> HandOptions {
    let usual = match preset {
        PresetWord::Paper => HandOptions::paper(),
        PresetWord::Touch => HandOptions::touch(),
    };
    let given = hand.detail.as_ref().map(|detail| detail.value);
    let detail = if hand.tets.is_some() { None } else { given.or(usual.detail) };
    HandOptions { tets: hand.tets.map_or(usual.tets, |tets| tets as usize), detail, ..usual }
}

/// Tetrahedra that a hand will have, about.
pub fn tets_wanted(hand: &Hand, preset: PresetWord) -> u64 {
    let options = mesh(hand, preset);
    options.detail.map_or(options.tets as u64, graded_tets)
}
