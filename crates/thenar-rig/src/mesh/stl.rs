//! STL, binary and ASCII.

use super::load::place;
use super::weld;
use crate::{RigError, TriMesh};
use thenar_core::Vec3;
use thenar_input::quoted;

const HEADER_BYTES: usize = 84;
const TRIANGLE_BYTES: usize = 50;

/// Reads the triangles of an STL file; equal positions become one vertex, and triangles without
/// extent are dropped. The stored normals are not read: the order of corners tells the outside.
pub fn read_stl(bytes: &[u8]) -> Result<TriMesh, RigError> {
    let soup = if is_binary(bytes) { read_binary(bytes)? } else { read_ascii(bytes)? };
    soup.check()?;
    let mesh = weld(&soup, 0.0).mesh;
    mesh.check()?;
    Ok(mesh)
}

fn declared_triangles(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..84)?;
    Some(u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize)
}

/// Binary files may begin with "solid" too: then the size decides.
fn is_binary(bytes: &[u8]) -> bool {
    let size = declared_triangles(bytes).map(|n| HEADER_BYTES + n * TRIANGLE_BYTES);
    let first = bytes.trim_ascii_start().get(..5);
    size == Some(bytes.len()) || !first.is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

fn read_binary(bytes: &[u8]) -> Result<TriMesh, RigError> {
    let count = declared_triangles(bytes).ok_or_else(|| {
        RigError::byte(
            bytes.len(),
            format!("the STL header needs {HEADER_BYTES} bytes, but the file has {}", bytes.len()),
        )
    })?;
    let needed = HEADER_BYTES + count * TRIANGLE_BYTES;
    if bytes.len() < needed {
        return Err(RigError::byte(
            80,
            format!("{count} triangles need {needed} bytes, but the file has {}", bytes.len()),
        ));
    }
    let mut mesh = TriMesh::default();
    for t in 0..count {
        let start = HEADER_BYTES + t * TRIANGLE_BYTES + 12;
        for k in 0..3 {
            let at = start + 12 * k;
            let number = |i: usize| {
                let b = &bytes[at + 4 * i..at + 4 * i + 4];
                f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            };
            let p = Vec3::new(number(0), number(1), number(2));
            if !p.iter().all(|x| x.is_finite()) {
                return Err(RigError::byte(
                    at,
                    format!("corner {k} of triangle {t} is not finite"),
                ));
            }
            mesh.positions.push(p);
        }
        mesh.triangles.push([0, 1, 2].map(|k| (3 * t + k) as u32));
    }
    Ok(mesh)
}

fn read_ascii(bytes: &[u8]) -> Result<TriMesh, RigError> {
    let mut mesh = TriMesh::default();
    let mut corners = 0;
    let (mut in_facet, mut ended) = (false, false);
    let mut number = 0;
    for line in bytes.split(|&b| b == b'\n') {
        number += 1;
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_ascii_whitespace();
        let Some(keyword) = words.next() else { continue };
        match keyword.to_ascii_lowercase().as_str() {
            "facet" if !in_facet => (in_facet, corners) = (true, 0),
            "vertex" if in_facet && corners < 3 => {
                mesh.positions.push(place(&mut words, number)?);
                corners += 1;
            }
            "endfacet" if in_facet && corners == 3 => {
                let first = mesh.positions.len() as u32 - 3;
                mesh.triangles.push([first, first + 1, first + 2]);
                in_facet = false;
            }
            "endfacet" if in_facet => {
                return Err(RigError::line(number, format!("a facet with {corners} vertices")));
            }
            "solid" if !in_facet => {}
            "outer" | "endloop" if in_facet => {}
            "endsolid" if !in_facet => ended = true,
            other => {
                return Err(RigError::line(
                    number,
                    format!("{} is out of place in STL", quoted(other)),
                ));
            }
        }
    }
    if in_facet || !ended {
        return Err(RigError::line(number, "the STL data ends before \"endsolid\""));
    }
    Ok(mesh)
}

/// Writes binary STL.
pub fn write_stl(mesh: &TriMesh) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for t in 0..mesh.triangles.len() {
        let normal = mesh.area_vector(t).try_normalize(0.0).unwrap_or_default();
        for p in std::iter::once(normal).chain(mesh.corners(t)) {
            p.iter().for_each(|&x| bytes.extend((x as f32).to_le_bytes()));
        }
        bytes.extend([0, 0]);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Topology, shapes};

    #[test]
    fn binary_goes_round() {
        let ball = shapes::sphere(0.5, 4);
        let mut bytes = write_stl(&ball);
        bytes[..5].copy_from_slice(b"solid");
        let read = read_stl(&bytes).unwrap();
        assert_eq!(read.triangles.len(), ball.triangles.len());
        assert_eq!(read.positions.len(), ball.positions.len());
        assert!(Topology::of(&read).closed());
        assert!((read.volume() / ball.volume() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn ascii_is_read() {
        let facet = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1e0 0\n endloop\nendfacet\n";
        let text = format!("solid a thing\n{facet}endsolid a thing\n");
        // Programs for CAD write it in capitals too.
        for text in [text.to_uppercase(), text] {
            let mesh = read_stl(text.as_bytes()).unwrap();
            assert_eq!((mesh.positions.len(), mesh.triangles.len()), (3, 1));
        }
    }

    #[test]
    fn errors_name_place_and_cause() {
        let error = |bytes: &[u8]| read_stl(bytes).unwrap_err().to_string();
        assert!(error(b"xyz").contains("the STL header needs 84 bytes, but the file has 3"));
        let mut bytes = write_stl(&shapes::cuboid(&Vec3::repeat(1.0)));
        bytes.pop();
        assert!(error(&bytes).contains("12 triangles need 684 bytes, but the file has 683"));
        bytes.push(0);
        bytes[84 + 50 + 12..84 + 50 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        assert_eq!(error(&bytes), "byte 146: corner 0 of triangle 1 is not finite");
        bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(error(&bytes).contains("4294967295 triangles need"));
        assert!(error(b"solid\nfacet normal 0 0 1\n").contains("ends before"));
        assert_eq!(error(b"solid\nvertex 1 2 3\n"), "line 2: \"vertex\" is out of place in STL");
        assert_eq!(error(b"solid\nfacet\nvertex 1 2\n"), "line 3: \"\" is not a finite number");
        assert!(error(b"solid\nendsolid\n").contains("no triangles"));
    }
}
