//! Every builder against damaged files, from the bytes to the simulated step: whatever a file says,
//! a body is made of it and moves, or it is refused with a message.
//!
//! Good files are damaged in a seeded sequence, in their bytes and, for meshes, in what the bytes
//! mean. The same code runs under `cargo fuzz`, see `fuzz/`.

use crate::bodies;
use crate::damage::{ascii_stl, glb, obj};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::OnceLock;
use thenar_core::Vec3;
use thenar_core::random::Random;
use thenar_rig::hand::asset;
use thenar_rig::mesh::{shapes, write_stl};
use thenar_rig::{Model, RigError, TriMesh};
use thenar_testing::damaged;

/// Makes a body of every damaged form of the seeds; returns how many were made and moved.
fn endures(
    name: &str,
    rounds: usize,
    seeds: &[Vec<u8>],
    build: impl Fn(&[u8]) -> Result<bool, RigError>,
) -> usize {
    let mut random = Random::new(0x5eed_0000_0000_0002);
    let mut moved = 0;
    for (i, seed) in seeds.iter().enumerate() {
        assert!(build(seed).unwrap(), "{name}: seed {i} moves");
        for round in 0..rounds {
            let other = &seeds[(i + round) % seeds.len()];
            let bytes = damaged(seed, other, &mut random);
            match catch_unwind(AssertUnwindSafe(|| build(&bytes))) {
                Err(_) => {
                    let path = std::env::temp_dir().join(format!("thenar-fuzz-{name}"));
                    let kept = std::fs::write(&path, &bytes).map(|()| path);
                    panic!("{name} panics on seed {i}, round {round}; the input is in {kept:?}");
                }
                Ok(Ok(true)) => moved += 1,
                Ok(Ok(false)) => {}
                Ok(Err(error)) => assert!(!error.to_string().trim().is_empty()),
            }
        }
    }
    moved
}

fn hand() -> &'static [u8] {
    static HAND: OnceLock<Vec<u8>> = OnceLock::new();
    HAND.get_or_init(|| bodies::small_hand().unwrap())
}

/// A file whose bytes from `at` on are replaced.
fn with(bytes: &[u8], at: usize, new: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[at..at + new.len()].copy_from_slice(new);
    bytes
}

