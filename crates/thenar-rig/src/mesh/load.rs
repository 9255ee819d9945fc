//! Mesh files, whatever their kind.

use super::{read_obj, read_off, read_ply, read_stl};
use crate::error::positive;
use crate::work::phase;
use crate::{RigError, TriMesh};
use std::path::Path;
use thenar_core::Vec3;
use thenar_input::quoted;

/// Larger files are refused.
const FILE_BYTES_MAX: u64 = 512 << 20;

/// Reads a GLB, OBJ, STL, PLY or OFF file (told by its first bytes, else by its extension) and
/// multiplies positions by `scale` (0.001 for a file in millimetres).
///
/// # Errors
/// [`RigError::InFile`] or [`RigError::Read`], naming the file, the place in it and the cause.
pub fn load_mesh(path: impl AsRef<Path>, scale: f64) -> Result<TriMesh, RigError> {
    let path = path.as_ref();
    positive("scale", scale)?;
    let read = || -> Result<TriMesh, RigError> {
        phase("reading the mesh")?;
        let mesh = parse(path, &read_file(path)?)?.scaled(scale);
        mesh.check()?;
        mesh.check_count()?;
        Ok(mesh)
    };
    read().map_err(|error| match error {
        RigError::Read { .. } => error,
        other => other.in_file(path.display()),
    })
}

/// The next three words of a line of text, as a place.
pub(super) fn place<'a>(
    words: &mut impl Iterator<Item = &'a str>,
    line: usize,
) -> Result<Vec3, RigError> {
    let mut p = Vec3::zeros();
    for k in 0..3 {
        p[k] = coordinate(words.next().unwrap_or_default(), line)?;
    }
    Ok(p)
}

/// A word of a line of text, as a coordinate.
pub(super) fn coordinate(word: &str, line: usize) -> Result<f64, RigError> {
    let number = word.parse().ok().filter(|x: &f64| x.is_finite());
    number.ok_or_else(|| RigError::line(line, format!("{} is not a finite number", quoted(word))))
}

/// The bytes of a mesh's file.
///
/// # Errors
/// The file cannot be read, or is larger than any mesh is.
pub fn read_file(path: &Path) -> Result<Vec<u8>, RigError> {
    let failed = |cause| RigError::Read { file: path.display().to_string(), cause };
    thenar_input::read(path, FILE_BYTES_MAX).map_err(|cause| failed(cause.into()))
}

fn parse(path: &Path, bytes: &[u8]) -> Result<TriMesh, RigError> {
    if bytes.starts_with(b"glTF") {
        return crate::glb::read_glb(bytes);
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("obj") => read_obj(bytes),
        Some("stl") => read_stl(bytes),
        Some("ply") => read_ply(bytes),
        Some("off") => read_off(bytes),
        Some("glb") => Err(RigError::byte(0, "not a GLB file: it does not begin with \"glTF\"")),
        _ => Err(RigError::invalid(
            "unknown kind of mesh file (.glb, .obj, .stl, .ply and .off are known)",
        )),
    }
}
