//! Goal: a hand whose skin is several meshes, such as a glove and the skin beside it, is one hand.
//! Method: the shipped hand, cut in two; what comes of it is held against the whole one.

use thenar_core::Vec3;
use thenar_core::model::Side;
use thenar_rig::TriMesh;
use thenar_rig::export::{GlbMesh, Skeleton, VertexSkin, glb};
use thenar_rig::glb::{SkinnedMesh, read_skinned_glb};
use thenar_rig::hand::{HandOptions, HandReport, asset, build_hand_with_report};

fn whole() -> SkinnedMesh {
    read_skinned_glb(asset(Side::Right)).unwrap()
}

/// A file of these meshes on the joints of the shipped hand.
fn file(meshes: &[(&str, &TriMesh)]) -> Vec<u8> {
    let rig = whole();
    let skeleton = Skeleton {
        names: rig.joints.iter().map(|joint| &joint.name[..]).collect(),
        parents: rig.joints.iter().map(|joint| joint.parent).collect(),
        poses: rig.joints.iter().map(|joint| joint.pose).collect(),
    };
    let first = VertexSkin { bones: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
    let skins: Vec<_> = meshes.iter().map(|(_, mesh)| vec![first; mesh.positions.len()]).collect();
    let written = meshes.iter().zip(&skins).map(|((name, mesh), skin)| GlbMesh {
        name,
        positions: &mesh.positions,
        triangles: &mesh.triangles,
        colour: [0.8; 3],
        skin: Some(skin),
    });
    glb(&written.collect::<Vec<_>>(), Some(&skeleton)).unwrap()
}

fn built(bytes: &[u8], meshes: &[&str]) -> HandReport {
    let meshes = meshes.iter().map(|name| name.to_string()).collect();
    let options = HandOptions { tets: 200, meshes, ..HandOptions::paper() };
    build_hand_with_report(bytes, &options).unwrap_or_else(|e| panic!("{e}")).1
}

/// The triangles whose middle is at most so far along from the wrist to the middle finger's tip, or
/// at least.
fn part(mesh: &TriMesh, keeps: impl Fn(f64) -> bool) -> TriMesh {
    let rig = whole();
    let place = |name: &str| {
        rig.joints.iter().find(|joint| joint.name == name).map(|j| j.pose.position).unwrap()
    };
    let (wrist, tip) = (place("wrist"), place("middle-finger-tip"));
    let along = |p: &Vec3| (p - wrist).dot(&(tip - wrist)) / (tip - wrist).norm_squared();
    let mut piece = mesh.clone();
    piece.triangles.retain(|t| {
        let middle = t.iter().map(|&v| mesh.positions[v as usize]).sum::<Vec3>() / 3.0;
        keeps(along(&middle))
    });
    piece.compacted()
}

/// Every vertex moved along its normal by so much \[m\].
fn inflated(mesh: &TriMesh, by: f64) -> TriMesh {
    let mut normals = vec![Vec3::zeros(); mesh.positions.len()];
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let normal = (b - a).cross(&(c - a));
        t.iter().for_each(|&v| normals[v as usize] += normal);
    }
    let mut out = mesh.clone();
    for (p, n) in out.positions.iter_mut().zip(&normals) {
        *p += n.try_normalize(1e-15).unwrap_or_default() * by;
    }
    out
}

/// A glove 1 mm off the fingers, which overlaps the skin of palm and wrist: what both enclose has
/// the volume of the hand and at most that of the glove's own thickness more.
#[test]
fn a_glove_over_skin_is_one_hand() {
    let mesh = whole().mesh;
    let skin = part(&mesh, |along| along < 0.35);
    let glove = inflated(&part(&mesh, |along| along > 0.2), 1e-3);
    let report = built(&file(&[("skin", &skin), ("glove", &glove)]), &["skin", "glove"]);
    let joined = report.rig.joined.unwrap();
    assert!((5e-4..2e-3).contains(&joined.cell), "{joined:?}");
    let alone = built(asset(Side::Right), &[]);
    assert!(alone.rig.joined.is_none());
    let more = report.skin_volume - alone.skin_volume;
    let most = 1.2e-3 * glove.area();
    // A cell's edge is lost at creases.
    assert!((-0.01 * alone.skin_volume..most).contains(&more), "{more} m³ of {most}");
    assert!((report.length - alone.length).abs() < 2e-3, "{} {}", report.length, alone.length);
}

/// Parts that have the vertices of their border in common are put together as they are.
#[test]
fn pieces_that_fit_together_stay_as_they_are() {
    let mesh = whole().mesh;
    let (near, far) = (part(&mesh, |along| along < 0.3), part(&mesh, |along| along >= 0.3));
    let report = built(&file(&[("near", &near), ("far", &far)]), &["near", "far"]);
    assert_eq!(report.rig.joined, None);
    let alone = built(asset(Side::Right), &[]);
    assert!((report.skin_volume / alone.skin_volume - 1.0).abs() < 1e-6);
}
