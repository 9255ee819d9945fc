//! Deformable bodies from explicit nodes and tetrahedra.

use super::boundary::{FACES, boundary_surface};
use crate::RigError;
use crate::error::positive;
use crate::lattice::Quality;
use crate::mesh::{find, join};
use crate::size::{bounds, sensible_size};
use thenar_core::Vec3;
use thenar_core::model::{EmbeddedSurface, Flesh, Material};

/// A deformable body in its model frame.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct SoftModel {
    /// Name of the body.
    pub name: String,
    /// Nodes, elements, materials and collision surface.
    pub flesh: Flesh,
    /// Surface for drawing.
    pub render: EmbeddedSurface,
}

/// Properties of a deformable body that do not follow from its geometry.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SoftOptions {
    /// Rayleigh damping: `D = mass_damping M + stiffness_damping K`. This one \[1/s\].
    pub mass_damping: f64,
    /// Rayleigh damping \[s\].
    pub stiffness_damping: f64,
    /// Coulomb friction coefficient.
    pub friction: f64,
}

impl Default for SoftOptions {
    fn default() -> Self {
        Self { mass_damping: 0.0, stiffness_damping: 0.0, friction: 0.5 }
    }
}

/// Composition of a deformable body.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SoftReport {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of tetrahedra.
    pub tets: usize,
    /// Triangles of the boundary.
    pub boundary_triangles: usize,
    /// Volume of all tetrahedra \[m³\].
    pub volume: f64,
    /// Mass \[kg\].
    pub mass: f64,
    /// Nodes that lie exactly where an earlier one does (a cut, or a mesh that was not welded).
    pub coincident_nodes: usize,
    /// Smallest dihedral angle \[rad\].
    pub dihedral_min: f64,
}

/// Elements flatter than this (volume over the cube of the longest edge) are refused.
const FLATNESS_MIN: f64 = 1e-9;

/// A body from nodes \[m\] and tetrahedra; `materials` has one entry per tetrahedron, or one for
/// all. Its boundary is both collision and render surface.
///
/// # Errors
/// When a number is not finite, an index out of range, a tetrahedron inverted
/// (`det[x1-x0, x2-x0, x3-x0] ≤ 0`), flat or given twice, a face shared by more than two, a node
/// unused, the body in several pieces, or a material outside its range.
pub fn soft_from_tets(
    name: &str,
    nodes: Vec<Vec3>,
    tets: Vec<[u32; 4]>,
    mut materials: Vec<Material>,
    options: &SoftOptions,
) -> Result<(SoftModel, SoftReport), RigError> {
    if let [one] = materials[..] {
        materials = vec![one; tets.len()];
    }
    if materials.len() != tets.len() {
        return Err(RigError::invalid(format!(
            "{} materials are given for {} tetrahedra",
            materials.len(),
            tets.len()
        )));
    }
    for material in &materials {
        check_material(material)?;
    }
    check_options(options)?;
    check_elements(&nodes, &tets)?;
    check_faces(&tets)?;
    check_connected(&nodes, &tets)?;

    let surface = boundary_surface(&tets);
    let volume_of = |tet: &[u32; 4]| volume(&tet.map(|n| nodes[n as usize]));
    let corners = tets.iter().map(|t| t.map(|n| nodes[n as usize]));
    let report = SoftReport {
        nodes: nodes.len(),
        tets: tets.len(),
        boundary_triangles: surface.triangles.len(),
        volume: tets.iter().map(volume_of).sum(),
        mass: tets.iter().zip(&materials).map(|(t, m)| volume_of(t) * m.density).sum(),
        coincident_nodes: coincident(&nodes),
        dihedral_min: Quality::of(corners).dihedral_min,
    };
    let flesh = Flesh {
        nodes,
        tets,
        materials,
        relaxation: Vec::new(),
        mass_damping: options.mass_damping,
        stiffness_damping: options.stiffness_damping,
        fixed: Vec::new(),
        collision: surface.clone(),
        friction: options.friction,
    };
    Ok((SoftModel { name: name.to_owned(), flesh, render: surface }, report))
}

/// Errs unless stiffness and density are positive and Poisson's ratio is in (-1, 0.5).
pub fn check_material(material: &Material) -> Result<(), RigError> {
    positive("young", material.young)?;
    positive("density", material.density)?;
    if !(material.poisson > -1.0 && material.poisson < 0.5) {
        return Err(RigError::Parameter {
            name: "poisson",
            expected: "above -1 and below 0.5",
            value: material.poisson,
        });
    }
    Ok(())
}

