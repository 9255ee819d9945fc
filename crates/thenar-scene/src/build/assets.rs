//! Files and built-in objects.

use super::lattice::Tets;
use super::shape::Solid;
use super::soft::{Rest, explicit};
use crate::format::{
    BreadShape, CarShape, ExplicitShape, FileShape, Hand, MeshShape, MeshSoftShape,
};
use crate::text::{At, Cx, Fault, Node, Read};
use std::path::{Path, PathBuf};
use thenar::model::HandModel;

/// Largest file with nodes and tetrahedra \[bytes\].
const TET_FILE_BYTES_MAX: u64 = 32 << 20;

/// A path in a scene, which starts at the scene's folder.
pub fn path(folder: &Path, file: &At<String>) -> PathBuf {
    folder.join(&file.value)
}

/// Text of a file that a scene names.
pub fn read_text(folder: &Path, file: &At<String>, bytes_max: u64) -> Result<String, Fault> {
    let path = path(folder, file);
    let fault = |problem: String| file.fault(format!("{}: {problem}", path.display()));
    let size = std::fs::metadata(&path).map_err(|e| fault(e.to_string()))?.len();
    if size > bytes_max {
        return Err(fault(format!("the file has {size} bytes, more than {bytes_max}")));
    }
    std::fs::read_to_string(&path).map_err(|e| fault(e.to_string()))
}

/// Nodes and tetrahedra from a TOML file.
pub fn tet_file(shape: &FileShape, folder: &Path) -> Result<Tets, Fault> {
    let text = read_text(folder, &shape.file, TET_FILE_BYTES_MAX)?;
    let inside = |fault: Fault| {
        let located = fault.locate(&path(folder, &shape.file), &text, &[]);
        shape.file.fault(located.to_string())
    };
    let root = Node::parse(&text).map_err(inside)?;
    let table = ExplicitShape::read(&root, &Cx::root()).map_err(inside)?;
    let (mut nodes, tets) = explicit(&table.nodes, &table.tets).map_err(inside)?;
    nodes.iter_mut().for_each(|x| *x *= shape.scale);
    Ok((nodes, tets))
}

/// Only until these are wired.
pub fn car(_: &CarShape, at: &At<crate::format::Shape>) -> Result<Solid, Fault> {
    Err(at.fault("not yet"))
}
pub fn rigid_mesh(mesh: &MeshShape, _: &Path) -> Result<Solid, Fault> {
    Err(mesh.file.fault("not yet"))
}
pub fn soft_mesh(mesh: &MeshSoftShape, _: &Path) -> Result<Rest, Fault> {
    Err(mesh.file.fault("not yet"))
}
pub fn bread(_: &BreadShape, at: &At<crate::format::SoftShape>) -> Result<Rest, Fault> {
    Err(at.fault("not yet"))
}
pub fn hand(hand: &Hand, _: &Path) -> Result<HandModel, Fault> {
    Err(hand.name.fault("not yet"))
}
