//! Leaving out nearly empty tetrahedra.

use super::bcc;
use super::pieces::{Pieces, for_each_link};
use super::samples::Samples;
use super::union_find::UnionFind;
use thenar::Vec3;

/// Removes pieces filled less than `fill_min` and those that hang on by less than a face, and
/// gives their points to the nearest piece that stays, along links.
pub(super) fn prune(pieces: &mut Pieces, samples: &Samples, fill_min: f64) {
    let tet_volume = bcc::TET_VOLUME * pieces.cube.powi(3);
    let point_volume = samples.spacing.powi(3);
    let mut keep: Vec<bool> = pieces
        .counts
        .iter()
        .map(|&count| f64::from(count) * point_volume >= fill_min * tet_volume)
        .collect();
    keep_largest_component(pieces, &mut keep);
    reassign(pieces, samples, &keep);
    compact(pieces, &keep);
}

/// Clears `keep` outside the face-connected component that holds most of the body.
fn keep_largest_component(pieces: &Pieces, keep: &mut [bool]) {
    let mut faces: Vec<([u32; 3], u32)> = Vec::new();
    for (t, nodes) in pieces.nodes.iter().enumerate().filter(|(t, _)| keep[*t]) {
        for k in 0..4 {
            let mut face = [nodes[(k + 1) % 4], nodes[(k + 2) % 4], nodes[(k + 3) % 4]];
            face.sort_unstable();
            faces.push((face, t as u32));
        }
    }
    faces.sort_unstable();
    let mut sets = UnionFind::new(pieces.len());
    for pair in faces.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        sets.union(pair[0].1, pair[1].1);
    }
    let mut sizes = vec![0_u64; pieces.len()];
    for t in (0..pieces.len()).filter(|&t| keep[t]) {
        sizes[sets.find(t as u32) as usize] += u64::from(pieces.counts[t]);
    }
    let largest = (0..sizes.len()).rev().max_by_key(|&t| sizes[t]).unwrap_or(0) as u32;
    for (t, keep) in keep.iter_mut().enumerate() {
        *keep &= sets.find(t as u32) == largest;
    }
}

/// Spreads the kept pieces over the points of the others, breadth first along links.
fn reassign(pieces: &mut Pieces, samples: &Samples, keep: &[bool]) {
    let lost = |pieces: &Pieces, i: u32| !keep[pieces.of_sample[i as usize] as usize];
    loop {
        let mut moves: Vec<(u32, u32)> = Vec::new();
        for_each_link(samples, |i, j| match (lost(pieces, i), lost(pieces, j)) {
            (true, false) => moves.push((i, pieces.of_sample[j as usize])),
            (false, true) => moves.push((j, pieces.of_sample[i as usize])),
            _ => {}
        });
        if moves.is_empty() {
            break;
        }
        for (i, piece) in moves {
            pieces.of_sample[i as usize] = piece;
        }
    }
    // What no link reaches (specks of the sampling) goes to the first kept piece near it.
    let kept = keep.iter().position(|&k| k).unwrap_or(0) as u32;
    for i in 0..samples.cells.len() as u32 {
        if lost(pieces, i) {
            let near = samples.near(&samples.position(i as usize), 2).find(|&j| !lost(pieces, j));
            pieces.of_sample[i as usize] = near.map_or(kept, |j| pieces.of_sample[j as usize]);
        }
    }
}

fn compact(pieces: &mut Pieces, keep: &[bool]) {
    let mut index = vec![u32::MAX; keep.len()];
    let mut count = 0;
    for t in (0..keep.len()).filter(|&t| keep[t]) {
        index[t] = count;
        pieces.keys[count as usize] = pieces.keys[t];
        pieces.nodes[count as usize] = pieces.nodes[t];
        count += 1;
    }
    pieces.keys.truncate(count as usize);
    pieces.nodes.truncate(count as usize);
    pieces.counts = vec![0; count as usize];
    for piece in &mut pieces.of_sample {
        *piece = index[*piece as usize];
        pieces.counts[*piece as usize] += 1;
    }
}

/// Removes nodes that no tetrahedron uses.
pub(super) fn drop_unused(tets: &mut [[u32; 4]], nodes: &mut Vec<Vec3>) {
    let mut index = vec![u32::MAX; nodes.len()];
    let mut kept = Vec::new();
    for node in tets.iter_mut().flatten() {
        if index[*node as usize] == u32::MAX {
            index[*node as usize] = kept.len() as u32;
            kept.push(nodes[*node as usize]);
        }
        *node = index[*node as usize];
    }
    *nodes = kept;
}
