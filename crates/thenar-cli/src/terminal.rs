//! Printing. Whoever read may have stopped, as `head` does: then a command that listens for Ctrl-C
//! ends as if it had been pressed, and others go on in silence. Where printing fails for another
//! reason, a full disk, the program says so in the end. The standard macros would panic.

use crate::error::CliError;
use crate::interrupt;
use std::fmt::Arguments;
use std::io::{ErrorKind, Write};
use std::sync::OnceLock;

/// Why something could not be printed.
static LOST: OnceLock<String> = OnceLock::new();

/// Prints to the standard output.
pub fn out(text: Arguments<'_>) {
    match std::io::stdout().write_fmt(text) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => interrupt::unread(),
        Err(error) => LOST.set(error.to_string()).unwrap_or_default(),
        Ok(()) => {}
    }
}

/// Completes what is printed, if somebody may still read it.
///
/// # Errors
/// Some of the output was lost.
pub fn complete() -> Result<(), CliError> {
    match LOST.get() {
        Some(cause) => Err(CliError::Other(format!("cannot write the standard output: {cause}"))),
        None => Ok(()),
    }
}

/// Prints to the error output, which nobody has to read.
pub fn err(text: Arguments<'_>) {
    let _ = std::io::stderr().write_fmt(text);
}

/// Prints a line to the error output, on which nothing that is quoted acts on the terminal.
pub fn line(text: Arguments<'_>) {
    err(format_args!("{}\n", thenar_input::visible(&text.to_string())));
}

macro_rules! println {
    () => { $crate::terminal::out(format_args!("\n")) };
    ($($text:tt)*) => { $crate::terminal::out(format_args!("{}\n", format_args!($($text)*))) };
}

macro_rules! print {
    ($($text:tt)*) => { $crate::terminal::out(format_args!($($text)*)) };
}

macro_rules! eprintln {
    ($($text:tt)*) => { $crate::terminal::line(format_args!($($text)*)) };
}
