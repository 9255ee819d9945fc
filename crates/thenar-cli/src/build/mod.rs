//! `thenar build`: a simulation-ready model from a mesh.

mod figure;
mod hand;
mod object;

pub use hand::{mesh_bytes, names};

use crate::error::CliError;
use crate::recorder::ends_in_png;
use crate::{building, interrupt};
use std::io::Write;
use std::path::PathBuf;
use thenar_core::model::Side;
use thenar_output::{Output, protect};
use thenar_picture::{Layers, Quality, portrait, write_png};
use thenar_rig::Model;
use thenar_rig::model_file::figure_bytes;

/// Build a simulation-ready model from a mesh.
#[derive(Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("kind").required(true).args(["hand", "figure", "rigid", "soft"])))]
#[command(group(clap::ArgGroup::new("boned").multiple(true).args(["hand", "figure"])))]
pub struct Args {
    /// A mesh: a skinned GLB for a hand; GLB, OBJ, STL, PLY or OFF for objects. For a hand also
    /// `left` or `right`, the built-in ones. For a figure a skinned GLB or VRM, a URDF, or an MJCF
    /// (.xml, .mjcf).
    input: PathBuf,
    /// Build a hand.
    #[arg(long)]
    hand: bool,
    /// Build a figure: flesh on any tree of bones, such as a gripper, an arm or a whole body.
    #[arg(long)]
    figure: bool,
    /// Figure: thickness of the flesh around bones that come without a skin (URDF, MJCF) [m].
    #[arg(long, value_name = "M", requires = "figure")]
    flesh: Option<f64>,
    /// Hand, figure: name of the skinned mesh that is the body, where a file has several, such as
    /// eyes and clothes; given again, they are joined. Default: the mesh that encloses most.
    #[arg(long, value_name = "NAME", requires = "boned")]
    mesh: Vec<String>,
    /// Build a rigid body; the mesh may be open or of many parts.
    #[arg(long)]
    rigid: bool,
    /// Build a soft body; holes of the mesh are closed, and told.
    #[arg(long)]
    soft: bool,
    /// The model file to write.
    #[arg(short, long, value_name = "MODEL.thenar")]
    output: Option<PathBuf>,
    /// Hand: mesh and coupling that go together, where --tets, --detail or --coupling do not say:
    /// the paper's 600 tetrahedra with springs on all flesh, or for touch: finer at the pads, flesh
    /// that hangs on bone. Default: paper with --tets and with --coupling uniform, else as scenes
    /// have it.
    #[arg(long, value_enum, value_name = "WORD", requires = "hand")]
    preset: Option<PresetArg>,
    /// Hand, figure, soft body: wanted number of tetrahedra, all of one size. Default of soft
    /// bodies: 600; of figures: 1000.
    #[arg(long, value_name = "N")]
    tets: Option<usize>,
    /// Hand: in the place of --tets, how fine a graded mesh is, from 0.25 to 1.5.
    #[arg(long, conflicts_with = "tets", requires = "hand")]
    detail: Option<f64>,
    /// Hand: what the springs to the bones hold where a scene does not say: all flesh, or that in
    /// the place of bone.
    #[arg(long, value_enum, value_name = "KIND", requires = "hand")]
    coupling: Option<CouplingArg>,
    /// Hand: wrist to middle fingertip [m].
    #[arg(long, value_name = "M", conflicts_with = "scale")]
    length: Option<f64>,
    /// Factor on all coordinates, e.g. 0.001 for a mesh in mm. Default: 1; of a hand that would be
    /// too long or too short in metres, the unit in which it is as long as people's.
    #[arg(long)]
    scale: Option<f64>,
    /// Hand: left or right, where the rig does not say, or has both.
    #[arg(long, value_enum, value_name = "SIDE", requires = "hand")]
    side: Option<SideArg>,
    /// Hand, figure, soft body: Young's modulus of the flesh [Pa].
    #[arg(long, value_name = "PA")]
    young: Option<f64>,
    /// Hand, figure, soft body: Poisson's ratio of the flesh.
    #[arg(long)]
    poisson: Option<f64>,
    /// Density, of hands and figures that of the flesh [kg/m³].
    #[arg(long, value_name = "KG/M3", conflicts_with = "mass")]
    density: Option<f64>,
    /// Rigid: mass [kg].
    #[arg(long, value_name = "KG", requires = "rigid")]
    mass: Option<f64>,
    /// Hand: a TOML file of `webxr-joint = "name in the rig"`, for rigs whose names say nothing.
    #[arg(long, value_name = "FILE.toml", requires = "hand")]
    joint_names: Option<PathBuf>,
    /// Hand: where the springs of its joints come from: a table, whatever the bent flesh adds, or
    /// what the flesh leaves of the stiffness of people's joints. Default: the preset's.
    #[arg(long, value_enum, value_name = "KIND", requires = "hand")]
    springs: Option<SpringsArg>,
    /// A TOML file of `[[joint]]` tables with ranges, springs and dampers, as `[[hand.joint]]` and
    /// `[[figure.joint]]` in scenes; a figure's with kinds and axes too.
    #[arg(long, value_name = "FILE.toml", requires = "boned")]
    joints: Option<PathBuf>,
    /// Write VTK files for ParaView into this folder.
    #[arg(long, value_name = "DIR")]
    vtk: Option<PathBuf>,
    /// Draw what was built as a PNG file.
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    /// Layers to draw: skin, flesh, bones, weights.
    #[arg(long, default_value = "skin,bones", value_name = "LIST", requires = "picture")]
    layers: Layers,
    /// Write a GLB of the built hand or figure.
    #[arg(long, value_name = "FILE.glb", requires = "boned")]
    glb: Option<PathBuf>,
    /// Hand or figure: write it as JSON, for simulating it with other programs.
    #[arg(long, value_name = "FILE.json", requires = "boned")]
    json: Option<PathBuf>,
}

