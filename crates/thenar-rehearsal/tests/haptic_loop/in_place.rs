//! Goal: threads are as urgent as they are said to be, and memory of hands that come later is
//! locked as well. Method: a real loop with a real device's thread, and what the system says of
//! this process.
#![cfg(target_os = "linux")]

use crate::rig::{SCENE, session};
use std::path::Path;
use std::time::{Duration, Instant};
use thenar_link::haptic_loop::{HapticLoop, Settings};
use thenar_link::realtime::{PriorityClass, lock_memory, raise_priority};

/// How much of the mapping around a place is locked \[KiB\].
fn locked_around(place: usize) -> usize {
    let maps = std::fs::read_to_string("/proc/self/smaps").unwrap();
    let mut around = false;
    for line in maps.lines() {
        let range = line.split(' ').next().and_then(|range| range.split_once('-'));
        let ends = range.map(|(a, b)| [a, b].map(|end| usize::from_str_radix(end, 16)));
        if let Some([Ok(from), Ok(to)]) = ends {
            around = (from..to).contains(&place);
        } else if let Some(size) = line.strip_prefix("Locked:").filter(|_| around) {
            return size.trim().trim_end_matches(" kB").parse().unwrap();
        }
    }
    panic!("no mapping holds {place:x}");
}

/// Priorities of `SCHED_FIFO` of all threads of this name; 0 for those without.
fn priorities(name: &str) -> Vec<u8> {
    let mut found = Vec::new();
    for task in std::fs::read_dir("/proc/self/task").unwrap().flatten() {
        let read = |file: &str| std::fs::read_to_string(Path::new(&task.path()).join(file));
        let (Ok(comm), Ok(stat)) = (read("comm"), read("stat")) else { continue };
        if comm.trim() == name {
            // Fields 40 and 41, counted from the first after the name, which is the third.
            let (_, rest) = stat.rsplit_once(") ").unwrap();
            let fields: Vec<_> = rest.split(' ').collect();
            let fifo = fields[38] == "1";
            found.push(if fifo { fields[37].parse().unwrap() } else { 0 });
        }
    }
    found
}

fn until(what: &str, mut done: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !done() {
        assert!(begun.elapsed() < Duration::from_secs(30), "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Where the system allows it, threads have their priorities; where not, the loop says so and names
/// the command that tells more.
#[test]
fn threads_are_as_urgent_as_they_are_said_to_be() {
    let allowed =
        std::thread::spawn(|| raise_priority(PriorityClass::Keeper).is_ok()).join().unwrap();
    let opened = thenar_link::open("null:right").unwrap();
    let trackers = opened.tracker.into_iter().collect();
    let displays = opened.display.into_iter().collect();
    let device = HapticLoop::start(Settings::default(), trackers, displays).unwrap();
    let warned = |what: &str| {
        let warnings = device.remote().status().warnings;
        warnings.iter().any(|w| w.contains(what) && w.contains("thenar devices check"))
    };
    assert_eq!(warned("real-time priority"), !allowed);
    let threads = [
        ("haptics", PriorityClass::Loop),
        ("device", PriorityClass::Device),
        ("watchdog", PriorityClass::Watchdog),
    ];
    for (name, urgency) in threads {
        let wanted = if allowed { urgency.priority() } else { 0 };
        until(name, || priorities(name).contains(&wanted));
    }
}

/// 24 MiB that came into use between the start of the loop and its first hand are locked with that
/// hand.
#[test]
fn memory_of_hands_that_come_later_is_locked() {
    let allowed = lock_memory().is_ok();
    let device = HapticLoop::start(Settings::default(), Vec::new(), Vec::new()).unwrap();
    let warned = |what: &str| device.remote().status().warnings.iter().any(|w| w.contains(what));
    assert_eq!(warned("locked memory"), !allowed);
    if !allowed {
        return;
    }
    const LATER: usize = 24 << 20;
    let later = std::hint::black_box(vec![1_u8; LATER]);
    // So large a piece has a mapping of its own, or shares one with others.
    let middle = later.as_ptr() as usize + LATER / 2;
    device.port().attach(&session(SCENE)).unwrap();
    let locked = locked_around(middle);
    assert!(locked >= LATER / 1024, "{locked} KiB");
    assert_eq!(later.iter().map(|byte| usize::from(*byte)).sum::<usize>(), LATER);
}
