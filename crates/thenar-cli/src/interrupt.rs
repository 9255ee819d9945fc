//! Ctrl-C, and being asked to end by the system, stop all forces at once and end a run after the
//! present step; a second time ends the program at once.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How long devices have for their last words when the program ends at once.
const LAST_WORDS: Duration = Duration::from_millis(100);

static ASKED: AtomicBool = AtomicBool::new(false);

/// Starts to listen. Where the system does not allow it, Ctrl-C ends the program as usual.
pub fn listen() {
    let _ = ctrlc::set_handler(|| {
        thenar_link::haptic_loop::stop_all();
        if ASKED.swap(true, Ordering::Relaxed) {
            thenar_link::release_all(LAST_WORDS);
            std::process::exit(1);
        }
    });
    stop_on_panic();
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

/// True once Ctrl-C was pressed.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
