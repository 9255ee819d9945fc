//! Wavefront OBJ: vertices and faces; everything else is passed over.

use super::load::coordinate;
use super::polygon::{check_corners, cut};
use crate::{RigError, TriMesh};
use thenar_core::Vec3;
use thenar_input::quoted;

/// Reads the triangles of an OBJ file. Polygons are cut into fans, those of
/// more than eight corners by chords. Positions keep the file's
/// unit and axes. Memory stays below about ten times the size of the input.
pub fn read_obj(bytes: &[u8]) -> Result<TriMesh, RigError> {
    let mut mesh = TriMesh::default();
    for (index, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let number = index + 1;
        // Comments may be in any encoding; numbers and keywords are ASCII.
        let text = String::from_utf8_lossy(line);
        let text = text.split('#').next().unwrap_or_default();
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("v") => mesh.positions.push(vertex(words, number)?),
            Some("f") => {
                face(words, number, &mut mesh)?;
                mesh.check_count()?;
            }
            _ => {}
        }
    }
    if mesh.triangles.is_empty() {
        return Err(RigError::invalid("no face (\"f\") in the OBJ data"));
    }
    mesh.check()?;
    Ok(mesh)
}

fn vertex<'a>(mut words: impl Iterator<Item = &'a str>, line: usize) -> Result<Vec3, RigError> {
    let mut p = Vec3::zeros();
    for k in 0..3 {
        let word = words.next().ok_or_else(|| {
            RigError::line(line, format!("a vertex needs three coordinates, not {k}"))
        })?;
        p[k] = coordinate(word, line)?;
    }
    Ok(p)
}

fn face<'a>(
    words: impl Iterator<Item = &'a str>,
    line: usize,
    mesh: &mut TriMesh,
) -> Result<(), RigError> {
    let count = mesh.positions.len();
    let mut corners = Vec::new();
    for word in words {
        corners.push(corner(word, line, count)?);
        check_corners(corners.len())?;
    }
    if cut(&corners, &mut mesh.triangles) {
        return Ok(());
    }
    Err(RigError::line(line, format!("a face needs three corners, not {}", corners.len())))
}

/// The vertex index of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`: from 1, or from -1 backwards.
fn corner(word: &str, line: usize, count: usize) -> Result<u32, RigError> {
    let text = word.split('/').next().unwrap_or_default();
    let index: i64 = text
        .parse()
        .map_err(|_| RigError::line(line, format!("{} is not a vertex index", quoted(text))))?;
    let from_zero = if index < 0 { index + count as i64 } else { index - 1 };
    match u32::try_from(from_zero) {
        Ok(v) if (v as usize) < count => Ok(v),
        _ => Err(RigError::line(
            line,
            format!("vertex {index} does not exist ({count} are given above)"),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_corner_forms_and_polygons_are_read() {
        let text = "# a comment \u{e9}\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0\r\n\
                    v 0 1 0\nvt 0 0\nvn 0 0 1\ns off\nf 1/1/1 2//1 3/1 4\nf -4 -3 -2 # end\n";
        let mesh = read_obj(text.as_bytes()).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        assert_eq!(mesh.positions[2], Vec3::new(1.0, 1.0, 0.0));
    }

    /// The area of a regular polygon, n/2 sin(2π/n), whatever its cuts; no triangle is a sliver.
    #[test]
    fn a_polygon_of_many_corners_is_halved() {
        for n in [3, 8, 9, 10, 57, 4000] {
            let corner = |i: usize| 2.0 * std::f64::consts::PI * i as f64 / n as f64;
            let mut text = String::new();
            (0..n).for_each(|i| text += &format!("v {} {} 0\n", corner(i).cos(), corner(i).sin()));
            text += "f";
            (1..=n).for_each(|i| text += &format!(" {i}"));
            let mesh = read_obj(text.as_bytes()).unwrap();
            assert_eq!(mesh.triangles.len(), n - 2);
            let exact = n as f64 / 2.0 * corner(1).sin();
            let up: f64 = (0..n - 2).map(|t| mesh.area_vector(t).z).sum();
            assert!((mesh.area() - exact).abs() < 1e-9 && (up - exact).abs() < 1e-9, "{n}");
            let edges = crate::mesh::Topology::of(&mesh);
            assert_eq!((edges.boundary_edges, edges.components), (n, 1));
        }
    }

    #[test]
    fn errors_name_line_and_cause() {
        let error = |text: &str| read_obj(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(error("v 0 0 0\nv 1 x 0\n"), "line 2: \"x\" is not a finite number");
        assert_eq!(error("v 0 nan 0\n"), "line 1: \"nan\" is not a finite number");
        assert_eq!(error("v 0 0\n"), "line 1: a vertex needs three coordinates, not 2");
        assert_eq!(
            error("v 0 0 0\nf 1 2 3\n"),
            "line 2: vertex 2 does not exist (1 are given above)"
        );
        assert_eq!(
            error("v 0 0 0\nf 1 0 1\n"),
            "line 2: vertex 0 does not exist (1 are given above)"
        );
        assert_eq!(error("v 0 0 0\nf 1 1\n"), "line 2: a face needs three corners, not 2");
        assert_eq!(error("v 0 0 0\nf a b c\n"), "line 2: \"a\" is not a vertex index");
        assert!(error("").contains("no face"));
    }
}
