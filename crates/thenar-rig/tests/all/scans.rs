//! Goal: scans become soft bodies: meshes with holes, triangles turned over, in files of every
//! kind. Method: a sphere with known volume loses caps; what is closed has the volume between the
//! planes of the cuts, whatever the file.

use std::f64::consts::TAU;
use thenar_core::Vec3;
use thenar_core::model::{Law, Material};
use thenar_rig::TriMesh;
use thenar_rig::embed::{EmbedOptions, can_be_closed, closed_surface, embed, mended_surface};
use thenar_rig::mesh::{load_mesh, shapes, write_stl};

const GEL: Material =
    Material { law: Law::Corotational, young: 1e4, poisson: 0.4, density: 1000.0 };
/// Radius of the ball \[m\].
const RADIUS: f64 = 0.03;

/// A ball without its caps beyond ±`height` radii along y, each `turned`-th triangle turned over.
fn cut_ball(height: f64, turned: usize) -> TriMesh {
    let ball = shapes::sphere(RADIUS, 30);
    let gone = |v: &u32| ball.positions[*v as usize].y.abs() > height * RADIUS;
    let kept = ball.triangles.iter().filter(|t| !t.iter().any(gone)).copied();
    let turn = |(k, [a, b, c]): (usize, [u32; 3])| {
        if turned > 0 && k % turned == 0 { [a, c, b] } else { [a, b, c] }
    };
    TriMesh { triangles: kept.enumerate().map(turn).collect(), positions: ball.positions }
        .compacted()
}

/// Between planes at ±z a ball holds `2π (r² z − z³/3)`.
fn volume_between(mesh: &TriMesh) -> f64 {
    let z = mesh.positions.iter().map(|p| p.y).fold(0.0, f64::max);
    TAU * (RADIUS * RADIUS * z - z.powi(3) / 3.0)
}

#[test]
fn holes_are_closed_and_told_however_triangles_are_turned() {
    for turned in [0, 1, 2, 3, 7] {
        let scan = cut_ball(0.7, turned);
        assert!(closed_surface(&scan).is_err());
        let (mesh, holes) = mended_surface(&scan).unwrap();
        assert_eq!(holes.len(), 2, "{turned}");
        assert!((mesh.volume() / volume_between(&scan) - 1.0).abs() < 0.03, "{turned}");
        let body =
            embed(&mesh, &EmbedOptions { tets: 200, ..EmbedOptions::default() }, |_| GEL).unwrap();
        let held: f64 = body.node_volumes.iter().sum();
        assert!((held / mesh.volume() - 1.0).abs() < 0.05, "{turned}: {held}");
    }
}

/// The refusal counts the holes, and says what closes them, where something does.
#[test]
fn an_open_mesh_is_refused_with_its_holes_and_what_closes_them() {
    let message = |mesh: &TriMesh| closed_surface(mesh).unwrap_err().to_string();
    let told = message(&cut_ball(0.7, 3));
    assert!(told.contains("edges have one triangle") && told.contains("around 2 holes"), "{told}");
    assert!(can_be_closed(&cut_ball(0.7, 3)));
    let mut one = cut_ball(2.0, 0);
    one.triangles.swap_remove(7);
    let told = message(&one);
    assert!(told.contains("3 edges have one triangle, 0 more than two, around one hole"), "{told}");
    // No promise is made that cannot be kept.
    let told = message(&finned());
    assert!(told.contains("1 more than two") && told.contains("program for meshes"), "{told}");
    assert!(!can_be_closed(&finned()));
    let told = message(&cloth());
    assert!(told.contains("it is a sheet") && told.contains("thickness"), "{told}");
    assert!(!can_be_closed(&cloth()));
}

/// A flat grid of 10 by 10 cells.
fn cloth() -> TriMesh {
    let at = |i: u32| Vec3::new(f64::from(i % 11), f64::from(i / 11), 0.0) * 0.01;
    let cells = (0..100).map(|c| c + c / 10);
    let triangles = cells.flat_map(|c| [[c, c + 1, c + 12], [c, c + 12, c + 11]]).collect();
    TriMesh { positions: (0..121).map(at).collect(), triangles }
}

/// A ball with a fin: an edge of three triangles is no border.
fn finned() -> TriMesh {
    let mut fin = cut_ball(2.0, 0);
    let [a, b, _] = fin.triangles[0];
    fin.positions.push(Vec3::repeat(0.1));
    fin.triangles.push([a, b, fin.positions.len() as u32 - 1]);
    fin
}

#[test]
fn what_no_loop_bounds_is_still_refused() {
    let message = |mesh: &TriMesh| mended_surface(mesh).unwrap_err().to_string();
    let mut two = cut_ball(0.7, 0);
    let far = cut_ball(0.7, 0);
    let first = two.positions.len() as u32;
    two.positions.extend(far.positions.iter().map(|p| p + Vec3::repeat(0.2)));
    two.triangles.extend(far.triangles.iter().map(|t| t.map(|v| v + first)));
    assert!(message(&two).contains("2 separate parts"), "{}", message(&two));
    assert!(message(&finned()).contains("more than two"), "{}", message(&finned()));
    let sheet = TriMesh {
        positions: vec![Vec3::zeros(), Vec3::x(), Vec3::y()],
        triangles: vec![[0, 1, 2]],
    };
    let flat = mended_surface(&sheet)
        .and_then(|(mesh, _)| embed(&mesh, &EmbedOptions::default(), |_| GEL));
    assert!(flat.is_err(), "a sheet closed by itself holds nothing");
}

/// The same ball as every kind of file, in millimetres.
#[test]
fn all_kinds_of_files_give_the_same_ball() {
    let ball = cut_ball(2.0, 0).scaled(1e3);
    let places = |sign: &str| -> String {
        ball.positions.iter().map(|p| format!("{sign}{} {} {}\n", p.x, p.y, p.z)).collect()
    };
    let faces = |sign: &str, from: u32| -> String {
        ball.triangles
            .iter()
            .map(|t| format!("{sign} {} {} {}\n", t[0] + from, t[1] + from, t[2] + from))
            .collect()
    };
    let (n, f) = (ball.positions.len(), ball.triangles.len());
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {n}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {f}\nproperty list uchar int vertex_indices\nend_header\n{}{}",
        places(""),
        faces("3", 0)
    );
    let files = [
        ("ball.ply", ply.into_bytes()),
        ("ball.OFF", format!("OFF\n{n} {f} 0\n{}{}", places(""), faces("3", 0)).into_bytes()),
        ("ball.obj", format!("{}{}", places("v "), faces("f", 1)).into_bytes()),
        ("ball.stl", write_stl(&ball)),
    ];
    let folder = own_folder();
    for (name, bytes) in files {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        let mesh = load_mesh(&path, 1e-3).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(mesh.triangles.len(), f, "{name}");
        assert!((mesh.volume() / (ball.volume() * 1e-9) - 1.0).abs() < 1e-6, "{name}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A folder of this test's own.
fn own_folder() -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("thenar-scans-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}
