//! Goal: writing a snapshot allocates nothing once warm. Method: a global allocator that counts,
//! around snapshots of a hand that holds bread.

use std::path::Path;
use thenar_scene::session::{Session, builtin};
use thenar_serve::protocol::{Pace, Snapshots};
use thenar_testing::allocations;

#[global_allocator]
static ALLOCATOR: allocations::Counting = allocations::Counting;

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
    let (allocated, ()) = allocations::count(|| {
        for number in 1..100 {
            let again = snapshots.write(&session, &Pace { number, ..Pace::default() });
            assert!(again.len() == first.len());
        }
    });
    assert_eq!(allocated, 0);
    assert!(first.len() < 10_000, "the paper-size hand and bread fit: {} bytes", first.len());
}
