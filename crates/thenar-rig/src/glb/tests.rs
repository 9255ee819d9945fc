//! Goal: the shipped hands read whole; damaged files give errors. Method: the files themselves,
//! cut and altered.

use super::*;
use thenar_core::random::Random;

const RIGHT: &[u8] = include_bytes!("../../assets/hands/right.glb");

#[test]
fn the_shipped_hand_reads() {
    let hand = read_skinned_glb(RIGHT).unwrap();
    assert_eq!(hand.mesh.positions.len(), 1360);
    assert_eq!(hand.mesh.triangles.len(), 2314);
    assert_eq!(hand.joints.len(), 25);
    for weights in &hand.influences {
        assert!((weights.iter().map(|w| w.1).sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_static_read_gives_the_same_triangles() {
    let mesh = read_glb(RIGHT).unwrap();
    assert_eq!(mesh.triangles, read_skinned_glb(RIGHT).unwrap().mesh.triangles);
}

#[test]
fn every_truncation_is_an_error() {
    // Every length inside the JSON chunk's first kilobyte, then a coarser sweep.
    for n in (0..1024).chain((1024..RIGHT.len()).step_by(997)) {
        assert!(read_skinned_glb(&RIGHT[..n]).is_err(), "{n} bytes were accepted");
    }
}

#[test]
fn altered_bytes_never_panic() {
    // Random places and values, mostly in the JSON chunk.
    let mut random = Random::new(1);
    for _ in 0..400 {
        let mut bytes = RIGHT.to_vec();
        for _ in 0..=random.below(4) {
            let most = if random.below(4) == 0 { bytes.len() } else { 9000 };
            let at = random.below(most);
            let digit = b'0' + random.below(10) as u8;
            bytes[at] = if random.below(2) == 0 { digit } else { random.bits() as u8 };
        }
        let _ = read_skinned_glb(&bytes);
        let _ = read_glb(&bytes);
    }
}

/// The shipped file with one piece of its JSON replaced by another of the same length.
fn with_json(from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let at = RIGHT.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
    let mut bytes = RIGHT.to_vec();
    bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
    bytes
}

#[test]
fn too_large_a_count_names_the_accessor() {
    let bytes = with_json("\"count\":1360", "\"count\":9999");
    let error = read_glb(&bytes).unwrap_err().to_string();
    assert!(error.contains("POSITION") && error.contains("9999"), "{error}");
}

#[test]
fn a_node_inside_itself_is_an_error() {
    let bytes = with_json("\"children\":[25,0,", "\"children\":[26,0,");
    let error = read_glb(&bytes).unwrap_err().to_string();
    assert!(error.contains("own ancestor"), "{error}");
}
