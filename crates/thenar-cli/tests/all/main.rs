//! The program as a user runs it, in one binary: `cargo test -p thenar-cli --test all sweep::` runs a part.

mod command_line;
mod compare;
mod devices;
mod inputs;
mod outputs;
mod recording;
mod stage;
mod sweep;
mod touch;
