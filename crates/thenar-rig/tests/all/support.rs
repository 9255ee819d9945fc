//! Goal: no node of a graded hand hangs in the air. Method: the stiffness of every node, of flesh
//! that is as stiff over joints as elsewhere, is compared with that of the nodes around it, and its
//! displacement under the loads that skin brings to it with theirs.

use thenar_core::Vec3;
use thenar_core::model::{HandModel, Side};
use thenar_rig::hand::{HandOptions, Size, Springs, asset, build_hand};
use thenar_rig::lattice::tet;

fn hand(side: Side, detail: f64, length: f64) -> HandModel {
    let options = HandOptions {
        detail: Some(detail),
        size: Size::Length(length),
        joint_softness: 1.0,
        root_softness: 1.0,
        springs: Springs::Fixed,
        ..HandOptions::touch()
    };
    build_hand(asset(side), &options).unwrap()
}

/// `E V |∇N|²` summed over the elements of each node \[N/m\], a multiple of its stiffness's trace;
/// and the nodes around each.
fn stiffness(hand: &HandModel) -> (Vec<f64>, Vec<Vec<usize>>) {
    let flesh = &hand.flesh;
    let mut stiffness = vec![0.0; flesh.nodes.len()];
    let mut around = vec![Vec::new(); flesh.nodes.len()];
    for (nodes, material) in flesh.tets.iter().zip(&flesh.materials) {
        let x = nodes.map(|n| flesh.nodes[n as usize]);
        let volume = tet::volume(&x);
        for k in 0..4 {
            // The gradient is the opposite face's normal over the height on it.
            let [a, b, c] = [1, 2, 3].map(|step| x[(k + step) % 4]);
            let gradient: Vec3 = (b - a).cross(&(c - a)) / (6.0 * volume);
            stiffness[nodes[k] as usize] += material.young * volume * gradient.norm_squared();
            around[nodes[k] as usize].extend(nodes.iter().map(|&n| n as usize));
        }
    }
    for (n, around) in around.iter_mut().enumerate() {
        around.sort_unstable();
        around.dedup();
        around.retain(|&m| m != n);
    }
    (stiffness, around)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = values.collect();
    all.iter().sum::<f64>() / all.len() as f64
}

fn check(side: Side, detail: f64, length: f64) {
    let hand = hand(side, detail, length);
    let (stiffness, around) = stiffness(&hand);
    let ratio = |n: usize| stiffness[n] / mean(around[n].iter().map(|&m| stiffness[m]));
    let least = (0..stiffness.len()).map(ratio).fold(f64::INFINITY, f64::min);
    println!("{side:?}, {detail}, {length} m: {least} of the stiffness around a node");

    // A load of 1 N on a vertex of the skin moves a node by its weight over its stiffness, were all
    // others held; and the vertex by the sum of these times the weights.
    let mut furthest = 0.0_f64;
    for vertex in &hand.flesh.collision.vertices {
        let nodes = hand.flesh.tets[vertex.tet as usize].map(|n| n as usize);
        let moved = [0, 1, 2, 3].map(|k| vertex.weights[k] / stiffness[nodes[k]]);
        let skin: f64 = moved.iter().zip(vertex.weights).map(|(u, w)| u * w).sum();
        furthest = moved.iter().fold(furthest, |most, u| most.max(u.abs() / skin));
    }
    println!("  a node goes {furthest} times as far as the skin that is pushed");
    assert!(least > 0.09, "{side:?}, {detail}, {length} m: {least}");
    assert!(furthest < 5.0, "{side:?}, {detail}, {length} m: {furthest}");
}

/// A node at the corner of a block of full elements has an eighth of the stiffness of those inside.
/// Of two nodes, one of a tenth of the other's stiffness, the load that moves it most has w = 0.3
/// at it: 2.2 times as far as the skin; other corners and places beside the elements add to that.
#[test]
fn no_node_hangs_in_the_air() {
    for side in [Side::Right, Side::Left] {
        for (detail, length) in [(0.3, 0.19), (0.6, 0.19), (0.6, 0.06), (1.0, 0.19)] {
            check(side, detail, length);
        }
    }
}
