//! Exported files, read back by readers that know nothing of the writer.

use std::path::PathBuf;
use thenar_core::model::{HandModel, Side};
use thenar_core::{Pose, Vec3};
use thenar_rig::export::{
    Field, GlbMesh, Series, Skeleton, VertexSkin, glb, hand_glb, surface, write_hand_vtk,
};
use thenar_rig::uniform_hand;

fn hand() -> HandModel {
    uniform_hand(Side::Right, 600).expect("the shipped hand")
}

fn folder(name: &str) -> PathBuf {
    let dir = std::env::temp_dir().join(format!("thenar-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&dir).expect("a folder for the test");
    dir
}

/// A node's pose in the scene, by walking down from the root.
fn walk(node: &gltf::Node, parent: Pose, found: &mut Vec<(String, Pose)>) {
    let (t, r, s) = node.transform().decomposed();
    assert_eq!(s, [1.0; 3]);
    let q = nalgebra::Quaternion::new(r[3], r[0], r[1], r[2]).cast::<f64>();
    let local = Pose::new(Vec3::from(t.map(f64::from)), thenar_core::Quat::from_quaternion(q));
    let pose = parent * local;
    found.push((node.name().unwrap_or_default().to_owned(), pose));
    for child in node.children() {
        walk(&child, pose, found);
    }
}

#[test]
fn a_hand_in_glb_is_valid_and_holds_its_surface_and_bones() {
    let hand = hand();
    let bytes = hand_glb(&hand).expect("exported");
    // `from_slice` validates the document against the glTF 2.0 rules.
    let file = gltf::Gltf::from_slice(&bytes).expect("a valid glTF");
    let blob = file.blob.as_deref().expect("a binary chunk");

    let mesh = file.meshes().next().expect("a mesh");
    let primitive = mesh.primitives().next().expect("a primitive");
    let reader = primitive.reader(|_| Some(blob));
    let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
    let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
    let corners: Vec<u32> = hand.render.triangles.iter().flatten().copied().collect();
    assert_eq!(indices, corners);
    let mut expected = vec![Vec3::zeros(); hand.render.vertices.len()];
    hand.render.positions(&hand.flesh.tets, &hand.flesh.nodes, &mut expected);
    for (p, e) in positions.iter().zip(&expected) {
        assert!((Vec3::from(p.map(f64::from)) - e).norm() < 1e-7);
    }
    for w in reader.read_weights(0).expect("weights").into_f32() {
        assert!((w.iter().sum::<f32>() - 1.0).abs() < 1e-6);
    }

    // Every bone is a node at its joint in the rest pose, and its inverse bind matrix undoes that
    // pose.
    let mut nodes = Vec::new();
    let scene = file.scenes().next().expect("a scene");
    scene.nodes().for_each(|n| walk(&n, Pose::identity(), &mut nodes));
    let skin = file.skins().next().expect("a skin");
    let inverse: Vec<[[f32; 4]; 4]> =
        skin.reader(|_| Some(blob)).read_inverse_bind_matrices().expect("matrices").collect();
    assert_eq!(skin.joints().count(), hand.bones.len());
    for (bone, matrix) in hand.bones.iter().zip(inverse) {
        let (_, pose) = nodes.iter().find(|(name, _)| *name == bone.name).expect("its node");
        let at_joint = bone.pose_MB * bone.pose_BT;
        assert!((pose.position - at_joint.position).norm() < 1e-6, "{}", bone.name);
        assert!(pose.rotation.angle_to(&at_joint.rotation) < 1e-3, "{}", bone.name);
        let matrix = nalgebra::Matrix4::from(matrix).cast::<f64>();
        let back = matrix * at_joint.position.push(1.0);
        assert!((back - nalgebra::Vector4::w()).norm() < 1e-6, "{}", bone.name);
    }
}

#[test]
fn what_glb_cannot_hold_is_refused() {
    let positions = [Vec3::zeros(), Vec3::x(), Vec3::y()];
    let mesh = |triangles: &'static [[u32; 3]], skin: Option<&'static [VertexSkin]>| GlbMesh {
        name: "leaf",
        positions: &positions,
        triangles,
        colour: [0.5; 3],
        skin,
    };
    const SKIN: &[VertexSkin] =
        &[VertexSkin { bones: [2, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] }; 3];
    let fault = |mesh: GlbMesh| glb(&[mesh], None).expect_err("refused").to_string();
    assert!(fault(mesh(&[[0, 1, 3]], None)).contains("vertex 3 of 3"));
    assert!(fault(mesh(&[], None)).contains("no triangles"));
    assert!(fault(mesh(&[[0, 1, 2]], Some(SKIN))).contains("beyond the 0"));
    let orphan =
        Skeleton { names: vec!["a"], parents: vec![Some(0)], poses: vec![Pose::identity()] };
    assert!(glb(&[mesh(&[[0, 1, 2]], None)], Some(&orphan)).is_err());
    let plain = glb(&[mesh(&[[0, 1, 2]], None)], None).expect("exported");
    assert_eq!(gltf::Gltf::from_slice(&plain).expect("valid").meshes().count(), 1);
}

#[test]
fn a_hand_in_vtk_is_four_files_with_its_counts() {
    let hand = hand();
    let dir = folder("hand-vtk");
    write_hand_vtk(&dir, &hand).expect("written");
    let read = |suffix: &str| {
        std::fs::read_to_string(dir.join(format!("{}-{suffix}", hand.name))).expect("there")
    };
    let (nodes, tets) = (hand.flesh.nodes.len(), hand.flesh.tets.len());
    let flesh = read("flesh.vtu");
    assert!(flesh.contains(&format!("NumberOfPoints=\"{nodes}\" NumberOfCells=\"{tets}\"")));
    for bone in &hand.bones {
        assert!(flesh.contains(&format!("Name=\"weight {}\"", bone.name)));
    }
    let triangles = hand.render.triangles.len();
    assert!(read("skin.vtp").contains(&format!("NumberOfPolys=\"{triangles}\"")));
    assert!(read("collision.vtp").contains("Name=\"digit\""));
    assert!(read("bones.vtp").contains(&format!("NumberOfLines=\"{}\"", hand.bones.len())));
    assert_eq!(std::fs::read_dir(&dir).expect("listed").count(), 4);
    std::fs::remove_dir_all(dir).expect("removed");
}

#[test]
fn a_series_lists_every_moment_and_part() {
    let dir = folder("series");
    let leaf = [Vec3::zeros(), Vec3::x(), Vec3::y()];
    let mut series = Series::create(&dir, "run").expect("created");
    for k in 0..3 {
        let lift = Field::scalar("lift", vec![f64::from(k); 3]);
        let text = surface(&leaf, &[[0, 1, 2]], &[lift], &[]).expect("a surface");
        series.push(0.5 * f64::from(k), &[("my hand/skin", "vtp", text)]).expect("pushed");
    }
    let list = std::fs::read_to_string(dir.join("run.pvd")).expect("there");
    for (k, time) in ["0", "0.5", "1"].iter().enumerate() {
        let file = format!("run-my-hand-skin-{k:06}.vtp");
        assert!(list.contains(&format!("timestep=\"{time}\" part=\"0\"")), "{list}");
        assert!(list.contains(&file) && dir.join(&file).is_file());
    }
    std::fs::remove_dir_all(dir).expect("removed");
}
