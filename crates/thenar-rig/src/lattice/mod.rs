//! A coarse tetrahedral mesh around a closed surface, cut along the body's own topology.
//!
//! The body is covered by a body-centred cubic lattice; a lattice tetrahedron that holds several
//! separate pieces of the body is there several times (see `pieces`). A tetrahedron that the
//! body fills only in part knows its filled fraction, by which its density and its stiffness are
//! to be scaled, so that mass and stiffness are those of the body (Nesme et al. 2009).
//!
//! Guaranteed: one face-connected component; positive volumes; the filled volume is the body's; the
//! result depends on nothing but the input. Not guaranteed: surface vertices may lie a little
//! outside their tetrahedron, where a nearly empty one was left out; of lattices of several sizes
//! up to a height of it, where its nodes had no other (see `support`).

mod bcc;
mod cells;
mod graded;
mod material;
mod octree;
mod pieces;
mod prune;
mod quality;
mod samples;
mod support;
mod surface;
pub mod tet;
mod union_find;

pub use quality::Quality;

use crate::size::REACH_MAX;
use crate::work::Stage;
use crate::{RigError, TriMesh};
use cells::Uniform;
use graded::Graded;
use octree::Octree;
use pieces::Pieces;
use samples::Samples;
use support::SUPPORT_MIN;
use thenar_core::{Quat, Vec3};

/// Fineness and orientation of a lattice.
#[derive(Clone, Copy, Debug)]
pub struct LatticeOptions {
    /// Wanted number of tetrahedra; met within about ±10 %.
    pub tets: usize,
    /// Orientation of the lattice in the mesh's frame.
    pub rotation: Quat,
}

/// Sizes of a graded lattice's elements.
#[derive(Clone, Copy, Debug)]
pub struct Grading {
    /// Edge of the coarsest cubes \[m\].
    pub coarse: f64,
    /// Number of times that cubes may be halved.
    pub halvings: usize,
}

/// Tetrahedra around a body.
pub struct Lattice {
    /// Node positions in the mesh's frame \[m\].
    pub nodes: Vec<Vec3>,
    /// Positively oriented tetrahedra.
    pub tets: Vec<[u32; 4]>,
    /// Volume of the body in each tetrahedron \[m³\]; their sum is the body's volume.
    pub filled: Vec<f64>,
    rotation: Quat,
    samples: Samples,
    of_sample: Vec<u32>,
}

/// Fewer elements than this say nothing about a body.
const TETS_MIN: usize = 12;
/// More are refused, so that memory stays bounded.
const TETS_MAX: usize = 200_000;
/// Sample spacing, relative to the cube root of the volume per wanted tetrahedron.
const SPACING: f64 = 0.28;
/// Spacing of samples relative to the finest tetrahedra of a graded lattice: 15 points in each,
/// three in the half-empty ones of a thin edge.
const SPACING_FINEST: f64 = 0.4;
/// Largest spacing of samples, relative to the same tetrahedra.
const SPACING_MAX: f64 = 0.5;
/// About as many grid points as memory should be spent on.
const POINTS_WANTED: f64 = 1.6e7;
/// Tetrahedra filled less than this are left out and their contents given to neighbours.
const FILL_MIN: f64 = 0.03;
/// Attempts at the wanted number of tetrahedra.
const ATTEMPTS: usize = 8;

impl Lattice {
    /// Covers the inside of a closed, outward-facing mesh.
    ///
    /// # Errors
    /// When the count is out of range, the mesh encloses no volume, or it hangs together too
    /// thinly for elements of this size.
    pub fn new(mesh: &TriMesh, options: &LatticeOptions) -> Result<Self, RigError> {
        if !(TETS_MIN..=TETS_MAX).contains(&options.tets) {
            return Err(RigError::invalid(format!(
                "the number of tetrahedra must be in {TETS_MIN}..={TETS_MAX}, not {}",
                options.tets
            )));
        }
        let volume = enclosed(mesh)?;
        let turned = turned(mesh, &options.rotation.inverse());
        let per_tet = (volume / options.tets as f64).cbrt();
        let samples = Samples::new(&turned, spacing(&turned, per_tet, SPACING)?)?;
        let pieces = fit_count(&samples, options.tets, 2.5 * per_tet)?;
        Self::from_pieces(samples, pieces, options.rotation, volume)
    }

    /// Covers the inside of a closed, outward-facing mesh with elements of several sizes: around
    /// every place inside, cubes are halved until their edge is at most `edge` there \[m\], as far
    /// as the grading goes. Dihedral angles are 45° to 120°. Every node has at least a tenth of the
    /// stiffness of those around it, but for places so thin that they hang on by less.
    ///
    /// # Errors
    /// When the mesh encloses no volume, hangs together too thinly for elements of this size, or
    /// needs more of them than there may be.
    pub fn graded(
        mesh: &TriMesh,
        grading: &Grading,
        edge: impl Fn(&Vec3) -> f64,
    ) -> Result<Self, RigError> {
        let volume = enclosed(mesh)?;
        let mut tree = Octree::new(mesh.bounds(), grading.coarse, grading.halvings)?;
        let finest = tree.edge(grading.halvings) * bcc::TET_VOLUME.cbrt();
        let samples = Samples::new(mesh, spacing(mesh, finest, SPACING_FINEST)?)?;
        let count = samples.cells.len();
        let stage = Stage::new("filling the mesh with tetrahedra", 3, 30.0 * count as f64, "")?;
        for i in 0..count {
            let p = samples.position(i);
            tree.refine(&p, edge(&p));
        }
        tree.balance();
        stage.at(1)?;
        let mut pieces = Pieces::new(&samples, &Graded { tree });
        stage.at(2)?;
        if pieces.len() > TETS_MAX {
            return Err(RigError::invalid(format!(
                "the mesh would have {} tetrahedra, more than {TETS_MAX}; ask for less detail",
                pieces.len()
            )));
        }
        prune::prune(&mut pieces, &samples, FILL_MIN, SUPPORT_MIN)?;
        stage.at(3)?;
        Self::from_pieces(samples, pieces, Quat::identity(), volume)
    }

