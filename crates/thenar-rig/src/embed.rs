//! Soft bodies without bones: a closed surface embedded in tetrahedra.

use crate::lattice::{Lattice, LatticeOptions, Quality};
use crate::mesh::{Hole, Topology, close_holes, decimate, subdivide_to, weld_near};
use crate::object::SoftModel;
use crate::size::sensible_size;
use crate::work::phase;
use crate::{RigError, TriMesh};
use thenar_core::model::{EmbeddedSurface, Flesh, Material};
use thenar_core::{Quat, Vec3};

/// Options of [`embed`].
#[derive(Clone, Copy, Debug)]
pub struct EmbedOptions {
    /// Wanted number of tetrahedra.
    pub tets: usize,
    /// Orientation of the lattice in the mesh's frame.
    pub rotation: Quat,
    /// Largest number of triangles of the surface that touches.
    pub collision_triangles: usize,
    /// Smooth refinement until the drawn surface has this many triangles; `None` draws the mesh
    /// as it is.
    pub render_triangles: Option<usize>,
    /// Rayleigh damping, mass-proportional \[1/s\].
    pub mass_damping: f64,
    /// Rayleigh damping, stiffness-proportional \[s\].
    pub stiffness_damping: f64,
    /// Coulomb friction coefficient.
    pub friction: f64,
}

impl Default for EmbedOptions {
    fn default() -> Self {
        Self {
            tets: 600,
            rotation: Quat::identity(),
            collision_triangles: 1500,
            render_triangles: None,
            mass_damping: 1.0,
            stiffness_damping: 1e-3,
            friction: 0.6,
        }
    }
}

/// A soft body in the frame of the mesh it was made from.
#[derive(Clone, Debug)]
pub struct Embedded {
    /// Nodes, elements, materials and the surface that touches.
    pub flesh: Flesh,
    /// The surface that is drawn.
    pub render: EmbeddedSurface,
    /// Volume of the body that each node stands for \[m³\].
    pub node_volumes: Vec<f64>,
    /// Worst element shapes.
    pub quality: Quality,
}

impl Embedded {
    /// The body as a model of this name.
    pub fn into_model(self, name: &str) -> SoftModel {
        SoftModel { name: name.to_owned(), flesh: self.flesh, render: self.render }
    }
}

/// The mesh of a file as [`embed`] wants it: welded, of one closed piece, its outside out.
///
/// # Errors
/// When the mesh is malformed, not closed, or of several parts.
pub fn closed_surface(mesh: &TriMesh) -> Result<TriMesh, RigError> {
    let mut whole = welded(mesh)?;
    // A mesh that cannot be used need not be turned first.
    phase("looking at the mesh's edges")?;
    let topology = Topology::of(&whole);
    if !topology.closed() {
        return Err(not_closed(whole, &topology));
    }
    check_parts("the mesh", &topology)?;
    whole.orient()?;
    Ok(whole)
}

/// A closed mesh whose volume is less than this part of a cube on its diagonal is a sheet: a hand's
/// breadth of paper has 1e-5.
const SHEET: f64 = 1e-6;

/// The refusal of an open mesh, with how many holes it has.
fn not_closed(whole: TriMesh, topology: &Topology) -> RigError {
    let open = open_edges("the mesh", topology);
    match mended(whole) {
        Ok((mesh, _)) if is_sheet(&mesh) => RigError::invalid(format!(
            "{open}: it is a sheet, which encloses nothing; give it thickness"
        )),
        Ok((_, holes)) if holes.len() == 1 => RigError::invalid(format!("{open}, around one hole")),
        Ok((_, holes)) => RigError::invalid(format!("{open}, around {} holes", holes.len())),
        Err(error) => error,
    }
}

fn is_sheet(mesh: &TriMesh) -> bool {
    let first = mesh.positions.first().copied().unwrap_or_default();
    let grown = |[low, high]: [Vec3; 2], p: &Vec3| [low.inf(p), high.sup(p)];
    let [low, high] = mesh.positions.iter().fold([first; 2], grown);
    mesh.volume().abs() < SHEET * (high - low).norm().powi(3)
}

/// True if the holes of a mesh that is not closed can be closed, and it encloses something then.
pub fn can_be_closed(mesh: &TriMesh) -> bool {
    mended_surface(mesh).is_ok_and(|(mesh, _)| !is_sheet(&mesh))
}

