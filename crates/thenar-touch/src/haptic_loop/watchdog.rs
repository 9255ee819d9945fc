//! Sends zeros when the loop does not.

use super::Shared;
use crate::realtime::{PriorityClass, raise_priority, touch_stack};
use crate::{HandOutput, now_ns};
use std::sync::atomic::Ordering;
use std::sync::{Arc, TryLockError};
use std::time::Duration;
use thenar_core::model::Side;

/// A loop that has not ticked for so long is taken over \[ns\].
pub const PATIENCE_NS: u64 = 20_000_000;
/// Between two looks: what is missed is seen 4 ms later at most.
const EVERY: Duration = Duration::from_millis(4);

/// Watches until the loop ends by itself.
///
/// It owns nothing that the loop waits for: the loop takes the displays only if they are free, and
/// leaves out a tick otherwise. Where the loop stands still with the displays in its hands, the
/// devices' own threads release after the same 20 ms.
pub fn run(shared: &Arc<Shared>) {
    // What the system refuses the loop has reported.
    touch_stack();
    let _ = raise_priority(PriorityClass::Watchdog);
    let control = &shared.control;
    let mut barking = false;
    while !control.quit.load(Ordering::Acquire) {
        let beat_ns = control.beat_ns.load(Ordering::Acquire);
        let failed = control.failed.load(Ordering::Acquire);
        let silent = beat_ns > 0 && now_ns().saturating_sub(beat_ns) > PATIENCE_NS;
        if silent || failed {
            // The guards begin anew at the first tick after the gap by themselves, or trip, and say
            // how long it was; in a loop that lives no stop has to be asked for.
            if !barking {
                control.barks.fetch_add(1, Ordering::Relaxed);
            }
            release(shared);
        }
        barking = silent || failed;
        std::thread::sleep(EVERY);
    }
}

/// Shows zeros on all displays, if they are free; true when it did.
pub fn release(shared: &Shared) -> bool {
    let mut displays = match shared.displays.try_lock() {
        Ok(displays) => displays,
        Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
        Err(TryLockError::WouldBlock) => return false,
    };
    let now = now_ns();
    for display in displays.iter_mut() {
        for side in [Side::Left, Side::Right] {
            display.show(&HandOutput::released(side, now));
        }
    }
    true
}
