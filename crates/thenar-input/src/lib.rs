//! Input from users: files, read up to a bound, text, quoted in messages up to one, and a checksum.
//!
//! Every file that a user names is read through this crate. It opens plain files only, so that a
//! pipe, a device or a folder gives an error instead of a wait without end, and reads no more than
//! it was told it may.

mod file;
mod hash;
mod text;

pub use file::{InputError, open_plain, read, read_text};
pub use hash::{FNV_START, fnv1a};
pub use text::{brief, plain, quoted, visible};
