//! Writes the shipped right hand as VTK and GLB files: open them in ParaView, or any glTF viewer.
//!
//! `cargo run --release -p thenar-rig --example export_hand -- OUT_DIR`

use std::path::PathBuf;
use thenar_core::model::Side;
use thenar_rig::RigError;
use thenar_rig::export::{write_hand_glb, write_hand_vtk};

fn main() -> Result<(), RigError> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "out".into()));
    let hand = thenar_rig::default_hand(Side::Right)?;
    write_hand_vtk(&folder, &hand)?;
    write_hand_glb(&folder.join("right-hand.glb"), &hand)?;
    println!("{} tetrahedra, {} triangles", hand.flesh.tets.len(), hand.render.triangles.len());
    Ok(())
}
