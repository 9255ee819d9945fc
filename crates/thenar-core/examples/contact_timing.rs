//! Times detection on a hand-sized surface among ten rigid bodies, with and without a loaf.
//! Run with `cargo run --release --example contact_timing`.

#[path = "../tests/common/contact_scene.rs"]
mod contact_scene;

use contact_scene::ContactScene;
use std::time::Instant;
use thenar_core::kernels::{Detector, Reach, SeenSides, Site, SurfaceState};

fn main() {
    for loaf in [false, true] {
        let mut scene = ContactScene::new(loaf);
        let mut detector = Detector::new(&scene.desc);
        let mut out = Vec::with_capacity(detector.capacity());
        let [mut seen, mut now] = [(); 2].map(|()| SeenSides::with_capacity(detector.sides_max()));
        let reach = Reach { h: 1.0 / 60.0, margin: 1e-3 };
        let (mut times, mut counts) = (Vec::new(), [0usize; 3]);
        for step in 0..2000 {
            scene.advance(step, 1e-3);
            let surfaces =
                SurfaceState { positions: &scene.positions, velocities: &scene.velocities };
            let start = Instant::now();
            detector.find(reach, &scene.places, surfaces, &seen, &mut now, &mut out);
            std::mem::swap(&mut seen, &mut now);
            times.push(start.elapsed().as_secs_f64() * 1e6);
            counts = [0; 3];
            for c in &out {
                let is_soft = |s: &Site| usize::from(matches!(s, Site::Soft(_)));
                counts[is_soft(&c.a) + is_soft(&c.b)] += 1;
            }
        }
        times.sort_by(f64::total_cmp);
        let at = |q: f64| times[(q * (times.len() - 1) as f64) as usize];
        println!(
            "loaf {loaf}: least {:.1} us, median {:.1} us, p99 {:.1} us; {} surface vertices, contacts: {} rigid, \
             {} soft-rigid, {} soft-soft",
            at(0.0),
            at(0.5),
            at(0.99),
            scene.positions.len(),
            counts[0],
            counts[1],
            counts[2]
        );
    }
}
