//! Goal: the files that a scene says it names are those that building it reads. Method: a scene
//! with every kind of file, against what its session has asked for.

use std::collections::BTreeSet;
use std::fs::write;
use std::path::Path;
use thenar_output::TemporaryFolder;
use thenar_scene::session::{Session, read};

/// A tetrahedron of 0.1 m, closed.
const OBJ: &str = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

const SCENE: &str = r#"
version = 1
[[rigid]]
name = "a"
mass = 1
position = [0, 1, 0]
shape = { kind = "mesh", file = "rigid.obj", grid = 8 }
[[rigid]]
name = "b"
mass = 1
position = [0, 2, 0]
[rigid.shape]
kind = "compound"
parts = [
    { shape = { kind = "sphere", radius = 0.01 } },
    { shape = { kind = "mesh", file = "part.obj", grid = 8 }, frame = { position = [0, 0.1, 0] } },
]
[[soft]]
name = "c"
position = [0, 3, 0]
shape = { kind = "mesh", file = "soft.obj", tets = 20 }
[[soft]]
name = "d"
position = [0, 4, 0]
shape = { kind = "tet-file", file = "tets.toml" }
[[hand]]
name = "e"
model = "HAND"
preset = "paper"
position = [0, 5, 0]
motion = { kind = "file", file = "keys.toml" }
[[hand]]
name = "f"
model = "left"
preset = "paper"
position = [0, 6, 0]
motion = { kind = "recorded", file = "RECORDED" }
"#;

#[test]
fn the_files_that_a_scene_names_are_those_that_are_read() {
    let folder = TemporaryFolder::new("thenar-named-files").unwrap();
    let put = |name: &str, text: &str| write(folder.path().join(name), text).unwrap();
    ["rigid.obj", "part.obj", "soft.obj"].into_iter().for_each(|name| put(name, OBJ));
    put("tets.toml", "nodes = [[0,0,0],[0.1,0,0],[0,0.1,0],[0,0,0.1]]\ntets = [[0,1,2,3]]\n");
    put("keys.toml", "[[key]]\ntime = 0\npose = \"rest\"\n");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let hand = root.join("crates/thenar-rig/assets/hands/right.glb").display().to_string();
    let recorded = root.join("crates/thenar-link/tests/data/hands.jsonl").display().to_string();
    let text = SCENE.replace("HAND", &hand).replace("RECORDED", &recorded);

    let scene = read(&text, &[]).unwrap();
    let named = scene.files();
    let session = Session::from_text(&text, &folder.path().join("s.toml"), &[]).unwrap();
    let asked: BTreeSet<&str> = session.files().keys().map(String::as_str).collect();
    assert_eq!(named, asked);
    assert_eq!(named.len(), 7);
    // Without them nothing is named.
    assert!(read("version = 1\n[[hand]]\nname = \"a\"\n", &[]).unwrap().files().is_empty());
}
