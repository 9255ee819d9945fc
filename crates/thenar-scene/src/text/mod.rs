//! From TOML text to checked values: positions, key paths, ranges, precise errors.
//!
//! Each table of the format is declared once (`table!`, `choice!`, `words!`); that one
//! declaration reads it, rejects what does not belong, and writes its JSON Schema.

pub(crate) mod declare;
mod fault;
mod node;
mod overrides;
mod path;
mod range;
mod read;
mod schema;
mod suggest;

pub(crate) use declare::{choice, table, words};
pub use fault::{Fault, SceneError, SourcePlace};
pub use node::{Node, Value};
pub use overrides::{Override, apply as apply_override};
pub use path::{Cx, Step};
pub use range::Range;
pub use read::{Fields, Located, Read, parse};
pub use schema::{Defs, document as schema_document};
pub use suggest::nearest;
pub use thenar_input::plain;
