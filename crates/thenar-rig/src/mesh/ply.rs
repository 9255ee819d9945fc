//! PLY (Stanford polygon format), ASCII and binary: positions and polygons; all else is passed
//! over.

use super::polygon::{check_corners, cut};
use crate::{RigError, TriMesh};
use thenar_core::Vec3;
use thenar_input::quoted;

/// Reads the triangles of a PLY file of any of its three encodings. Polygons are cut; triangle
/// strips are refused. Positions keep the file's unit and axes.
///
/// # Errors
/// Names the line of the header or of ASCII data, or the byte of binary data, and the cause.
pub fn read_ply(bytes: &[u8]) -> Result<TriMesh, RigError> {
    let header = Header::read(bytes)?;
    let mut data =
        Data { bytes, at: header.end, line: header.lines + 1, encoding: header.encoding };
    let mut mesh = TriMesh::default();
    let mut vertices = None;
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => {
                read_vertices(element, &mut data, &mut mesh)?;
                vertices = Some(mesh.positions.len());
            }
            "face" => read_faces(element, &mut data, &mut mesh)?,
            "tristrips" if element.count > 0 => {
                return Err(RigError::invalid("PLY of triangle strips is not read: write faces"));
            }
            _ => pass_over(element, &mut data)?,
        }
    }
    let count =
        vertices.ok_or_else(|| RigError::invalid("the PLY data has no element \"vertex\""))?;
    if mesh.triangles.is_empty() {
        let what =
            format!("the PLY data has no faces, only {count} points: make a surface of them first");
        return Err(RigError::invalid(what));
    }
    mesh.check()?;
    Ok(mesh)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

/// A kind of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn named(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number that begins `b`, lowest byte first.
    fn number(self, b: [u8; 8]) -> f64 {
        let [b0, b1, b2, b3, ..] = b;
        match self {
            Self::I8 => f64::from(b0 as i8),
            Self::U8 => f64::from(b0),
            Self::I16 => f64::from(i16::from_le_bytes([b0, b1])),
            Self::U16 => f64::from(u16::from_le_bytes([b0, b1])),
            Self::I32 => f64::from(i32::from_le_bytes([b0, b1, b2, b3])),
            Self::U32 => f64::from(u32::from_le_bytes([b0, b1, b2, b3])),
            Self::F32 => f64::from(f32::from_le_bytes([b0, b1, b2, b3])),
            Self::F64 => f64::from_le_bytes(b),
        }
    }
}

#[derive(Debug)]
struct Property {
    name: String,
    /// Kind of a list's length.
    length: Option<Kind>,
    kind: Kind,
}

#[derive(Debug)]
struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    /// First byte behind it.
    end: usize,
    lines: usize,
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Self, RigError> {
        let mut header = Self { encoding: Encoding::Ascii, elements: Vec::new(), end: 0, lines: 0 };
        let mut encoding = None;
        loop {
            let rest = &bytes[header.end..];
            let Some(length) = rest.iter().position(|&b| b == b'\n') else {
                return Err(RigError::line(
                    header.lines + 1,
                    "the PLY header ends before \"end_header\"",
                ));
            };
            header.lines += 1;
            header.end += length + 1;
            let line = String::from_utf8_lossy(&rest[..length]);
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let wrong = |what: String| RigError::line(header.lines, what);
            match words[..] {
                ["ply"] if header.lines == 1 => {}
                _ if header.lines == 1 => {
                    return Err(wrong("not a PLY file: it does not begin with \"ply\"".into()));
                }
                [] | ["comment" | "obj_info", ..] => {}
                ["format", word, ..] => {
                    encoding = Some(match word {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::Little,
                        "binary_big_endian" => Encoding::Big,
                        other => {
                            return Err(wrong(format!("{} is no encoding of PLY", quoted(other))));
                        }
                    });
                }
                ["element", name, count] => {
                    let count = count
                        .parse()
                        .map_err(|_| wrong(format!("{} is not a count", quoted(count))))?;
                    header.elements.push(Element {
                        name: name.into(),
                        count,
                        properties: Vec::new(),
                    });
                }
                ["property", ref property @ ..] => {
                    let property = property_of(property)
                        .ok_or_else(|| wrong("this is no property of PLY".into()))?;
                    let element = header.elements.last_mut();
                    let element =
                        element.ok_or_else(|| wrong("a property before all elements".into()))?;
                    element.properties.push(property);
                }
                ["end_header"] => break,
                [other, ..] => {
                    return Err(wrong(format!(
                        "{} is out of place in a PLY header",
                        quoted(other)
                    )));
                }
            }
        }
        header.encoding = encoding
            .ok_or_else(|| RigError::line(header.lines, "the PLY header has no \"format\""))?;
        Ok(header)
    }
}