/// Where a GLB's view of `what` begins, and its bytes: `indices`, or an attribute.
fn view(glb: &[u8], what: &str) -> (usize, usize) {
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let text: serde_json::Value = serde_json::from_slice(&glb[20..20 + word(12)]).unwrap();
    let primitive = &text["meshes"][0]["primitives"][0];
    let accessor = match what {
        "indices" => &primitive["indices"],
        attribute => &primitive["attributes"][attribute],
    };
    let accessor = &text["accessors"][accessor.as_u64().unwrap() as usize];
    let view = &text["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let number = |key: &str| view[key].as_u64().unwrap_or(0) as usize;
    (28 + word(12) + number("byteOffset"), number("byteLength"))
}

#[test]
fn rigid_bodies_endure() {
    let ball = shapes::sphere(0.05, 2);
    let cube = shapes::cuboid(&Vec3::repeat(0.02));
    let seeds = [obj(&ball), write_stl(&cube), ascii_stl(&cube), glb(false)];
    let moved = endures("rigid", 250, &seeds, bodies::rigid);
    assert!(moved > 60, "{moved}");
}

#[test]
fn soft_bodies_endure() {
    let ball = shapes::sphere(0.05, 2);
    let cube = shapes::cuboid(&Vec3::repeat(0.02));
    let moved = endures("soft", 250, &[obj(&ball), write_stl(&cube), obj(&cube)], bodies::soft);
    assert!(moved > 12, "{moved}");
}

#[test]
fn model_files_endure() {
    let seeds = [obj(&shapes::sphere(0.05, 2)), hand().to_vec()].map(|bytes| {
        let model = match bytes.starts_with(b"glTF") {
            false => bodies::rigid_model(&bytes).map(Model::Rigid),
            true => bodies::hand_model(&bytes).map(Model::Hand),
        };
        model.unwrap().to_bytes().unwrap()
    });
    let moved = endures("model", 200, &seeds, bodies::model);
    assert!(moved > 20, "{moved}");
}

#[test]
fn hands_endure() {
    endures("hand", 60, &[hand().to_vec()], bodies::hand);
    // The text before them stays as it is: places, corners and joints alone.
    let (head, numbers) = hand().split_at(view(hand(), "POSITION").0);
    let whole = |bytes: &[u8]| {
        let mut bytes = [head, bytes].concat();
        bytes.resize(hand().len(), 0);
        bodies::hand(&bytes)
    };
    let moved = endures("hand's numbers", 60, &[numbers.to_vec()], whole);
    assert!(moved > 1, "{moved}");
}

/// Triangles without extent, vertices all at one place, all in one plane, all on a line.
#[test]
fn a_hand_without_a_surface_is_refused() {
    for glb in [hand(), asset(thenar_core::model::Side::Left)] {
        let (indices, length) = view(glb, "indices");
        let refused = |bytes: &[u8]| bodies::hand(bytes).unwrap_err().to_string();
        let error = refused(&with(glb, indices, &vec![0; length]));
        assert_eq!(error, "all triangles of the hand's surface are without extent");
        // One triangle, again and again.
        let one: Vec<u8> = glb[indices..indices + length / 3 * 3].to_vec();
        let size = one.len() / 3;
        assert!(size > 0);
        let first = &one[..12.min(length)];
        let again: Vec<u8> = first.iter().copied().cycle().take(length / 12 * 12).collect();
        refused(&with(glb, indices, &again));
        let (places, length) = view(glb, "POSITION");
        refused(&with(glb, places, &vec![0; length]));
        for flat in 1..7_usize {
            let mut bytes = glb.to_vec();
            for (k, word) in bytes[places..places + length].chunks_exact_mut(4).enumerate() {
                if flat >> (k % 3) & 1 == 1 {
                    word.fill(0);
                }
            }
            refused(&bytes);
        }
    }
}

/// Meshes damaged in what they mean: corners swapped, moved onto others, far away, onto a plane;
/// triangles left out, repeated, turned over.
#[test]
fn crooked_meshes_endure() {
    let mut random = Random::new(0x5eed_0000_0000_0003);
    let (mut rigid, mut soft) = (0, 0);
    for round in 0..300 {
        let mut mesh = match round % 3 {
            0 => shapes::sphere(0.05, 2),
            1 => shapes::cuboid(&Vec3::new(0.01, 0.03, 0.05)),
            _ => shapes::capsule(0.02, 0.02, 7),
        };
        for _ in 0..1 + random.below(4) {
            crooked(&mut mesh, &mut random);
        }
        let bytes = obj(&mesh);
        let made = |build: fn(&[u8]) -> Result<bool, RigError>| {
            catch_unwind(|| build(&bytes)).unwrap_or_else(|_| {
                panic!("round {round}: {}", String::from_utf8_lossy(&bytes));
            })
        };
        rigid += usize::from(matches!(made(bodies::rigid), Ok(true)));
        soft += usize::from(matches!(made(bodies::soft), Ok(true)));
    }
    assert!(rigid > 150 && soft > 5, "{rigid} {soft}");
}

/// One corner of a ball far away leaves a spike; where it fills no tetrahedron, the body is
/// refused.
#[test]
fn spikes_endure() {
    let ball = shapes::sphere(0.05, 2);
    for corner in 0..ball.positions.len() {
        for far in [0.2, 80.0, 822.66] {
            let mut mesh = ball.clone();
            mesh.positions[corner] = mesh.positions[corner].normalize() * far;
            catch_unwind(|| bodies::soft(&obj(&mesh)))
                .unwrap_or_else(|_| panic!("corner {corner} at {far} m"))
                .ok();
        }
    }
    let thin = bodies::soft(include_bytes!("../../../../fuzz/seeds/soft/spike.obj"));
    let told = thin.unwrap_err().to_string();
    assert!(told.contains("fills no tetrahedron"), "{told}");
}

fn crooked(mesh: &mut TriMesh, random: &mut Random) {
    let (t, v) = (random.below(mesh.triangles.len()), random.below(mesh.positions.len()));
    let w = random.below(mesh.positions.len());
    if mesh.triangles.is_empty() {
        return;
    }
    match random.below(10) {
        0 => mesh.triangles[t].swap(0, 1),
        1 => mesh.triangles[t][random.below(3)] = w as u32,
        2 => mesh.positions[v] = mesh.positions[w],
        3 => mesh.positions[v] *= 1e3,
        4 => mesh.positions.iter_mut().for_each(|p| p.y = 0.0),
        5 => drop(mesh.triangles.remove(t)),
        6 => mesh.triangles.push(mesh.triangles[t]),
        7 => mesh.positions.iter_mut().for_each(|p| *p *= 1e-9),
        8 => mesh.positions.iter_mut().for_each(|p| p.x += 1e5),
        _ => {
            let copy = mesh.clone();
            mesh.append(&copy);
        }
    }
}
