//! Hands.

use super::object::{print_holes, shapes};
use super::{Args, CouplingArg, Outputs, PresetArg, SideArg, SpringsArg, name, write};
use crate::error::CliError;
use crate::words::counted;
use std::path::Path;
use thenar_core::model::{CouplingKind, HandModel, Side};
use thenar_rig::export::{hand_glb, hand_json, write_hand_vtk};
use thenar_rig::glb::SkinnedPart;
use thenar_rig::hand::{
    HandOptions, JoinedMeshes, JointStiffness, NameMap, RigReading, Size, Springs, asset,
    build_hand_with_report, joint_stiffness,
};
use thenar_rig::object::size_in_words;
use thenar_rig::{HandReport, Model};
use thenar_scene::build::change_by_file;

/// Largest file of joint names, and of a mesh \[bytes\].
const NAMES_BYTES_MAX: u64 = 1 << 20;
const MESH_BYTES_MAX: u64 = 512 << 20;

/// Builds a hand and prints what it is like.
pub fn build(args: &Args, outputs: &mut Outputs) -> Result<Model, CliError> {
    let options = options(args)?;
    let bytes = match args.input.to_str() {
        Some("left") => asset(Side::Left).to_vec(),
        Some("right") => asset(Side::Right).to_vec(),
        _ => mesh_bytes(&args.input)?,
    };
    let (mut hand, report) = build_hand_with_report(&bytes, &options)
        .map_err(|e| CliError::from(e.in_file(args.input.display())))?;
    if let Some(file) = &args.joints {
        change_by_file(&mut hand, file).map_err(|e| CliError::Input(e.to_string()))?;
    }
    print(&report);
    print_joints(&joint_stiffness(&hand)?);
    write_boned(args, outputs, &hand)?;
    Ok(Model::Hand(hand))
}

/// Writes what is asked for of a hand or a figure.
pub fn write_boned(args: &Args, outputs: &mut Outputs, hand: &HandModel) -> Result<(), CliError> {
    if let Some(folder) = &args.vtk {
        std::fs::create_dir_all(folder)
            .map_err(|e| CliError::Other(format!("cannot make {}: {e}", folder.display())))?;
        write_hand_vtk(folder, hand)?;
    }
    if let Some(output) = outputs.glb.take() {
        write(Some(output), &hand_glb(hand)?)?;
    }
    if let Some(output) = outputs.json.take() {
        write(Some(output), hand_json(hand)?.as_bytes())?;
    }
    Ok(())
}

/// Options as in scenes: what is not given comes from the preset, and a number of tetrahedra of one
/// size or springs on all flesh are about the paper's hand.
fn options(args: &Args) -> Result<HandOptions, CliError> {
    let is_papers = args.tets.is_some() || args.coupling == Some(CouplingArg::Uniform);
    let usual = match args.preset {
        Some(PresetArg::Touch) => HandOptions::touch(),
        Some(PresetArg::Paper) => HandOptions::paper(),
        None if is_papers => HandOptions::paper(),
        None => HandOptions::default(),
    };
    let mut material = usual.material;
    material.young = args.young.unwrap_or(material.young);
    material.poisson = args.poisson.unwrap_or(material.poisson);
    material.density = args.density.unwrap_or(material.density);
    Ok(HandOptions {
        name: name(args),
        side: args.side.map(SideArg::side),
        size: size(args),
        tets: args.tets.unwrap_or(usual.tets),
        detail: if args.tets.is_some() { None } else { args.detail.or(usual.detail) },
        material,
        coupling: args.coupling.map_or(usual.coupling, |kind| match kind {
            CouplingArg::Uniform => CouplingKind::Uniform,
            CouplingArg::Bone => CouplingKind::Bone,
        }),
        springs: match args.springs {
            Some(SpringsArg::Fixed) => Springs::Fixed,
            Some(SpringsArg::Rest) => Springs::Rest,
            None => usual.springs,
        },
        meshes: args.mesh.clone(),
        name_map: args.joint_names.as_deref().map_or(Ok(NameMap::new()), names)?,
        ..usual
    })
}

fn size(args: &Args) -> Size {
    match (args.length, args.scale) {
        (Some(length), _) => Size::Length(length),
        (None, Some(scale)) => Size::Scale(scale),
        (None, None) => Size::Own,
    }
}

/// A file of joint names.
pub fn names(path: &Path) -> Result<NameMap, CliError> {
    let text = String::from_utf8(read(path, NAMES_BYTES_MAX)?)
        .map_err(|_| CliError::Input(format!("{}: not text", path.display())))?;
    toml::from_str(&text).map_err(|e| CliError::Input(format!("{}: {e}", path.display())))
}

/// The bytes of a mesh's file.
pub fn mesh_bytes(path: &Path) -> Result<Vec<u8>, CliError> {
    read(path, MESH_BYTES_MAX)
}

