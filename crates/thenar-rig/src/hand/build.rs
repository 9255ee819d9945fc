//! The steps from a file's bytes to a hand.

use super::digits::{self, DigitRig};
use super::loose::{Loose, Softness};
use super::options::{HandOptions, Size, Springs};
use super::relax::relax;
use super::report::{HandReport, JoinedMeshes, RigReading};
use super::rig::{self, Frames, Posed, RigJoints};
use super::sides::Sides;
use super::solids::Covered;
use super::{
    bones, grading, in_bone, joints, layers, nails, passive, regions, solids, unit, weights,
};
use crate::embed::check_closed;
use crate::glb::{self, RigJoint, SkinnedMesh};
use crate::lattice::{Lattice, LatticeOptions};
use crate::mesh::{
    Bvh, Topology, close_holes, decimate, decimate_within, read_file, subdivide_to, weld,
};
use crate::united::{United, united};
use crate::work::{Stage, phase};
use crate::{RigError, TriMesh, model_file};
use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::{
    Binding, Bone, BoneSolid, Digit, Flesh, HandModel, HandRegion, Material, Side,
};

/// Vertices nearer than this are one \[m\], at the size of the file.
const WELD_TOLERANCE: f64 = 1e-5;
/// Lengths that a hand may have \[m\].
pub const LENGTHS: [f64; 2] = [0.05, 0.5];
/// Least part of the hand's mass that is flesh, where a very light hand was asked for.
const FLESH_MIN: f64 = 0.2;

/// Builds a hand from the bytes of a skinned GLB file. The model frame M is that of the wrist
/// (WebXR: -z towards the fingers, +y out of the back of the hand).
///
/// # Errors
/// When the file is damaged, its mesh is not closed, joints are missing, or an option is out of
/// range.
pub fn build_hand(bytes: &[u8], options: &HandOptions) -> Result<HandModel, RigError> {
    match options.springs {
        Springs::Fixed => made(bytes, options).map(|made| made.hand),
        Springs::Rest => build_hand_with_report(bytes, options).map(|(hand, _)| hand),
    }
}

/// [`build_hand`], and what there is to know about the result.
///
/// # Errors
/// As there.
pub fn build_hand_with_report(
    bytes: &[u8],
    options: &HandOptions,
) -> Result<(HandModel, HandReport), RigError> {
    let AssembledModel { mut hand, skin, digits, covered, reading } = made(bytes, options)?;
    let joints = match options.springs {
        Springs::Fixed => Vec::new(),
        Springs::Rest => passive::fill_up(&mut hand)?,
    };
    phase("measuring the hand")?;
    let report = HandReport::new(&hand, reading, &skin, &digits, &covered, joints)?;
    Ok((hand, report))
}

/// A hand with springs from the table, and what it was made from.
struct AssembledModel {
    hand: HandModel,
    skin: TriMesh,
    digits: Vec<DigitRig>,
    covered: Vec<Covered>,
    reading: RigReading,
}

