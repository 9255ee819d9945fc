//! Edges of meshes that cross other edges.
//!
//! Where edges cross, neither's vertices nor the faces beside them are nearest: what lies across an edge sinks in between
//! its ends unless the crossing itself is a contact.

use crate::contact::MeshShape;
use crate::contact::aabb::Aabb;
use crate::contact::features::edges as cuboid_edges;
use crate::contact::manifold::Manifold;
use crate::contact::mesh_index::{Edges, MeshEdge};
use crate::contact::mesh_pair::{CROSSING, FROM_B, Pair, SHALLOW};
use crate::math::Vec3;

/// Crossings are offered up to this many times as deep as the shallowest: that much too deep, if the shallowest is
/// the way out.
const AS_DEEP: f64 = 1.2;

/// Axes of the twelve edges of a cuboid.
const AXES: [usize; 12] = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2];

/// Adds the crossings of the twelve edges of cuboid A with edges of mesh B.
pub(super) fn of_cuboid(pair: &Pair, half: &Vec3, mesh: &MeshShape, manifold: &mut Manifold) {
    offer_crossings(pair, manifold, |found| {
        for (i, (ends, axis)) in cuboid_edges(half).into_iter().zip(AXES).enumerate() {
            let out =
                Vec3::from_fn(|k, _| if k == axis { 0.0 } else { 1.0_f64.copysign(ends[0][k]) });
            let mut normals = [Vec3::zeros(); 2];
            for (slot, k) in [(axis + 1) % 3, (axis + 2) % 3].into_iter().enumerate() {
                normals[slot][k] = out[k];
            }
            let edge = Crosses { i: i as u32, ends, normals, rounding: 0.0 };
            crossing(pair, &edge, mesh, &mesh.index.edges, found);
            crossing(pair, &edge, mesh, &mesh.index.bends, found);
        }
    });
}

/// Where an edge of A and one of B cross.
#[derive(Clone, Copy)]
struct Crossing {
    feature: u32,
    position_W: Vec3,
    normal_W: Vec3,
    gap: f64,
    /// Deeper than this it may be that of edges that lie behind each other.
    shallow: f64,
}

/// Edges of mesh A that cross edges of mesh B, of which one is sharp: blunt ones sink in between their vertices by what
/// triangles stand off the round surface that they stand for.
pub(super) fn crossings(pairs: [&Pair; 2], meshes: [&MeshShape; 2], manifold: &mut Manifold) {
    let [a, b] = meshes.map(|mesh| &mesh.index);
    offer_crossings(pairs[0], manifold, |found| {
        sharp_on(pairs[0], meshes, &b.edges, found);
        sharp_on(pairs[0], meshes, &b.bends, found);
        sharp_on(pairs[1], [meshes[1], meshes[0]], &a.bends, &mut |c: Crossing| {
            found(Crossing { normal_W: -c.normal_W, feature: c.feature ^ FROM_B, ..c });
        });
    });
}

/// Adds the crossings that `each` finds. Edges that have gone deep into each other cross at the shallowest of them and at
/// what is little deeper: others lie behind each other, on far sides of the bodies.
fn offer_crossings(pair: &Pair, manifold: &mut Manifold, each: impl Fn(&mut dyn FnMut(Crossing))) {
    let lies_inside =
        |c: &Crossing| [pair.a, pair.b].iter().all(|s| s.distance(&c.position_W).value < 0.0);
    let mut highest = f64::NEG_INFINITY;
    let mut is_deep = false;
    each(&mut |c: Crossing| {
        if c.gap > -c.shallow {
            pair.push(c.feature, c.position_W, c.normal_W, c.gap, manifold);
        }
        let counts = c.gap < 0.0 && c.gap > highest && lies_inside(&c);
        if counts {
            highest = c.gap;
        }
        is_deep |= c.gap <= -c.shallow && (counts || c.gap >= AS_DEEP * highest);
    });
    if is_deep {
        each(&mut |c: Crossing| {
            if c.gap <= -c.shallow && c.gap >= AS_DEEP * highest && lies_inside(&c) {
                pair.push(c.feature, c.position_W, c.normal_W, c.gap, manifold);
            }
        });
    }
}

