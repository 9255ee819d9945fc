//! Output files that are complete or not there.
//!
//! An [`Output`] is written beside its target, as `NAME.PID.part`, and takes the target's name when
//! it is finished; dropped before, it leaves nothing. A target that is there already keeps its
//! content until then, and its permissions for good.
//!
//! | target | what happens |
//! |---|---|
//! | a plain file, or nothing | replaced, or made, as a whole |
//! | a symbolic link | stays; the file it leads to is replaced or made |
//! | a terminal, `/dev/null`, another character device | written as it goes |
//! | a named pipe with a reader | written as it goes |
//! | `/dev/stdout`, `/dev/fd/3` and the like | written behind what is there |
//! | a folder, a block device, a socket | refused |
//! | an input of this command, the target of another output | refused |
//!
//! A program that is asked to end calls [`seal`], which removes what is unfinished. A [`Lock`]
//! keeps two processes from writing the same outputs at a time.

mod claim;
mod error;
mod folder;
mod lock;
mod open;
mod output;
mod place;

pub use claim::{Claim, protect, seal};
pub use error::{Cause, OutputError};
pub use folder::TemporaryFolder;
pub use lock::{Lock, LockError};
pub use output::{Output, write_whole};
