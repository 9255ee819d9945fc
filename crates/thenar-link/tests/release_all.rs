//! Goal: a way out that drops nothing still lets go of the hand. Method: a simulated glove whose
//! finger is stopped. Alone in its file: it ends every device of its process.
#![cfg(unix)]

mod conformance;

use conformance::{Bench, wait};
use std::time::Duration;
use thenar_link::lucidgloves::{LucidGlovesDriver, LucidGlovesTwin};
use thenar_link::twin::Twin;

#[test]
fn release_all_frees_the_fingers() {
    let twin = LucidGlovesTwin::new(false, false);
    let bench = Bench::new("all", twin, &LucidGlovesDriver, |_| [0.0; 20]);
    let mut device = bench.open();
    wait("a stop", || {
        device.show([0.5; 5]);
        (bench.twin.twin().felt() == [0.5; 5]).then_some(())
    });
    assert!(thenar_link::release_all(Duration::from_secs(20)), "the last words were said");
    wait("the release", || {
        device.show([0.5; 5]);
        (bench.twin.twin().felt() == [0.0; 5]).then_some(())
    });
}
