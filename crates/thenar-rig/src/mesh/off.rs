//! OFF (Object File Format): vertices, then polygons; colours and normals are passed over.

use super::load::place;
use super::polygon::{check_corners, cut};
use crate::{RigError, TriMesh};
use std::str::SplitAsciiWhitespace;
use thenar_input::quoted;

/// Reads the triangles of an ASCII OFF file, also of its forms with colours or normals (`COFF`,
/// `NOFF`, `CNOFF`). Polygons are cut. Positions keep the file's unit and axes.
///
/// # Errors
/// Names the line and the cause.
pub fn read_off(bytes: &[u8]) -> Result<TriMesh, RigError> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = (1..)
        .zip(text.lines())
        .map(|(number, line)| (number, line.split('#').next().unwrap_or_default()))
        .filter(|(_, line)| !line.trim().is_empty());
    let (mut number, first) =
        lines.next().ok_or_else(|| RigError::line(1, "the OFF data is empty"))?;
    let mut words = first.split_ascii_whitespace();
    let keyword = words.next().unwrap_or_default();
    if !["OFF", "COFF", "NOFF", "CNOFF"].contains(&keyword) {
        let what = format!("{} is no kind of OFF that can be read", quoted(keyword));
        return Err(RigError::line(number, what));
    }
    // Counts may stand beside the keyword.
    if words.clone().next().is_none() {
        let ended = RigError::line(number, "the OFF data ends before its counts");
        let (at, line) = lines.next().ok_or(ended)?;
        (number, words) = (at, line.split_ascii_whitespace());
    }
    if words.clone().next().is_some_and(|word| word.eq_ignore_ascii_case("binary")) {
        return Err(RigError::line(number, "binary OFF is not read: write it as text, or as PLY"));
    }
    let [vertices, faces] = [whole(&mut words, number)?, whole(&mut words, number)?];

    let mut mesh = TriMesh::default();
    let mut last = number;
    for k in 0..vertices {
        let (number, line) = lines.next().ok_or_else(|| {
            RigError::line(last, format!("the data ends after {k} of {vertices} vertices"))
        })?;
        last = number;
        mesh.positions.push(place(&mut line.split_ascii_whitespace(), number)?);
    }
    let mut corners = Vec::new();
    for k in 0..faces {
        let (number, line) = lines.next().ok_or_else(|| {
            RigError::line(last, format!("the data ends after {k} of {faces} faces"))
        })?;
        last = number;
        let mut words = line.split_ascii_whitespace();
        let count = whole(&mut words, number)?;
        corners.clear();
        check_corners(count)?;
        for _ in 0..count {
            let v = whole(&mut words, number)?;
            if v >= vertices {
                let what = format!("vertex {v} does not exist ({vertices} are given, from 0)");
                return Err(RigError::line(number, what));
            }
            corners.push(v as u32);
        }
        // Points and lines are no surface.
        cut(&corners, &mut mesh.triangles);
        mesh.check_count()?;
    }
    if mesh.triangles.is_empty() {
        return Err(RigError::invalid("no face in the OFF data"));
    }
    mesh.check()?;
    Ok(mesh)
}

/// The next word as a count or an index.
fn whole(words: &mut SplitAsciiWhitespace<'_>, line: usize) -> Result<usize, RigError> {
    let word = words.next().unwrap_or_default();
    let number = word.parse().ok().filter(|n| *n <= u32::MAX as usize);
    number
        .ok_or_else(|| RigError::line(line, format!("{} is not a count or an index", quoted(word))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::Vec3;

    #[test]
    fn polygons_colours_comments_and_counts_beside_the_word_are_read() {
        let text = "COFF 4 3 0 # counts\n\n0 0 0 255 0 0 255\n1 0 0 0 0 0 1\n# between\n1 1 0\n0 1 0\r\n\
                    4 0 1 2 3 0.5 0.5 0.5\n3 0 1 2\n2 0 1\n";
        let mesh = read_off(text.as_bytes()).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        assert_eq!(mesh.positions[2], Vec3::new(1.0, 1.0, 0.0));
    }

    #[test]
    fn errors_name_line_and_cause() {
        let error = |text: &str| read_off(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(error(""), "line 1: the OFF data is empty");
        assert_eq!(error("4OFF\n"), "line 1: \"4OFF\" is no kind of OFF that can be read");
        assert_eq!(error("OFF\n"), "line 1: the OFF data ends before its counts");
        assert!(error("OFF BINARY\n").contains("binary OFF is not read"));
        assert_eq!(error("OFF\n1 x 0\n"), "line 2: \"x\" is not a count or an index");
        assert_eq!(error("OFF\n-1 0 0\n"), "line 2: \"-1\" is not a count or an index");
        assert_eq!(error("OFF\n2 1 0\n0 0 0\n"), "line 3: the data ends after 1 of 2 vertices");
        assert_eq!(error("OFF\n1 1 0\n0 nan 0\n"), "line 3: \"nan\" is not a finite number");
        let cut = error("OFF\n1 1 0\n0 0 0\n3 0 1 2\n");
        assert_eq!(cut, "line 4: vertex 1 does not exist (1 are given, from 0)");
        assert_eq!(error("OFF\n1 1 0\n0 0 0\n"), "line 3: the data ends after 0 of 1 faces");
        assert_eq!(error("OFF\n1 1 0\n0 0 0\n1 0\n"), "no face in the OFF data");
        let huge = error("OFF\n1 1 0\n0 0 0\n1000001 0 0 0\n");
        assert!(huge.contains("1000001 corners"), "{huge}");
        // A count as large as numbers go asks for no memory.
        assert!(error("OFF\n4294967295 4294967295 0\n").contains("after 0 of 4294967295"));
    }
}