/// [`closed_surface`] of a mesh whose holes are closed first, those whose border is a simple loop;
/// and these holes.
///
/// # Errors
/// When the mesh is malformed, of several parts, or not closed for another reason.
pub fn mended_surface(mesh: &TriMesh) -> Result<(TriMesh, Vec<Hole>), RigError> {
    mended(welded(mesh)?)
}

/// A welded mesh with its holes closed, its outside out; and these holes.
fn mended(mut whole: TriMesh) -> Result<(TriMesh, Vec<Hole>), RigError> {
    phase("closing holes of the mesh")?;
    // Along a border of triangles that disagree lies no hole.
    whole.orient()?;
    let (mut whole, holes) = close_holes(&whole);
    phase("looking at the mesh's edges")?;
    let topology = Topology::of(&whole);
    if !topology.closed() {
        return Err(RigError::invalid(format!(
            "{}, not around holes that could be closed: mend it in a program for meshes",
            open_edges("the mesh", &topology)
        )));
    }
    check_parts("the mesh", &topology)?;
    whole.orient()?;
    Ok((whole, holes))
}

fn welded(mesh: &TriMesh) -> Result<TriMesh, RigError> {
    mesh.check()?;
    phase("welding the mesh")?;
    Ok(weld_near(mesh))
}

/// Fills a closed, outward-facing mesh with tetrahedra. `material` gives the material at each
/// place of the mesh's frame (the same everywhere, or a crust around a crumb).
///
/// # Errors
/// When the mesh is not closed, has several parts, encloses no volume or hangs together too thinly
/// for so few elements, or a count is out of range.
pub fn embed(
    mesh: &TriMesh,
    options: &EmbedOptions,
    material: impl Fn(&Vec3) -> Material,
) -> Result<Embedded, RigError> {
    mesh.check()?;
    sensible_size(mesh.bounds())?;
    phase("looking at the mesh's edges")?;
    check_closed("the mesh", mesh)?;
    let fine = match options.render_triangles {
        Some(triangles) => subdivide_to(mesh, triangles)?.mesh,
        None => mesh.clone(),
    };
    let lattice =
        Lattice::new(&fine, &LatticeOptions { tets: options.tets, rotation: options.rotation })?;
    let collision = lattice.embed(&decimate(&fine, options.collision_triangles)?)?;
    phase("binding the surface to the tetrahedra")?;
    let render = lattice.embed(&fine)?;
    phase("weighing the tetrahedra")?;
    Ok(Embedded {
        quality: Quality::of((0..lattice.tets.len()).map(|t| lattice.corners(t))),
        node_volumes: lattice.node_volumes(),
        flesh: Flesh {
            materials: lattice.materials(material),
            nodes: lattice.nodes,
            tets: lattice.tets,
            relaxation: Vec::new(),
            mass_damping: options.mass_damping,
            stiffness_damping: options.stiffness_damping,
            fixed: Vec::new(),
            collision,
            friction: options.friction,
        },
        render,
    })
}

/// Errs unless a mesh is one closed surface whose triangles agree on which side is out.
pub(crate) fn check_closed(what: &str, mesh: &TriMesh) -> Result<(), RigError> {
    let topology = Topology::of(mesh);
    check_holes(what, &topology)?;
    if topology.misoriented_edges > 0 || topology.non_manifold_vertices > 0 {
        return Err(RigError::invalid(format!(
            "{what} is not a manifold: {} edges turn over, {} vertices pinch it",
            topology.misoriented_edges, topology.non_manifold_vertices
        )));
    }
    check_parts(what, &topology)
}

fn check_holes(what: &str, topology: &Topology) -> Result<(), RigError> {
    if topology.closed() {
        return Ok(());
    }
    Err(RigError::invalid(open_edges(what, topology)))
}

/// The edges at which a surface is not closed, in words.
fn open_edges(what: &str, topology: &Topology) -> String {
    format!(
        "{what} is not closed: {} edges have one triangle, {} more than two",
        topology.boundary_edges, topology.non_manifold_edges
    )
}

fn check_parts(what: &str, topology: &Topology) -> Result<(), RigError> {
    if topology.components != 1 {
        return Err(RigError::invalid(format!(
            "{what} has {} separate parts, expected one",
            topology.components
        )));
    }
    Ok(())
}
