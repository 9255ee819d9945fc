//! Pairs with a deformable body, and which parts of one are neighbours: settled when a world is
//! built.

use crate::contact::apart::{Regions, SeparateTriangles};
use crate::contact::pairs::PairTable;
use crate::contact::rigid_body::RigidBody;
use crate::contact::surface::Surface;
use crate::math::Vec3;
use crate::model::{BodyId, SoftDesc, SurfaceVertex, WorldDesc};

/// A pair with a deformable body, settled when the world is built.
#[derive(Clone, Copy, Debug)]
pub(super) struct SoftPair {
    pub soft: u32,
    pub other: u32,
    pub friction: f64,
}

/// A deformable and a rigid body.
pub(super) fn soft_rigid_pairs(
    table: &PairTable,
    surfaces: &[Surface],
    bodies: &[Option<RigidBody>],
) -> Vec<SoftPair> {
    let mut pairs = Vec::new();
    for (s, surface) in surfaces.iter().enumerate() {
        for (r, body) in bodies.iter().enumerate() {
            let Some(body) = body else { continue };
            let (soft, other) = (s as u32, r as u32);
            let ids = [BodyId::Soft(soft), BodyId::Rigid(other)];
            let friction = table.friction(ids[0], ids[1], surface.friction, body.friction);
            pairs.extend(friction.map(|friction| SoftPair { soft, other, friction }));
        }
    }
    pairs
}

/// Two deformable bodies, or one that touches itself.
pub(super) fn soft_soft_pairs(
    table: &PairTable,
    surfaces: &[Surface],
    apart: &[Option<SeparateTriangles>],
) -> Vec<SoftPair> {
    let mut pairs = Vec::new();
    for i in 0..surfaces.len() {
        for j in i..surfaces.len() {
            if i == j && apart[i].is_none() {
                continue;
            }
            let (soft, other) = (i as u32, j as u32);
            let ids = [BodyId::Soft(soft), BodyId::Soft(other)];
            let friction =
                table.friction(ids[0], ids[1], surfaces[i].friction, surfaces[j].friction);
            pairs.extend(friction.map(|friction| SoftPair { soft, other, friction }));
        }
    }
    pairs
}

/// The bone that carries most of each surface vertex.
pub(super) fn regions(desc: &WorldDesc, soft: usize) -> Regions {
    let SoftDesc { flesh, coupling, .. } = &desc.softs[soft];
    let Some(coupling) = coupling else { return Regions::default() };
    let carrier = |vertex: &SurfaceVertex| {
        // Shares of the bones of the four nodes, of which the largest decides.
        let nodes = flesh.tets[vertex.tet as usize].map(|n| &coupling.bindings[n as usize]);
        let share = |bone: u32| -> f64 {
            let of = |k: usize| -> f64 {
                (0..2).filter(|&j| nodes[k].bones[j] == bone).map(|j| nodes[k].weights[j]).sum()
            };
            (0..4).map(|k| vertex.weights[k] * of(k)).sum()
        };
        let bones = nodes.iter().flat_map(|binding| binding.bones);
        bones.max_by(|&i, &j| share(i).total_cmp(&share(j)).then(j.cmp(&i))).unwrap_or(0)
    };
    let joints = desc.joints.iter();
    let mut joined: Vec<[u32; 2]> = joints
        .filter_map(|joint| Some([joint.parent?.min(joint.child), joint.parent?.max(joint.child)]))
        .collect();
    joined.sort_unstable();
    Regions { of_vertex: flesh.collision.vertices.iter().map(carrier).collect(), joined }
}

/// The neighbours on each surface that touches itself.
pub(super) fn neighbors_at_rest(
    desc: &WorldDesc,
    surfaces: &[Surface],
) -> Vec<Option<SeparateTriangles>> {
    let of = |(i, surface): (usize, &Surface)| {
        let flesh = &desc.softs[i].flesh;
        let wanted = desc.self_contact.contains(&(i as u32));
        wanted.then(|| {
            let mut rest = vec![Vec3::zeros(); flesh.collision.vertices.len()];
            flesh.collision.positions(&flesh.tets, &flesh.nodes, &mut rest);
            SeparateTriangles::new(surface, &rest, regions(desc, i))
        })
    };
    surfaces.iter().enumerate().map(of).collect()
}
