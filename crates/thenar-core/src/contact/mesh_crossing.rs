//! Edges of meshes that cross other edges.
//!
//! Where edges cross, neither's vertices nor the faces beside them are nearest: what lies across an
//! edge sinks in between its ends unless the crossing itself is a contact.

use crate::contact::MeshShape;
use crate::contact::aabb::Aabb;
use crate::contact::edge::{self, Crossed, Edge, FOLLOWED};
use crate::contact::manifold::Manifold;
use crate::contact::mesh_index::{Edges, MeshEdge};
use crate::contact::mesh_normals::STANDING;
use crate::contact::mesh_pair::{CROSSING, FROM_B, Pair, SHALLOW};
use crate::math::Vec3;

/// Crossings are offered up to this many times as deep as the shallowest: that much too deep, if
/// the shallowest is the way out.
const AS_DEEP: f64 = 1.2;

/// Adds the crossings of the twelve edges of cuboid A with edges of mesh B.
pub(super) fn of_cuboid(pair: &Pair, half: &Vec3, mesh: &MeshShape, manifold: &mut Manifold) {
    offer_crossings(pair, manifold, |found| {
        for (i, Edge { ends, normals }) in edge::of_cuboid(half).into_iter().enumerate() {
            let edge = CrossingEdge { i: i as u32, ends, normals, rounding: 0.0 };
            crossing(pair, &edge, mesh, &mesh.index.edges, found);
            crossing(pair, &edge, mesh, &mesh.index.bends, found);
        }
    });
}

/// Crossing of an edge of A and one of B.
#[derive(Clone, Copy)]
struct Crossing {
    feature: u32,
    position_W: Vec3,
    /// Moved from there into both bodies, square to the normal: where that is one of a face, the
    /// place itself lies in the face beside it, to round-off and what the normal leans.
    inner_W: Vec3,
    normal_W: Vec3,
    gap: f64,
    /// Deeper than this it may be that of edges that lie behind each other, on far sides of thin
    /// bodies.
    shallow: f64,
}

/// Edges of mesh A that cross edges of mesh B, of which one is sharp: blunt ones sink in between
/// their vertices by what triangles stand off the round surface that they stand for.
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

/// Adds the crossings that `each` finds. Edges that have gone deep into each other cross at the
/// shallowest of them and at what is little deeper: others lie behind each other, on far sides of
/// the bodies.
fn offer_crossings(pair: &Pair, manifold: &mut Manifold, each: impl Fn(&mut dyn FnMut(Crossing))) {
    // A place that stands out as far as a normal may lean is moved in by twice that: half of what
    // is left.
    let lies_inside = |c: &Crossing| {
        let deep = 0.25 * STANDING * c.gap;
        [pair.a, pair.b].iter().all(|s| s.distance(&c.inner_W).value < deep)
    };
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
    if is_deep && highest > f64::NEG_INFINITY {
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
    let ahead = if pair.travel > pair.reach.margin { FOLLOWED * pair.travel } else { 0.0 };
    sharp.tree.overlapping(&around.inflate(pair.reach.margin + ahead), |i| {
        let MeshEdge { vertices, normals } = sharp.list[i as usize];
        let ends = vertices.map(|v| mesh.points[v as usize]);
        let edge = CrossingEdge { i, ends, normals, rounding: mesh.index.rounding };
        crossing(pair, &edge, below, others, found);
    });
}

/// An edge of A: its number, ends, normals of its faces and rounding, in A's frame.
struct CrossingEdge {
    i: u32,
    ends: [Vec3; 2],
    normals: [Vec3; 2],
    rounding: f64,
}

/// Thickness of the thinner piece, and of both together \[m\].
fn thicknesses(pair: &Pair) -> [f64; 2] {
    let [a, b] = pair.movers.map(|m| 2.0 * m.piece.bounds.half().min());
    [a.min(b), a + b]
}

/// One edge of A and those of mesh B that it crosses, or comes to on its way.
fn crossing(
    pair: &Pair,
    edge: &CrossingEdge,
    mesh: &MeshShape,
    others: &Edges,
    found: &mut dyn FnMut(Crossing),
) {
    let turn = pair.b.rotation.transpose() * pair.a.rotation;
    let at_W = edge.ends.map(|p| pair.a.world_point(&p));
    let ends = at_W.map(|p_W| pair.b.shape_point(&p_W));
    let edge_a = Edge { ends, normals: edge.normals.map(|n| turn * n) };
    let roundings = [edge.rounding, mesh.index.rounding];
    let [spin_a, spin_b] = pair.movers.map(|m| m.side.placed.angular_velocity);
    let margin = pair.reach.margin;
    let fast = pair.travel > margin;
    let turns = if fast { pair.reach.h * (spin_a - spin_b).norm() } else { 0.0 };
    // Straight ways are no likeness of the ways of bodies that are led round.
    let led_round = pair.movers.iter().any(|m| m.is_turned_fast(pair.reach));
    let ways = (fast && !led_round).then(|| at_W.map(|p_W| pair.way(&p_W)));
    let swept = ways.map(|ways| [0, 1].map(|k| ends[k] + FOLLOWED * ways[k]));
    let [thinner, thickness] = thicknesses(pair);
    // Edges that are apart along an axis may be as deep as both bodies are thick; of shorter ones
    // ends lie inside then, and are met themselves.
    let length = (ends[1] - ends[0]).norm().min(others.longest);
    let deep = margin.max(thickness.min(0.5 * length));
    let mut near = Aabb::of_points(&ends);
    if let Some(swept) = &swept {
        near = near.union(&Aabb::of_points(swept));
    }
    others.tree.overlapping(&near.inflate(deep + roundings[0] + roundings[1]), |j| {
        let MeshEdge { vertices, normals } = others.list[j as usize];
        let edge_b = Edge { ends: vertices.map(|v| mesh.points[v as usize]), normals };
        let within = |c: &Crossed| c.gap() - roundings[0] - roundings[1] <= margin;
        let apart = |c: &Crossed| c.gap() > roundings[0] + roundings[1];
        let comes = || ways.and_then(|ways| edge_a.arrival(&ways, &edge_b)).filter(apart);
        let Some(c) = edge_a.cross(&edge_b, turns).filter(within).or_else(comes) else { return };
        let gap = c.gap() - roundings[0] - roundings[1];
        // From the edge of A: its lever is known however far off the other is now.
        let middle = c.p - (roundings[0] + 0.5 * gap) * c.n;
        let out = edge_a.normals[0] + edge_a.normals[1] + normals[0] + normals[1];
        let aside = STANDING * gap * (out - out.dot(&c.n) * c.n);
        let lengths = [&edge_a, &edge_b].map(|e| (e.ends[1] - e.ends[0]).norm());
        found(Crossing {
            feature: CROSSING | crossing_name(edge.i, others.first + j),
            position_W: pair.b.world_point(&middle),
            inner_W: pair.b.world_point(&(middle + aside)),
            normal_W: pair.b.rotation * c.n,
            gap,
            shallow: (SHALLOW * lengths[0].min(lengths[1])).min(0.5 * thinner),
        });
    });
}

/// A name of 28 bits for two edges that cross. Should two crossings have one name, the next solve
/// starts for both from the force of one.
fn crossing_name(i: u32, j: u32) -> u32 {
    (i.wrapping_mul(0x9E37_79B1) ^ j.wrapping_mul(0x85EB_CA6B).rotate_left(13)) >> 4
}

#[cfg(test)]
mod tests;