fn property_of(words: &[&str]) -> Option<Property> {
    match *words {
        ["list", length, kind, name] => {
            let length =
                Kind::named(length).filter(|kind| !matches!(kind, Kind::F32 | Kind::F64))?;
            Some(Property { name: name.into(), length: Some(length), kind: Kind::named(kind)? })
        }
        [kind, name] => {
            Some(Property { name: name.into(), length: None, kind: Kind::named(kind)? })
        }
        _ => None,
    }
}

/// Data after the header, read from its beginning.
struct Data<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    encoding: Encoding,
}

impl Data<'_> {
    fn wrong(&self, what: String) -> RigError {
        match self.encoding {
            Encoding::Ascii => RigError::line(self.line, what),
            _ => RigError::byte(self.at, what),
        }
    }

    fn number(&mut self, kind: Kind, of: &Element) -> Result<f64, RigError> {
        match self.encoding {
            Encoding::Ascii => self.word(of),
            _ => self.binary(kind, of),
        }
    }

    fn word(&mut self, of: &Element) -> Result<f64, RigError> {
        while let Some(b) = self.bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            self.line += usize::from(*b == b'\n');
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if length == 0 {
            return Err(self.wrong(ended(of)));
        }
        let word = String::from_utf8_lossy(&rest[..length]);
        let number =
            word.parse().map_err(|_| self.wrong(format!("{} is not a number", quoted(&word))))?;
        self.at += length;
        Ok(number)
    }

    fn binary(&mut self, kind: Kind, of: &Element) -> Result<f64, RigError> {
        let Some(found) = self.bytes.get(self.at..self.at + kind.bytes()) else {
            return Err(self.wrong(ended(of)));
        };
        let mut b = [0; 8];
        b[..found.len()].copy_from_slice(found);
        if self.encoding == Encoding::Big {
            b[..found.len()].reverse();
        }
        self.at += kind.bytes();
        Ok(kind.number(b))
    }

    /// A number that counts or names something.
    fn whole(&mut self, kind: Kind, of: &Element) -> Result<usize, RigError> {
        let number = self.number(kind, of)?;
        if number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number) {
            return Ok(number as usize);
        }
        Err(self.wrong(format!("{number} is no count and no index")))
    }

    fn pass(&mut self, property: &Property, of: &Element) -> Result<(), RigError> {
        let count = match property.length {
            Some(length) => self.whole(length, of)?,
            None => 1,
        };
        (0..count).try_for_each(|_| self.number(property.kind, of).map(|_| ()))
    }
}

fn ended(of: &Element) -> String {
    format!("the PLY data ends within its {} elements {}", of.count, quoted(&of.name))
}

fn read_vertices(element: &Element, data: &mut Data, mesh: &mut TriMesh) -> Result<(), RigError> {
    let axis = |name: &str| ["x", "y", "z"].iter().position(|axis| *axis == name);
    let scalar = |p: &&Property| p.length.is_none() && axis(&p.name).is_some();
    if element.properties.iter().filter(scalar).count() != 3 {
        return Err(RigError::invalid("the vertices of the PLY data have no x, y and z"));
    }
    for k in 0..element.count {
        let mut p = Vec3::zeros();
        for property in &element.properties {
            match axis(&property.name).filter(|_| property.length.is_none()) {
                Some(axis) => p[axis] = data.number(property.kind, element)?,
                None => data.pass(property, element)?,
            }
        }
        if !p.iter().all(|x| x.is_finite()) {
            return Err(data.wrong(format!("vertex {k} is not finite")));
        }
        mesh.positions.push(p);
        mesh.check_count()?;
    }
    Ok(())
}

fn read_faces(element: &Element, data: &mut Data, mesh: &mut TriMesh) -> Result<(), RigError> {
    let is_corners = |p: &Property| ["vertex_indices", "vertex_index"].contains(&p.name.as_str());
    if element.count > 0 && !element.properties.iter().any(|p| is_corners(p) && p.length.is_some())
    {
        return Err(RigError::invalid("the faces of the PLY data have no list \"vertex_indices\""));
    }
    let vertices = mesh.positions.len();
    let mut corners = Vec::new();
    for _ in 0..element.count {
        for property in &element.properties {
            let Some(length) = property.length.filter(|_| is_corners(property)) else {
                data.pass(property, element)?;
                continue;
            };
            corners.clear();
            let count = data.whole(length, element)?;
            check_corners(count)?;
            for _ in 0..count {
                let v = data.whole(property.kind, element)?;
                if v >= vertices {
                    let what =
                        format!("vertex {v} does not exist ({vertices} are given before, from 0)");
                    return Err(data.wrong(what));
                }
                corners.push(v as u32);
            }
            cut(&corners, &mut mesh.triangles);
            mesh.check_count()?;
        }
    }
    Ok(())
}

