//! Draws a hand mesh and simple solids: what the renderer can do.
//!
//! `cargo run --release --example gallery -- OUT_DIR`

#![allow(dead_code, unused_imports)]

#[path = "../src/picture/mod.rs"]
mod picture;

use picture::*;
use std::path::Path;
use thenar::{Pose, Quat, Vec3};

/// The triangles of a GLB file, welded by position, each cut in four `times` times.
fn load(path: &str, times: usize) -> Result<Solid, Box<dyn std::error::Error>> {
    let file = gltf::Gltf::open(path)?;
    let blob = file.blob.as_deref().ok_or("no binary part")?;
    let document = &file.document;
    let mut solid = Solid::default();
    let mut known = std::collections::BTreeMap::new();
    for primitive in document.meshes().flat_map(|m| m.primitives().collect::<Vec<_>>()) {
        let reader = primitive.reader(|_| Some(blob));
        let points: Vec<[f32; 3]> = reader.read_positions().ok_or("no positions")?.collect();
        let indices: Vec<u32> = reader.read_indices().ok_or("no indices")?.into_u32().collect();
        let mut weld = |i: u32| {
            let p = points[i as usize];
            *known.entry(p.map(f32::to_bits)).or_insert_with(|| {
                solid.positions.push(Vec3::from(p.map(f64::from)));
                solid.positions.len() as u32 - 1
            })
        };
        let triangles: Vec<[u32; 3]> =
            indices.chunks_exact(3).map(|t| [weld(t[0]), weld(t[1]), weld(t[2])]).collect();
        solid.triangles.extend(triangles);
    }
    for _ in 0..times {
        solid = cut_in_four(&solid);
    }
    Ok(solid)
}

fn cut_in_four(solid: &Solid) -> Solid {
    let mut out = Solid { positions: solid.positions.clone(), triangles: Vec::new() };
    let mut middles = std::collections::BTreeMap::new();
    for &[a, b, c] in &solid.triangles {
        let mut middle = |i: u32, j: u32| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                out.positions.push((out.positions[i as usize] + out.positions[j as usize]) / 2.0);
                out.positions.len() as u32 - 1
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        out.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    out
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).unwrap_or_else(|| "out".into());
    let out = Path::new(&out);
    std::fs::create_dir_all(out)?;
    let hand = load("assets/hands/right.glb", 2)?;
    let (mut low, mut high) = (Vec3::repeat(1e9), Vec3::repeat(-1e9));
    for p in &hand.positions {
        (low, high) = (low.inf(p), high.sup(p));
    }
    println!("{} triangles, from {low:?} to {high:?}", hand.triangles.len());
    let floor = low.y - 0.002;

    let mut scene = Scene3d {
        ground: Some(Ground::horizontal(floor, Pattern::Wood(0.09))),
        ..Scene3d::default()
    };
    scene.meshes.push(hand.clone().mesh(Material::skin()));
    let ball = sphere(Vec3::new(high.x + 0.05, floor + 0.03, 0.0), 0.03, 64);
    scene.meshes.push(ball.mesh(Material::paint([0.55, 0.02, 0.02])));
    let block = Pose::new(
        Vec3::new(low.x - 0.06, floor + 0.025, -0.05),
        Quat::from_axis_angle(&Vec3::y_axis(), 0.5),
    );
    scene.meshes.push(
        cuboid(&block, Vec3::new(0.03, 0.025, 0.02), 12).mesh(Material::paint([0.05, 0.2, 0.6])),
    );
    scene.meshes.push(
        arrow(Vec3::new(high.x + 0.05, floor + 0.06, 0.0), Vec3::new(0.0, 0.05, 0.0), 0.002)
            .mesh(Material::unlit([0.9, 0.1, 0.1])),
    );
    let mut corners = hand.positions.clone();
    corners.extend(scene.meshes[1].positions.iter().chain(scene.meshes[2].positions.iter()));
    let camera = Camera::fitted(&corners, Vec3::new(-0.25, -0.75, -0.6), 0.6, 1.5, 0.08);
    for (name, quality) in [("still", Quality::still()), ("movie", Quality::movie())] {
        let start = std::time::Instant::now();
        let image = render(&scene, &camera, 960, 640, &quality);
        println!("{name}: {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
        write_png(&out.join(format!("{name}.png")), &image)?;
    }

    let mut overlay = Scene3d { ground: scene.ground, ..Scene3d::default() };
    overlay.ground = Some(Ground::horizontal(
        floor,
        Pattern::Checker([[0.75, 0.77, 0.8], [0.55, 0.58, 0.62]], 0.05),
    ));
    let raised = hand.clone().placed(&Pose::translation(0.01, 0.03, 0.0));
    let span = high - low;
    let tint: Vec<Rgb> =
        hand.positions.iter().map(|p| weight_colour((p.z - low.z) / span.z)).collect();
    overlay.meshes.push(hand.clone().mesh(Material::matte([1.0; 3])).coloured(tint));
    overlay.meshes.push(raised.mesh(Material::ghost([0.95, 0.75, 0.05], 0.45)));
    let image = render(&overlay, &camera, 960, 640, &Quality::still());
    write_png(&out.join("overlay.png"), &image)?;

    let mut bones = Scene3d { ground: overlay.ground, ..Scene3d::default() };
    bones.meshes.push(hand.clone().mesh(Material::ghost([0.8, 0.5, 0.4], 0.3)));
    let middle = (low + high) / 2.0;
    bones
        .meshes
        .push(bone([middle, middle + Vec3::new(0.0, 0.0, -0.06)], 0.008).mesh(Material::bone()));
    let edges: Vec<[Vec3; 2]> = hand.triangles[..4000]
        .iter()
        .flat_map(|t| [[t[0], t[1]], [t[1], t[2]]])
        .map(|e| e.map(|i| hand.positions[i as usize]))
        .collect();
    bones.meshes.push(Pen::new(&camera, 640, 1.2).lines(edges, Material::unlit([0.1, 0.2, 0.4])));
    let image = render(&bones, &camera, 960, 640, &Quality::still());
    write_png(&out.join("bones.png"), &image)?;
    Ok(())
}
