//! Goal: of a file of several skinned meshes, as avatars are, the body is taken, by rule or by
//! name, and what is wrong with a rig is said with its place and what helps. Method: boxes and
//! balls on two joints, written as GLB; expected sizes are those of the boxes.

use crate::mesh_limits::changed;
use serde_json::json;
use thenar_core::{Pose, Quat, Vec3};
use thenar_rig::TriMesh;
use thenar_rig::export::{GlbMesh, Skeleton, VertexSkin, glb};
use thenar_rig::figure::{FigureOptions, build_figure, read_glb_plan, read_glb_plan_of};
use thenar_rig::glb::{read_glb, read_skinned_glb, read_skinned_glb_of};
use thenar_rig::mesh::shapes;

fn at(mesh: TriMesh, x: f64, y: f64) -> TriMesh {
    mesh.transformed(&Pose::translation(x, y, 0.0))
}

/// A box of 0.4 by 1.6 by 0.4 m.
fn body() -> TriMesh {
    shapes::cuboid(&Vec3::new(0.2, 0.8, 0.2))
}

/// An eye before the body, and hair that is wider and of more area and encloses nothing.
fn avatar() -> Vec<(&'static str, TriMesh)> {
    let eye = at(shapes::sphere(0.02, 3), 0.0, 0.7);
    let mut hair = shapes::cuboid(&Vec3::new(2.0, 1.0, 1.0));
    let places = hair.positions.clone();
    hair.triangles.retain(|t| t.iter().all(|&v| places[v as usize].y > 0.9));
    vec![("eye", eye), ("hair", hair.compacted()), ("body", body())]
}

/// Meshes on two joints, at y = -0.6 and 0: vertices below 0 are the first one's.
fn file(meshes: &[(&str, TriMesh)], joints: [Vec3; 2]) -> Vec<u8> {
    file_of(meshes, joints, [1.0, 0.0, 0.0, 0.0])
}

fn file_of(meshes: &[(&str, TriMesh)], joints: [Vec3; 2], weights: [f32; 4]) -> Vec<u8> {
    let skeleton = Skeleton {
        names: vec!["hips", "chest"],
        parents: vec![None, Some(0)],
        poses: joints.map(|p| Pose::new(p, Quat::identity())).to_vec(),
    };
    let skins: Vec<Vec<VertexSkin>> = meshes
        .iter()
        .map(|(_, mesh)| {
            let bone = |p: &Vec3| u16::from(p.y > 0.0);
            let of = |p: &Vec3| VertexSkin { bones: [bone(p), 0, 0, 0], weights };
            mesh.positions.iter().map(of).collect()
        })
        .collect();
    let written: Vec<GlbMesh> = meshes
        .iter()
        .zip(&skins)
        .map(|((name, mesh), skin)| GlbMesh {
            name,
            positions: &mesh.positions,
            triangles: &mesh.triangles,
            colour: [0.8; 3],
            skin: Some(skin),
        })
        .collect();
    glb(&written, Some(&skeleton)).unwrap()
}

const JOINTS: [Vec3; 2] = [Vec3::new(0.0, -0.6, 0.0), Vec3::new(0.0, 0.0, 0.0)];

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| name.to_string()).collect()
}

fn options() -> FigureOptions {
    FigureOptions {
        tets: 200,
        render_triangles: 600,
        collision_triangles: 300,
        ..FigureOptions::default()
    }
}

#[test]
fn the_mesh_that_encloses_most_is_the_body() {
    let bytes = file(&avatar(), JOINTS);
    let rig = read_skinned_glb(&bytes).unwrap();
    let told: Vec<(&str, bool)> = rig.parts.iter().map(|p| (&p.name[..], p.chosen)).collect();
    assert_eq!(told, [("eye", false), ("hair", false), ("body", true)]);
    assert!((rig.parts[2].volume - 0.4 * 1.6 * 0.4).abs() < 1e-6, "{:?}", rig.parts[2]);
    assert!(rig.parts[1].volume < 1e-9 && (rig.parts[1].size.x - 4.0).abs() < 1e-6);
    assert_eq!(rig.mesh.triangles, body().triangles);

    let (figure, report) = build_figure(read_glb_plan(&bytes).unwrap(), &options()).unwrap();
    let size = report.bounds[1] - report.bounds[0];
    assert!((size - Vec3::new(0.4, 1.6, 0.4)).norm() < 1e-5, "{size}");
    assert_eq!(figure.bones.len(), 2);
    let notes = report.notes.join("\n");
    for part in
        ["body: \"body\" (400.00 mm x 1.600 m x 400.00 mm)", "left out: \"eye\" (", "--mesh"]
    {
        assert!(notes.contains(part), "{notes}");
    }
}

