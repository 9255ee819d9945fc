//! Every parser against damaged input: whatever the bytes, it returns a value or an error.
//!
//! Valid files are cut at every byte, have bits flipped, numbers replaced by extreme ones, parts
//! repeated, removed and mixed, in a seeded sequence. A panic fails the test, and so does an input
//! on which a parser takes longer than a second. The same parsers run under `cargo fuzz`, see
//! `fuzz/`.

use crate::bodies::sealed;
use crate::damage::{ascii_stl, glb, obj};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};
use thenar_core::Vec3;
use thenar_core::model::EmbeddedSurface;
use thenar_core::random::Random;
use thenar_rig::glb::{read_glb, read_skinned_glb};
use thenar_rig::mesh::{read_obj, read_off, read_ply, read_stl, shapes, write_stl};
use thenar_rig::{Model, RigError};
use thenar_testing::damaged;

/// A damaged copy is made this often per seed; longer seeds are cut only at so many bytes.
const ROUNDS: usize = 3000;
const SLOW: Duration = Duration::from_secs(1);

/// Runs `parse` on every damaged form of the seeds; seeds themselves must be read.
fn endures<T>(
    name: &str,
    rounds: usize,
    seeds: &[Vec<u8>],
    parse: impl Fn(&[u8]) -> Result<T, RigError>,
) {
    let run = |bytes: &[u8], what: &str| -> bool {
        let start = Instant::now();
        let result = catch_unwind(AssertUnwindSafe(|| parse(bytes).map_err(|e| e.to_string())));
        let path = || {
            let path = std::env::temp_dir().join(format!("thenar-fuzz-{name}"));
            std::fs::write(&path, bytes).map(|()| path)
        };
        match result {
            Err(_) => panic!("{name} panics on {what}; the input is in {:?}", path()),
            Ok(_) if start.elapsed() > SLOW => panic!("{name} is slow on {what}: {:?}", path()),
            Ok(Err(message)) => {
                assert!(!message.trim().is_empty());
                false
            }
            Ok(Ok(_)) => true,
        }
    };
    let mut random = Random::new(0x5eed_0000_0000_0001);
    for (i, seed) in seeds.iter().enumerate() {
        assert!(run(seed, &format!("seed {i}")), "seed {i} of {name} is not read");
        for cut in (0..seed.len()).step_by(seed.len().div_ceil(rounds)) {
            run(&seed[..cut], &format!("seed {i} cut at byte {cut}"));
        }
        let other = &seeds[(i + 1) % seeds.len()];
        for round in 0..rounds {
            run(&damaged(seed, other, &mut random), &format!("seed {i}, round {round}"));
        }
    }
    assert!(!run(b"", "nothing"), "{name} reads nothing as something");
    run(&[0xff; 4096], "4096 bytes of 255");
}

#[test]
fn obj_endures() {
    let quad = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\n".to_vec();
    endures("obj", ROUNDS, &[obj(&shapes::cuboid(&Vec3::repeat(1.0))), quad], read_obj);
}

#[test]
fn stl_endures() {
    let cube = shapes::cuboid(&Vec3::repeat(1.0));
    endures("stl", ROUNDS, &[write_stl(&cube), ascii_stl(&cube)], read_stl);
}

/// A tetrahedron's corners, and its faces.
const CORNERS: &str = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
const FACES: &str = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

#[test]
fn off_endures() {
    let seeds =
        ["OFF\n4 4 6\n", "COFF 4 4 0\n"].map(|head| format!("{head}{CORNERS}{FACES}").into_bytes());
    endures("off", ROUNDS, &seeds, read_off);
}

#[test]
fn ply_endures() {
    let head = |encoding: &str| {
        format!(
            "ply\nformat {encoding} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             element face 4\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let text = format!("{}{CORNERS}{FACES}", head("ascii")).into_bytes();
    let numbers =
        |text: &str| -> Vec<f32> { text.split_whitespace().map(|w| w.parse().unwrap()).collect() };
    let mut binary = head("binary_little_endian").into_bytes();
    numbers(CORNERS).iter().for_each(|x| binary.extend(x.to_le_bytes()));
    for face in numbers(FACES).chunks(4) {
        binary.push(3);
        face[1..].iter().for_each(|v| binary.extend((*v as i32).to_le_bytes()));
    }
    endures("ply", ROUNDS, &[text, binary], read_ply);
}

#[test]
fn glb_endures() {
    endures("glb", ROUNDS, &[glb(false), glb(true)], read_glb);
    endures("skinned glb", ROUNDS, &[glb(true)], read_skinned_glb);
}

#[test]
fn the_model_file_endures() {
    // A real hand without its drawn surface, which is most of the file.
    let mut hand = thenar_rig::uniform_hand(thenar_core::model::Side::Right, 600).unwrap();
    hand.render = EmbeddedSurface::default();
    let bytes = Model::Hand(hand).to_bytes().unwrap();
    endures("model", 300, std::slice::from_ref(&bytes), Model::from_bytes);
    // Damage that the checksum does not catch.
    endures("sealed model", 300, &[bytes], |bytes| Model::from_bytes(&sealed(bytes)));
}
