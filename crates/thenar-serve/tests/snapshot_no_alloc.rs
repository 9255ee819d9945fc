//! Goal: writing a snapshot allocates nothing once warm. Method: a global allocator that counts,
//! around snapshots of a hand that holds bread.

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use thenar_scene::session::{Session, builtin};
use thenar_serve::protocol::{Pace, Snapshots};

struct Counting;

static COUNT: AtomicU64 = AtomicU64::new(0);

// The only way to see allocations is to stand in for the allocator, which is an unsafe trait.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_snapshot_allocates_nothing_once_warm() {
    let scene = builtin("bread-grasp").unwrap();
    let mut session =
        Session::from_text(scene.text, Path::new("bread-grasp"), &["hand.0.preset=paper".into()])
            .unwrap();
    while session.world().time() < 2.0 {
        session.step(&mut ());
    }
    let mut snapshots = Snapshots::default();
    let first = snapshots.write(&session, &Pace::default()).to_vec();
    let before = COUNT.load(Ordering::Relaxed);
    for number in 1..100 {
        let again = snapshots.write(&session, &Pace { number, ..Pace::default() });
        assert!(again.len() == first.len());
    }
    assert_eq!(COUNT.load(Ordering::Relaxed), before);
    assert!(first.len() < 10_000, "the paper-size hand and bread fit: {} bytes", first.len());
}