#[test]
fn meshes_are_taken_by_name() {
    let bytes = file(&avatar(), JOINTS);
    let eye = read_skinned_glb_of(&bytes, &names(&["eye"])).unwrap();
    assert_eq!(eye.mesh.triangles.len(), shapes::sphere(0.02, 3).triangles.len());
    let both = read_skinned_glb_of(&bytes, &names(&["body", "eye"])).unwrap();
    assert_eq!(both.mesh.triangles.len(), 12 + eye.mesh.triangles.len());
    assert_eq!(both.influences.len(), both.mesh.positions.len());
    let error = read_skinned_glb_of(&bytes, &names(&["skirt"])).unwrap_err().to_string();
    assert!(error.contains("\"skirt\"; it has \"eye\", \"hair\", \"body\""), "{error}");
}

/// An eye whose triangles name vertices that are not there might have been the body: the file is
/// refused until another mesh is named; the eye is then left out, which is reported.
#[test]
fn a_damaged_mesh_asks_for_the_name_of_the_body() {
    let damaged = |of: &[usize]| {
        changed(&file(&avatar(), JOINTS), |json| {
            let hair = json["meshes"][1]["primitives"][0]["attributes"]["POSITION"].clone();
            of.iter().for_each(|&k| {
                json["meshes"][k]["primitives"][0]["attributes"]["POSITION"] = hair.clone();
            });
        })
    };
    let bytes = damaged(&[0]);
    let error = read_skinned_glb(&bytes).unwrap_err().to_string();
    assert!(error.contains("mesh \"eye\": ") && error.contains("name it"), "{error}");
    assert!(error.ends_with("\"hair\", \"body\""), "{error}");
    let rig = read_skinned_glb_of(&bytes, &names(&["body"])).unwrap();
    assert_eq!(rig.mesh.triangles, body().triangles);
    let damage = rig.parts[0].damage.as_deref().unwrap();
    assert!(damage.contains("names vertex") && !rig.parts[0].chosen, "{damage}");
    assert!(rig.parts[1..].iter().all(|part| part.damage.is_none()));
    let notes = read_glb_plan_of(&bytes, &names(&["body"])).unwrap().notes.join("\n");
    assert!(
        notes.contains(&format!("mesh \"eye\" is damaged and cannot be the body: {damage}")),
        "{notes}"
    );
    let error = read_skinned_glb_of(&bytes, &names(&["eye"])).unwrap_err().to_string();
    assert_eq!(error, format!("mesh \"eye\": {damage}"));
    // Where no mesh is whole, the first's damage is that of the file.
    let only = file(&[("eye", shapes::sphere(0.02, 3)), ("hair", avatar()[1].1.clone())], JOINTS);
    let none = changed(&only, |json| {
        for k in 0..2 {
            json["meshes"][k]["primitives"][0]["indices"] =
                json["meshes"][k]["primitives"][0]["attributes"]["POSITION"].clone();
        }
    });
    assert!(read_skinned_glb(&none).is_err());
}

/// An upper and a lower part, each open where it lies in the other, and an eye inside: one body of
/// the whole height.
#[test]
fn meshes_that_cross_are_one_body() {
    let half = |y: f64, lid: f64| {
        let mut part = shapes::cuboid(&Vec3::new(0.2, 0.5, 0.2));
        let places = part.positions.clone();
        part.triangles.retain(|t| !t.iter().all(|&v| (places[v as usize].y - lid).abs() < 1e-9));
        at(part, 0.0, y)
    };
    let eye = at(shapes::sphere(0.02, 3), 0.0, 0.5);
    let meshes = [("trousers", half(-0.3, 0.5)), ("shirt", half(0.3, -0.5)), ("eye", eye)];
    let bytes = file(&meshes, JOINTS);
    let plan = read_glb_plan_of(&bytes, &names(&["trousers", "shirt", "eye"])).unwrap();
    let (_, report) = build_figure(plan, &options()).unwrap();
    let size = report.bounds[1] - report.bounds[0];
    // Within a cell of 1.6/200 m.
    assert!((size - Vec3::new(0.4, 1.6, 0.4)).amax() < 0.011, "{size}");
    assert_eq!((report.left_out, report.holes), (0, 0));
    let mass: f64 = report.masses.iter().sum();
    assert!((mass / (1080.0 * 0.4 * 1.6 * 0.4) - 1.0).abs() < 0.1, "{mass}");
}