/// Meshes and couplings that go together.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum PresetArg {
    /// The paper's.
    Paper,
    /// For touch.
    Touch,
}

impl PresetArg {
    /// Word for it in scenes.
    pub fn word(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Touch => "touch",
        }
    }
}

/// Left or right.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum SideArg {
    /// A left hand.
    Left,
    /// A right hand.
    Right,
}

impl SideArg {
    /// Side, as models have it.
    pub fn side(self) -> Side {
        match self {
            Self::Left => Side::Left,
            Self::Right => Side::Right,
        }
    }
}

/// Flesh that springs hold to bones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum CouplingArg {
    /// All flesh.
    Uniform,
    /// Flesh in the place of bone.
    Bone,
}

/// Source of the springs of a hand's joints.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum SpringsArg {
    /// A table.
    Fixed,
    /// The stiffness of people's joints, less that of the bent flesh.
    Rest,
}

/// Builds a model.
///
/// # Errors
/// The mesh or an option is wrong, or an output cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    refuse_what_is_for_others(args)?;
    ends_in_png("--picture", args.picture.as_deref())?;
    // What cannot be written is known before anything is built.
    let mut outputs = Outputs::create(args)?;
    interrupt::listen();
    let alone = |model| (model, Vec::new());
    let (model, mimics) = building::told(|| match (args.hand, args.figure, args.rigid) {
        (true, ..) => hand::build(args, &mut outputs).map(alone),
        (_, true, _) => figure::build(args, &mut outputs),
        (.., true) => object::rigid(args).map(alone),
        _ => object::soft(args).map(alone),
    })?;
    if let Some(output) = outputs.picture.take() {
        let image = portrait(&model, &args.layers, [960, 640], &Quality::still())
            .map_err(|e| CliError::Input(e.to_string()))?;
        write_png(output, &image)?;
    }
    let Some(path) = &args.output else {
        println!("note: {}", not_kept(args));
        return Ok(());
    };
    let bytes = match &model {
        Model::Hand(figure) => figure_bytes(figure, &mimics),
        other => other.to_bytes(),
    };
    write(outputs.model, &bytes.map_err(|e| e.in_file(path.display()))?)?;
    let kind = match model {
        Model::Hand(_) if args.figure => "figure",
        Model::Hand(_) => "hand",
        Model::Rigid(_) => "rigid body",
        Model::Soft(_) => "soft body",
    };
    println!("wrote the {kind} to {}", path.display());
    Ok(())
}

/// Words for a model that no file was asked for; other files than the model's may have been
/// written.
fn not_kept(args: &Args) -> &'static str {
    let others = [&args.vtk, &args.picture, &args.glb, &args.json];
    match others.iter().any(|file| file.is_some()) {
        true => "no model written; add -o FILE to keep it",
        false => "nothing written; add -o FILE to keep it",
    }
}

/// Refuses options that would change nothing of what is built.
fn refuse_what_is_for_others(args: &Args) -> Result<(), CliError> {
    let given = [
        ("--length", args.length.is_some(), args.hand, "a hand; all else takes --scale"),
        ("--tets", args.tets.is_some(), !args.rigid, SOFT_KINDS),
        ("--young", args.young.is_some(), !args.rigid, SOFT_KINDS),
        ("--poisson", args.poisson.is_some(), !args.rigid, SOFT_KINDS),
    ];
    match given.iter().find(|(_, given, applies, _)| *given && !applies) {
        Some((option, _, _, whose)) => Err(CliError::Input(format!("{option} is that of {whose}"))),
        None => Ok(()),
    }
}

/// The kinds of models that consist of flesh.
const SOFT_KINDS: &str = "a hand, a figure or a soft body; a rigid body has no flesh";

/// The files that are asked for.
struct Outputs {
    model: Option<Output>,
    glb: Option<Output>,
    json: Option<Output>,
    picture: Option<Output>,
}

impl Outputs {
    fn create(args: &Args) -> Result<Self, CliError> {
        protect(&args.input);
        args.joint_names.iter().chain(&args.joints).for_each(|file| protect(file));
        let begin = |path: &Option<PathBuf>| path.as_deref().map(Output::create).transpose();
        Ok(Self {
            model: begin(&args.output)?,
            glb: begin(&args.glb)?,
            json: begin(&args.json)?,
            picture: begin(&args.picture)?,
        })
    }
}

/// Writes all of an output, if it is wanted.
fn write(output: Option<Output>, bytes: &[u8]) -> Result<(), CliError> {
    let Some(mut output) = output else { return Ok(()) };
    output.write_all(bytes).map_err(|e| CliError::Other(format!("cannot write {e}")))?;
    Ok(output.finish()?)
}

/// Name of a model: that of its file.
fn name(args: &Args) -> String {
    args.input.file_stem().map_or_else(|| "model".into(), |s| s.to_string_lossy().into_owned())
}
