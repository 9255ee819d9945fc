//! Keepers of devices: this very program, started anew (`thenar_link::keeper`).

#[cfg(unix)]
use std::process::ExitCode;

/// From now on devices that need one have a keeper.
pub fn enable() {
    // What runs, even when its file was replaced meanwhile.
    let running = std::path::PathBuf::from("/proc/self/exe");
    let program = if running.exists() { Ok(running) } else { std::env::current_exe() };
    // Without it devices report that they have none.
    if let Ok(program) = program {
        thenar_link::keeper::use_program(program);
    }
}

/// True if this process is to be a keeper.
#[cfg(unix)]
pub fn is_asked() -> bool {
    let mut arguments = std::env::args_os().skip(1);
    arguments.next().is_some_and(|first| first == thenar_link::keeper::ARGUMENT)
        && arguments.next().is_none()
}

/// Keeps a device. What asks programs to end does not end this one: it ends with the program that
/// it keeps for.
#[cfg(unix)]
pub fn run() -> ExitCode {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    for signal in [SIGHUP, SIGINT, SIGTERM] {
        // Where that cannot be had, the keeper still stands in a group of its own.
        let _ = signal_hook::flag::register(signal, std::sync::Arc::default());
    }
    match thenar_link::keeper::run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: only the program itself starts its keepers: {error}");
            ExitCode::from(2)
        }
    }
}