/// A skin of its own, of the upper joint alone, whose mesh is stored where the lower joint is.
#[test]
fn skins_with_a_common_joint_are_put_into_one_space() {
    let ball = at(shapes::sphere(0.1, 3), 0.0, -0.6);
    let bytes = changed(&file(&[("body", body()), ("ball", ball.clone())], JOINTS), |json| {
        let binds = json["skins"][0]["inverseBindMatrices"].clone();
        let skins = json["skins"].as_array_mut().unwrap();
        skins.push(json!({ "joints": [1], "inverseBindMatrices": binds }));
        let nodes = json["nodes"].as_array_mut().unwrap();
        nodes
            .iter_mut()
            .filter(|node| node["name"] == "ball")
            .for_each(|node| node["skin"] = json!(1));
    });
    let rig = read_skinned_glb_of(&bytes, &names(&["body", "ball"])).unwrap();
    assert_eq!(rig.joints.len(), 2);
    let first = rig.mesh.positions.len() - ball.positions.len();
    for (p, own) in rig.mesh.positions[first..].iter().zip(&ball.positions) {
        assert!((p - own - Vec3::y() * 0.6).norm() < 1e-6, "{p} of {own}");
    }
    assert!(rig.influences[first..].iter().all(|four| four[0] == (1, 1.0)));
    // Without a common joint nothing says where the one lies to the other.
    let apart = changed(&bytes, |json| {
        json["nodes"].as_array_mut().unwrap().push(json!({ "name": "neck" }));
        json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(4));
        json["skins"][1]["joints"] = json!([4]);
    });
    let error = read_skinned_glb_of(&apart, &names(&["body", "ball"])).unwrap_err().to_string();
    assert!(error.contains("\"ball\"") && error.contains("no joint in common"), "{error}");
}

#[test]
fn a_vertex_without_weights_is_told_with_its_mesh_and_its_place() {
    let bytes = file_of(&[("coat", body())], JOINTS, [0.0; 4]);
    let error = read_skinned_glb(&bytes).unwrap_err().to_string();
    let first = body().positions[0];
    let place = format!("vertex 0 at ({:.4}, {:.4}, {:.4})", first.x, first.y, first.z);
    let more = format!("nor have {} more", body().positions.len() - 1);
    for part in ["mesh \"coat\"", &place, &more, "Normalize All"] {
        assert!(error.contains(part), "{error}: no {part}");
    }
}

#[test]
fn a_bone_outside_the_skin_is_told_with_its_place() {
    let bytes = file(&[("body", body())], [JOINTS[0], Vec3::new(3.0, 0.5, 0.0)]);
    let error = build_figure(read_glb_plan(&bytes).unwrap(), &options()).unwrap_err().to_string();
    for part in ["bone \"", "from (", " m, in the mean by ", "`--mesh`"] {
        assert!(error.contains(part), "{error}: no {part}");
    }
}

/// Packed vertices are refused in one line, whatever else is missing; what is about looks alone
/// does not matter.
#[test]
fn extensions_are_named_with_what_helps() {
    let plain = file(&[("body", body())], JOINTS);
    let requiring = |extensions: &[&str]| {
        changed(&plain, |json| {
            json["extensionsRequired"] = json!(extensions);
            json["extensionsUsed"] = json!(extensions);
            json["textures"] = json!([{ "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
        })
    };
    let packed =
        requiring(&["EXT_meshopt_compression", "EXT_texture_webp", "KHR_mesh_quantization"]);
    let error = read_glb(&packed).unwrap_err().to_string();
    assert_eq!(read_skinned_glb(&packed).unwrap_err().to_string(), error);
    assert!(error.contains("EXT_meshopt_compression, KHR_mesh_quantization, which"), "{error}");
    assert!(error.contains("gltf-transform dequantize") && !error.contains("Missing"), "{error}");
    let looks = requiring(&["EXT_texture_webp", "KHR_texture_transform", "KHR_materials_unlit"]);
    assert_eq!(read_glb(&looks).unwrap(), read_glb(&plain).unwrap());
    let other = read_glb(&requiring(&["XYZ_strange"])).unwrap_err().to_string();
    assert!(other.contains("XYZ_strange, which is not read"), "{other}");
}
