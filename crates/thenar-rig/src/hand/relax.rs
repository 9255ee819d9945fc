//! Evening out weights where a fist would turn elements inside out.
//!
//! A node's binding is a place on its digit's chain of bones: `s` in 0..3, from the palm (0) over
//! the first moving bone (1) to the last (3); in between two adjacent bones share it. Nodes of
//! elements that a fist made by skinning would invert take, step by step, the mean place of their
//! neighbours. Nothing else changes, and two adjacent bones remain the most that a node has.

use super::fist::{inverted, pose};
use crate::RigError;
use crate::weights::pair;
use crate::work::Stage;
use thenar_core::model::{Binding, Digit, HandModel};

/// Rounds of evening out; most elements that can be saved are after a dozen.
const ROUNDS: usize = 24;
/// Degrees of the hand's closing at which elements are looked at.
const CLOSINGS: [f64; 3] = [0.5, 0.75, 1.0];
/// Comparisons of a point with a triangle that take as long as to skin and measure a tetrahedron,
/// about.
const TET: usize = 4;
/// Part of the way to the neighbours' mean in one round.
const STEP: f64 = 0.5;

/// Bones of the chain of digit `d`, root first.
fn chain(d: usize) -> [u32; 4] {
    let first = 1 + 3 * d as u32;
    [0, first, first + 1, first + 2]
}

/// A node's digit (none: palm alone) and place on its chain.
type Place = (Option<usize>, f64);

/// Evens out the bindings of a hand; stops early when a full fist inverts nothing.
///
/// # Errors
/// When the model's joints do not make a tree.
pub(super) fn relax(hand: &mut HandModel) -> Result<(), RigError> {
    let work = (TET * ROUNDS * CLOSINGS.len() * hand.flesh.tets.len()) as f64;
    let stage =
        Stage::new("closing the hand", ROUNDS * CLOSINGS.len(), work, "ask for fewer tetrahedra")?;
    let neighbours = neighbours(hand);
    let poses = CLOSINGS.map(|closing| pose(hand, closing));
    let poses = poses.into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut places: Vec<Place> = hand.bindings.iter().map(place).collect();
    for round in 0..ROUNDS {
        let mut touched = vec![false; places.len()];
        for (k, pose) in poses.iter().enumerate() {
            stage.at(round * CLOSINGS.len() + k)?;
            for t in inverted(hand, pose) {
                hand.flesh.tets[t].iter().for_each(|&n| touched[n as usize] = true);
            }
        }
        if !touched.contains(&true) {
            break;
        }
        let before = places.clone();
        for n in (0..places.len()).filter(|&n| touched[n]) {
            places[n] = moved(&before, n, &neighbours[n]);
            hand.bindings[n] = binding(&places[n]);
        }
    }
    Ok(())
}

/// The place of node `n` after a step towards the mean of its neighbours.
fn moved(places: &[Place], n: usize, neighbours: &[u32]) -> Place {
    let (digit, s) = places[n];
    // A node of the palm alone follows the digit that most of its neighbours follow, if any.
    let digit = digit.or_else(|| {
        let mut sums = [0.0; 5];
        for &m in neighbours {
            if let (Some(d), s) = places[m as usize] {
                sums[d] += s;
            }
        }
        (0..5).filter(|&d| sums[d] > 0.0).max_by(|&a, &b| sums[a].total_cmp(&sums[b]))
    });
    let Some(d) = digit else { return (None, 0.0) };
    let mean = neighbours.iter().map(|&m| seen_from(d, &places[m as usize])).sum::<f64>()
        / neighbours.len().max(1) as f64;
    (digit, s + STEP * (mean - s))
}

/// Place on the chain of digit `d` that stands for another node's. Fingers bend alike, so a
/// finger's place is taken as it is on another finger, up to the web; the thumb goes its own way.
fn seen_from(d: usize, place: &Place) -> f64 {
    let thumb = Digit::FINGERS.iter().position(|&f| f == Digit::Thumb);
    match place.0 {
        Some(other) if other == d => place.1,
        Some(other) if Some(other) != thumb && Some(d) != thumb => place.1.min(1.0),
        _ => 0.0,
    }
}

fn place(binding: &Binding) -> Place {
    let on_chain = |bone: u32| if bone == 0 { 0.0 } else { f64::from((bone - 1) % 3 + 1) };
    let digit = binding.bones.iter().find(|&&b| b > 0).map(|&b| (b as usize - 1) / 3);
    let s = (0..2).map(|k| binding.weights[k] * on_chain(binding.bones[k])).sum();
    (digit, s)
}

fn binding(&(digit, s): &Place) -> Binding {
    let Some(d) = digit else { return pair(0, 0, 0.0) };
    let chain = chain(d);
    let k = (s.floor().max(0.0) as usize).min(2);
    pair(chain[k], chain[k + 1], s - k as f64)
}

/// The nodes that share an edge with each node, in ascending order.
fn neighbours(hand: &HandModel) -> Vec<Vec<u32>> {
    let mut neighbours = vec![Vec::new(); hand.flesh.nodes.len()];
    for nodes in &hand.flesh.tets {
        for &n in nodes {
            neighbours[n as usize].extend(nodes.iter().filter(|&&m| m != n));
        }
    }
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
    }
    neighbours
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_on_the_chain_says_the_same_as_a_binding() {
        for d in 0..5 {
            for i in 0..=30 {
                let s = f64::from(i) / 10.0;
                let (digit, back) = place(&binding(&(Some(d), s)));
                assert!((back - s).abs() < 1e-12);
                assert!(digit == Some(d) || s == 0.0);
            }
        }
    }
}
