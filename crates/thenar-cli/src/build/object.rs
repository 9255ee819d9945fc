//! Rigid and soft objects.

use super::{Args, name};
use crate::error::CliError;
use crate::words::counted;
use std::path::Path;
use thenar_core::model::{Law, Material};
use thenar_rig::embed::{EmbedOptions, embed, mended_surface};
use thenar_rig::export::{flesh_cell_fields, surface, tetrahedra, write_whole};
use thenar_rig::lattice::Quality;
use thenar_rig::mesh::{Hole, load_mesh};
use thenar_rig::object::{
    Extent, ImportOptions, Interior, SoftModel, Weight, length_in_words, mass_in_words,
    rigid_from_mesh, size_in_words, unit_question, volume_in_words,
};
use thenar_rig::{Model, TriMesh};
use thenar_scene::build::TET_BYTES;

/// Tetrahedra of a soft body where it is not said.
const SOFT_TETS: usize = 600;

fn read(args: &Args) -> Result<TriMesh, CliError> {
    Ok(load_mesh(&args.input, args.scale.unwrap_or(1.0))?)
}

/// Builds a rigid body and prints what became of its mesh.
pub fn rigid(args: &Args) -> Result<Model, CliError> {
    let weight = match (args.mass, args.density) {
        (Some(mass), _) => Weight::Mass(mass),
        (None, density) => Weight::Density(density.unwrap_or(1000.0)),
    };
    let mesh = read(args)?;
    let (model, report) = rigid_from_mesh(&name(args), &mesh, weight, &ImportOptions::default())
        .map_err(|e| e.in_file(args.input.display()))?;
    print_extent(args, &mesh, model.mass, report.volume);
    println!("inside: {}", inside(report.interior));
    println!(
        "mesh: {} triangles in {}, {} open edges, {} triangles turned, {} vertices welded",
        report.topology.triangles,
        counted(report.topology.components, "piece"),
        report.topology.boundary_edges,
        report.orientation.flipped_triangles,
        report.welded_vertices
    );
    println!(
        "contact: {} points, distances every {:.2} mm",
        report.contact_points,
        report.grid_cell * 1e3
    );
    if let Some(folder) = &args.vtk {
        let text = surface(&model.render.positions, &model.render.triangles, &[], &[])?;
        write(folder, &format!("{}.vtp", name(args)), &text)?;
    }
    Ok(Model::Rigid(model))
}

/// Builds a soft body and prints what it is like.
pub fn soft(args: &Args) -> Result<Model, CliError> {
    let mesh = read(args)?;
    let wrong = |e: thenar_rig::RigError| CliError::from(e.in_file(args.input.display()));
    let (mesh, holes) = mended_surface(&mesh).map_err(wrong)?;
    print_holes(&holes);
    let material = Material {
        law: Law::Corotational,
        young: args.young.unwrap_or(5e4),
        poisson: args.poisson.unwrap_or(0.4),
        density: args.density.unwrap_or(1000.0),
    };
    thenar_rig::object::check_material(&material)?;
    let options = EmbedOptions { tets: args.tets.unwrap_or(SOFT_TETS), ..EmbedOptions::default() };
    let body = embed(&mesh, &options, |_| material).map_err(wrong)?;
    println!("flesh: {} tetrahedra, {} nodes", body.flesh.tets.len(), body.flesh.nodes.len());
    let volume = body.node_volumes.iter().sum::<f64>();
    print_extent(args, &mesh, volume * material.density, volume);
    println!("elements: {}", shapes(&body.quality));
    let bytes = TET_BYTES * body.flesh.tets.len() as u64;
    println!("memory: about {} when simulated", crate::files::size(bytes));
    let model = SoftModel { name: name(args), flesh: body.flesh, render: body.render };
    if let Some(folder) = &args.vtk {
        let flesh = &model.flesh;
        let text = tetrahedra(&flesh.nodes, &flesh.tets, &[], &flesh_cell_fields(flesh))?;
        write(folder, &format!("{}-flesh.vtu", name(args)), &text)?;
    }
    Ok(Model::Soft(model))
}

/// Bounding box, volume and mass; and what to ask where they are no thing's that hands hold.
fn print_extent(args: &Args, mesh: &TriMesh, mass: f64, volume: f64) {
    let [low, high] = mesh.bounds();
    let size = high - low;
    println!("size: {}", size_in_words(&size));
    println!("mass: {}, volume {}", mass_in_words(mass), volume_in_words(volume));
    let longest = size.max();
    let body = Extent { longest, mass, still: false };
    if let Some(question) = unit_question(&body, args.scale.unwrap_or(1.0), "--scale ") {
        let [long, weight] = [length_in_words(longest), mass_in_words(mass)];
        println!(
            "warning: it is {long} long and weighs {weight}, if it is to be moved: {question}"
        );
    }
}

/// Describes, for a person, how the inside of a mesh was found.
fn inside(interior: Interior) -> String {
    match interior {
        Interior::Closed => "of a closed surface, exact".into(),
        Interior::Winding => {
            "where the surface winds around a place at least half a time, for it is open or overlaps itself".into()
        }
        Interior::Shell(thickness) => {
            format!("none, so a shell of {} around the surface", length_in_words(thickness))
        }
    }
}

/// The worst shapes of tetrahedra, for a person.
pub fn shapes(quality: &Quality) -> String {
    format!(
        "dihedral angles of {:.1}° to {:.1}°, longest over shortest edge at most {:.2}",
        quality.dihedral_min.to_degrees(),
        quality.dihedral_max.to_degrees(),
        quality.edge_ratio_max
    )
}

/// Most holes that are listed one by one, the largest first.
const HOLES_TOLD_MAX: usize = 5;

/// Holes that were closed, the largest first.
pub fn print_holes(holes: &[Hole]) {
    let (told, rest) = holes.split_at(holes.len().min(HOLES_TOLD_MAX));
    for hole in told {
        println!(
            "closed a hole: {} edges, border {:.1} mm, {:.1} mm²",
            hole.edges,
            hole.border * 1e3,
            hole.area * 1e6
        );
    }
    if !rest.is_empty() {
        let area: f64 = rest.iter().map(|hole| hole.area).sum();
        println!("closed {} smaller holes: {:.1} mm² in all", rest.len(), area * 1e6);
    }
}

fn write(folder: &Path, file: &str, text: &str) -> Result<(), CliError> {
    std::fs::create_dir_all(folder)
        .map_err(|e| CliError::Other(format!("cannot make {}: {e}", folder.display())))?;
    Ok(write_whole(&folder.join(file), text.as_bytes())?)
}
