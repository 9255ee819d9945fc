//! Counts allocations by thread, so that neither the test harness nor a device's thread is counted
//! with the code under test.
//!
//! ```
//! use thenar_testing::allocations;
//!
//! #[global_allocator]
//! static ALLOCATOR: allocations::Counting = allocations::Counting;
//!
//! let (held, boxed) = allocations::count(|| Box::new(1));
//! assert_eq!((held, *boxed), (1, 1));
//! assert_eq!(allocations::count(|| 1 + 1), (0, 2));
//! ```

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, which counts what this thread asks for. Growing in place counts as an
/// allocation.
#[derive(Debug)]
pub struct Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

// The only way to see allocations is to stand in for the allocator, which is an unsafe trait.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // A thread that ends has no count any more.
        let _ = COUNT.try_with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// Allocations of this thread so far.
///
/// # Panics
/// [`Counting`] is not the global allocator, so that nothing is counted.
pub fn so_far() -> u64 {
    let before = COUNT.get();
    drop(std::hint::black_box(Box::new(0_u8)));
    assert!(COUNT.get() > before, "`Counting` is not the global allocator of this test");
    // The box is not the test's.
    COUNT.set(before);
    before
}

/// Allocations of this thread within `act`, and what `act` returns.
///
/// # Panics
/// [`Counting`] is not the global allocator, so that nothing would be counted.
pub fn count<T>(act: impl FnOnce() -> T) -> (u64, T) {
    let before = so_far();
    let done = act();
    (so_far() - before, done)
}
