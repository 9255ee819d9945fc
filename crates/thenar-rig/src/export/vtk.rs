//! VTK XML files: `.vtu` for tetrahedra, `.vtp` for surfaces and lines.
//!
//! Arrays are binary (base64, little endian, 64-bit lengths, not compressed).

use crate::RigError;
use data_encoding::BASE64;
use std::fmt::Write;
use thenar_core::Vec3;
use thenar_core::model::Flesh;

/// The numbers of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Real numbers.
    Real(Vec<f64>),
    /// Whole numbers.
    Whole(Vec<i32>),
}

/// A named array over points or cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name, with its unit where it has one, as ParaView shows it.
    pub name: String,
    /// Numbers per point or cell.
    pub components: usize,
    /// `components` numbers for each.
    pub values: Values,
}

impl Field {
    /// One real number each.
    pub fn scalar(name: impl Into<String>, values: Vec<f64>) -> Self {
        Self { name: name.into(), components: 1, values: Values::Real(values) }
    }

    /// One whole number each.
    pub fn whole(name: impl Into<String>, values: Vec<i32>) -> Self {
        Self { name: name.into(), components: 1, values: Values::Whole(values) }
    }

    /// One vector each.
    pub fn vector(name: impl Into<String>, values: &[Vec3]) -> Self {
        let flat = values.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
        Self { name: name.into(), components: 3, values: Values::Real(flat) }
    }

    fn len(&self) -> usize {
        match &self.values {
            Values::Real(v) => v.len(),
            Values::Whole(v) => v.len(),
        }
    }
}

/// Young's modulus, Poisson's ratio, density and law of each tetrahedron.
pub fn flesh_cell_fields(flesh: &Flesh) -> Vec<Field> {
    let real = |name: &str, f: fn(&thenar_core::model::Material) -> f64| {
        Field::scalar(name, flesh.materials.iter().map(f).collect())
    };
    vec![
        real("young [Pa]", |m| m.young),
        real("poisson", |m| m.poisson),
        real("density [kg/m3]", |m| m.density),
        Field::whole("law", flesh.materials.iter().map(|m| m.law.number()).collect()),
    ]
}

/// A `.vtu` file of tetrahedra.
///
/// # Errors
/// When an index or the length of a field does not fit.
pub fn tetrahedra(
    points: &[Vec3],
    tets: &[[u32; 4]],
    point_fields: &[Field],
    cell_fields: &[Field],
) -> Result<String, RigError> {
    check(points, tets.iter().flatten(), tets.len(), point_fields, cell_fields)?;
    let mut xml = Xml::open("UnstructuredGrid");
    let (p, c) = (points.len(), tets.len());
    xml.line(&format!("<Piece NumberOfPoints=\"{p}\" NumberOfCells=\"{c}\">"));
    xml.data(points, point_fields, cell_fields);
    xml.line("<Cells>");
    xml.connectivity(tets);
    // 10 is VTK's number for a tetrahedron.
    xml.array("UInt8", "types", 1, &vec![10; c]);
    xml.line("</Cells>");
    Ok(xml.close("UnstructuredGrid"))
}

/// A `.vtp` file of triangles.
///
/// # Errors
/// As [`tetrahedra`].
pub fn surface(
    points: &[Vec3],
    triangles: &[[u32; 3]],
    point_fields: &[Field],
    cell_fields: &[Field],
) -> Result<String, RigError> {
    polygons("Polys", points, triangles, point_fields, cell_fields)
}

/// A `.vtp` file of line segments.
///
/// # Errors
/// As [`tetrahedra`].
pub fn lines(
    points: &[Vec3],
    segments: &[[u32; 2]],
    point_fields: &[Field],
    cell_fields: &[Field],
) -> Result<String, RigError> {
    polygons("Lines", points, segments, point_fields, cell_fields)
}

fn polygons<const N: usize>(
    kind: &str,
    points: &[Vec3],
    cells: &[[u32; N]],
    point_fields: &[Field],
    cell_fields: &[Field],
) -> Result<String, RigError> {
    check(points, cells.iter().flatten(), cells.len(), point_fields, cell_fields)?;
    let mut xml = Xml::open("PolyData");
    let (p, c) = (points.len(), cells.len());
    xml.line(&format!("<Piece NumberOfPoints=\"{p}\" NumberOf{kind}=\"{c}\">"));
    xml.data(points, point_fields, cell_fields);
    xml.line(&format!("<{kind}>"));
    xml.connectivity(cells);
    xml.line(&format!("</{kind}>"));
    Ok(xml.close("PolyData"))
}

