//! Every parser against damaged input: whatever the bytes, it returns a value or an error.
//!
//! Valid files are cut at every byte, have bits flipped, numbers replaced by extreme ones, parts
//! repeated, removed and mixed, in a seeded sequence. A panic fails the test, and so does an input
//! on which a parser takes longer than a second. The same parsers run under `cargo fuzz`, see
//! `fuzz/`.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};
use thenar::Vec3;
use thenar::model::EmbeddedSurface;
use thenar_rig::glb::{read_glb, read_skinned_glb};
use thenar_rig::mesh::{read_obj, read_stl, shapes, write_stl};
use thenar_rig::{Model, RigError, TriMesh};

/// A damaged copy is made this often per seed; longer seeds are cut only at so many bytes.
const ROUNDS: usize = 3000;
const SLOW: Duration = Duration::from_secs(1);

struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

const EXTREME_WORDS: [&[u8]; 10] = [
    b"-1",
    b"0",
    b"1e999",
    b"nan",
    b"inf",
    b"4294967295",
    b"-9223372036854775808",
    b"1e-320",
    b"99999999999999999999",
    b"",
];
const EXTREME_NUMBERS: [u32; 8] =
    [0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x7fc0_0000, 0x7f80_0000, 0x00ff_ffff];

/// One to four kinds of damage.
fn damaged(seed: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..1 + random.below(4) {
        let (n, at) = (bytes.len(), random.below(bytes.len()));
        match random.below(7) {
            0 => bytes.truncate(at),
            1 if n > 0 => bytes[at] ^= 1 << random.below(8),
            2 if n > 4 => {
                let at = at.min(n - 4) & !3;
                let number = EXTREME_NUMBERS[random.below(EXTREME_NUMBERS.len())];
                bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
            }
            3 => {
                let word = EXTREME_WORDS[random.below(EXTREME_WORDS.len())];
                let end = (at + random.below(6)).min(n);
                bytes.splice(at..end, word.iter().copied());
            }
            4 => {
                let end = (at + random.below(200)).min(n);
                let part = bytes[at..end].to_vec();
                bytes.splice(at..at, part);
            }
            5 => {
                let end = (at + random.below(200)).min(n);
                bytes.drain(at..end);
            }
            _ => {
                let from = random.below(other.len());
                let end = (from + random.below(200)).min(other.len());
                bytes.splice(at..at, other[from..end].iter().copied());
            }
        }
    }
    bytes
}

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
    let mut random = Random(0x5eed_0000_0000_0001);
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

fn obj(mesh: &TriMesh) -> Vec<u8> {
    let mut text = String::from("# a mesh\nmtllib none.mtl\no thing\n");
    for p in &mesh.positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.triangles {
        text += &format!("f {}/1/1 {}//2 {}\n", a + 1, b + 1, c + 1);
    }
    text.into_bytes()
}