fn check_options(options: &SoftOptions) -> Result<(), RigError> {
    for (name, value) in [
        ("mass_damping", options.mass_damping),
        ("stiffness_damping", options.stiffness_damping),
        ("friction", options.friction),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(RigError::Parameter { name, expected: "finite and not negative", value });
        }
    }
    Ok(())
}

/// Signed volume \[m³\].
pub(crate) fn volume([a, b, c, d]: &[Vec3; 4]) -> f64 {
    (b - a).dot(&(c - a).cross(&(d - a))) / 6.0
}

fn check_elements(nodes: &[Vec3], tets: &[[u32; 4]]) -> Result<(), RigError> {
    if tets.is_empty() {
        return Err(RigError::invalid("the body has no tetrahedra"));
    }
    if let Some(i) = nodes.iter().position(|p| !p.iter().all(|x| x.abs() <= 1e6)) {
        return Err(RigError::invalid(format!("node {i} is not finite, or beyond 1e6 m")));
    }
    sensible_size(bounds(nodes))?;
    for (t, tet) in tets.iter().enumerate() {
        if let Some(n) = tet.iter().find(|&&n| n as usize >= nodes.len()) {
            return Err(RigError::invalid(format!(
                "tetrahedron {t} names node {n}, but there are only {}",
                nodes.len()
            )));
        }
        let x = tet.map(|n| nodes[n as usize]);
        let longest = (0..4)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| (x[i] - x[j]).norm())
            .fold(0.0, f64::max);
        let volume = volume(&x);
        if volume.abs() <= FLATNESS_MIN * longest.powi(3) {
            return Err(RigError::invalid(format!(
                "tetrahedron {t} is flat: its volume is {volume:e} m³"
            )));
        }
        if volume < 0.0 {
            return Err(RigError::invalid(format!(
                "tetrahedron {t} is inverted: its volume is {volume:e} m³ (swap two of its nodes)"
            )));
        }
    }
    Ok(())
}

/// No face of three tetrahedra, and none on the same side of two.
fn check_faces(tets: &[[u32; 4]]) -> Result<(), RigError> {
    let mut all = Vec::with_capacity(4 * tets.len());
    for (t, tet) in tets.iter().enumerate() {
        for face in FACES {
            let mut key = face.map(|k| tet[k]);
            // The orientation is the parity of the sorting.
            let even =
                [(0, 1), (1, 2), (0, 2)].iter().filter(|&&(i, j)| key[i] > key[j]).count() % 2;
            key.sort_unstable();
            all.push((key, even, t));
        }
    }
    all.sort_unstable();
    for same in all.chunk_by(|a, b| a.0 == b.0) {
        match same {
            [_] => {}
            [a, b] if a.1 != b.1 => {}
            [a, b, ..] => {
                return Err(RigError::invalid(format!(
                    "tetrahedra {} and {} lie on the same side of their common face {:?}: \
                     the body overlaps itself",
                    a.2, b.2, a.0
                )));
            }
            [] => {}
        }
    }
    Ok(())
}

/// Every node is used and all tetrahedra hang together.
fn check_connected(nodes: &[Vec3], tets: &[[u32; 4]]) -> Result<(), RigError> {
    let mut parent: Vec<u32> = (0..nodes.len() as u32).collect();
    let mut used = vec![false; nodes.len()];
    for tet in tets {
        tet.iter().for_each(|&n| used[n as usize] = true);
        (1..4).for_each(|k| join(&mut parent, tet[0], tet[k]));
    }
    if let Some(n) = used.iter().position(|u| !u) {
        return Err(RigError::invalid(format!("node {n} belongs to no tetrahedron")));
    }
    let roots = (0..nodes.len() as u32).filter(|&n| find(&mut parent, n) == n).count();
    if roots > 1 {
        return Err(RigError::invalid(format!(
            "the body is in {roots} pieces that share no node; make each a body of its own"
        )));
    }
    Ok(())
}

fn coincident(nodes: &[Vec3]) -> usize {
    let mut keys: Vec<_> =
        nodes.iter().map(|p| [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())).collect();
    keys.sort_unstable();
    let all = keys.len();
    keys.dedup();
    all - keys.len()
}