fn check<'a>(
    points: &[Vec3],
    mut indices: impl Iterator<Item = &'a u32>,
    cells: usize,
    point_fields: &[Field],
    cell_fields: &[Field],
) -> Result<(), RigError> {
    if let Some(i) = indices.find(|&&i| i as usize >= points.len()) {
        let what = format!("a cell names point {i}, but there are {} points", points.len());
        return Err(RigError::invalid(what));
    }
    let of_points = point_fields.iter().map(|f| (f, points.len()));
    for (field, count) in of_points.chain(cell_fields.iter().map(|f| (f, cells))) {
        if field.len() != count * field.components {
            return Err(RigError::invalid(format!(
                "field \"{}\" has {} numbers, but {count} times {} are needed",
                field.name,
                field.len(),
                field.components
            )));
        }
    }
    Ok(())
}

/// A VTK XML file in the making.
struct Xml(String);

impl Xml {
    fn open(kind: &str) -> Self {
        let mut xml = Self(String::from("<?xml version=\"1.0\"?>\n"));
        xml.line(&format!(
            "<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">"
        ));
        xml.line(&format!("<{kind}>"));
        xml
    }

    fn close(mut self, kind: &str) -> String {
        self.line("</Piece>");
        self.line(&format!("</{kind}>"));
        self.line("</VTKFile>");
        self.0
    }

    fn line(&mut self, text: &str) {
        self.0.push_str(text);
        self.0.push('\n');
    }

    fn data(&mut self, points: &[Vec3], point_fields: &[Field], cell_fields: &[Field]) {
        self.line("<Points>");
        self.field(&Field::vector("Points", points));
        self.line("</Points>");
        self.line("<PointData>");
        point_fields.iter().for_each(|f| self.field(f));
        self.line("</PointData>");
        self.line("<CellData>");
        cell_fields.iter().for_each(|f| self.field(f));
        self.line("</CellData>");
    }

    fn field(&mut self, field: &Field) {
        match &field.values {
            Values::Real(v) => {
                let bytes: Vec<u8> = v.iter().flat_map(|x| x.to_le_bytes()).collect();
                self.array("Float64", &field.name, field.components, &bytes);
            }
            Values::Whole(v) => {
                let bytes: Vec<u8> = v.iter().flat_map(|x| x.to_le_bytes()).collect();
                self.array("Int32", &field.name, field.components, &bytes);
            }
        }
    }

    fn connectivity<const N: usize>(&mut self, cells: &[[u32; N]]) {
        let bytes = |numbers: &mut dyn Iterator<Item = i64>| -> Vec<u8> {
            numbers.flat_map(i64::to_le_bytes).collect()
        };
        let connectivity = bytes(&mut cells.iter().flatten().map(|&i| i64::from(i)));
        self.array("Int64", "connectivity", 1, &connectivity);
        let offsets = bytes(&mut (1..=cells.len()).map(|k| (k * N) as i64));
        self.array("Int64", "offsets", 1, &offsets);
    }

    fn array(&mut self, kind: &str, name: &str, components: usize, bytes: &[u8]) {
        let name = name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        // Writing to a string cannot fail.
        let _ = write!(
            self.0,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
             format=\"binary\">"
        );
        let mut block = (bytes.len() as u64).to_le_bytes().to_vec();
        block.extend_from_slice(bytes);
        BASE64.encode_append(&block, &mut self.0);
        self.line("</DataArray>");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> (Vec<Vec3>, Vec<[u32; 4]>) {
        (vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()], vec![[0, 1, 2, 3]])
    }

    #[test]
    fn a_tetrahedron_is_written_as_the_format_says() {
        let (points, tets) = corner();
        let weight = Field::scalar("weight", vec![0.0, 1.0, 2.0, 3.0]);
        let text = tetrahedra(&points, &tets, &[weight], &[]).expect("written");
        assert!(text.contains("<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">"));
        // Eight bytes of length, then the one byte 10: AQ..., computed by hand.
        assert!(text.contains(">AQAAAAAAAAAK</DataArray>"), "{text}");
        // Four doubles 0, 1, 2, 3 after the length 32 (Python: base64 of struct "<Q4d").
        assert!(
            text.contains(">IAAAAAAAAAAAAAAAAAAAAAAAAAAAAPA/AAAAAAAAAEAAAAAAAAAIQA==</DataArray>")
        );
    }

    #[test]
    fn what_does_not_fit_is_refused_by_name() {
        let (points, tets) = corner();
        let error = tetrahedra(&points, &[[0, 1, 2, 7]], &[], &[]).expect_err("point 7");
        assert!(error.to_string().contains("point 7"), "{error}");
        let short = [Field::scalar("weight", vec![0.0; 3])];
        let error = tetrahedra(&points, &tets, &short, &[]).expect_err("three numbers");
        assert!(error.to_string().contains("\"weight\" has 3"), "{error}");
    }
}
