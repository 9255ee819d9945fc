//! Nodes, faces or elements that a selector means.

use crate::format::{Selector, SideWord};
use crate::math::Vec3;
use crate::text::{Fault, Located};
use thenar_rig::object::boundary_surface;

/// Nodes of a boundary face, counter-clockwise from outside.
pub type Face = [u32; 3];

/// A soft body at rest as a selector sees it.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Rest positions, model frame \[m\].
    pub nodes: Vec<Vec3>,
    /// Corners of each element.
    pub tets: Vec<[u32; 4]>,
    /// Boundary faces.
    pub faces: Vec<Face>,
    on_boundary: Vec<bool>,
    low: Vec3,
    high: Vec3,
}

impl Mesh {
    /// Prepares a mesh.
    pub fn new(nodes: &[Vec3], tets: &[[u32; 4]]) -> Self {
        let faces = boundary_faces(tets);
        let mut on_boundary = vec![false; nodes.len()];
        faces.iter().flatten().for_each(|n| on_boundary[*n as usize] = true);
        let infinite = Vec3::repeat(f64::INFINITY);
        let low = nodes.iter().fold(infinite, |a, b| a.inf(b));
        let high = nodes.iter().fold(-infinite, |a, b| a.sup(b));
        Self { nodes: nodes.to_vec(), tets: tets.to_vec(), faces, on_boundary, low, high }
    }

    /// Nodes that a selector means; all without one.
    ///
    /// # Errors
    /// It means none, or names an index that does not exist.
    pub fn select_nodes(&self, selector: Option<&Located<Selector>>) -> Result<Vec<u32>, Fault> {
        let Some(at) = selector else { return Ok((0..self.nodes.len() as u32).collect()) };
        self.check_indices(at, self.nodes.len(), "nodes")?;
        let place = |n: &u32| self.nodes[*n as usize];
        let mut chosen: Vec<u32> = (0..self.nodes.len() as u32)
            .filter(|n| self.covers(&at.value, &place(n)) && has_index(&at.value, *n))
            .filter(|n| at.value.boundary.is_none_or(|b| self.on_boundary[*n as usize] == b))
            .collect();
        keep_nearest(&mut chosen, &at.value, place);
        not_empty(at, chosen, "nodes")
    }

    /// Elements whose centre a selector means; all without one.
    ///
    /// # Errors
    /// It means none, or names an index that does not exist.
    pub fn select_tets(&self, selector: Option<&Located<Selector>>) -> Result<Vec<u32>, Fault> {
        let Some(at) = selector else { return Ok((0..self.tets.len() as u32).collect()) };
        self.check_indices(at, self.tets.len(), "elements")?;
        let centre = |t: &u32| {
            self.tets[*t as usize].iter().map(|n| self.nodes[*n as usize]).sum::<Vec3>() / 4.0
        };
        let on_boundary =
            |t: &u32| self.tets[*t as usize].iter().any(|n| self.on_boundary[*n as usize]);
        let mut chosen: Vec<u32> = (0..self.tets.len() as u32)
            .filter(|t| self.covers(&at.value, &centre(t)) && has_index(&at.value, *t))
            .filter(|t| at.value.boundary.is_none_or(|b| on_boundary(t) == b))
            .collect();
        keep_nearest(&mut chosen, &at.value, centre);
        not_empty(at, chosen, "elements")
    }

    /// Boundary faces all of whose nodes a selector means.
    ///
    /// # Errors
    /// It means none, or names an index that does not exist.
    pub fn select_faces(&self, at: &Located<Selector>) -> Result<Vec<Face>, Fault> {
        self.check_indices(at, self.faces.len(), "boundary faces")?;
        let inside = |f: &Face| f.iter().all(|n| self.covers(&at.value, &self.nodes[*n as usize]));
        let centre =
            |f: &(u32, Face)| f.1.iter().map(|n| self.nodes[*n as usize]).sum::<Vec3>() / 3.0;
        let mut chosen: Vec<(u32, Face)> = (0..)
            .zip(self.faces.iter().copied())
            .filter(|(i, f)| inside(f) && has_index(&at.value, *i))
            .collect();
        keep_nearest(&mut chosen, &at.value, centre);
        let faces = chosen.into_iter().map(|(_, f)| f).collect();
        not_empty(at, faces, "boundary faces")
    }

    fn covers(&self, s: &Selector, p: &Vec3) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= s.tolerance;
        let side = s.side.is_none_or(|side| match side {
            SideWord::XMin => near(p.x, self.low.x),
            SideWord::XMax => near(p.x, self.high.x),
            SideWord::YMin => near(p.y, self.low.y),
            SideWord::YMax => near(p.y, self.high.y),
            SideWord::ZMin => near(p.z, self.low.z),
            SideWord::ZMax => near(p.z, self.high.z),
        });
        let above = s.box_min.is_none_or(|m| (0..3).all(|k| p[k] >= m[k] - s.tolerance));
        let below = s.box_max.is_none_or(|m| (0..3).all(|k| p[k] <= m[k] + s.tolerance));
        let shell = s.shell.as_ref().is_none_or(|shell| {
            let r = (p - shell.centre).norm();
            r >= shell.radius_min - s.tolerance && r <= shell.radius_max + s.tolerance
        });
        side && above && below && shell
    }

    fn check_indices(&self, at: &Located<Selector>, count: usize, what: &str) -> Result<(), Fault> {
        let beyond = at.value.indices.iter().flatten().find(|i| **i as usize >= count);
        match beyond {
            None => Ok(()),
            Some(i) => Err(at.fault(format!("there is no index {i}: the body has {count} {what}"))),
        }
    }
}

/// The boundary of elements whose surface vertices are nodes.
fn boundary_faces(tets: &[[u32; 4]]) -> Vec<Face> {
    let surface = boundary_surface(tets);
    let node = |v: u32| {
        let vertex = &surface.vertices[v as usize];
        let corner = vertex.weights.iter().position(|w| *w == 1.0).unwrap_or(0);
        tets[vertex.tet as usize][corner]
    };
    surface.triangles.iter().map(|t| t.map(node)).collect()
}

fn has_index(s: &Selector, i: u32) -> bool {
    s.indices.as_ref().is_none_or(|list| list.contains(&i))
}

fn keep_nearest<T>(chosen: &mut Vec<T>, s: &Selector, place: impl Fn(&T) -> Vec3) {
    if let Some(point) = s.nearest {
        chosen.sort_by(|a, b| (place(a) - point).norm().total_cmp(&(place(b) - point).norm()));
        chosen.truncate(1);
    }
}

fn not_empty<T>(at: &Located<Selector>, chosen: Vec<T>, what: &str) -> Result<Vec<T>, Fault> {
    match chosen.is_empty() {
        false => Ok(chosen),
        true => Err(at.fault(format!("no {what} fulfil these conditions"))),
    }
}