fn read(path: &Path, bytes_max: u64) -> Result<Vec<u8>, CliError> {
    thenar_input::read(path, bytes_max)
        .map_err(|e| CliError::Input(format!("{}: {e}", path.display())))
}

/// Prints how the rig was read, where that was not as it states itself.
fn print_reading(rig: &RigReading) {
    print_meshes(&rig.meshes);
    if let Some(JoinedMeshes { cell, left_out }) = rig.joined {
        println!("joined: what the meshes enclose together, on a grid of {:.1} mm", cell * 1e3);
        if left_out > 0 {
            println!("left out: {} of that", counted(left_out, "separate piece"));
        }
    }
    if let Some(unit) = rig.unit {
        println!(
            "unit: taken for {unit} (--scale {}); --scale or --length says otherwise",
            rig.scale
        );
    }
    if !rig.own_axes {
        println!("axes: from the places of the joints; the rig's own are not those of WebXR");
    }
    if !rig.made.is_empty() {
        println!("made: {}, which the rig lacks", rig.made.join(", "));
    }
    if rig.inside_out {
        println!("turned over: the triangles of the skin, which faced inward");
    }
    print_holes(&rig.holes);
}

/// Prints which of several skinned meshes the hand is, and which are left out.
fn print_meshes(meshes: &[SkinnedPart]) {
    if meshes.len() < 2 {
        return;
    }
    for (what, chosen) in [("mesh", true), ("left out", false)] {
        for part in meshes.iter().filter(|part| part.chosen == chosen) {
            let name = thenar_input::visible(&part.name);
            match &part.damage {
                Some(damage) => println!("{what}: {name}, which is damaged: {damage}"),
                None => println!("{what}: {name}, {}", size_in_words(&part.size)),
            }
        }
    }
}

fn print(r: &HandReport) {
    print_reading(&r.rig);
    println!("skin: {} vertices, {} triangles, closed", r.skin.vertices, r.skin.triangles);
    println!("size: {:.1} mm, {:.1} ml", r.length * 1e3, r.volume * 1e6);
    println!("mass: {:.0} g flesh, {:.0} g bones", r.flesh_mass * 1e3, r.bone_mass * 1e3);
    println!("flesh: {} tetrahedra, {} nodes", r.tets, r.nodes);
    println!(
        "surfaces: {} triangles that touch, {} that are drawn",
        r.collision_triangles, r.render_triangles
    );
    println!("elements: {}", shapes(&r.quality));
    println!(
        "in a fist: {} inside out with {:.2} % of the volume, smallest volume ratio (det F) {:.3}",
        counted(r.fist.tets, "element"),
        100.0 * r.fist.volume_fraction,
        r.fist.det_min
    );
    println!("bones against radiographs, scaled by {:.3}:", r.anatomy_scale);
    for bone in &r.bone_lengths {
        println!(
            "  {:22} {:5.1} mm, mean {:5.1} mm, {:+.1} SD",
            bone.bone,
            bone.length * 1e3,
            bone.expected * 1e3,
            bone.deviation_sd
        );
    }
    println!(
        "solids of bones, and the flesh over them: mean on the back, mean on the palm's side, least:"
    );
    for cover in &r.bone_covers {
        let [thick, dorsal, palmar, least] =
            [cover.thickness, cover.dorsal, cover.palmar, cover.flesh].map(|x| x * 1e3);
        println!(
            "  {:22} {thick:5.1} mm thick, flesh {dorsal:5.1}, {palmar:5.1}, {least:5.1} mm; {} nodes \
             hold {:.2} of {:.2} ml",
            cover.bone,
            cover.nodes,
            cover.bound * 1e6,
            cover.volume * 1e6
        );
    }
}

/// Prints the resistance of joints, axis by axis.
fn print_joints(joints: &[JointStiffness]) {
    println!(
        "joints [N m/rad]: total with all others free = flesh + spring (flesh with all others held):"
    );
    for joint in joints {
        let range = match joint.range_deg {
            Some([low, high]) => format!("{low:4.0} to {high:3.0}°"),
            None => format!("{:12}", "no limits"),
        };
        let people = match (joint.band, joint.met()) {
            (Some([low, high]), Some(true)) => format!("people {low:.3} to {high:.3}"),
            (Some([low, high]), _) => format!("NOT as people's {low:.3} to {high:.3}"),
            _ => format!("{:.3} wanted, not measured in people", joint.wanted),
        };
        println!(
            "  {:11} {:9} {range}, {:.4} = {:.4} + {:.4} ({:.4}), damper {:.3} mN m s/rad; {people}",
            joint.joint,
            joint.axis,
            joint.total,
            joint.flesh,
            joint.spring,
            joint.flesh_held,
            joint.damping * 1e3
        );
    }
}