fn ascii_stl(mesh: &TriMesh) -> Vec<u8> {
    let mut text = String::from("solid thing\n");
    for t in 0..mesh.triangles.len() {
        text += "facet normal 0 0 0\nouter loop\n";
        for p in mesh.corners(t) {
            text += &format!("vertex {} {} {}\n", p.x, p.y, p.z);
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid thing\n").into_bytes()
}

/// A GLB with one triangle, and one whose triangle is bound to a joint.
fn glb(skinned: bool) -> Vec<u8> {
    let mut blob: Vec<u8> = Vec::new();
    for x in [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        blob.extend(x.to_le_bytes());
    }
    for i in [0u16, 1, 2, 0] {
        blob.extend(i.to_le_bytes());
    }
    blob.extend([0u8; 12]); // joints
    for x in [1f32, 0.0, 0.0, 0.0].repeat(3) {
        blob.extend(x.to_le_bytes());
    }
    for i in 0..16 {
        blob.extend((if i % 5 == 0 { 1f32 } else { 0.0 }).to_le_bytes());
    }
    let skin = if skinned {
        (
            r#","JOINTS_0":2,"WEIGHTS_0":3"#,
            r#","skin":0"#,
            r#","skins":[{"joints":[1],"inverseBindMatrices":4}]"#,
        )
    } else {
        ("", "", "")
    };
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1]}}],"nodes":[{{"mesh":0{}}},{{"name":"wrist"}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0{}}},"indices":1}}]}}],"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},{{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}},{{"bufferView":2,"componentType":5121,"count":3,"type":"VEC4"}},{{"bufferView":3,"componentType":5126,"count":3,"type":"VEC4"}},{{"bufferView":4,"componentType":5126,"count":1,"type":"MAT4"}}],"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":8}},{{"buffer":0,"byteOffset":44,"byteLength":12}},{{"buffer":0,"byteOffset":56,"byteLength":48}},{{"buffer":0,"byteOffset":104,"byteLength":64}}],"buffers":[{{"byteLength":{}}}]{}}}"#,
        skin.1,
        skin.0,
        blob.len(),
        skin.2
    );
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + blob.len();
    let mut bytes = b"glTF".to_vec();
    for n in [2, total as u32, json.len() as u32] {
        bytes.extend(n.to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((blob.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(blob);
    bytes
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

#[test]
fn glb_endures() {
    endures("glb", ROUNDS, &[glb(false), glb(true)], read_glb);
    endures("skinned glb", ROUNDS, &[glb(true)], read_skinned_glb);
}

#[test]
fn the_model_file_endures() {
    // A real hand without its drawn surface, which is most of the file.
    let mut hand = thenar_rig::default_hand(thenar::model::Side::Right, 600).unwrap();
    hand.render = EmbeddedSurface::default();
    let bytes = Model::Hand(hand).to_bytes().unwrap();
    endures("model", 300, std::slice::from_ref(&bytes), Model::from_bytes);
    // Damage that the checksum does not catch.
    endures("sealed model", 300, &[bytes], |bytes| Model::from_bytes(&sealed(bytes)));
}

/// The bytes with length and checksum (FNV-1a) of the header made right.
fn sealed(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if let Some(body) = bytes.get(32..) {
        let step = |h: u64, &b: &u8| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3);
        let checksum = body.iter().fold(0xcbf2_9ce4_8422_2325_u64, step);
        let length = body.len() as u64;
        bytes[16..24].copy_from_slice(&length.to_le_bytes());
        bytes[24..32].copy_from_slice(&checksum.to_le_bytes());
    }
    bytes
}

#[test]
fn what_is_read_can_be_made_a_body_or_is_refused() {
    // Damaged meshes that parse go through the whole import; few, since each lays a grid.
    use thenar_rig::mesh::GridOptions;
    use thenar_rig::object::{ImportOptions, Weight, rigid_from_mesh};
    let seed = obj(&shapes::sphere(0.05, 2));
    let grid = GridOptions { cells: 10, values_max: 5000, ..GridOptions::default() };
    let options = ImportOptions { grid, points_max: 200, ..ImportOptions::default() };
    let mut random = Random(77);
    let mut built = 0;
    for round in 0..1000 {
        let bytes = damaged(&seed, &seed, &mut random);
        let Ok(mesh) = read_obj(&bytes) else { continue };
        let result = catch_unwind(AssertUnwindSafe(|| {
            rigid_from_mesh("x", &mesh, Weight::Density(1000.0), &options)
        }));
        match result {
            Err(_) => panic!("import panics in round {round}"),
            Ok(Ok((model, _))) => {
                assert!(model.mass.is_finite() && model.mass > 0.0);
                assert!(model.inertia.symmetric_eigenvalues().min() > 0.0);
                built += 1;
            }
            Ok(Err(error)) => assert!(!error.to_string().is_empty()),
        }
    }
    assert!(built > 60, "{built}");
}