/// Sharp edges of A that cross `others`, of B.
fn sharp_on(
    pair: &Pair,
    [mesh, below]: [&MeshShape; 2],
    others: &Edges,
    found: &mut dyn FnMut(Crossing),
) {
    if others.list.is_empty() {
        return;
    }
    let rotation = pair.a.rotation.transpose() * pair.b.rotation;
    let around = pair.movers[1].piece.bounds.moved(&rotation, &pair.a.shape_point(&pair.b.origin));
    let sharp = &mesh.index.edges;
    sharp.tree.overlapping(&around.inflate(pair.reach.margin), |i| {
        let MeshEdge { vertices, normals } = sharp.list[i as usize];
        let ends = vertices.map(|v| mesh.points[v as usize]);
        let edge = Crosses { i, ends, normals, rounding: mesh.index.rounding };
        crossing(pair, &edge, below, others, found);
    });
}

/// An edge of A: its number, ends, normals of its faces and rounding, in A's frame.
struct Crosses {
    i: u32,
    ends: [Vec3; 2],
    normals: [Vec3; 2],
    rounding: f64,
}

/// One edge of A and those of mesh B that it crosses.
fn crossing(
    pair: &Pair,
    edge: &Crosses,
    mesh: &MeshShape,
    others: &Edges,
    found: &mut dyn FnMut(Crossing),
) {
    let turn = pair.b.rotation.transpose() * pair.a.rotation;
    let ends = edge.ends.map(|p| pair.b.shape_point(&pair.a.world_point(&p)));
    let edge_a = MeshEdge { vertices: [0; 2], normals: edge.normals.map(|n| turn * n) };
    let roundings = [edge.rounding, mesh.index.rounding];
    let near = Aabb::of_points(&ends).inflate(pair.reach.margin + roundings[0] + roundings[1]);
    others.tree.overlapping(&near, |j| {
        let edge_b = &others.list[j as usize];
        let ends_b = edge_b.vertices.map(|v| mesh.points[v as usize]);
        let Some((p, q, n)) = cross((&edge_a, ends), (edge_b, ends_b)) else { return };
        let gap = (p - q).dot(&n) - roundings[0] - roundings[1];
        if gap <= pair.reach.margin {
            let middle = 0.5 * (p + q + (roundings[1] - roundings[0]) * n);
            found(Crossing {
                feature: CROSSING | crossing_name(edge.i, others.first + j),
                position_W: pair.b.world_point(&middle),
                normal_W: pair.b.rotation * n,
                gap,
                shallow: SHALLOW * (ends[1] - ends[0]).norm().min((ends_b[1] - ends_b[0]).norm()),
            });
        }
    });
}

/// A name of 28 bits for two edges that cross. Should two crossings have one name, the next solve starts for both from
/// the force of one.
fn crossing_name(i: u32, j: u32) -> u32 {
    (i.wrapping_mul(0x9E37_79B1) ^ j.wrapping_mul(0x85EB_CA6B).rotate_left(13)) >> 4
}

/// The nearest points of two edges' lines if both lie within the edges, and the normal from B to A
/// if it is outward of both.
fn cross(a: (&MeshEdge, [Vec3; 2]), b: (&MeshEdge, [Vec3; 2])) -> Option<(Vec3, Vec3, Vec3)> {
    let (da, db) = (a.1[1] - a.1[0], b.1[1] - b.1[0]);
    let normal = da.cross(&db);
    let square = normal.norm_squared();
    if square <= 1e-6 * da.norm_squared() * db.norm_squared() {
        return None;
    }
    let between = b.1[0] - a.1[0];
    let s = between.cross(&db).dot(&normal) / square;
    let t = between.cross(&da).dot(&normal) / square;
    let inside = |x: f64| x > 1e-9 && x < 1.0 - 1e-9;
    if !inside(s) || !inside(t) {
        return None;
    }
    let n = normal / square.sqrt();
    let n = n * 1.0_f64.copysign(n.dot(&(b.0.normals[0] + b.0.normals[1])));
    let fits = in_cone(&n, b.0, &db) && in_cone(&-n, a.0, &da);
    fits.then(|| (a.1[0] + s * da, b.1[0] + t * db, n))
}

/// True when a normal lies between the normals of the faces beside an edge.
fn in_cone(n: &Vec3, edge: &MeshEdge, along: &Vec3) -> bool {
    let [n1, n2] = edge.normals;
    if n1 == n2 {
        return true;
    }
    // From the edge into each face.
    let into = |own: &Vec3, other: &Vec3| {
        let t = along.cross(own).normalize();
        t * -1.0_f64.copysign(t.dot(other))
    };
    n.dot(&into(&n1, &n2)) < 1e-6 && n.dot(&into(&n2, &n1)) < 1e-6
}
