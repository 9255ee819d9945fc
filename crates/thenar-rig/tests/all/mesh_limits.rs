//! Files that say more than they hold or may: refused with the thing, the number and the bound.
//! Goal: a file of a few megabytes never costs gigabytes or minutes. Method: valid files, changed
//! in one place.

use crate::damage;
use serde_json::{Value, json};
use thenar_core::Vec3;
use thenar_core::model::{Law, Material};
use thenar_rig::TriMesh;
use thenar_rig::embed::{EmbedOptions, embed};
use thenar_rig::glb::{read_glb, read_skinned_glb};
use thenar_rig::mesh::{read_obj, shapes};
use thenar_rig::object::{SoftOptions, Weight, rigid_from_mesh, soft_from_tets};

/// The GLB with its text changed.
pub fn changed(glb: &[u8], change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let mut json: Value = serde_json::from_slice(&glb[20..20 + word(12)]).unwrap();
    change(&mut json);
    let mut text = serde_json::to_vec(&json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let rest = &glb[20 + word(12)..];
    let mut bytes = b"glTF".to_vec();
    for n in [2, 20 + text.len() + rest.len(), text.len()] {
        bytes.extend((n as u32).to_le_bytes());
    }
    [&bytes[..], b"JSON", &text, rest].concat()
}

fn refused(bytes: &[u8]) -> String {
    let error = read_glb(bytes).unwrap_err().to_string();
    assert_eq!(read_skinned_glb(bytes).unwrap_err().to_string(), error);
    error
}

#[test]
fn a_sparse_accessor_is_refused_also_where_nothing_uses_it() {
    let glb = damage::glb(true);
    assert!(read_glb(&changed(&glb, |_| {})).is_ok());
    let sparse = json!({
        "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
        "sparse": {
            "count": 1,
            "indices": { "bufferView": 1, "componentType": 5123 },
            "values": { "bufferView": 0 },
        },
    });
    let bytes = changed(&glb, |json| json["accessors"].as_array_mut().unwrap().push(sparse));
    assert_eq!(refused(&bytes), "accessor 5 is sparse, which is not supported");
}

#[test]
fn a_buffer_longer_than_its_chunk_is_refused() {
    let glb = damage::glb(true);
    let there = read_length(&glb);
    for more in [1, 1000, 1 << 40] {
        let bytes = changed(&glb, |json| json["buffers"][0]["byteLength"] = json!(there + more));
        let wanted = format!("buffer 0 says {} bytes, its binary chunk has {there}", there + more);
        assert_eq!(refused(&bytes), wanted);
    }
}

fn read_length(glb: &[u8]) -> u64 {
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap());
    u64::from(word(20 + word(12) as usize))
}

/// A mesh of 5000 triangles, named by its scene as often as a file of some kilobytes can.
#[test]
fn one_primitive_named_ten_thousand_times_is_refused() {
    let ball = shapes::sphere(0.05, 16);
    let count = ball.triangles.len();
    let surface = thenar_rig::export::GlbMesh {
        name: "ball",
        positions: &ball.positions,
        triangles: &ball.triangles,
        colour: [1.0; 3],
        skin: None,
    };
    let glb = thenar_rig::export::glb(&[surface], None).unwrap();
    let repeated = |n: usize| {
        changed(&glb, |json| {
            let list = json["meshes"][0]["primitives"].as_array_mut().unwrap();
            let one = list[0].clone();
            list.resize(n, one);
        })
    };
    assert_eq!(read_glb(&repeated(20)).unwrap().triangles.len(), 20 * count);
    let error = read_glb(&repeated(10_000)).unwrap_err().to_string();
    assert!(error.contains("at most 1000000"), "{error}");
}

/// Two bytes make a triangle of a polygon.
#[test]
fn a_polygon_without_end_is_refused() {
    let mut text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
    for _ in 0..20 {
        text += "f";
        text += &" 1 2 3".repeat(20_000);
        text += "\n";
    }
    let error = read_obj(text.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("at most 1000000"), "{error}");
}

/// Bodies of 1e-30 m and 1e30 m, and what lies so far away that nothing of it is resolved.
#[test]
fn bodies_beyond_sense_are_refused_whatever_they_are() {
    let gel = Material { law: Law::Corotational, young: 1e5, poisson: 0.3, density: 1000.0 };
    let cases =
        [(1e-30, 0.0), (1e-5, 0.0), (2e3, 0.0), (0.01, 1e5 + 5e5), (f64::MIN_POSITIVE, 0.0)];
    for (edge, away) in cases {
        let mut cube = shapes::cuboid(&Vec3::repeat(edge / 2.0));
        cube.positions.iter_mut().for_each(|p| p.y += away);
        let rigid = rigid_from_mesh("x", &cube, Weight::Mass(1.0), &Default::default());
        let soft = embed(&cube, &EmbedOptions::default(), |_| gel);
        let nodes =
            vec![Vec3::y() * away, Vec3::new(edge, away, 0.0), Vec3::new(0.0, away + edge, 0.0)];
        let nodes = [nodes, vec![Vec3::new(0.0, away, edge)]].concat();
        let tets =
            soft_from_tets("x", nodes, vec![[0, 1, 2, 3]], vec![gel], &SoftOptions::default());
        let errors = [rigid.err(), soft.err(), tets.err()].map(|e| e.unwrap().to_string());
        for error in errors {
            let named =
                error.contains("m long, outside 1e-4 to 1e3 m") || error.contains("times its size");
            assert!(named, "{edge} at {away}: {error}");
        }
    }
}

/// A closed box of one piece whose sides fold to and fro across it: rays would cross it thousands
/// of times.
#[test]
fn a_folded_surface_is_refused_before_it_is_sampled() {
    let mut mesh = TriMesh::default();
    let layers = 20_000_u32;
    for i in 0..layers {
        let y = if i % 2 == 0 { -0.05 } else { 0.05 } + 1e-7 * f64::from(i);
        let corners = [(-0.05, -0.05), (0.05, -0.05), (0.05, 0.05), (-0.05, 0.05)];
        mesh.positions.extend(corners.map(|(x, z)| Vec3::new(x * (1.0 + y), y, z)));
    }
    for i in 0..layers - 1 {
        for k in 0..4 {
            let (a, b) = (4 * i + k, 4 * i + (k + 1) % 4);
            mesh.triangles.extend([[b, a, a + 4], [b, a + 4, b + 4]]);
        }
    }
    let top = 4 * (layers - 1);
    mesh.triangles.extend([[0, 1, 2], [0, 2, 3], [top, top + 2, top + 1], [top, top + 3, top + 2]]);
    let gel = Material { law: Law::Corotational, young: 1e5, poisson: 0.3, density: 1000.0 };
    let _ = mesh.orient();
    let options = EmbedOptions { tets: 20_000, ..EmbedOptions::default() };
    let error = embed(&mesh, &options, |_| gel).err().unwrap().to_string();
    assert!(error.contains("would take") || error.contains("encloses"), "{error}");
}
