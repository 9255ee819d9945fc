//! Real time, as far as the system gives it: priority, memory and stacks that stay in place.

/// Threads and processes of touch, the least urgent first. All are above everything that is not
/// real-time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PriorityClass {
    /// The loop.
    Loop,
    /// The thread behind a device that shows forces, above the loop: a loop gone wild cannot keep
    /// it from letting the wearer go.
    Device,
    /// The watchdog, above both for the same reason.
    Watchdog,
    /// The keeper, a process of its own that outlives the others.
    Keeper,
}

impl PriorityClass {
    /// Priority of `SCHED_FIFO` on Linux, 1 to 99; Linux runs threaded interrupts at 50.
    pub fn priority(self) -> u8 {
        match self {
            Self::Loop => 60,
            Self::Device => 65,
            Self::Watchdog => 70,
            Self::Keeper => 75,
        }
    }
}

/// Asks for real-time priority for this thread.
///
/// # Errors
/// The system refuses; the cause, for a person.
pub fn raise_priority(urgency: PriorityClass) -> Result<(), String> {
    use thread_priority::{ThreadPriority, ThreadPriorityValue};
    let value = ThreadPriorityValue::try_from(urgency.priority()).map_err(|e| e.to_string())?;
    set_priority(ThreadPriority::Crossplatform(value))
}

#[cfg(target_os = "linux")]
fn set_priority(priority: thread_priority::ThreadPriority) -> Result<(), String> {
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy,
        thread_native_id,
    };
    let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), priority, fifo).map_err(cause)
}

#[cfg(not(target_os = "linux"))]
fn set_priority(_: thread_priority::ThreadPriority) -> Result<(), String> {
    thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Max)
        .map_err(cause)
}

fn cause(error: thread_priority::Error) -> String {
    match error {
        thread_priority::Error::OS(code) => std::io::Error::from_raw_os_error(code).to_string(),
        other => other.to_string(),
    }
}

/// Keeps the memory that is in use now, stacks of all threads included, from being paged out. What
/// is allocated later is locked by asking again: locking all there will be would end the program at
/// its limit.
///
/// # Errors
/// The system refuses; the cause, for a person.
#[cfg(target_os = "linux")]
pub fn lock_memory() -> Result<(), String> {
    use rustix::mm::{MlockAllFlags, mlockall};
    mlockall(MlockAllFlags::CURRENT).map_err(|cause| cause.to_string())
}

/// Locks no memory: that is done on Linux.
///
/// # Errors
/// Always.
#[cfg(not(target_os = "linux"))]
pub fn lock_memory() -> Result<(), String> {
    Err("not done on this system".into())
}

/// Stack that a tick may need \[B\]: threads have 2 MiB, the deepest path of a tick seen uses some
/// tens of KiB.
const STACK: usize = 256 * 1024;
/// Size of a page \[B\], or a part of it.
const PAGE: usize = 4096;

/// Touches this thread's stack, so that no page of it is missing when a tick first goes deep.
#[inline(never)]
pub fn touch_stack() {
    let mut stack = [0_u8; STACK];
    stack.iter_mut().step_by(PAGE).for_each(|byte| *byte = 1);
    std::hint::black_box(&mut stack);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever releases the wearer is never kept from it by whom it watches.
    #[test]
    fn who_releases_is_above_whom_it_watches() {
        use PriorityClass::{Device, Keeper, Loop, Watchdog};
        let order = [Loop, Device, Watchdog, Keeper].map(PriorityClass::priority);
        assert!(order.is_sorted_by(|a, b| a < b) && order[0] > 50 && order[3] < 99, "{order:?}");
    }

    /// The pages that the kernel counts as this thread's stack are there after it was touched.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_touched_stack_is_there() {
        let resident = || {
            // The mapping that holds a local variable of this thread.
            let local = 0_u8;
            let place = std::ptr::from_ref(&local) as usize;
            let maps = std::fs::read_to_string("/proc/thread-self/smaps").unwrap();
            let mut ours = false;
            for line in maps.lines() {
                let range = line.split(' ').next().unwrap_or("").split_once('-');
                let ends = range.and_then(|(a, b)| {
                    Some([usize::from_str_radix(a, 16).ok()?, usize::from_str_radix(b, 16).ok()?])
                });
                if let Some([from, to]) = ends {
                    ours = (from..to).contains(&place);
                } else if let Some(size) = line.strip_prefix("Rss:").filter(|_| ours) {
                    return size.trim().trim_end_matches(" kB").parse::<usize>().unwrap() * 1024;
                }
            }
            panic!("no mapping holds {place:x}");
        };
        let thread = std::thread::spawn(move || {
            touch_stack();
            resident()
        });
        // Before, it may have fewer: not where another test has locked all memory, or this stack
        // was another thread's.
        let after = thread.join().unwrap();
        assert!(after >= STACK, "{after} B");
    }
}
