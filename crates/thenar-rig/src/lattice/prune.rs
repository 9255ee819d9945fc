//! Leaving out nearly empty tetrahedra.

use super::pieces::{Pieces, for_each_link};
use super::samples::Samples;
use super::support::leave_out_unsupported;
use super::union_find::UnionFind;
use crate::RigError;
use thenar_core::Vec3;

/// Removes pieces filled less than `fill_min`, those that hang on by less than a face, and those
/// around nodes with less than `support_min` of the stiffness of their neighbours (`support`), and
/// gives their points to the nearest piece that stays, along links.
///
/// # Errors
/// When no piece is filled that far.
pub(super) fn prune(
    pieces: &mut Pieces,
    samples: &Samples,
    fill_min: f64,
    support_min: f64,
) -> Result<(), RigError> {
    let point_volume = samples.spacing.powi(3);
    let mut keep: Vec<bool> = pieces
        .counts
        .iter()
        .zip(&pieces.volumes)
        .map(|(&count, volume)| f64::from(count) * point_volume >= fill_min * volume)
        .collect();
    if !keep.contains(&true) {
        return Err(RigError::invalid(
            "the mesh is so thin that it fills no tetrahedron: a corner may lie far away, or more \
             tetrahedra are needed",
        ));
    }
    keep_largest_component(pieces, &mut keep);
    if support_min > 0.0 {
        leave_out_unsupported(pieces, point_volume, support_min, &mut keep);
    }
    reassign(pieces, samples, &keep);
    compact(pieces, &keep);
    Ok(())
}

/// Clears `keep` outside the face-connected component that holds most of the body.
pub(super) fn keep_largest_component(pieces: &Pieces, keep: &mut [bool]) {
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

/// Spreads the kept pieces over the points of the others, breadth first along links; returns how
/// many links were looked at: about those of each point twice, however far the pieces reach.
fn reassign(pieces: &mut Pieces, samples: &Samples, keep: &[bool]) -> usize {
    let lost = |pieces: &Pieces, i: u32| !keep[pieces.of_sample[i as usize] as usize];
    let mut looked_at = 0;
    // Points and the pieces they go to; of several the one along the last link counts.
    let mut moves: Vec<(u32, u32)> = Vec::new();
    for_each_link(samples, |i, j| {
        looked_at += 1;
        match (lost(pieces, i), lost(pieces, j)) {
            (true, false) => moves.push((i, pieces.of_sample[j as usize])),
            (false, true) => moves.push((j, pieces.of_sample[i as usize])),
            _ => {}
        }
    });
    while !moves.is_empty() {
        for &(i, piece) in &moves {
            pieces.of_sample[i as usize] = piece;
        }
        // Only beside what has just moved can anything follow.
        let mut front: Vec<u32> = moves.drain(..).map(|(i, _)| i).collect();
        front.sort_unstable();
        front.dedup();
        let mut links: Vec<(u32, usize, u32, u32)> = Vec::new();
        for i in front {
            let piece = pieces.of_sample[i as usize];
            for axis in 0..3 {
                looked_at += 2;
                if let Some(j) = samples.next(i as usize, axis).filter(|&j| lost(pieces, j)) {
                    links.push((i, axis, j, piece));
                }
                if let Some(j) = samples.previous(i as usize, axis).filter(|&j| lost(pieces, j)) {
                    links.push((j, axis, j, piece));
                }
            }
        }
        links.sort_unstable();
        moves.extend(links.into_iter().map(|(_, _, i, piece)| (i, piece)));
    }
    // What no link reaches (specks of the sampling) goes to the first kept piece near it.
    let kept = keep.iter().position(|&k| k).unwrap_or(0) as u32;
    for i in 0..samples.cells.len() as u32 {
        if lost(pieces, i) {
            let near = samples.near(&samples.position(i as usize), 2).find(|&j| !lost(pieces, j));
            pieces.of_sample[i as usize] = near.map_or(kept, |j| pieces.of_sample[j as usize]);
        }
    }
    looked_at
}

fn compact(pieces: &mut Pieces, keep: &[bool]) {
    let mut index = vec![u32::MAX; keep.len()];
    let mut count = 0;
    for t in (0..keep.len()).filter(|&t| keep[t]) {
        index[t] = count;
        pieces.keys[count as usize] = pieces.keys[t];
        pieces.volumes[count as usize] = pieces.volumes[t];
        pieces.nodes[count as usize] = pieces.nodes[t];
        count += 1;
    }
    pieces.keys.truncate(count as usize);
    pieces.volumes.truncate(count as usize);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::cells::Uniform;
    use crate::mesh::shapes;

    /// A bar of one piece at its end, and many behind it that are left out.
    fn bar(length: f64) -> (Samples, Pieces) {
        let mesh = shapes::cuboid(&Vec3::new(length, 0.01, 0.01));
        let samples = Samples::new(&mesh, 2e-3).unwrap();
        let pieces = Pieces::new(&samples, &Uniform { cube: 0.01, shift: Vec3::repeat(0.25) });
        (samples, pieces)
    }

    /// Removes the same links by looking at all of them again and again.
    fn by_rounds(pieces: &mut Pieces, samples: &Samples, keep: &[bool]) {
        let lost = |of: &[u32], i: u32| !keep[of[i as usize] as usize];
        loop {
            let mut moves = Vec::new();
            let of = &pieces.of_sample;
            for_each_link(samples, |i, j| match (lost(of, i), lost(of, j)) {
                (true, false) => moves.push((i, of[j as usize])),
                (false, true) => moves.push((j, of[i as usize])),
                _ => {}
            });
            if moves.is_empty() {
                return;
            }
            moves.into_iter().for_each(|(i, piece)| pieces.of_sample[i as usize] = piece);
        }
    }

    /// Two pieces in the middle are kept.
    #[test]
    fn points_go_to_the_piece_that_the_last_link_leads_to() {
        let (samples, mut pieces) = bar(0.05);
        let keep: Vec<bool> = (0..pieces.len()).map(|k| k == 40 || k == 41).collect();
        assert!(keep.len() > 100);
        let (_, mut expected) = bar(0.05);
        by_rounds(&mut expected, &samples, &keep);
        reassign(&mut pieces, &samples, &keep);
        assert_eq!(pieces.of_sample, expected.of_sample);
    }

    /// A point has three links to others behind it, and six in all.
    #[test]
    fn the_way_through_a_long_body_costs_no_more_than_its_points() {
        for length in [0.02, 0.2, 2.0] {
            let (samples, mut pieces) = bar(length);
            let keep: Vec<bool> = (0..pieces.len()).map(|k| k == 0).collect();
            let looked_at = reassign(&mut pieces, &samples, &keep);
            let points = samples.cells.len();
            assert!(points as f64 > 5e4 * length && looked_at <= 9 * points, "{looked_at}");
            assert!(pieces.of_sample.iter().all(|&piece| piece == 0));
        }
    }
}
