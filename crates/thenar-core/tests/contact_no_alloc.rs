//! Goal: detection allocates nothing in a step. Method: a global allocator that counts.

#[path = "common/contact_scene.rs"]
mod contact_scene;

use contact_scene::ContactScene;
use thenar_core::kernels::{Detector, Reach, SeenSides, SurfaceState};
use thenar_testing::allocations;

#[global_allocator]
static ALLOCATOR: allocations::Counting = allocations::Counting;

#[test]
fn detection_allocates_nothing() {
    let mut scene = ContactScene::new(true);
    let mut detector = Detector::new(&scene.desc);
    let mut out = Vec::with_capacity(detector.capacity());
    let [mut seen, mut now] = [(); 2].map(|()| SeenSides::with_capacity(detector.sides_max()));
    let reach = Reach { h: 1.0 / 60.0, margin: 1e-3 };
    let before = allocations::so_far();
    let mut contacts = 0;
    for step in 0..100 {
        scene.advance(step, 1e-3);
        let surfaces = SurfaceState { positions: &scene.positions, velocities: &scene.velocities };
        contacts +=
            detector.find(reach, &scene.places, surfaces, &seen, &mut now, &mut out).contacts;
        std::mem::swap(&mut seen, &mut now);
        let surfaces = SurfaceState { positions: &scene.positions, velocities: &scene.velocities };
        assert!(detector.penetration(&scene.places, surfaces, &seen) > 0.0);
    }
    let made = allocations::so_far() - before;
    assert!(contacts > 100 * 50, "{contacts} contacts make no test");
    assert_eq!(made, 0);
}