fn made(bytes: &[u8], options: &HandOptions) -> Result<AssembledModel, RigError> {
    options.check()?;
    phase("reading the hand")?;
    let mut rig = glb::read_skinned_glb_of(bytes, &options.meshes)?;
    let joined = join(&mut rig)?;
    let Rigged { skin, digits, side, length, mut reading } = rigged(&rig, options)?;
    let scale = reading.scale;
    reading.joined = joined.map(|joined| JoinedMeshes { cell: joined.cell * scale, ..joined });
    check_closed("the hand's surface", &skin)?;
    let surface = Bvh::new(&skin);
    let bones = bones::bones(&digits, &surface, length);
    let joints = joints::joints(&digits, &bones, side, length);
    let covered = solids::solids(&bones, &digits, &surface, length)?;

    // The smooth surface through the skin's vertices is the body; all else is made from it.
    let grading = options.detail.map(|detail| grading::grading(length, detail)).transpose()?;
    let fine = grading.map_or(0, |grading| grading::triangles(skin.area(), &grading));
    let triangles = options.render_triangles.max(options.collision_triangles).max(fine);
    let smooth = subdivide_to(&skin, triangles)?.mesh;
    let lattice = match &grading {
        Some(grading) => {
            Lattice::graded(&smooth, grading, |p| grading::edge(p, &digits, length, grading))?
        }
        None => {
            let rotation = thenar_core::Quat::identity();
            Lattice::new(&smooth, &LatticeOptions { tets: options.tets, rotation })?
        }
    };
    phase("binding the flesh to the bones")?;
    let samples = regions::digits_of_samples(&lattice, &digits);
    let bindings = bindings(&lattice, &digits, &samples);

    let near = |p: &Vec3| bones::nearest(&bones, p);
    let collision_mesh = match &grading {
        Some(_) => {
            // An edge may be no longer than those of the elements under its ends.
            let edges = grading::element_edges(&lattice);
            let under = lattice.embed_near(&smooth, near)?;
            let limits = under.vertices.iter().map(|v| edges[v.tet as usize]).collect();
            decimate_within(&smooth, options.collision_triangles, limits)?
        }
        None => decimate(&smooth, options.collision_triangles)?,
    };
    let collision_digits =
        collision_mesh.positions.iter().map(|p| regions::nearest(p, &digits)).collect();
    let sides = Sides::new(&digits, &surface);
    let body = Bvh::new(&smooth);
    let layers = layers::of_samples(&options.layers, &lattice, &sides, &body)?;
    phase("weighing the flesh")?;
    let loose = Loose::new(&lattice, &digits, &samples);
    let softness = Softness { joint: options.joint_softness, root: options.root_softness };
    let flesh = Flesh {
        materials: materials(&lattice, &bones, &loose, &softness, &layers, options),
        nodes: lattice.nodes.clone(),
        tets: lattice.tets.clone(),
        relaxation: Vec::new(),
        mass_damping: options.mass_damping,
        stiffness_damping: options.stiffness_damping,
        fixed: Vec::new(),
        collision: lattice.embed_near(&collision_mesh, near)?,
        friction: options.friction,
    };
    phase("binding the skin to the flesh")?;
    let solids: Vec<BoneSolid> = covered.iter().map(|covered| covered.solid.clone()).collect();
    let bone_nodes = in_bone::bone_nodes(&lattice, &bones, &joints, &solids);
    let nail_nodes = nails::nail_nodes(&lattice, &bones, &sides, &body, length);
    let render = lattice.embed_near(&decimate(&smooth, options.render_triangles)?, near)?;
    let mut hand = HandModel {
        name: options.name.clone(),
        side: Some(side),
        joints,
        flesh,
        bindings,
        node_volumes: lattice.node_volumes(),
        render,
        collision_digits,
        length,
        bone_nodes,
        bones,
        solids,
        coupling: options.coupling,
        regions: regions_of(&collision_mesh, &sides),
        nail_nodes,
        bending: Vec::new(),
    };
    relax(&mut hand)?;
    // A rig of strange proportions can still lead to a bone without length or mass.
    model_file::check_hand(&hand)?;
    Ok(AssembledModel { hand, skin, digits, covered, reading })
}

/// Makes one surface of several meshes, as a glove over skin, or a hand and its sleeve. Meshes that
/// have the vertices of their borders in common, and close each other, stay as they are; of others
/// that is what they enclose together, on a grid whose cell is given in the file's unit.
fn join(rig: &mut SkinnedMesh) -> Result<Option<JoinedMeshes>, RigError> {
    if rig.parts.iter().filter(|part| part.chosen).count() < 2 {
        return Ok(None);
    }
    let welded = weld(&rig.mesh, WELD_TOLERANCE).mesh.compacted();
    let topology = Topology::of(&close_holes(&welded).0);
    if topology.closed() && topology.components == 1 {
        return Ok(None);
    }
    let United { mesh, left_out, cell } = united(&rig.mesh)?;
    rig.mesh = mesh;
    // They were those of the vertices that are gone; a hand's flesh is bound by the places of its
    // bones.
    rig.influences.clear();
    Ok(Some(JoinedMeshes { cell, left_out }))
}

/// Region of each triangle.
fn regions_of(mesh: &TriMesh, sides: &Sides) -> Vec<HandRegion> {
    let middle = |t: usize| mesh.corners(t).iter().sum::<Vec3>() / 3.0;
    (0..mesh.triangles.len()).map(|t| sides.of(&middle(t)).0).collect()
}

fn bindings(lattice: &Lattice, digits: &[DigitRig], samples: &[Digit]) -> Vec<Binding> {
    let tets = regions::digits_of_tets(lattice, samples);
    let nodes = node_digits(lattice, &tets);
    let chains = weights::chains(digits);
    (lattice.nodes.iter().zip(&nodes))
        .map(|(p, &own)| weights::binding(p, own, digits, &chains))
        .collect()
}

/// [`build_hand`] from a file.
///
/// # Errors
/// As there, naming the file; also when it cannot be read.
pub fn build_hand_file(path: &Path, options: &HandOptions) -> Result<HandModel, RigError> {
    let bytes = read_file(path)?;
    build_hand(&bytes, options).map_err(|e| e.in_file(path.display()))
}

/// The rig in the model frame at its final size.
pub(super) struct Rigged {
    pub skin: TriMesh,
    pub digits: Vec<DigitRig>,
    pub side: Side,
    pub length: f64,
    pub reading: RigReading,
}

