//! Goal: detection allocates nothing in a step. Method: a global allocator that counts.
#![allow(unsafe_code)]

#[path = "common/contact_scene.rs"]
mod contact_scene;

use contact_scene::ContactScene;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use thenar::kernels::{Detector, Reach, Sides, SurfaceState};

struct Counting;

thread_local! {
    /// Of this thread alone: the test harness allocates on its own.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

fn allocations() -> usize {
    ALLOCATIONS.with(Cell::get)
}

// SAFETY: every call is handed to the system allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|n| n.set(n.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn detection_allocates_nothing() {
    let mut scene = ContactScene::new(true);
    let mut detector = Detector::new(&scene.desc);
    let mut out = Vec::with_capacity(detector.capacity());
    let [mut seen, mut now] = [(); 2].map(|()| Sides::with_capacity(detector.sides_max()));
    let reach = Reach { h: 1.0 / 60.0, margin: 1e-3 };
    let before = allocations();
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
    let made = allocations() - before;
    assert!(contacts > 100 * 50, "{contacts} contacts make no test");
    assert_eq!(made, 0);
    drop(Box::new(1));
    assert!(allocations() > before, "the counter counts");
}
