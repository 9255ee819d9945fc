//! Rigid and soft objects.

use super::{Args, name};
use crate::error::CliError;
use std::path::Path;
use thenar::model::{Law, Material};
use thenar_rig::embed::{EmbedOptions, closed_surface, embed};
use thenar_rig::export::{flesh_cell_fields, surface, tetrahedra, write_whole};
use thenar_rig::mesh::load_mesh;
use thenar_rig::object::{ImportOptions, SoftModel, Weight, rigid_from_mesh};
use thenar_rig::{Model, TriMesh};
use thenar_scene::build::TET_BYTES;

/// Tetrahedra of a soft body where it is not said.
const SOFT_TETS: usize = 600;

fn read(args: &Args) -> Result<TriMesh, CliError> {
    Ok(load_mesh(&args.input, args.scale)?)
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
    println!("mass: {:.6} kg, volume {:.3} ml", model.mass, report.volume * 1e6);
    println!("inside: {:?}", report.interior);
    println!(
        "mesh: {} triangles in {} pieces, {} open edges, {} turned, {} vertices welded",
        report.topology.triangles,
        report.topology.components,
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
    let mesh = closed_surface(&mesh).map_err(wrong)?;
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
    println!("volume: {:.3} ml", body.node_volumes.iter().sum::<f64>() * 1e6);
    println!("elements: {:?}", body.quality);
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

fn write(folder: &Path, file: &str, text: &str) -> Result<(), CliError> {
    std::fs::create_dir_all(folder)
        .map_err(|e| CliError::Other(format!("cannot make {}: {e}", folder.display())))?;
    Ok(write_whole(&folder.join(file), text.as_bytes())?)
}
