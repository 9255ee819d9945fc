//! Thenar for C: worlds behind opaque handles. `include/thenar.h` is made of this crate,
//! `docs/c.md` tells how it is used.
//!
//! What holds for every function:
//!
//! - It returns a [`Status`]; where that is not [`Status::Ok`], `thenar_last_error` has the words,
//!   which are the program's own, and nothing has changed.
//! - Pointers that are null or not aligned, sizes that do not fit and text that is not UTF-8 are
//!   refused.
//! - A panic does not cross the border. It ends the world in which it happened, whose every further
//!   use is refused.
//! - One thread has a world at a time; another that comes meanwhile is refused at once, and nobody
//!   waits.
//!
//! No check can tell whether a pointer leads to what its type says. Callers answer for that, which
//! is why the functions are unsafe; the unsafe code is in [`pointer`], and here and there one line
//! that calls it.

mod body;
mod boundary;
mod contact;
mod drive;
mod hand;
mod open;
mod pointer;
mod running;
mod world;

pub use boundary::Status;
pub use contact::{Contact, Load};
pub use running::World;
pub use world::Report;
