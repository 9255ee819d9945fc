//! Overlaps in a state: bodies that were put into each other.

use crate::contact::{Contact, Reach, RigidPlace, SeenSides, Shape, Site, SurfaceState};
use crate::math::Vec3;
use crate::model::{BodyId, RigidDesc, SoftDesc};
use crate::world::World;
use crate::world::response::{body_of, nearest_vertex};

/// Depth from which two surfaces overlap instead of touching \[m\]: what the place of a contact is
/// good for between rigid shapes of some centimetres (as `contact/pair_tests.rs` holds pairs that
/// are apart to it).
const DEPTH_LEAST: f64 = 1e-5;
/// A surface of triangles, deformable or a rigid mesh, is no finer than these: with one, that depth
/// in mean edge lengths.
const DEPTH_OF_EDGE: f64 = 0.01;

/// Two bodies that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// The bodies; equal for one that overlaps itself.
    pub bodies: [BodyId; 2],
    /// Collision-surface vertex nearest to the deepest point, of each body that is deformable.
    pub vertices: [Option<u32>; 2],
    /// Depth of the deepest point \[m\].
    pub depth: f64,
    /// The deepest point, world \[m\].
    pub place_W: Vec3,
}

impl World {
    /// The pairs of bodies that overlap in the present state, the deepest first, by the points that
    /// collision detection finds for bodies at rest. A pair counts from a depth of 10 µm, with a
    /// deformable body or a mesh from a hundredth of the mean edge of its collision surface, if
    /// that is more. Pairs that do not touch by the rules of the description are left out.
    /// Allocates: for use outside the stepped loop.
    pub fn overlaps(&self) -> Vec<Overlap> {
        let softs: Vec<f64> = self.desc.softs.iter().map(soft_edge).collect();
        let rigids: Vec<f64> = self.desc.rigids.iter().map(rigid_edge).collect();
        let least = |site: &Site| {
            let edge = match site {
                Site::Rigid { body, .. } => rigids[*body as usize],
                Site::Soft(point) => softs[point.soft as usize],
            };
            DEPTH_LEAST.max(DEPTH_OF_EDGE * edge)
        };
        let mut overlaps: Vec<Overlap> = Vec::new();
        for contact in self.contacts_at_rest() {
            let sites = [&contact.a, &contact.b];
            let found = Overlap {
                bodies: sites.map(body_of),
                vertices: sites.map(nearest_vertex),
                depth: -contact.gap,
                place_W: contact.position_W,
            };
            if found.depth < least(sites[0]).max(least(sites[1])) {
                continue;
            }
            overlaps.push(found);
        }
        // Of each pair the deepest; of equals the first.
        overlaps.sort_by(|a, b| a.pair().cmp(&b.pair()).then(b.depth.total_cmp(&a.depth)));
        overlaps.dedup_by_key(|overlap| overlap.pair());
        overlaps.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        overlaps
    }

    /// Returns the contacts that one search finds with nothing moving and no margin.
    fn contacts_at_rest(&self) -> Vec<Contact> {
        let mut detector = self.detector.clone();
        let still = |pose_WB: &_| RigidPlace {
            pose_WB: *pose_WB,
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        };
        let places: Vec<RigidPlace> = self.state.poses_WB.iter().map(still).collect();
        let positions = self.all_collision_vertices();
        let velocities = vec![Vec3::zeros(); positions.len()];
        let surfaces = SurfaceState { positions, velocities: &velocities };
        let mut sides = SeenSides::with_capacity(detector.sides_max());
        let mut found = Vec::new();
        let reach = Reach { h: 0.0, margin: 0.0 };
        detector.find(reach, &places, surfaces, &self.state.sides, &mut sides, &mut found);
        found
    }
}

impl Overlap {
    /// Pair of the bodies, one and the same in either order.
    fn pair(&self) -> [(bool, u32); 2] {
        let mut pair = self.bodies.map(|body| match body {
            BodyId::Rigid(i) => (false, i),
            BodyId::Soft(i) => (true, i),
        });
        pair.sort_unstable();
        pair
    }
}

/// Mean edge of a body's collision surface at rest \[m\].
fn soft_edge(soft: &SoftDesc) -> f64 {
    let flesh = &soft.flesh;
    let mut x = vec![Vec3::zeros(); flesh.collision.vertices.len()];
    flesh.collision.positions(&flesh.tets, &flesh.nodes, &mut x);
    mean_edge(&x, &flesh.collision.triangles)
}

/// Mean edge of a rigid mesh \[m\]; zero for exact shapes.
fn rigid_edge(rigid: &RigidDesc) -> f64 {
    match &rigid.shape {
        Some(Shape::Mesh(mesh)) => mean_edge(&mesh.points, &mesh.triangles),
        _ => 0.0,
    }
}

/// Mean edge of some triangles \[m\]; zero without any.
fn mean_edge(x: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let edges = triangles.iter().flat_map(|&[i, j, k]| [[i, j], [j, k], [k, i]]);
    let whole: f64 = edges.map(|[i, j]| (x[i as usize] - x[j as usize]).norm()).sum();
    whole / (3 * triangles.len()).max(1) as f64
}