fn pass_over(element: &Element, data: &mut Data) -> Result<(), RigError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    let mut of_element =
        || element.properties.iter().try_for_each(|property| data.pass(property, element));
    (0..element.count).try_for_each(|_| of_element())
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "ply\nformat ENCODING 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\n\
                          property float y\nproperty double z\nproperty uchar red\nelement face 2\n\
                          property list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n";
    const PLACES: [[f64; 3]; 4] =
        [[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.5]];
    const FACES: [&[u32]; 2] = [&[0, 1, 2, 3], &[0, 1, 2]];

    fn ascii() -> Vec<u8> {
        let mut text = HEADER.replace("ENCODING", "ascii");
        PLACES.iter().for_each(|[x, y, z]| text += &format!("{x} {y} {z} 255\n"));
        text += "4 0 1 2 3 2 0.1 0.2\r\n3 0 1 2 0\n";
        text.into_bytes()
    }

    fn binary(big: bool) -> Vec<u8> {
        let encoding = if big { "binary_big_endian" } else { "binary_little_endian" };
        let mut bytes = HEADER.replace("ENCODING", encoding).into_bytes();
        let mut put = |le: &[u8]| match big {
            true => bytes.extend(le.iter().rev()),
            false => bytes.extend(le),
        };
        for [x, y, z] in PLACES {
            put(&(x as f32).to_le_bytes());
            put(&(y as f32).to_le_bytes());
            put(&z.to_le_bytes());
            put(&[255]);
        }
        for face in FACES {
            put(&[face.len() as u8]);
            face.iter().for_each(|v| put(&v.to_le_bytes()));
            put(&[1]);
            put(&0.25_f32.to_le_bytes());
        }
        bytes
    }

    #[test]
    fn all_encodings_give_the_same_mesh() {
        for bytes in [ascii(), binary(false), binary(true)] {
            let mesh = read_ply(&bytes).unwrap();
            assert_eq!(mesh.positions, PLACES.map(Vec3::from));
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        }
    }

    #[test]
    fn a_file_that_ends_anywhere_is_refused() {
        for bytes in [binary(false), binary(true)] {
            for end in 0..bytes.len() {
                assert!(read_ply(&bytes[..end]).is_err(), "{end}");
            }
        }
    }

    #[test]
    fn errors_name_place_and_cause() {
        let error = |text: &str| read_ply(text.as_bytes()).unwrap_err().to_string();
        let vertices = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
        let faces = "element face 1\nproperty list uchar int vertex_index\n";
        let file =
            |data: &str| format!("ply\nformat ascii 1.0\n{vertices}{faces}end_header\n{data}");
        assert_eq!(error("plx\n"), "line 1: not a PLY file: it does not begin with \"ply\"");
        assert!(error("ply").contains("ends before"), "{}", error("ply"));
        assert_eq!(error("ply\nformat latin 1.0\n"), "line 2: \"latin\" is no encoding of PLY");
        assert_eq!(error("ply\nelement vertex x\n"), "line 2: \"x\" is not a count");
        assert_eq!(error("ply\nproperty float x\n"), "line 2: a property before all elements");
        assert!(error("ply\nelement a 1\nproperty list float int b\n").contains("no property"));
        assert!(error("ply\nend_header\n").contains("no \"format\""));
        assert_eq!(
            error("ply\nformat ascii 1.0\nend_header\n"),
            "the PLY data has no element \"vertex\""
        );
        assert_eq!(error(&file("0 0 nan\n3 0 0 0\n")), "line 10: vertex 0 is not finite");
        assert_eq!(error(&file("0 0 z\n")), "line 10: \"z\" is not a number");
        assert_eq!(
            error(&file("0 0 0\n3 0 1 0\n")),
            "line 11: vertex 1 does not exist (1 are given before, from 0)"
        );
        assert!(error(&file("0 0 0\n3 0 -1 0\n")).contains("-1 is no count and no index"));
        assert!(error(&file("0 0 0\n3 0\n")).contains("ends within its 1 elements \"face\""));
        let huge = error(&file("0 0 0\n1000001 0 0 0\n").replace("uchar int", "uint int"));
        assert!(huge.contains("1000001 corners"), "{huge}");
        let points = format!("ply\nformat ascii 1.0\n{vertices}end_header\n0 0 0\n");
        assert!(error(&points).contains("only 1 points"), "{}", error(&points));
        // An element of no properties has no data, however many there are said to be.
        let many = format!(
            "ply\nformat ascii 1.0\nelement tag 99999999999\n{vertices}{faces}end_header\n0 0 0\n3 0 0 0\n"
        );
        assert!(read_ply(many.as_bytes()).is_ok());
    }
}