    fn from_pieces(
        samples: Samples,
        pieces: Pieces,
        rotation: Quat,
        volume: f64,
    ) -> Result<Self, RigError> {
        let Pieces { nodes: mut tets, positions: mut nodes, of_sample, .. } = pieces;
        prune::drop_unused(&mut tets, &mut nodes);
        let mut counts = vec![0_u32; tets.len()];
        of_sample.iter().for_each(|&t| counts[t as usize] += 1);
        let per_sample = volume / samples.cells.len() as f64;
        let filled = counts.iter().map(|&c| f64::from(c) * per_sample).collect();
        nodes.iter_mut().for_each(|x| *x = rotation * *x);
        Ok(Self { nodes, tets, filled, rotation, samples, of_sample })
    }

    /// Corner positions of tetrahedron `t`.
    pub fn corners(&self, t: usize) -> tet::Corners {
        self.tets[t].map(|n| self.nodes[n as usize])
    }

    /// Filled fraction of tetrahedron `t`, in 0..1 up to sampling error.
    pub fn fill(&self, t: usize) -> f64 {
        self.filled[t] / tet::volume(&self.corners(t))
    }

    /// Volume of the body that each node stands for \[m³\].
    pub fn node_volumes(&self) -> Vec<f64> {
        let mut volumes = vec![0.0; self.nodes.len()];
        for (tet, filled) in self.tets.iter().zip(&self.filled) {
            tet.iter().for_each(|&n| volumes[n as usize] += filled / 4.0);
        }
        volumes
    }

    /// Number of inside points that carry the volume.
    pub fn sample_count(&self) -> usize {
        self.of_sample.len()
    }

    /// Place of inside point `i` in the mesh's frame \[m\].
    pub fn sample_position(&self, i: usize) -> Vec3 {
        self.rotation * self.samples.position(i)
    }

    /// Tetrahedron that carries inside point `i`.
    pub fn sample_tet(&self, i: usize) -> u32 {
        self.of_sample[i]
    }

    /// Distance between inside points \[m\].
    pub fn sample_spacing(&self) -> f64 {
        self.samples.spacing
    }

    /// Calls `f` for every two neighbouring inside points that the surface does not part.
    pub fn for_each_link(&self, f: impl FnMut(u32, u32)) {
        pieces::for_each_link(&self.samples, f);
    }
}

/// The volume that a mesh encloses.
fn enclosed(mesh: &TriMesh) -> Result<f64, RigError> {
    let volume = mesh.volume();
    if volume.is_finite() && volume > 0.0 {
        return Ok(volume);
    }
    Err(RigError::invalid(format!(
        "the mesh encloses {volume:e} m³: it is open, empty or inside out"
    )))
}

/// Distance between inside points: fine enough to resolve elements, coarse enough for memory.
fn spacing(mesh: &TriMesh, per_tet: f64, wanted: f64) -> Result<f64, RigError> {
    let [low, high] = mesh.bounds();
    let extent = high - low;
    // Lattice points are counted from the origin in 32 bits, with room for smaller elements.
    let far = low.amax().max(high.amax());
    if far > REACH_MAX * per_tet {
        return Err(RigError::invalid(format!(
            "the mesh lies {far:e} m from its origin: too far for elements of {per_tet:e} m"
        )));
    }
    let affordable = (extent.x * extent.y * extent.z / POINTS_WANTED).cbrt();
    let spacing = affordable.max(wanted * per_tet);
    if spacing > SPACING_MAX * per_tet {
        return Err(RigError::invalid(
            "the mesh is too thin, or the elements too many, for its volume to be resolved",
        ));
    }
    Ok(spacing)
}

/// Searches the cube edge that gives about the wanted number of tetrahedra.
fn fit_count(samples: &Samples, wanted: usize, first: f64) -> Result<Pieces, RigError> {
    let shift = Vec3::new(0.25, 0.25, 0.25);
    let mut cube = first;
    let mut best: Option<Pieces> = None;
    // An inside point is looked at about ten times.
    let work = (10 * ATTEMPTS * samples.cells.len()) as f64;
    let stage = Stage::new("filling the mesh with tetrahedra", ATTEMPTS, work, "")?;
    for attempt in 0..ATTEMPTS {
        let mut pieces = Pieces::new(samples, &Uniform { cube, shift });
        prune::prune(&mut pieces, samples, FILL_MIN, 0.0)?;
        let ratio = pieces.len() as f64 / wanted as f64;
        let off = |n: usize| (n as f64 / wanted as f64).ln().abs();
        if best.as_ref().is_none_or(|b| off(pieces.len()) < off(b.len())) {
            best = Some(pieces);
        }
        stage.at(attempt + 1)?;
        if (ratio - 1.0).abs() < 0.05 {
            break;
        }
        // The count goes about as the inverse volume of a tetrahedron; surface ones make it less
        // steep on coarse lattices.
        cube *= ratio.powf(0.36);
    }
    Ok(best.unwrap_or_else(|| Pieces::new(samples, &Uniform { cube, shift })))
}

fn turned(mesh: &TriMesh, rotation: &Quat) -> TriMesh {
    let positions = mesh.positions.iter().map(|p| rotation * p).collect();
    TriMesh { positions, triangles: mesh.triangles.clone() }
}
