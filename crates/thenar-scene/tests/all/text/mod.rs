//! Scenes as text: what is read, what it becomes, and what is refused.

mod damage;
mod errors;
mod files;
mod format;
mod fuzz_scenes;
mod grips;
mod meshes;
mod old_words;
mod scenes;
mod shapes;
mod tissue;