/// Moves the rig to the model frame M, which is the frame of the wrist, and scales it.
pub(super) fn rigged(rig: &SkinnedMesh, options: &HandOptions) -> Result<Rigged, RigError> {
    let found = rig::find(&rig.joints, &options.name_map, options.side)?;
    let frames = Frames::new(&found, &rig.joints, options.side)?;
    let unscaled = at_scale(rig, &found, &frames, 1.0)?;
    let unit = match options.size {
        Size::Own if !within_lengths(unscaled.length) => unit::of_length(unscaled.length),
        _ => None,
    };
    let scale = match (options.size, unit) {
        (Size::Length(length), _) => length / unscaled.length,
        (Size::Scale(scale), _) => scale,
        (Size::Own, Some((_, metres))) => metres,
        (Size::Own, None) => 1.0,
    };
    let mut rigged = at_scale(rig, &found, &frames, scale)?;
    unit::check_length(rigged.length, scale)?;
    rigged.reading.unit = unit.map(|(unit, _)| unit);
    if options.side.is_some_and(|side| side != rigged.side) {
        return Err(RigError::invalid(format!(
            "the rig shows a {} hand by where its thumb lies, not the other one that is asked for",
            rigged.side.name()
        )));
    }
    Ok(rigged)
}

fn within_lengths(length: f64) -> bool {
    (LENGTHS[0]..=LENGTHS[1]).contains(&length)
}

fn at_scale(
    rig: &SkinnedMesh,
    found: &RigJoints,
    frames: &Frames,
    scale: f64,
) -> Result<Rigged, RigError> {
    let joints = rig.joints.iter().cloned().map(|mut joint| {
        joint.pose.position *= scale;
        joint
    });
    let joints: Vec<RigJoint> = joints.collect();
    let posed = Posed::new(found, &joints, frames);

    let welded = weld(&rig.mesh.clone().scaled(scale), WELD_TOLERANCE * scale).mesh;
    let skin = welded.compacted().transformed(posed.pose_MR());
    if skin.triangles.is_empty() {
        return Err(RigError::invalid("all triangles of the hand's surface are without extent"));
    }
    // Most rigs are open at the wrist.
    let (mut skin, holes) = close_holes(&skin);
    // The volume of an open surface depends on where it lies.
    let inside_out = skin.volume() < 0.0 && Topology::of(&skin).closed();
    if inside_out {
        skin.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let surface = Bvh::new(&skin);
    // First guess of the length: wrist to the middle finger's tracked tip.
    let middle_tip = posed.digit(Digit::Middle, &surface)?[4].position;
    let guess = middle_tip.norm();
    let stage = Stage::new(
        "finding the fingertips",
        Digit::FINGERS.len(),
        (Digit::FINGERS.len() * digits::WAY_MAX) as f64 * surface.signed_distance_cost(&middle_tip),
        "its triangles lie in each other's way; simplify the mesh",
    )?;
    let mut digits = Vec::new();
    for (k, &digit) in Digit::FINGERS.iter().enumerate() {
        digits.push(digits::read(&posed, digit, &surface, guess)?);
        stage.at(k + 1)?;
    }
    let length = digits[2].tip.norm();
    let side = digits::side(&digits);
    let reading = RigReading {
        scale,
        unit: None,
        own_axes: matches!(frames, Frames::Own),
        made: posed.made(),
        inside_out,
        holes,
        meshes: rig.parts.clone(),
        joined: None,
    };
    Ok(Rigged { skin, digits, side, length, reading })
}

/// The finger that alone surrounds a node, or the palm.
fn node_digits(lattice: &Lattice, tets: &[Digit]) -> Vec<Digit> {
    let mut digits: Vec<Option<Digit>> = vec![None; lattice.nodes.len()];
    for (nodes, &digit) in lattice.tets.iter().zip(tets) {
        for &n in nodes {
            let of_node = &mut digits[n as usize];
            *of_node = match *of_node {
                Some(other) if other != digit => Some(Digit::Palm),
                _ => Some(digit),
            };
        }
    }
    digits.into_iter().map(|d| d.unwrap_or(Digit::Palm)).collect()
}

/// Materials whose density makes the whole hand, bones included, as heavy as it should be. The
/// flesh's elements fill the bones' place too, so the flesh is lighter than real flesh by the
/// bones' mass.
fn materials(
    lattice: &Lattice,
    bones: &[Bone],
    loose: &Loose,
    softness: &Softness,
    layers: &[Option<u32>],
    options: &HandOptions,
) -> Vec<Material> {
    let volume: f64 = lattice.filled.iter().sum();
    let bone_mass: f64 = bones.iter().map(|b| b.mass).sum();
    let whole = options.material.density * volume;
    let density = (whole - bone_mass).max(FLESH_MIN * whole) / volume;
    lattice.sample_materials(|i| {
        let own = match layers[i] {
            Some(layer) => options.layers[layer as usize].material(&options.material),
            None => options.material,
        };
        let young = own.young * loose.left(i, softness);
        Material { young, density, ..own }
    })
}
