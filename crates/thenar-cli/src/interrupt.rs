//! Ctrl-C, and being asked to end by the system. Both stop all forces at once. A command that
//! [listens](listen) ends after its present step, with what it has; a second time, or where none
//! listens, the program ends at once, and leaves no unfinished file. A file that outgrows its bound
//! ends nothing.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Time that devices have for their last words when the program ends at once.
const LAST_WORDS: Duration = Duration::from_millis(100);

static LISTENS: AtomicBool = AtomicBool::new(false);
static ASKED: AtomicBool = AtomicBool::new(false);
static UNREAD: AtomicBool = AtomicBool::new(false);

/// Begins to hear signals, before anything else is done. Where the system does not allow it, Ctrl-C
/// ends the program as usual.
pub fn hear() {
    let _ = outgrow();
    let _ = each_signal(|| {
        thenar_link::haptic_loop::stop_all();
        let asked_before = ASKED.swap(true, Ordering::SeqCst);
        if asked_before || !LISTENS.load(Ordering::SeqCst) {
            end();
        }
    });
    stop_on_panic();
}

/// A file that may grow no further (`ulimit -f`) is a full disk: whoever writes gets an error. The
/// system would end the program, and partial files would stay. Programs that this one starts are
/// ended as usual.
#[cfg(unix)]
fn outgrow() -> std::io::Result<()> {
    let unused = std::sync::Arc::default();
    signal_hook::flag::register(nix::sys::signal::Signal::SIGXFSZ as i32, unused).map(drop)
}

#[cfg(not(unix))]
fn outgrow() -> std::io::Result<()> {
    Ok(())
}

/// Calls this, on a thread of its own, whenever the program is asked to end.
#[cfg(unix)]
fn each_signal(heard: impl Fn() + Send + 'static) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    // `nohup` lets programs outlast their terminal.
    let wanted: &[i32] = match is_ignored(SIGHUP) {
        true => &[SIGINT, SIGTERM],
        false => &[SIGINT, SIGTERM, SIGHUP],
    };
    let mut signals = held_back(wanted, || signal_hook::iterator::Signals::new(wanted))??;
    let thread = std::thread::Builder::new().name("signals".into());
    thread.spawn(move || signals.forever().for_each(|_| heard())).map(drop)
}

/// Does something while these signals wait: one that came between its handler and what the handler
/// calls would be lost.
#[cfg(unix)]
fn held_back<T>(signals: &[i32], act: impl FnOnce() -> T) -> std::io::Result<T> {
    use nix::sys::signal::{SigSet, Signal};
    let mut set = SigSet::empty();
    for &signal in signals {
        set.add(Signal::try_from(signal)?);
    }
    set.thread_block()?;
    let done = act();
    set.thread_unblock()?;
    Ok(done)
}

/// True if whoever started the program had this signal ignored. Told by Linux only.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & (1 << (signal - 1)) != 0)
}

#[cfg(not(unix))]
fn each_signal(heard: impl Fn() + Send + 'static) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(heard)
}

/// Ends the program at once; no unfinished file is left.
pub fn end() -> ! {
    thenar_link::release_all(LAST_WORDS);
    thenar_output::seal();
    eprintln!("error: interrupted");
    std::process::exit(1);
}

/// From now on the command asks whether it is to end.
pub fn listen() {
    LISTENS.store(true, Ordering::SeqCst);
}

/// A panic of the main thread ends the program, and forces before that. Other threads are looked
/// after by those who started them: what the simulation owes fades, and returns with it.
fn stop_on_panic() {
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if std::thread::current().name() == Some("main") {
            thenar_link::haptic_loop::stop_all();
        }
        before(info);
    }));
}

/// True once Ctrl-C was pressed, or nobody reads any more what is printed: there is nothing left to
/// do.
pub fn asked() -> bool {
    pressed() || UNREAD.load(Ordering::Relaxed)
}

/// True once Ctrl-C was pressed: what was asked for is not complete.
pub fn pressed() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// Notes that printing has lost its reader.
pub fn unread() {
    UNREAD.store(true, Ordering::SeqCst);
}
