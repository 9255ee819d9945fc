//! Scenes and sessions, in one binary: `cargo test -p thenar-scene --test all probes::` runs a
//! part. Tests that count allocations stand apart.

mod accuracy;
mod contact;
mod figures;
mod hand;
mod mimics;
mod recording;
#[path = "../../../../fuzz/src/recordings.rs"]
mod recordings;
mod run;
#[path = "../../../../fuzz/src/scenes.rs"]
mod scenes;
mod text;
